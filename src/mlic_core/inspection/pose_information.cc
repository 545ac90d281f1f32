#include "mlic_core/inspection/pose_information.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/lidar/plane_map.h"

namespace mlic {
namespace {

constexpr std::size_t kDrawn = 800;     // points of a scan that are looked at; from: guard, time
constexpr std::size_t kTaken = 2000;    // points of a scan in a calibration; from: definition, pipeline/
constexpr std::size_t kFewest = 1000;   // points on planes; from: guard
constexpr double kLongestPlane = 4.0;   // s; from: guard, odometry drifts little meanwhile
constexpr double kLeastScatter = 1e-3;  // m; from: guard
constexpr double kUnseenAngle = 0.1;    // rad, at one second; from: guard, far above what counts
constexpr double kUnseenShift = 1.0;    // m, likewise; from: guard

// At a time between two poses; nothing before the first and after the last.
std::optional<RigidTransform> PoseAt(const std::vector<TimedPose>& poses, double time) {
  const auto after = std::lower_bound(poses.begin(), poses.end(), time,
                                      [](const TimedPose& p, double t) { return p.time < t; });
  if (after == poses.begin() || after == poses.end()) return std::nullopt;
  const TimedPose& before = *std::prev(after);
  const double share = (time - before.time) / (after->time - before.time);
  RigidTransform pose;
  pose.rotation = before.pose.rotation.slerp(share, after->pose.rotation);
  pose.translation = (1.0 - share) * before.pose.translation + share * after->pose.translation;
  return pose;
}

struct DrawnPoint {
  Eigen::Vector3d position;  // in the LiDAR's frame
  Eigen::Quaterniond R_odom_lidar;
};

struct DrawnMap {
  std::vector<MapSample> samples;
  std::vector<DrawnPoint> points;  // of each sample
  double taken = 0.0;              // points that a calibration would take for these
};

void DrawScan(const LidarScan& scan, int index, const std::vector<TimedPose>& poses, DrawnMap* map) {
  const std::size_t count = scan.points.size();
  const std::size_t stride = std::max<std::size_t>(1, (count + kDrawn - 1) / kDrawn);
  std::size_t drawn = 0;
  for (std::size_t i = static_cast<std::size_t>(index) % stride; i < count; i += stride) {
    const LidarPoint& point = scan.points[i];
    const auto pose = PoseAt(poses, scan.time + point.time);
    if (!pose) continue;
    const Eigen::Vector3d position = point.position.cast<double>();
    MapSample sample;
    sample.position = (*pose * position).cast<float>();
    sample.view = (pose->rotation * -position.normalized()).cast<float>();
    sample.time = scan.time + point.time;
    sample.scan = index;
    sample.index = static_cast<std::int32_t>(i);
    map->samples.push_back(sample);
    map->points.push_back({position, pose->rotation});
    ++drawn;
  }
  const double scale = static_cast<double>(std::min(kTaken, count)) /
                       static_cast<double>(std::max<std::size_t>(1, std::min(kDrawn, count)));
  map->taken += scale * static_cast<double>(drawn);
}

double Scatter(const std::vector<MapPlane>& planes, const std::vector<MapSample>& samples) {
  std::vector<double> distances;
  for (const MapPlane& plane : planes) {
    for (const std::uint32_t i : plane.samples)
      distances.push_back(std::abs(plane.plane.SignedDistance(samples[i].position.cast<double>())));
  }
  constexpr double kSigmaOfMedian = 1.4826;  // from: derivation, of a normal distribution
  return std::max(kLeastScatter, kSigmaOfMedian * Median(std::move(distances)));
}

}  // namespace

std::optional<PoseInformation> MeasurePoseInformation(const LidarRecording& recording,
                                                      const std::vector<TimedPose>& poses) {
  if (poses.size() < 2) return std::nullopt;
  DrawnMap map;
  for (std::size_t s = 0; s < recording.scans.size(); ++s)
    DrawScan(recording.scans[s], static_cast<int>(s), poses, &map);
  PlaneMapOptions options;
  options.longest = kLongestPlane;
  const std::vector<MapPlane> planes = BuildPlaneMap(map.samples, {PlaneNoise()}, options);
  PoseInformation information = PoseInformation::Zero();
  std::size_t on_planes = 0;
  for (const MapPlane& plane : planes) {
    on_planes += plane.samples.size();
    for (const std::uint32_t i : plane.samples) {
      const DrawnPoint& point = map.points[i];
      const Eigen::Vector3d normal = point.R_odom_lidar.conjugate() * plane.plane.normal;
      Eigen::Matrix<double, 6, 1> row;
      row << point.position.cross(normal), normal;
      information += row * row.transpose();
    }
  }
  if (on_planes < kFewest) return std::nullopt;
  const double scatter = Scatter(planes, map.samples);
  const double seconds = poses.back().time - poses.front().time;
  const double scale = map.taken / static_cast<double>(map.samples.size());
  return PoseInformation(information * scale / (scatter * scatter * seconds));
}

PoseNoise TypicalPoseNoise() {
  // from: measured, on the simulated drives of the paper's rig
  constexpr double kRotation = 9.5e-6;  // rad/sqrt(Hz); from: measured, as above
  constexpr double kPosition = 9.5e-5;  // m/sqrt(Hz); from: measured, as above
  return {kRotation * kRotation * Eigen::Matrix3d::Identity(),
          kPosition * kPosition * Eigen::Matrix3d::Identity(), false};
}

PoseNoise NoiseOfPoses(const PoseInformation& information) {
  PoseInformation known = information;
  known.diagonal().head<3>().array() += 1.0 / (kUnseenAngle * kUnseenAngle);
  known.diagonal().tail<3>().array() += 1.0 / (kUnseenShift * kUnseenShift);
  const PoseInformation covariance = SolveSymmetric(known, PoseInformation::Identity());
  return {covariance.topLeftCorner<3, 3>(), covariance.bottomRightCorner<3, 3>(), true};
}

}  // namespace mlic
