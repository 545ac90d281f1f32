#pragma once

#include <cmath>

namespace mlic {

// How unlikely what was found is, in the standard deviations of one normal variable. Far tails stay finite:
// probabilities are logarithms.

// Of a sum of squares of so many (1 or more) independent standard normal variables: that it is larger.
inline double LogProbabilityBeyond(double squares, int degrees) {
  const double half = 0.5 * squares;
  constexpr double kFarTail =
      300.0;  // from: guard, exp(-300) is a number, and the tail's first term suffices
  if (half > kFarTail) return (0.5 * degrees - 1.0) * std::log(half) - std::lgamma(0.5 * degrees) - half;
  double probability = degrees % 2 == 1 ? std::erfc(std::sqrt(half)) : std::exp(-half);
  for (int k = degrees % 2 == 1 ? 1 : 2; k < degrees; k += 2) {
    probability += std::exp(0.5 * k * std::log(half) - half - std::lgamma(0.5 * k + 1.0));
  }
  return std::log(probability);
}

// Where `exceeds` (falling) comes down to zero, between 0 and `most`.
template <typename Exceeds>
double Crossing(const Exceeds& exceeds, double most) {
  double low = 0.0, high = most;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (exceeds(middle) > 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// The deviation that one normal variable exceeds, to either side, as rarely as `degrees` of them together
// exceed these squares: |z| where degrees = 1 and squares = z^2.
inline double EquivalentDeviation(double squares, int degrees) {
  const double sought = LogProbabilityBeyond(squares, degrees);
  return Crossing([&](double z) { return LogProbabilityBeyond(z * z, 1) - sought; },
                  std::sqrt(squares) + 1.0);
}

// What a normal variable exceeds, to either side, with this probability, in units of a sigma that was itself
// found from `degrees` (even) squares: Student's t.
inline double StudentDeviation(double probability, int degrees) {
  const auto beyond = [&](double t) {
    const double angle = std::atan(t / std::sqrt(static_cast<double>(degrees)));
    double term = 1.0, within = 1.0;
    for (int k = 2; k < degrees; k += 2) {
      term *= (k - 1.0) / k * std::cos(angle) * std::cos(angle);
      within += term;
    }
    return 1.0 - std::sin(angle) * within;
  };
  constexpr double kMost = 1e4;  // from: guard
  return Crossing([&](double t) { return beyond(t) - probability; }, kMost);
}

}  // namespace mlic
