#include "mlic_core/sensors/pinhole_model.h"

#include <Eigen/LU>
#include <cmath>

#include "mlic_core/sensors/positive_polynomial.h"

namespace mlic {
namespace {

struct Distortion {
  double n[4], d[4];  // numerator and denominator in powers of the squared radius
  double p1, p2;

  Distortion(const double* parameters, bool rational)
      : n{1.0, parameters[4], parameters[5], parameters[8]},
        d{1.0, 0.0, 0.0, 0.0},
        p1(parameters[6]),
        p2(parameters[7]) {
    if (!rational) return;
    for (int k = 0; k < 3; ++k) d[k + 1] = parameters[9 + k];
  }

  static double Value(const double (&c)[4], double s) { return c[0] + s * (c[1] + s * (c[2] + s * c[3])); }
  static double Slope(const double (&c)[4], double s) { return c[1] + s * (2.0 * c[2] + s * 3.0 * c[3]); }

  // Whether the distorted radius r N/D rises with r all the way from the centre to r^2 = s.
  bool Monotonic(double s, bool rational) const {
    if (!rational) {
      const double slope[4] = {1.0, 3.0 * n[1], 5.0 * n[2], 7.0 * n[3]};
      return PositivePolynomial<3>::On(slope, s);
    }
    if (!PositivePolynomial<3>::On(d, s)) return false;
    double slope[7] = {};  // times D^2
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) slope[i + j] += n[i] * d[j] * (1 + 2 * i - 2 * j);
    }
    return PositivePolynomial<6>::On(slope, s);
  }

  // The distorted point; A: its derivative. False where the map folds over.
  bool Apply(double x, double y, Eigen::Vector2d* distorted, Eigen::Matrix2d* A) const {
    const double s = x * x + y * y;
    const double below = 1.0 / Value(d, s);
    const double radial = Value(n, s) * below;
    const double slope = 2.0 * (Slope(n, s) - radial * Slope(d, s)) * below;
    *distorted << x * radial + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x),
        y * radial + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y;
    const double mixed = x * y * slope + 2.0 * (p1 * x + p2 * y);
    *A << radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
        radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
    return (*A)(0, 0) > 0.0 && A->determinant() > 0.0;
  }
};

// The radius that radial distortion takes to `distorted`, or where monotonic distortion ends before it.
double UndistortRadius(const Distortion& distortion, bool rational, double distorted) {
  const auto below = [&](double r) {
    const double s = r * r;
    return distortion.Monotonic(s, rational) &&
           r * Distortion::Value(distortion.n, s) < distorted * Distortion::Value(distortion.d, s);
  };
  constexpr double kFarthest = 1e4;  // from: guard, the tangent of 89.99 deg
  double low = 0.0, high = distorted;
  while (high < kFarthest && below(high)) {
    low = high;
    high *= 2.0;
  }
  for (int i = 0; i < 60 && high - low > 1e-9 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (below(middle) ? low : high) = middle;
  }
  return low;
}

// Newton's method with halved steps where they leave the domain or do not improve. False if it does not
// arrive.
bool Undistort(const Distortion& distortion, bool rational, const Eigen::Vector2d& target,
               Eigen::Vector2d* point) {
  Eigen::Vector2d value;
  Eigen::Matrix2d A;
  if (!distortion.Monotonic(point->squaredNorm(), rational)) return false;
  if (!distortion.Apply(point->x(), point->y(), &value, &A)) return false;
  double error = (value - target).norm();
  const double enough = 1e-13 * (1.0 + target.norm());
  for (int iteration = 0; iteration < 50 && error > enough; ++iteration) {
    Eigen::Vector2d step = A.inverse() * (target - value);
    bool better = false;
    for (int half = 0; half < 20 && !better; ++half, step *= 0.5) {
      const Eigen::Vector2d trial = *point + step;
      Eigen::Vector2d trial_value;
      Eigen::Matrix2d trial_A;
      if (!distortion.Monotonic(trial.squaredNorm(), rational)) continue;
      if (!distortion.Apply(trial.x(), trial.y(), &trial_value, &trial_A)) continue;
      const double trial_error = (trial_value - target).norm();
      if (!(trial_error < error)) continue;
      *point = trial;
      value = trial_value;
      A = trial_A;
      error = trial_error;
      better = true;
    }
    if (!better) break;
  }
  return error < 1e-10 * (1.0 + target.norm());
}

}  // namespace

