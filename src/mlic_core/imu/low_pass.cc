#include "mlic_core/imu/low_pass.h"

#include <cmath>

namespace mlic {
namespace {

// From pass to stop of a Hann window, times its length. from: derivation
constexpr double kTransition = 3.3;

}  // namespace

LowPass::LowPass(double top) : cut_off_(2.5 * top), half_width_(0.5 * kTransition / top) {}

double LowPass::Weight(double lag) const {
  const double x = 2.0 * M_PI * cut_off_ * lag;
  return (x == 0.0 ? 1.0 : std::sin(x) / x) * (1.0 + std::cos(M_PI * lag / half_width_));
}

}  // namespace mlic
