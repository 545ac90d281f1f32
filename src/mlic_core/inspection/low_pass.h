#pragma once

#include <Eigen/Core>
#include <cmath>

namespace mlic {

// Low-passes of gain 1 at frequency 0, by the bilinear transform. Each starts as if its first value had stood
// for ever.

// |H(f)|^2 = 1 / (1 + (f / cutoff)^2).
template <int Rows, int Columns>
class FirstOrderLowPass {
 public:
  using Value = Eigen::Matrix<double, Rows, Columns>;
  // Hz; the cutoff is below half the rate.
  FirstOrderLowPass(double cutoff, double rate) {
    const double k = std::tan(M_PI * cutoff / rate);
    b_ = k / (1.0 + k);
    a_ = (k - 1.0) / (1.0 + k);
  }
  Value Next(const Value& x) {
    if (!started_) last_ = output_ = x;
    started_ = true;
    output_ = b_ * (x + last_) - a_ * output_;
    last_ = x;
    return output_;
  }

 private:
  double b_ = 0.0, a_ = 0.0;
  bool started_ = false;
  Value last_, output_;
};

// Butterworth's, |H(f)|^2 = 1 / (1 + (f / cutoff)^4).
template <int Rows, int Columns>
class SecondOrderLowPass {
 public:
  using Value = Eigen::Matrix<double, Rows, Columns>;
  // Hz; the cutoff is below half the rate.
  SecondOrderLowPass(double cutoff, double rate) {
    const double k = std::tan(M_PI * cutoff / rate), scale = 1.0 + std::sqrt(2.0) * k + k * k;
    b_ = k * k / scale;
    a1_ = 2.0 * (k * k - 1.0) / scale;
    a2_ = (1.0 - std::sqrt(2.0) * k + k * k) / scale;
  }
  Value Next(const Value& x) {
    if (!started_) {
      first_ = (1.0 - b_) * x;
      second_ = (b_ - a2_) * x;
    }
    started_ = true;
    const Value y = b_ * x + first_;
    first_ = 2.0 * b_ * x - a1_ * y + second_;
    second_ = b_ * x - a2_ * y;
    return y;
  }

 private:
  double b_ = 0.0, a1_ = 0.0, a2_ = 0.0;
  bool started_ = false;
  Value first_, second_;
};

}  // namespace mlic
