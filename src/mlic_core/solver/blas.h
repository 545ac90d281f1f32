#pragma once

// The few routines of BLAS and LAPACK that the joint solve and the search for matches call, and a guard that
// keeps OpenBLAS on the calling thread: our own loops are what runs in parallel, so that results do not
// depend on the number of threads. Matrices are column-major.

extern "C" {
void dpotrf_(const char* triangle, const int* size, double* a, const int* stride, int* info);
void dtrsm_(const char* side, const char* triangle, const char* transposed, const char* unit, const int* rows,
            const int* columns, const double* factor, const double* a, const int* a_stride, double* b,
            const int* b_stride);
void dgemm_(const char* a_transposed, const char* b_transposed, const int* rows, const int* columns,
            const int* inner, const double* factor, const double* a, const int* a_stride, const double* b,
            const int* b_stride, const double* keep, double* c, const int* c_stride);
void sgemm_(const char* a_transposed, const char* b_transposed, const int* rows, const int* columns,
            const int* inner, const float* factor, const float* a, const int* a_stride, const float* b,
            const int* b_stride, const float* keep, float* c, const int* c_stride);
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

// The upper left rows x columns of a column-major matrix whose columns lie `stride` apart.
template <typename T>
struct BlasView {
  T* data;
  int rows, columns, stride;
};

// c -= a * b^T.
inline void SubtractTransposedProduct(const BlasView<const double>& a, const BlasView<const double>& b,
                                      const BlasView<double>& c) {
  constexpr double kFactor = -1.0, kKeep = 1.0;  // from: structural
  dgemm_("N", "T", &c.rows, &c.columns, &a.columns, &kFactor, a.data, &a.stride, b.data, &b.stride, &kKeep,
         c.data, &c.stride);
}

// c = a^T * b.
inline void TransposedProduct(const BlasView<const float>& a, const BlasView<const float>& b,
                              const BlasView<float>& c) {
  constexpr float kFactor = 1.0f, kKeep = 0.0f;  // from: structural
  sgemm_("T", "N", &c.rows, &c.columns, &a.rows, &kFactor, a.data, &a.stride, b.data, &b.stride, &kKeep,
         c.data, &c.stride);
}

}  // namespace mlic
