#pragma once

// The few routines of BLAS and LAPACK that the joint solve calls, and a guard that keeps OpenBLAS on the
// calling thread: our own loops are what runs in parallel, so that results do not depend on the number of
// threads. Matrices are column-major.

extern "C" {
void dpotrf_(const char* triangle, const int* size, double* a, const int* stride, int* info);
void dtrsm_(const char* side, const char* triangle, const char* transposed, const char* unit, const int* rows,
            const int* columns, const double* factor, const double* a, const int* a_stride, double* b,
            const int* b_stride);
void dgemm_(const char* a_transposed, const char* b_transposed, const int* rows, const int* columns,
            const int* inner, const double* factor, const double* a, const int* a_stride, const double* b,
            const int* b_stride, const double* keep, double* c, const int* c_stride);
void openblas_set_num_threads(int threads);
int openblas_get_num_threads();
}

namespace mlic {

class BlasOnOneThread {
 public:
  BlasOnOneThread() : before_(openblas_get_num_threads()) {
    if (before_ != 1) openblas_set_num_threads(1);
  }
  ~BlasOnOneThread() {
    if (before_ != 1) openblas_set_num_threads(before_);
  }
  BlasOnOneThread(const BlasOnOneThread&) = delete;
  BlasOnOneThread& operator=(const BlasOnOneThread&) = delete;

 private:
  int before_;
};

// c = keep * c + factor * a * b^T; a: rows x inner, b: columns x inner.
inline void MultiplyTransposed(int rows, int columns, int inner, double factor, const double* a, int a_stride,
                               const double* b, int b_stride, double keep, double* c, int c_stride) {
  dgemm_("N", "T", &rows, &columns, &inner, &factor, a, &a_stride, b, &b_stride, &keep, c, &c_stride);
}

}  // namespace mlic
