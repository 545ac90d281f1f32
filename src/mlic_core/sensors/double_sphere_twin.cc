#include "mlic_core/sensors/double_sphere_twin.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/sensors/double_sphere_model.h"

namespace mlic {
namespace {

constexpr int kRadii = 64;           // from: structural, of the lens's curve
constexpr double kLargestXi = 0.95;  // from: guard, the model ends at 1
constexpr double kStep = 0.02;       // of xi; from: guard, half of what twins lie apart at least
constexpr double kLargestRms = 0.5;  // px; from: guard, with more the data tell the two apart
// Of xi: nearer twins, either side of where a change of xi does not show to first order, are within the sigma
// that this leaves. from: measured, trials, camera and IMU, open 357: at 0.09 they are ten sigmas apart
constexpr double kLeastApart = 0.04;

struct Shape {
  double f, xi, alpha;
};

struct Fit {
  Shape shape;
  double rms;  // px
};

// Angles from the axis and radii of a lens, as far as the image's edges are away.
class Curve {
 public:
  explicit Curve(const CameraIntrinsics& intrinsics) {
    const std::vector<double>& p = intrinsics.parameters;
    const double edge = std::max({p[2], intrinsics.width - 1.0 - p[2], p[3], intrinsics.height - 1.0 - p[3]});
    const double round[] = {p[0], p[0], 0.0, 0.0, p[4], p[5]};
    for (int i = 1; i <= kRadii; ++i) {
      Eigen::Vector3d bearing;
      const double radius = edge * i / kRadii;
      if (!UnprojectDoubleSphere(round, {radius, 0.0}, &bearing)) break;
      bearings_.push_back(bearing);
      radii_.push_back(radius);
    }
  }

  // Least squares over the image's area; xi moves if it is free. Nothing where the fit leaves the model.
  std::optional<Fit> Approach(Shape shape, bool xi_free) const {
    constexpr int kIterations = 20;  // from: guard
    Fit fit{shape, 0.0};
    for (int iteration = 0; iteration <= kIterations; ++iteration) {
      const double parameters[] = {fit.shape.f, fit.shape.f, 0.0, 0.0, fit.shape.xi, fit.shape.alpha};
      Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
      Eigen::Vector3d b = Eigen::Vector3d::Zero();
      double squares = 0.0, weights = 0.0;
      for (std::size_t i = 0; i < radii_.size(); ++i) {
        Eigen::Vector2d pixel;
        CameraParameterJacobian J;
        if (!ProjectDoubleSphere(parameters, bearings_[i], &pixel, nullptr, &J)) return std::nullopt;
        const Eigen::Vector3d row(J(0, 0), xi_free ? J(0, 4) : 0.0, J(0, 5));
        const double error = radii_[i] - pixel.x();
        H += radii_[i] * row * row.transpose();
        b += radii_[i] * error * row;
        squares += radii_[i] * error * error;
        weights += radii_[i];
      }
      fit.rms = std::sqrt(squares / weights);
      if (iteration == kIterations) break;
      if (!xi_free) H(1, 1) = 1.0;
      const Eigen::Vector3d step = H.ldlt().solve(b);
      if (!step.allFinite()) return std::nullopt;
      fit.shape.f += step[0];
      fit.shape.xi = std::clamp(fit.shape.xi + step[1], -kLargestXi, kLargestXi);
      fit.shape.alpha = std::clamp(fit.shape.alpha + step[2], 0.01, 0.99);
    }
    return fit;
  }

  bool IsEmpty() const { return radii_.size() < kRadii / 2; }

 private:
  std::vector<Eigen::Vector3d> bearings_;
  std::vector<double> radii_;  // px
};

// The lens of this xi that is most alike, from one of a xi nearby.
std::optional<Fit> MoveXi(const Curve& curve, const Shape& from, double xi) {
  return curve.Approach({from.f * (1.0 + xi) / (1.0 + from.xi), xi, from.alpha}, false);
}

CameraIntrinsics OfShape(CameraIntrinsics intrinsics, const Shape& shape) {
  std::vector<double>& p = intrinsics.parameters;
  p = {shape.f, p[1] * shape.f / p[0], p[2], p[3], shape.xi, shape.alpha};
  return intrinsics;
}

// The best of the local minima along xi, away from where the lens stands, walking to one side of it.
std::optional<Fit> WalkAlongXi(const Curve& curve, const Shape& start, double step) {
  std::vector<Fit> walk{{start, 0.0}};
  std::optional<Fit> best;
  for (double xi = start.xi + step; std::abs(xi) <= kLargestXi; xi += step) {
    const std::optional<Fit> fit = MoveXi(curve, walk.back().shape, xi);
    if (!fit) break;
    walk.push_back(*fit);
  }
  for (std::size_t i = 1; i + 1 < walk.size(); ++i) {
    if (walk[i].rms >= walk[i - 1].rms || walk[i].rms > walk[i + 1].rms) continue;
    const std::optional<Fit> fit = curve.Approach(walk[i].shape, true);
    if (!fit || std::abs(fit->shape.xi - start.xi) < kLeastApart) continue;
    if (!best || fit->rms < best->rms) best = fit;
  }
  return best;
}

}  // namespace

std::optional<CameraIntrinsics> DoubleSphereTwin(const CameraIntrinsics& intrinsics) {
  const std::vector<double>& p = intrinsics.parameters;
  const Curve curve(intrinsics);
  if (curve.IsEmpty()) return std::nullopt;
  std::optional<Fit> best;
  for (const double step : {-kStep, kStep}) {
    const std::optional<Fit> found = WalkAlongXi(curve, {p[0], p[4], p[5]}, step);
    if (found && (!best || found->rms < best->rms)) best = found;
  }
  if (!best || best->rms > kLargestRms) return std::nullopt;
  return OfShape(intrinsics, best->shape);
}

std::optional<CameraIntrinsics> DoubleSphereOfXi(const CameraIntrinsics& intrinsics, double xi) {
  const std::vector<double>& p = intrinsics.parameters;
  const Curve curve(intrinsics);
  if (curve.IsEmpty()) return std::nullopt;
  Shape shape{p[0], p[4], p[5]};
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(xi - p[4]) / kStep)));
  for (int i = 1; i <= steps; ++i) {
    const std::optional<Fit> fit = MoveXi(curve, shape, p[4] + (xi - p[4]) * i / steps);
    if (!fit) return std::nullopt;
    shape = fit->shape;
  }
  return OfShape(intrinsics, shape);
}

}  // namespace mlic
