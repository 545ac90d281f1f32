#include "mlic_core/problem/partial_problem.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mlic {
namespace {

constexpr std::size_t kFewestOfPlane = 4;  // from: derivation, a plane has three parameters

template <typename Spline>
Spline CutSpline(const Spline& spline, const TimeInterval& stretch) {
  const UniformKnots& knots = spline.knots();
  const auto segment = [&](double time, auto round, int least) {
    const double at = round((time - knots.start) / knots.spacing);
    return static_cast<int>(
        std::clamp(at, static_cast<double>(least), static_cast<double>(knots.Segments())));
  };
  const int first = std::min(segment(
                                 stretch.start, [](double v) { return std::floor(v); }, 0),
                             knots.Segments() - 1);
  const int end = segment(
      stretch.end, [](double v) { return std::ceil(v); }, first + 1);
  auto points = spline.control_points();
  points.erase(points.begin() + end + 3, points.end());
  points.erase(points.begin(), points.begin() + first);
  const UniformKnots cut{knots.start + first * knots.spacing, knots.spacing, end - first + 3};
  return Spline(cut, std::move(points));
}

PlaneAssociation PlanesOf(const PlaneAssociation& whole, const CalibrationState& state,
                          const DriveStretch& stretch) {
  PlaneAssociation planes;
  planes.begin = {0};
  for (std::size_t p = 0; p < whole.planes.size(); ++p) {
    for (std::size_t k = whole.begin[p]; k < whole.begin[p + 1]; ++k) {
      const SensorCalibration& lidar = state.lidars[whole.observations[k].lidar];
      if (!stretch.Contains(lidar, whole.observations[k].time)) continue;
      planes.observations.push_back(whole.observations[k]);
      planes.observations.back().time = stretch.Shifted(lidar, whole.observations[k].time);
    }
    if (planes.observations.size() - planes.begin.back() < kFewestOfPlane) {
      planes.observations.resize(planes.begin.back());
      continue;
    }
    planes.planes.push_back(whole.planes[p]);
    planes.begin.push_back(planes.observations.size());
  }
  return planes;
}

LandmarkSet LandmarksOf(const LandmarkSet& whole, const CalibrationState& state,
                        const DriveStretch& stretch) {
  LandmarkSet landmarks;
  landmarks.begin = {0};
  for (std::size_t p = 0; p < whole.points.size(); ++p) {
    const bool on_map = whole.IsOnMap(p);
    LidarPointObservation measured;
    if (!whole.lidar_points.empty()) measured = whole.lidar_points[p];
    if (on_map) {
      const SensorCalibration& lidar = state.lidars[measured.lidar];
      if (!stretch.Contains(lidar, measured.time)) continue;
      measured.time = stretch.Shifted(lidar, measured.time);
    }
    for (std::size_t k = whole.begin[p]; k < whole.begin[p + 1]; ++k) {
      const LandmarkObservation& observation = whole.observations[k];
      const SensorCalibration& camera = state.cameras[observation.camera].sensor;
      if (!stretch.Contains(camera, observation.time)) continue;
      landmarks.observations.push_back(observation);
      landmarks.observations.back().time = stretch.Shifted(camera, observation.time);
    }
    if (landmarks.observations.size() - landmarks.begin.back() < (on_map ? 1 : kFewestOfPoint)) {
      landmarks.observations.resize(landmarks.begin.back());
      continue;
    }
    landmarks.points.push_back(whole.points[p]);
    if (!whole.lidar_points.empty()) landmarks.lidar_points.push_back(measured);
    landmarks.begin.push_back(landmarks.observations.size());
  }
  return landmarks;
}

}  // namespace

double DriveStretch::Shifted(const SensorCalibration& sensor, double time) const {
  const double drift = sensor.clock_drift.value_or(0.0);
  return time + drift / (1.0 + drift) * (middle - whole_middle);
}

PartialProblem::PartialProblem(const JointProblem& whole, const CalibrationState& whole_state,
                               const std::vector<TimeInterval>& intervals)
    : state(whole_state) {
  problem.lidars = whole.lidars;
  problem.cameras = whole.cameras;
  problem.estimate_imu_matrices = whole.estimate_imu_matrices;
  problem.imu = whole.imu;
  problem.held_translations = whole.held_translations;
  problem.dataset = &dataset;
  for (std::size_t d = 0; d < intervals.size(); ++d) {
    SplitSpline& trajectory = state.drives[d].trajectory;
    const double whole_middle = trajectory.Middle();
    trajectory.rotation = CutSpline(trajectory.rotation, intervals[d]);
    trajectory.position = CutSpline(trajectory.position, intervals[d]);
    stretches.push_back({intervals[d], whole_middle, trajectory.Middle()});
    const Drive& drive = whole.dataset->drives[d];
    dataset.drives.emplace_back().epoch = drive.epoch;
    std::copy_if(drive.imu.begin(), drive.imu.end(), std::back_inserter(dataset.drives.back().imu),
                 [&](const ImuSample& sample) { return intervals[d].Contains(sample.time); });
    DriveTerms& terms = problem.drives.emplace_back();
    terms.imu_sigma = whole.drives[d].imu_sigma;
    terms.bias_steps = whole.drives[d].bias_steps;
    terms.planes = PlanesOf(whole.drives[d].planes, whole_state, stretches[d]);
    terms.landmarks = LandmarksOf(whole.drives[d].landmarks, whole_state, stretches[d]);
  }
}

}  // namespace mlic
