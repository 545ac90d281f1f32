#pragma once

namespace mlic {

// The finest spacing of a trajectory's knots, s: up to half of their rate (12.5 Hz) splines follow an IMU.
// from: standard, a vehicle's body and a walking person move below 10 Hz
constexpr double kFinestKnots = 0.04;

// A low-pass without delay: what lies below 2 * top (Hz) stays as it was, what lies above 3 * top goes. A
// sinc of 2.5 * top under a Hann window.
class LowPass {
 public:
  explicit LowPass(double top);

  double HalfWidth() const { return half_width_; }  // s
  // s, from the middle of the weights to where they are zero first.
  double MainLobe() const { return 0.5 / cut_off_; }
  // Relative weight of a sample `lag` (s, within the half width) from where the signal is wanted.
  double Weight(double lag) const;

 private:
  double cut_off_, half_width_;
};

}  // namespace mlic
