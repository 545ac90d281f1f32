#pragma once

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace mlic {

// How unlikely what was found is, in the standard deviations of one normal variable.

// The deviation that one normal variable exceeds, to either side, as rarely as `degrees` (1 or more) of them
// together exceed these squares: |z| where degrees = 1 and squares = z^2.
inline double EquivalentDeviation(double squares, int degrees) {
  namespace math = boost::math;
  constexpr double kFarTail =
      600.0;  // from: guard, exp(-300) is a number, and the tail's first term suffices
  if (squares <= kFarTail) {
    const double probability = math::cdf(math::complement(math::chi_squared(degrees), squares));
    return math::quantile(math::complement(math::normal(), 0.5 * probability));
  }
  // First terms of the logarithms of both tails, alike: h and z^2 / 2 are what is squared there, halved.
  const double h = 0.5 * squares;
  const double tail = h - (0.5 * degrees - 1.0) * std::log(h) + std::lgamma(0.5 * degrees);
  double of_one = h;
  for (int i = 0; i < 5; ++i) of_one = tail - 0.5 * std::log(of_one) - 0.5 * std::log(M_PI);
  return std::sqrt(2.0 * of_one);
}

// What a normal variable exceeds, to either side, with this probability, in units of a sigma that was itself
// found from `degrees` squares: Student's t.
inline double StudentDeviation(double probability, int degrees) {
  return boost::math::quantile(boost::math::complement(boost::math::students_t(degrees), 0.5 * probability));
}

}  // namespace mlic
