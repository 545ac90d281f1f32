#pragma once

#include <cmath>

namespace mlic::sim {

// A function of time by its value and its first two derivatives at one instant. Motion that is written once
// for a generic scalar gives poses with double and, with Taylor, velocities and accelerations that agree with
// the poses exactly.
struct Taylor {
  double value = 0.0;
  double first = 0.0;
  double second = 0.0;

  Taylor() = default;
  Taylor(double constant) : value(constant) {}  // NOLINT: a constant is a function of time, too
  Taylor(double v, double d, double dd) : value(v), first(d), second(dd) {}

  // The function t at the instant t.
  static Taylor Time(double t) { return {t, 1.0, 0.0}; }
};

inline Taylor operator+(const Taylor& a, const Taylor& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
inline Taylor operator-(const Taylor& a, const Taylor& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
inline Taylor operator-(const Taylor& a) { return {-a.value, -a.first, -a.second}; }
inline Taylor operator*(const Taylor& a, const Taylor& b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second};
}
inline Taylor& operator+=(Taylor& a, const Taylor& b) { return a = a + b; }

// f(a) from f, f' and f'' at a.value.
inline Taylor Chain(const Taylor& a, double f, double df, double ddf) {
  return {f, df * a.first, ddf * a.first * a.first + df * a.second};
}
inline Taylor sin(const Taylor& a) {
  const double s = std::sin(a.value), c = std::cos(a.value);
  return Chain(a, s, c, -s);
}
inline Taylor cos(const Taylor& a) {
  const double s = std::sin(a.value), c = std::cos(a.value);
  return Chain(a, c, -s, -c);
}
// The angle of (x, y), which must not be zero.
inline Taylor atan2(const Taylor& y, const Taylor& x) {
  const double q = x.value * x.value + y.value * y.value;
  const double dq = 2.0 * (x.value * x.first + y.value * y.first);
  const double n = x.value * y.first - y.value * x.first;
  const double dn = x.value * y.second - y.value * x.second;
  return {std::atan2(y.value, x.value), n / q, (dn * q - n * dq) / (q * q)};
}

}  // namespace mlic::sim