bool ProjectPinhole(const double* parameters, bool rational, const Eigen::Vector3d& point,
                    Eigen::Vector2d* pixel, CameraPointJacobian* J_point,
                    CameraParameterJacobian* J_parameters) {
  if (!(point.z() > 0.0)) return false;
  const double inverse_z = 1.0 / point.z();
  const double x = point.x() * inverse_z, y = point.y() * inverse_z;
  const double s = x * x + y * y;
  if (!std::isfinite(s)) return false;
  const Distortion distortion(parameters, rational);
  if (!distortion.Monotonic(s, rational)) return false;
  Eigen::Vector2d distorted;
  Eigen::Matrix2d A;
  if (!distortion.Apply(x, y, &distorted, &A)) return false;
  const double fx = parameters[0], fy = parameters[1];
  *pixel << fx * distorted.x() + parameters[2], fy * distorted.y() + parameters[3];
  if (J_point != nullptr) {
    A.row(0) *= fx * inverse_z;
    A.row(1) *= fy * inverse_z;
    *J_point << A(0, 0), A(0, 1), -(A(0, 0) * x + A(0, 1) * y), A(1, 0), A(1, 1),
        -(A(1, 0) * x + A(1, 1) * y);
  }
  if (J_parameters != nullptr) {
    CameraParameterJacobian& J = *J_parameters;
    J.resize(2, rational ? 12 : 9);
    const double below = 1.0 / Distortion::Value(distortion.d, s);
    const double radial = Distortion::Value(distortion.n, s) * below;
    const double fx_x = fx * x, fy_y = fy * y;
    J.col(0) << distorted.x(), 0.0;
    J.col(1) << 0.0, distorted.y();
    J.col(2) << 1.0, 0.0;
    J.col(3) << 0.0, 1.0;
    J.col(4) << fx_x * s * below, fy_y * s * below;
    J.col(5) = s * J.col(4);
    J.col(6) << fx * 2.0 * x * y, fy * (s + 2.0 * y * y);
    J.col(7) << fx * (s + 2.0 * x * x), fy * 2.0 * x * y;
    J.col(8) = s * J.col(5);
    if (rational) {
      for (int k = 0; k < 3; ++k) J.col(9 + k) = -radial * J.col(k == 2 ? 8 : 4 + k);
    }
  }
  return true;
}

bool UnprojectPinhole(const double* parameters, bool rational, const Eigen::Vector2d& pixel,
                      Eigen::Vector3d* bearing) {
  const Eigen::Vector2d target((pixel.x() - parameters[2]) / parameters[0],
                               (pixel.y() - parameters[3]) / parameters[1]);
  if (!target.allFinite()) return false;
  const Distortion distortion(parameters, rational);
  Eigen::Vector2d point = target;
  if (!Undistort(distortion, rational, target, &point)) {
    const double radius = target.norm();
    point = radius > 0.0 ? Eigen::Vector2d(target * (UndistortRadius(distortion, rational, radius) / radius))
                         : Eigen::Vector2d(Eigen::Vector2d::Zero());
    if (!Undistort(distortion, rational, target, &point)) return false;
  }
  *bearing = Eigen::Vector3d(point.x(), point.y(), 1.0).normalized();
  return true;
}

std::optional<Magnification> PinholeMagnification(const double* parameters, bool rational, double radius) {
  const Distortion lens(parameters, rational);
  const double target = radius / parameters[0];
  const double r = UndistortRadius(lens, rational, target);
  const double s = r * r;
  const double D = Distortion::Value(lens.d, s), D_slope = Distortion::Slope(lens.d, s);
  // rho / f = r g, g = N / D, slopes by s.
  const double g = Distortion::Value(lens.n, s) / D;
  const double g_slope = (Distortion::Slope(lens.n, s) - g * D_slope) / D;
  const double by_r = g + 2.0 * s * g_slope;
  if (!(by_r > 0.0) || std::abs(r * g - target) > 1e-6 * (1.0 + target)) return std::nullopt;
  Magnification magnification;
  magnification.log = std::log(by_r * (1.0 + s));
  magnification.gradient.setZero();
  constexpr int kNumerator[] = {4, 5, 8};  // places of k1, k2, k3; from: structural
  double below = 1.0;                      // s^j
  for (int j = 0; j < 3; ++j) {
    const double power = below * s;
    // Of g by the numerator's term, and its slope.
    const double a = power / D, a_slope = ((j + 1) * below - a * D_slope) / D;
    magnification.gradient[kNumerator[j]] = (a + 2.0 * s * a_slope) / by_r;
    if (rational) magnification.gradient[9 + j] = -(g * a + 2.0 * s * (g_slope * a + g * a_slope)) / by_r;
    below = power;
  }
  return magnification;
}

}  // namespace mlic
