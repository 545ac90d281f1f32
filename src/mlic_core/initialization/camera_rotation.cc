#include "mlic_core/initialization/camera_rotation.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/camera/two_view/two_view.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/geometry/wahba.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/imu/rotation_fit.h"

namespace mlic {
namespace {

// Halved and doubled together, with the errors of lenses in camera_on_trajectory.cc, the errors of its test
// (lens from the field of view, every fifth observation wrong) of up to 0.023 deg and 0.29 px become at most
// 0.027 deg and 0.34 px.
constexpr double kAgreement = 0.05;  // rad, residual beyond which a motion has no more say; from: measured
constexpr double kVisualRotationSigma = 0.01;  // rad, of a visual rotation; from: measured
constexpr double kDirectionSigma = 0.3;        // rad, of a direction of motion: the lever arm is not known
constexpr double kLeastTravel = 0.05;          // m, of the IMU, for a direction; from: guard

// Rotation vectors of IMU and camera over the same intervals, and their directions of motion in the frame at
// the interval's end.
struct Correspondences {
  std::vector<Eigen::Vector3d> imu, camera, imu_direction, camera_direction;
};

Correspondences At(const std::vector<VisualMotion>& motions, const std::vector<const SplitSpline*>& T_map_imu,
                   double offset, const Eigen::Vector3d& lever, bool with_directions) {
  Correspondences result;
  for (const VisualMotion& motion : motions) {
    const SplitSpline& trajectory = *T_map_imu[motion.drive];
    const double a = motion.time_a + offset, b = motion.time_b + offset;
    if (!trajectory.Contains(a) || !trajectory.Contains(b)) continue;
    const Eigen::Quaterniond R_a = trajectory.rotation.Rotation(a), R_b = trajectory.rotation.Rotation(b);
    result.imu.push_back(Log(Eigen::Quaterniond(R_a.conjugate() * R_b)));
    result.camera.push_back(Log(motion.R_a_b));
    if (!with_directions || motion.direction.isZero()) continue;
    const auto position = [&](double t) {
      return trajectory.position.Position(SplineBasis(trajectory.position.knots(), t));
    };
    // The gyroscope's rotations alone make a trajectory that stands still: it tells no directions.
    const Eigen::Vector3d travelled = position(b) - position(a);
    if (travelled.norm() < kLeastTravel) continue;
    const Eigen::Vector3d moved = R_b.conjugate() * (travelled + R_b * lever - R_a * lever);
    result.imu_direction.push_back(moved.normalized());
    result.camera_direction.push_back(motion.direction);
  }
  return result;
}

// Whether all offsets up to `range` off the middle have the motion within the trajectory.
bool IsWithin(const VisualMotion& motion, const SplitSpline& trajectory, double middle, double range) {
  return trajectory.Contains(std::min(motion.time_a, motion.time_b) + middle - range) &&
         trajectory.Contains(std::max(motion.time_a, motion.time_b) + middle + range);
}

// The motions of which that holds. An offset that leaves out some others would look better or worse for what
// it leaves out. All where that leaves less than half.
std::vector<VisualMotion> WithinAtAll(const std::vector<VisualMotion>& motions,
                                      const std::vector<const SplitSpline*>& T_map_imu, double middle,
                                      double range) {
  std::vector<VisualMotion> within;
  for (const VisualMotion& motion : motions) {
    if (IsWithin(motion, *T_map_imu[motion.drive], middle, range)) within.push_back(motion);
  }
  return 2 * within.size() < motions.size() ? motions : within;
}

struct Fit {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  double cost = 1e300;  // truncated squares, mean
  std::size_t count = 0;
};

// Robust rotation between corresponding vectors. scale: of the camera's rotation vectors across its axis.
Fit FitRotation(const Correspondences& c, const std::optional<ExtrinsicGuess>& guess, double scale,
                bool use_directions) {
  Fit fit;
  fit.count = c.imu.size();
  if (c.imu.empty()) return fit;
  const Eigen::Vector3d stretch(scale, scale, 1.0);
  Eigen::Matrix3d prior = Eigen::Matrix3d::Zero();
  if (guess) {
    const double sigma = guess->sigma_rotation.norm() / std::sqrt(3.0);
    prior = guess->T_imu_sensor.rotation.toRotationMatrix() / (2.0 * sigma * sigma);
  }
  std::vector<double> weights(c.imu.size(), 1.0), direction_weights(c.imu_direction.size(), 1.0);
  for (int iteration = 0; iteration < 6; ++iteration) {
    Eigen::Matrix3d profile = prior;
    for (std::size_t k = 0; k < c.imu.size(); ++k) {
      profile += weights[k] / (kVisualRotationSigma * kVisualRotationSigma) * c.imu[k] *
                 c.camera[k].cwiseProduct(stretch).transpose();
    }
    for (std::size_t k = 0; k < c.imu_direction.size() && use_directions; ++k) {
      profile += direction_weights[k] / (kDirectionSigma * kDirectionSigma) * c.imu_direction[k] *
                 c.camera_direction[k].transpose();
    }
    fit.rotation = Eigen::Quaterniond(WahbaRotation(profile));
    fit.cost = 0.0;
    for (std::size_t k = 0; k < c.imu.size(); ++k) {
      const double error = (c.imu[k] - fit.rotation * c.camera[k].cwiseProduct(stretch)).norm();
      fit.cost += std::min(error * error, kAgreement * kAgreement);
      // Lets all speak at first, then those that agree.
      weights[k] = iteration < 2 ? AbsoluteWeight(error, kVisualRotationSigma)
                                 : TukeyWeight(error, kVisualRotationSigma);
    }
    for (std::size_t k = 0; k < c.imu_direction.size(); ++k) {
      const double error = (c.imu_direction[k] - fit.rotation * c.camera_direction[k]).norm();
      direction_weights[k] = AbsoluteWeight(error, kDirectionSigma);
    }
  }
  fit.cost /= static_cast<double>(fit.count);
  return fit;
}

// How well rotations tell the time offset: by how they would change with it.
double OffsetSigma(const std::vector<VisualMotion>& motions, const std::vector<const SplitSpline*>& T_map_imu,
                   double offset) {
  constexpr double kStep = 0.05;  // s; from: guard, motion is even for so long
  double squares = 1e-12;
  for (const VisualMotion& motion : motions) {
    const auto turned = [&](double later) {
      const So3Spline& rotation = T_map_imu[motion.drive]->rotation;
      return Log(Eigen::Quaterniond(rotation.Rotation(motion.time_a + offset + later).conjugate() *
                                    rotation.Rotation(motion.time_b + offset + later)));
    };
    if (!IsWithin(motion, *T_map_imu[motion.drive], offset, kStep)) continue;
    squares += ((turned(kStep) - turned(-kStep)) / (2.0 * kStep)).squaredNorm();
  }
  return kVisualRotationSigma / std::sqrt(squares);
}

// By how much longer the camera's rotation vectors must be made across its axis to fit the IMU's.
double FocalRatio(const Correspondences& c, const Eigen::Quaterniond& R_imu_camera) {
  double numerator = 0.0, denominator = 0.0;
  for (int iteration = 0; iteration < 3; ++iteration) {
    const double ratio = denominator > 0.0 ? numerator / denominator : 1.0;
    numerator = denominator = 0.0;
    for (std::size_t k = 0; k < c.imu.size(); ++k) {
      const Eigen::Vector3d truth = R_imu_camera.conjugate() * c.imu[k];
      const double error = (c.camera[k].head<2>() - ratio * truth.head<2>()).norm();
      const double weight = AbsoluteWeight(error, kVisualRotationSigma);
      numerator += weight * truth.head<2>().dot(c.camera[k].head<2>());
      denominator += weight * truth.head<2>().squaredNorm();
    }
  }
  // Turns of 0.5 rad in all, in the root of squares, show the ratio to some per cent.
  return denominator > 0.25 ? std::clamp(numerator / denominator, 0.6, 1.6) : 1.0;
}

}  // namespace

std::vector<VisualMotion> VisualMotions(const std::vector<PixelMatches>& pairs,
                                        const CameraIntrinsics& intrinsics, double largest_error) {
  TwoViewOptions options;
  options.largest_error = largest_error / intrinsics.parameters[0];
  std::vector<std::optional<TwoViewGeometry>> geometries(pairs.size());
  ParallelFor(pairs.size(), [&](std::size_t k) {
    std::vector<Eigen::Vector3d> bearings_a, bearings_b;
    for (std::size_t i = 0; i < pairs[k].pixels_a.size(); ++i) {
      Eigen::Vector3d a, b;
      if (!Unproject(intrinsics, pairs[k].pixels_a[i], &a)) continue;
      if (!Unproject(intrinsics, pairs[k].pixels_b[i], &b)) continue;
      bearings_a.push_back(a);
      bearings_b.push_back(b);
    }
    geometries[k] = EstimateTwoView(bearings_a, bearings_b, options);
  });
  std::vector<VisualMotion> motions;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (!geometries[k]) continue;
    VisualMotion motion{
        pairs[k].drive, pairs[k].time_a, pairs[k].time_b, geometries[k]->R_b_a.transpose(), {}};
    // The first camera's centre stands at t_b_a in frame b: the camera came from there.
    motion.direction = -geometries[k]->t_b_a;
    motions.push_back(motion);
  }
  return motions;
}

