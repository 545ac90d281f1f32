#include "mlic_core/association/plane_association.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/association/group_errors.h"
#include "mlic_core/association/ring_corrections.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/problem/plane_terms.h"
#include "mlic_core/problem/time_windows.h"

namespace mlic {
namespace {

constexpr double kMostPlanes = 2000.0;  // for each stretch of kLongestCoupling; from: guard, time and memory

struct ScanSamples {
  std::vector<MapSample> samples;
};

void DrawScan(const LidarScan& scan, const SplitSpline& trajectory, const CalibrationState& state, int lidar,
              int scan_index, std::size_t largest, ScanSamples* out) {
  const SensorCalibration& calibration = state.lidars[lidar];
  const std::size_t stride = std::max<std::size_t>(1, (scan.points.size() + largest - 1) / largest);
  const Eigen::Matrix3d R_imu_lidar = calibration.T_imu_sensor.rotation.toRotationMatrix();
  const double middle = trajectory.Middle();
  // Another phase of the stride in each scan, so that the same ring is not taken always.
  for (std::size_t i = static_cast<std::size_t>(scan_index) % stride; i < scan.points.size(); i += stride) {
    const LidarPoint& point = scan.points[i];
    const double t = calibration.OnImuClock(scan.time + point.time, middle);
    if (!trajectory.Contains(t)) continue;
    const So3Spline::Value rotation =
        trajectory.rotation.Evaluate(SplineBasis(trajectory.rotation.knots(), t));
    const Eigen::Vector3d position =
        trajectory.position.Position(SplineBasis(trajectory.position.knots(), t));
    const Eigen::Vector3d arm = R_imu_lidar * CorrectedPoint(point, state, lidar).cast<double>();
    MapSample sample;
    sample.position =
        (rotation.rotation * (arm + calibration.T_imu_sensor.translation) + position).cast<float>();
    sample.view = (rotation.rotation * -arm.normalized()).cast<float>();
    sample.time = t;
    sample.lidar = lidar;
    sample.scan = scan_index;
    sample.index = static_cast<std::int32_t>(i);
    out->samples.push_back(sample);
  }
}

std::vector<MapSample> DrawMap(const Drive& drive, const CalibrationState& state, std::size_t drive_index,
                               const AssociationOptions& options) {
  std::vector<std::pair<int, int>> scans;
  for (std::size_t l = 0; l < drive.lidars.size(); ++l) {
    if (!options.lidars.empty() && !options.lidars[l]) continue;
    for (std::size_t s = 0; s < drive.lidars[l].scans.size(); ++s) scans.emplace_back(l, s);
  }
  std::vector<ScanSamples> parts(scans.size());
  ParallelFor(scans.size(), [&](std::size_t k) {
    const auto [lidar, scan] = scans[k];
    DrawScan(drive.lidars[lidar].scans[scan], state.drives[drive_index].trajectory, state, lidar, scan,
             options.points_per_scan, &parts[k]);
  });
  std::vector<MapSample> samples;
  std::size_t count = 0;
  for (const ScanSamples& part : parts) count += part.samples.size();
  samples.reserve(count);
  for (ScanSamples& part : parts) {
    samples.insert(samples.end(), part.samples.begin(), part.samples.end());
    part.samples = {};
  }
  return samples;
}

}  // namespace

double RootVoxelSize(const Drive& drive) {
  std::vector<float> ranges;
  for (const LidarRecording& lidar : drive.lidars) {
    const LidarScan& scan = lidar.scans[lidar.scans.size() / 2];
    for (std::size_t i = 0; i < scan.points.size(); i += 7) ranges.push_back(scan.points[i].position.norm());
  }
  if (ranges.empty()) return 2.0;
  const auto far = ranges.begin() + ranges.size() * 9 / 10;
  std::nth_element(ranges.begin(), far, ranges.end());
  return std::clamp(0.1 * *far, 1.0, 2.0);
}

PlaneAssociation AssociatePlanes(const Drive& drive, const CalibrationState& state, std::size_t drive_index,
                                 const std::vector<PlaneNoise>& noise, const AssociationOptions& options) {
  const std::vector<MapSample> samples = DrawMap(drive, state, drive_index, options);
  PlaneMapOptions map_options;
  map_options.root_voxel = options.root_voxel;
  map_options.longest = kLongestCoupling;
  map_options.last_voxels = options.last_voxels;
  const SplitSpline& trajectory = state.drives[drive_index].trajectory;
  const double stretches = std::max(1.0, (trajectory.End() - trajectory.Start()) / kLongestCoupling);
  map_options.largest_count = static_cast<std::size_t>(kMostPlanes * stretches);
  PlaneAssociation association;
  association.planes = BuildPlaneMap(samples, noise, map_options);
  association.begin.push_back(0);
  for (const MapPlane& plane : association.planes) {
    association.begin.push_back(association.begin.back() + plane.samples.size());
  }
  association.observations.resize(association.begin.back());
  ParallelFor(association.planes.size(), [&](std::size_t p) {
    const MapPlane& plane = association.planes[p];
    for (std::size_t i = 0; i < plane.samples.size(); ++i) {
      const MapSample& sample = samples[plane.samples[i]];
      const LidarScan& scan = drive.lidars[sample.lidar].scans[sample.scan];
      const LidarPoint& point = scan.points[sample.index];
      const double cosine = plane.plane.normal.dot(sample.view.cast<double>());
      PlaneObservation& o = association.observations[association.begin[p] + i];
      o.position = CorrectedPoint(point, state, sample.lidar);
      o.ring = point.ring;
      o.cos_incidence = static_cast<float>(cosine);
      o.intensity = point.intensity;
      o.sigma = static_cast<float>(noise[sample.lidar].Sigma(cosine) * plane.inflation / cosine);
      o.lidar = sample.lidar;
      o.time = scan.time + point.time;
    }
    WeighGroups(noise, p, &association);
  });
  for (MapPlane& plane : association.planes) {
    plane.samples.clear();
    plane.samples.shrink_to_fit();
  }
  return association;
}

std::vector<PlaneNoise> MeasurePlaneNoise(const std::vector<DriveTerms>& drives,
                                          const CalibrationState& state,
                                          const std::vector<PlaneNoise>& last) {
  constexpr int kBins = 6;              // from: structural
  constexpr std::size_t kFewest = 200;  // from: guard
  constexpr double kLeast = 1e-4;       // m: below what the spline itself leaves over; from: guard
  const std::size_t lidars = last.size();
  std::vector<std::vector<float>> sizes(lidars * kBins), cosines(lidars * kBins);
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const PlaneAssociation& association = drives[d].planes;
    const std::vector<float> residuals = PlaneResiduals(association, state, d);
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      const PlaneObservation& o = association.observations[k];
      const float squared = o.cos_incidence * o.cos_incidence;
      const int bin = std::min(kBins - 1, static_cast<int>(squared * kBins));
      sizes[o.lidar * kBins + bin].push_back(std::abs(residuals[k] * o.cos_incidence));
      cosines[o.lidar * kBins + bin].push_back(squared);
    }
  }
  std::vector<PlaneNoise> noise = last;
  for (std::size_t l = 0; l < lidars; ++l) {
    // Relative errors of the variances are alike, so the fit is weighted by variance: two rounds.
    std::vector<Eigen::Vector3d> bins;  // cos^2, variance, count
    for (int b = 0; b < kBins; ++b) {
      auto& values = sizes[l * kBins + b];
      if (values.size() < kFewest) continue;
      double cosine = 0.0;
      for (const float c : cosines[l * kBins + b]) cosine += c;
      const double sigma = 1.4826 * Median(values);
      bins.emplace_back(cosine / values.size(), sigma * sigma, static_cast<double>(values.size()));
    }
    if (bins.empty()) continue;
    double a = 0.0, f = 0.0;
    for (int round = 0; round < 3; ++round) {
      Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
      Eigen::Vector2d g = Eigen::Vector2d::Zero();
      for (const Eigen::Vector3d& bin : bins) {
        const double model = round == 0 ? bin[1] : std::max(1e-16, a * bin[0] + f);
        const double weight = std::sqrt(bin[2]) / (model * model + 1e-24);
        const Eigen::Vector2d row(bin[0], 1.0);
        H += weight * row * row.transpose();
        g += weight * bin[1] * row;
      }
      const Eigen::Vector2d fit = H.ldlt().solve(g);
      a = fit[0];
      f = fit[1];
      if (bins.size() < 2 || a < 0.0) {
        a = 0.0;
        f = g[1] / H(1, 1);
      } else if (f < 0.0) {
        f = 0.0;
        a = g[0] / H(0, 0);
      }
    }
    const double most = 1.5 * last[l].Sigma(1.0);
    noise[l].range = std::clamp(std::sqrt(std::max(0.0, a)), std::max(0.2 * last[l].range, kLeast), most);
    noise[l].floor = std::clamp(std::sqrt(std::max(0.0, f)), std::max(0.2 * last[l].floor, kLeast), most);
  }
  return noise;
}

}  // namespace mlic
