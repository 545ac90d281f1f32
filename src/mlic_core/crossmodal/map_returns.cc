#include "mlic_core/crossmodal/map_returns.h"

#include <algorithm>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// Poses of a LiDAR over one scan, tabulated: between entries matrices are interpolated linearly, which is off
// by (angle between entries)^2 / 8, below 1e-5 rad at 500 deg/s.
class ScanPoses {
 public:
  ScanPoses(const SplitSpline& trajectory, const RigidTransform& T_imu_lidar, double start, double end)
      : start_(start) {
    const int count = 2 + static_cast<int>((end - start) / kStep);
    for (int k = 0; k < count; ++k) {
      const RigidTransform T = trajectory.Pose(start + k * kStep) * T_imu_lidar;
      rotations_.push_back(T.rotation.toRotationMatrix());
      translations_.push_back(T.translation);
    }
  }

  void Place(double time, const Eigen::Vector3f& point, MapReturn* out) const {
    const double position = std::clamp((time - start_) / kStep, 0.0, rotations_.size() - 1.001);
    const int k = static_cast<int>(position);
    const double share = position - k;
    const Eigen::Vector3d p = point.cast<double>();
    const Eigen::Vector3d beam = (1.0 - share) * (rotations_[k] * p) + share * (rotations_[k + 1] * p);
    out->beam = beam.cast<float>();
    out->position = (beam + (1.0 - share) * translations_[k] + share * translations_[k + 1]).cast<float>();
  }

 private:
  static constexpr double kStep = 1e-3;  // s; from: structural, poses between are interpolated
  double start_;
  std::vector<Eigen::Matrix3d> rotations_;
  std::vector<Eigen::Vector3d> translations_;
};

// Uniform in [0, 1), from the number of a scan and of a point in it (splitmix64's last step).
double Draw(std::size_t scan, std::size_t point) {
  std::uint64_t z = ((static_cast<std::uint64_t>(scan) << 32) + point + 1) * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

}  // namespace

std::vector<MapReturn> CollectReturns(const Drive& drive, const SplitSpline& trajectory,
                                      const std::vector<SensorCalibration>& lidars, std::size_t largest_count,
                                      const std::optional<TimeInterval>& window,
                                      const PointCorrection& correction, const std::vector<bool>& left_out) {
  std::vector<std::pair<std::size_t, std::size_t>> scans;  // LiDAR, scan
  std::size_t total = 0;
  for (std::size_t l = 0; l < drive.lidars.size(); ++l) {
    if (!left_out.empty() && left_out[l]) continue;
    for (std::size_t s = 0; s < drive.lidars[l].scans.size(); ++s) {
      const LidarScan& scan = drive.lidars[l].scans[s];
      if (scan.points.empty() ||
          (window && !window->Contains(lidars[l].OnImuClock(scan.time, trajectory.Middle())))) {
        continue;
      }
      scans.emplace_back(l, s);
      total += scan.points.size();
    }
  }
  const double share =
      static_cast<double>(largest_count) / static_cast<double>(std::max<std::size_t>(1, total));
  std::vector<std::vector<MapReturn>> parts(scans.size());
  ParallelFor(scans.size(), [&](std::size_t k) {
    const auto [l, s] = scans[k];
    const LidarScan& scan = drive.lidars[l].scans[s];
    const double clock = lidars[l].OnImuClock(scan.time, trajectory.Middle());
    const auto [first, last] =
        std::minmax_element(scan.points.begin(), scan.points.end(),
                            [](const LidarPoint& a, const LidarPoint& b) { return a.time < b.time; });
    const double start = std::max(clock + first->time, trajectory.Start());
    const double end = std::min(clock + last->time, trajectory.End());
    if (end < start) return;
    const ScanPoses poses(trajectory, lidars[l].T_imu_sensor, start, end);
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      const LidarPoint& point = scan.points[i];
      if (Draw(k, i) >= share || !trajectory.Contains(clock + point.time)) continue;
      MapReturn r;
      poses.Place(clock + point.time, correction ? correction(l, point) : point.position, &r);
      r.intensity = point.intensity;
      r.ring = point.ring;
      r.lidar = static_cast<std::uint16_t>(l);
      r.time = scan.time + point.time;
      parts[k].push_back(r);
    }
  });
  std::vector<MapReturn> returns;
  std::size_t count = 0;
  for (const auto& part : parts) count += part.size();
  returns.reserve(count);
  for (auto& part : parts) {
    returns.insert(returns.end(), part.begin(), part.end());
    part = {};
  }
  return returns;
}

}  // namespace mlic