CameraRotation AlignCameraRotation(const std::vector<VisualMotion>& motions,
                                   const std::vector<const SplitSpline*>& T_map_imu,
                                   const std::optional<ExtrinsicGuess>& guess,
                                   const std::optional<double>& time_offset) {
  CameraRotation result;
  constexpr std::size_t kFewest = 10;  // from: guard
  if (motions.size() < kFewest) return result;
  const Eigen::Vector3d lever = guess ? guess->T_imu_sensor.translation : Eigen::Vector3d::Zero();
  const double middle = time_offset.value_or(0.0);
  double scale = 1.0;
  bool use_directions = false;
  double best_offset = middle;
  // The search is wide first, then narrower about the best; the focal length's ratio is found on the way.
  // from: definition, offsets up to 1 s; then three steps of the level before and more.
  constexpr double kRanges[] = {1.0, 0.04, 0.04, 0.006};
  // from: guard, the last is refined by the solve.
  constexpr double kSteps[] = {0.01, 0.002, 0.002, 0.0005};
  Fit best;
  for (int level = 0; level < 4; ++level) {
    const double range = kRanges[level], step = kSteps[level], centre = best_offset;
    const std::vector<VisualMotion> compared = WithinAtAll(motions, T_map_imu, centre, range);
    const int count = 2 * static_cast<int>(std::lround(range / step)) + 1;
    std::vector<Fit> fits(count);
    ParallelFor(count, [&](std::size_t i) {
      const double offset = centre - range + step * static_cast<double>(i);
      fits[i] =
          FitRotation(At(compared, T_map_imu, offset, lever, use_directions), guess, scale, use_directions);
    });
    best = Fit();
    for (int i = 0; i < count; ++i) {
      // Offsets that push much of the drive off the trajectory are no better for what they leave out.
      if (2 * fits[i].count < motions.size() || fits[i].count < kFewest || fits[i].cost >= best.cost)
        continue;
      best = fits[i];
      best_offset = centre - range + step * i;
    }
    if (best.count == 0) return result;
    const Correspondences c = At(motions, T_map_imu, best_offset, lever, false);
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& v : c.imu) information += v * v.transpose();
    const SymmetricEigen<3> eigen(information);
    result.weakest_axis = std::sqrt(std::max(0.0, eigen.eigenvalues()[1])) / kVisualRotationSigma;
    use_directions = result.weakest_axis < kWeakAxis;
    result.focal_ratio = FocalRatio(c, best.rotation);
    scale = 1.0 / result.focal_ratio;
  }
  const Correspondences c = At(motions, T_map_imu, best_offset, lever, false);
  std::vector<double> errors;
  std::size_t inliers = 0;
  const Eigen::Quaterniond unstretched = FitRotation(c, guess, 1.0, false).rotation;
  for (std::size_t k = 0; k < c.imu.size(); ++k) {
    const Eigen::Vector3d stretched = c.camera[k].cwiseProduct(Eigen::Vector3d(scale, scale, 1.0));
    errors.push_back((c.imu[k] - best.rotation * stretched).norm());
    inliers += errors.back() < kAgreement;
    const double plain = (c.imu[k] - unstretched * c.camera[k]).squaredNorm();
    result.cost += std::min(plain, kAgreement * kAgreement) / static_cast<double>(c.imu.size());
  }
  result.valid = true;
  result.R_imu_camera = best.rotation;
  result.time_offset = best_offset;
  result.offset_sigma = OffsetSigma(motions, T_map_imu, best_offset);
  result.residual = Median(errors);
  result.inlier_share = static_cast<double>(inliers) / static_cast<double>(errors.size());
  return result;
}

}  // namespace mlic
