#include "mlic_core/summary/snapshot.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/summary/camera_views.h"

namespace mlic {
namespace {

constexpr std::size_t kMostLandmarks = 50000;  // from: guard, what RViz draws fluently

}  // namespace

RigidTransform MapOrigin(const SplitSpline& trajectory) {
  const RigidTransform first = trajectory.Pose(trajectory.Start());
  const Eigen::Vector3d x_axis = first.rotation * Eigen::Vector3d::UnitX();
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(-std::atan2(x_axis.y(), x_axis.x()), Eigen::Vector3d::UnitZ()));
  return {turn, -(turn * first.translation)};
}

std::vector<StampedPose> SampleTrajectory(const Drive& drive, const SplitSpline& trajectory,
                                          const RigidTransform& origin, double period) {
  std::vector<StampedPose> poses;
  const int count = static_cast<int>(std::floor((trajectory.End() - trajectory.Start()) / period)) + 1;
  for (int k = 0; k < count; ++k) {
    const double t = trajectory.Start() + k * period;
    poses.push_back({TimeFrom(drive.epoch, t), origin * trajectory.Pose(t)});
  }
  return poses;
}

std::vector<MapPoint> SampleMap(const CalibrationState& state, const PlaneAssociation& planes,
                                const RigidTransform& origin, std::size_t largest) {
  const SplitSpline& trajectory = state.drives[0].trajectory;
  const std::size_t stride = std::max<std::size_t>(1, (planes.observations.size() + largest - 1) / largest);
  std::vector<MapPoint> points;
  std::size_t plane = 0;
  for (std::size_t k = 0; k < planes.observations.size(); k += stride) {
    while (planes.begin[plane + 1] <= k) ++plane;
    const PlaneObservation& o = planes.observations[k];
    const double t = state.lidars[o.lidar].OnImuClock(o.time, trajectory.Middle());
    if (!trajectory.Contains(t)) continue;
    MapPoint point;
    point.position =
        (origin * (trajectory.Pose(t) * (state.lidars[o.lidar].T_imu_sensor * o.position.cast<double>())))
            .cast<float>();
    point.intensity = o.intensity;
    point.lidar = o.lidar;
    point.plane = static_cast<int>(plane);
    points.push_back(point);
  }
  return points;
}

namespace {

std::size_t CameraOf(const CameraView& view, const Rig& rig) {
  const auto found = std::find_if(rig.cameras.begin(), rig.cameras.end(),
                                  [&](const CameraConfig& camera) { return camera.name == view.camera; });
  return static_cast<std::size_t>(found - rig.cameras.begin());
}

// T_map_camera; a little outside the span that of its end.
RigidTransform PoseAtExposure(const CameraView& view, const CameraCalibration& camera,
                              const SplitSpline& trajectory) {
  const double middle = view.images->Time(view.image) + 0.5 * camera.readout;
  const double time = camera.sensor.OnImuClock(middle, trajectory.Middle());
  return trajectory.Pose(std::clamp(time, trajectory.Start(), trajectory.End())) * camera.sensor.T_imu_sensor;
}

// What is known without a solve.
CalibrationSnapshot Show(const Rig& rig, const Dataset& dataset, const CalibrationState& state,
                         const PlaneAssociation& planes, const LandmarkSet& landmarks) {
  CalibrationSnapshot snapshot;
  for (const LidarConfig& lidar : rig.lidars) {
    snapshot.sensor_names.push_back(lidar.name);
    snapshot.sensor_frames.push_back(lidar.frame_id.empty() ? lidar.name : lidar.frame_id);
  }
  snapshot.sensors = state.lidars;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const CameraConfig& camera = rig.cameras[c];
    snapshot.sensor_names.push_back(camera.name);
    snapshot.sensor_frames.push_back(camera.frame_id.empty() ? camera.name : camera.frame_id);
    snapshot.sensors.push_back(state.cameras[c].sensor);
    snapshot.intrinsics.push_back(state.cameras[c].intrinsics);
  }
  const RigidTransform origin = MapOrigin(state.drives[0].trajectory);
  snapshot.trajectory = SampleTrajectory(dataset.drives[0], state.drives[0].trajectory, origin, 0.1);
  snapshot.points = SampleMap(state, planes, origin, 100000);
  for (const MapPlane& plane : planes.planes) {
    snapshot.planes.push_back({origin * plane.center, origin.rotation * plane.plane.normal,
                               origin.rotation * plane.axis_u, origin.rotation * plane.axis_v});
  }
  snapshot.landmarks = MarkLandmarks(landmarks, state, origin, kMostLandmarks);
  snapshot.views = ChooseViews(rig, dataset.drives[0], state, landmarks);
  for (const CameraView& view : snapshot.views) {
    const std::size_t c = CameraOf(view, rig);
    snapshot.view_poses.push_back(origin *
                                  PoseAtExposure(view, state.cameras[c], state.drives[0].trajectory));
  }
  return snapshot;
}

}  // namespace

CalibrationSnapshot MakeSnapshot(const std::string& stage, int iteration, const Rig& rig,
                                 const Dataset& dataset, const Adjustment& adjustment) {
  const DriveTerms& drive = adjustment.problem.drives[0];
  CalibrationSnapshot snapshot = Show(rig, dataset, adjustment.state, drive.planes, drive.landmarks);
  snapshot.stage = stage;
  snapshot.iteration = iteration;
  snapshot.cost = adjustment.last_solve.last_cost;
  if (adjustment.last_solve.solved) snapshot.mean_square = MeanSquaredResidual(adjustment, dataset);
  if (adjustment.last_solve.information.size() > 0) snapshot.sigmas = Analyze(adjustment, dataset).sigmas;
  return snapshot;
}

CalibrationSnapshot MakeSnapshotOfCameras(const std::string& stage, const Rig& rig, const Dataset& dataset,
                                          const Adjustment& adjustment,
                                          const std::vector<CameraCalibration>& cameras,
                                          const LandmarkSet& landmarks) {
  CalibrationState state = adjustment.state;
  state.cameras = cameras;
  CalibrationSnapshot snapshot = Show(rig, dataset, state, adjustment.problem.drives[0].planes, landmarks);
  snapshot.stage = stage;
  snapshot.after_solve = false;
  return snapshot;
}

}  // namespace mlic
