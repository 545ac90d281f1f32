#include "mlic_core/evaluation/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "mlic_core/common/angles.h"
#include "mlic_core/common/error.h"
#include "mlic_core/evaluation/pose_interpolation.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/geometry/wahba.h"

namespace mlic {
namespace {

constexpr TimeNs kShortestStep = 80000000;  // ns; lets sensors of 10 Hz through, jitter and all; from: guard
constexpr std::size_t kFewestPoses = 10;    // from: guard
constexpr std::size_t kFewestParts = 3;     // from: guard

struct PosePair {
  RigidTransform T_map_imu;
  RigidTransform T_world_body;
};

std::vector<PosePair> MatchedPoses(const std::vector<StampedPose>& trajectory,
                                   const std::vector<StampedPose>& reference) {
  std::vector<PosePair> pairs;
  std::size_t hint = 0;
  TimeNs last = 0;
  for (const StampedPose& stamped : reference) {
    if (!pairs.empty() && stamped.time - last < kShortestStep) continue;
    PosePair pair;
    pair.T_world_body = stamped.pose;
    if (!InterpolatePose(trajectory, stamped.time, &hint, &pair.T_map_imu)) continue;
    pairs.push_back(pair);
    last = stamped.time;
  }
  return pairs;
}

// Rotation and translation that bring the reference's positions to the IMU's (Umeyama, PAMI 1991).
RigidTransform AlignPositions(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d map = Eigen::Vector3d::Zero(), world = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    map += pair.T_map_imu.translation / static_cast<double>(pairs.size());
    world += pair.T_world_body.translation / static_cast<double>(pairs.size());
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    covariance += (pair.T_map_imu.translation - map) * (pair.T_world_body.translation - world).transpose();
  }
  RigidTransform aligned;
  aligned.rotation = Eigen::Quaterniond(WahbaRotation(covariance)).normalized();
  aligned.translation = map - aligned.rotation * world;
  return aligned;
}

// Gauss-Newton over T_map_world and the lever arm: p_imu + R_map_imu * lever = T_map_world * p_body.
// Directions that the motion does not show (the lever arm along the only axis of rotation is one with a shift
// of the world) do not move.
void AlignWithLeverArm(const std::vector<PosePair>& pairs, RigidTransform* T_map_world,
                       Eigen::Vector3d* lever_arm) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) center += pair.T_map_imu.translation / static_cast<double>(pairs.size());
  for (int iteration = 0; iteration < 15; ++iteration) {
    Eigen::Matrix<double, 9, 9> information = Eigen::Matrix<double, 9, 9>::Zero();
    Eigen::Matrix<double, 9, 1> gradient = Eigen::Matrix<double, 9, 1>::Zero();
    for (const PosePair& pair : pairs) {
      const Eigen::Vector3d in_map = *T_map_world * pair.T_world_body.translation;
      const Eigen::Vector3d residual =
          pair.T_map_imu.translation + pair.T_map_imu.rotation * *lever_arm - in_map;
      Eigen::Matrix<double, 3, 9> J;  // turn about the centre, shift, lever arm
      J << Hat(in_map - center), -Eigen::Matrix3d::Identity(), pair.T_map_imu.rotation.toRotationMatrix();
      information += J.transpose() * J;
      gradient += J.transpose() * residual;
    }
    const SymmetricEigen<Eigen::Dynamic> eigen(information);
    Eigen::Matrix<double, 9, 1> step = Eigen::Matrix<double, 9, 1>::Zero();
    for (int i = 0; i < 9; ++i) {
      // A hundredth of a metre or radian for each pose: less is not motion but noise.
      if (eigen.eigenvalues()[i] < 1e-4 * static_cast<double>(pairs.size())) continue;
      step -=
          eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(gradient) / eigen.eigenvalues()[i]);
    }
    const Eigen::Quaterniond turn = ExpQuaternion(step.head<3>());
    T_map_world->rotation = (turn * T_map_world->rotation).normalized();
    T_map_world->translation = turn * (T_map_world->translation - center) + center + step.segment<3>(3);
    *lever_arm += step.tail<3>();
    if (step.norm() < 1e-12) break;
  }
}

void MeasureAbsolute(const std::vector<PosePair>& pairs, TrajectoryError* error) {
  double translation2 = 0.0, translation = 0.0, rotation2 = 0.0;
  for (const PosePair& pair : pairs) {
    const RigidTransform estimate = pair.T_map_imu * error->T_imu_body;
    const RigidTransform truth = error->T_map_world * pair.T_world_body;
    const double distance = (estimate.translation - truth.translation).norm();
    const double angle = kDegreesPerRadian * AngleBetween(estimate.rotation, truth.rotation);
    translation2 += distance * distance;
    translation += distance;
    rotation2 += angle * angle;
    error->translation_largest = std::max(error->translation_largest, distance);
    error->rotation_largest_deg = std::max(error->rotation_largest_deg, angle);
  }
  const double count = static_cast<double>(pairs.size());
  error->translation_rms = std::sqrt(translation2 / count);
  error->translation_mean = translation / count;
  error->rotation_rms_deg = std::sqrt(rotation2 / count);
}

