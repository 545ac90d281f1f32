#include "ceres_reference/evaluation_point.h"

#include <utility>

namespace mlic::ceres_reference {
namespace {

PositionBlock BlockOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

EvaluationPoint::DriveBlocks ControlPoints(const SplitSpline& trajectory) {
  EvaluationPoint::DriveBlocks blocks;
  for (const Eigen::Quaterniond& q : trajectory.rotation.control_points()) {
    blocks.rotations.push_back({q.x(), q.y(), q.z(), q.w()});
  }
  for (const Eigen::Vector3d& p : trajectory.position.control_points()) {
    blocks.positions.push_back(BlockOf(p));
  }
  return blocks;
}

}  // namespace

PlaneBlock BlockOf(const MapPlane& plane) {
  const Eigen::Vector3d &n = plane.plane.normal, &c = plane.center;
  return {n.x(), n.y(), n.z(), plane.plane.offset, c.x(), c.y(), c.z()};
}

PointBlock BlockOf(const PointLandmark& point) {
  const Eigen::Vector3d &p = point.position, &a = point.anchor;
  return {p.x(), p.y(), p.z(), a.x(), a.y(), a.z()};
}

MapPlane PlaneOf(const double* block) {
  MapPlane plane;
  plane.plane.normal = Eigen::Vector3d(block[0], block[1], block[2]);
  plane.plane.offset = block[3];
  plane.center = Eigen::Vector3d(block[4], block[5], block[6]);
  return plane;
}

PointLandmark PointOf(const double* block) {
  return {Eigen::Vector3d(block[0], block[1], block[2]), Eigen::Vector3d(block[3], block[4], block[5])};
}

EvaluationPoint::EvaluationPoint(const CalibrationState& start, const std::vector<DriveTerms>& terms)
    : state(start) {
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    drives.push_back(ControlPoints(state.drives[d].trajectory));
    for (const MapPlane& plane : terms[d].planes.planes) drives[d].planes.push_back(BlockOf(plane));
    for (const PointLandmark& point : terms[d].landmarks.points) drives[d].points.push_back(BlockOf(point));
  }
  PrepareForEvaluation(true, true);
}

void EvaluationPoint::PrepareForEvaluation(bool, bool) {
  for (std::size_t d = 0; d < drives.size(); ++d) {
    std::vector<Eigen::Quaterniond> rotations;
    std::vector<Eigen::Vector3d> positions;
    for (const RotationBlock& q : drives[d].rotations) rotations.emplace_back(q[3], q[0], q[1], q[2]);
    for (const PositionBlock& p : drives[d].positions) positions.emplace_back(p[0], p[1], p[2]);
    SplitSpline& trajectory = state.drives[d].trajectory;
    trajectory.rotation = So3Spline(trajectory.rotation.knots(), std::move(rotations));
    trajectory.position = PositionSpline(trajectory.position.knots(), std::move(positions));
  }
  lidars.clear();
  for (const SensorCalibration& lidar : state.lidars) {
    lidars.push_back({lidar.T_imu_sensor.rotation.toRotationMatrix(), lidar.T_imu_sensor.translation});
  }
  cameras.clear();
  for (const CameraCalibration& camera : state.cameras) {
    const RigidTransform& T = camera.sensor.T_imu_sensor;
    cameras.push_back({T.rotation.toRotationMatrix(), T.translation, &camera.intrinsics});
  }
}

}  // namespace mlic::ceres_reference
