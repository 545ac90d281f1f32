#pragma once

namespace mlic {

// Whether sum_k c_k x^k > 0 on all of [0, end], for c_0 > 0. Distortions are monotonic up to a radius where
// such a polynomial, the derivative of the distorted radius, has its first root. Without searching for roots:
// a polynomial lies within the hull of its Bernstein coefficients, which are halved until they decide.
template <int Degree>
class PositivePolynomial {
 public:
  static bool On(const double (&c)[Degree + 1], double end) {
    double scaled[Degree + 1];
    double power = 1.0, least = 0.0, value = 0.0;
    for (int k = 0; k <= Degree; ++k) {
      scaled[k] = c[k] * power;
      power *= end;
      value += scaled[k];
      if (k == 0 || scaled[k] < 0.0) least += scaled[k];
    }
    if (least > 0.0) return true;  // the usual case
    if (!(value > 0.0)) return false;
    // Bernstein coefficients: b_i = sum_k binomial(i, k) / binomial(Degree, k) * scaled_k.
    double b[Degree + 1];
    for (int i = 0; i <= Degree; ++i) {
      double ratio = 1.0;
      b[i] = 0.0;
      for (int k = 0; k <= i; ++k) {
        b[i] += ratio * scaled[k];
        ratio *= static_cast<double>(i - k) / (Degree - k);
      }
    }
    return Decide(b, kDeepest);
  }

 private:
  static constexpr int kDeepest = 30;  // from: guard, intervals of 2^-30

  static bool Decide(const double (&b)[Degree + 1], int depth) {
    if (!(b[0] > 0.0) || !(b[Degree] > 0.0)) return false;
    bool all = true;
    for (int i = 1; i < Degree; ++i) all = all && b[i] > 0.0;
    if (all) return true;
    if (depth == 0) return false;  // touches zero
    double left[Degree + 1], right[Degree + 1];
    for (int i = 0; i <= Degree; ++i) right[i] = b[i];
    for (int level = 0; level <= Degree; ++level) {
      left[level] = right[0];
      for (int i = 0; i < Degree - level; ++i) right[i] = 0.5 * (right[i] + right[i + 1]);
    }
    return Decide(left, depth - 1) && Decide(right, depth - 1);
  }
};

}  // namespace mlic