// Over all parts along which `way` grows by `extent`.
RelativeTrajectoryError MeasureRelative(const std::vector<PosePair>& pairs, const std::vector<double>& way,
                                        double extent, const RigidTransform& T_imu_body) {
  RelativeTrajectoryError error;
  error.extent = extent;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto end =
        std::lower_bound(way.begin() + static_cast<std::ptrdiff_t>(i), way.end(), way[i] + extent);
    if (end == way.end()) break;
    const std::size_t j = static_cast<std::size_t>(end - way.begin());
    const RigidTransform estimate =
        (pairs[i].T_map_imu * T_imu_body).Inverse() * (pairs[j].T_map_imu * T_imu_body);
    const RigidTransform truth = pairs[i].T_world_body.Inverse() * pairs[j].T_world_body;
    const RigidTransform difference = truth.Inverse() * estimate;
    error.translation_rms += difference.translation.squaredNorm();
    error.rotation_rms_deg += std::pow(kDegreesPerRadian * Log(difference.rotation).norm(), 2);
    ++error.parts;
  }
  if (error.parts == 0) return error;
  error.translation_rms = std::sqrt(error.translation_rms / static_cast<double>(error.parts));
  error.rotation_rms_deg = std::sqrt(error.rotation_rms_deg / static_cast<double>(error.parts));
  return error;
}

}  // namespace

TrajectoryError CompareTrajectories(const std::vector<StampedPose>& trajectory,
                                    const std::vector<StampedPose>& reference) {
  const std::vector<PosePair> pairs = MatchedPoses(trajectory, reference);
  if (pairs.size() < kFewestPoses) {
    throw InputError("the reference has " + std::to_string(pairs.size()) +
                     " poses 0.08 s apart or more within the trajectory, expected at least " +
                     std::to_string(kFewestPoses) +
                     "; is its clock another one, or its topic the wrong one?");
  }
  TrajectoryError error;
  error.poses = pairs.size();
  error.T_map_world = AlignPositions(pairs);
  AlignWithLeverArm(pairs, &error.T_map_world, &error.T_imu_body.translation);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PosePair& pair : pairs) {
    sum += (pair.T_map_imu.rotation.conjugate() * error.T_map_world.rotation * pair.T_world_body.rotation)
               .toRotationMatrix();
  }
  error.T_imu_body.rotation = Eigen::Quaterniond(WahbaRotation(sum)).normalized();
  MeasureAbsolute(pairs, &error);

  std::vector<double> metres{0.0}, degrees{0.0};
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    const RigidTransform step = pairs[i - 1].T_world_body.Inverse() * pairs[i].T_world_body;
    metres.push_back(metres.back() + step.translation.norm());
    degrees.push_back(degrees.back() + kDegreesPerRadian * Log(step.rotation).norm());
  }
  error.length = metres.back();
  error.turned_deg = degrees.back();
  for (const double extent : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0}) {
    const RelativeTrajectoryError part = MeasureRelative(pairs, metres, extent, error.T_imu_body);
    if (part.parts >= kFewestParts) error.over_metres.push_back(part);
  }
  for (const double extent : {10.0, 30.0, 90.0, 180.0, 360.0, 720.0, 1800.0, 3600.0}) {
    const RelativeTrajectoryError part = MeasureRelative(pairs, degrees, extent, error.T_imu_body);
    if (part.parts >= kFewestParts) error.over_degrees.push_back(part);
  }
  return error;
}

std::string TableOf(const TrajectoryError& error) {
  char line[240];
  std::snprintf(line, sizeof(line), "%zu poses, %.1f m, %.0f deg turned\n", error.poses, error.length,
                error.turned_deg);
  std::string table = line;
  const Eigen::Vector3d lever = error.T_imu_body.translation;
  const Eigen::Vector3d turn = kDegreesPerRadian * ToRollPitchYaw(error.T_imu_body.rotation);
  std::snprintf(line, sizeof(line),
                "reference body in the IMU frame: xyz %.3f %.3f %.3f m, rpy %.2f %.2f %.2f deg (fitted)\n",
                lever.x(), lever.y(), lever.z(), turn.x(), turn.y(), turn.z());
  table += line;
  std::snprintf(
      line, sizeof(line),
      "absolute, aligned: %.4f m rms, %.4f m mean, %.4f m at most; %.4f deg rms, %.4f deg at most\n",
      error.translation_rms, error.translation_mean, error.translation_largest, error.rotation_rms_deg,
      error.rotation_largest_deg);
  table += line;
  for (const RelativeTrajectoryError& part : error.over_metres) {
    std::snprintf(line, sizeof(line), "over %4.0f m:   %.4f m rms (%.3f %%), %.4f deg rms (%.5f deg/m)\n",
                  part.extent, part.translation_rms, 100.0 * part.translation_rms / part.extent,
                  part.rotation_rms_deg, part.rotation_rms_deg / part.extent);
    table += line;
  }
  for (const RelativeTrajectoryError& part : error.over_degrees) {
    std::snprintf(line, sizeof(line), "over %4.0f deg: %.4f m rms, %.4f deg rms (%.3f %%)\n", part.extent,
                  part.translation_rms, part.rotation_rms_deg, 100.0 * part.rotation_rms_deg / part.extent);
    table += line;
  }
  return table;
}

std::string CsvOf(const TrajectoryError& error) {
  char line[160];
  std::snprintf(line, sizeof(line), "absolute,,%zu,%.6f,%.6f\n", error.poses, error.translation_rms,
                error.rotation_rms_deg);
  std::string csv = "kind,extent,count,translation_rms_m,rotation_rms_deg\n" + std::string(line);
  const auto add = [&](const char* kind, const std::vector<RelativeTrajectoryError>& parts) {
    for (const RelativeTrajectoryError& part : parts) {
      std::snprintf(line, sizeof(line), "%s,%g,%zu,%.6f,%.6f\n", kind, part.extent, part.parts,
                    part.translation_rms, part.rotation_rms_deg);
      csv += line;
    }
  };
  add("per_metres", error.over_metres);
  add("per_degrees", error.over_degrees);
  return csv;
}

}  // namespace mlic
