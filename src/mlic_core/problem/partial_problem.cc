#include "mlic_core/problem/partial_problem.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace mlic {
namespace {

constexpr std::size_t kFewestOfPlane = 4;  // from: derivation, a plane has three parameters
constexpr std::size_t kFewestOfPoint = 2;  // from: derivation, one says nothing about anything else

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

// One drive's stretch. Clocks' offsets belong to the middle of the trajectory, which is another one in the
// part: where a clock drifts, its times are shifted so that the offset stays the same number.
struct Part {
  const CalibrationState& whole;
  TimeInterval stretch;
  double middle;       // of the whole drive
  double part_middle;  // of the part

  bool Contains(const SensorCalibration& sensor, double time) const {
    return stretch.Contains(sensor.OnImuClock(time, middle));
  }
  double Shifted(const SensorCalibration& sensor, double time) const {
    const double drift = sensor.clock_drift.value_or(0.0);
    return time + drift / (1.0 + drift) * (part_middle - middle);
  }
};

PlaneAssociation PlanesOf(const PlaneAssociation& whole, const Part& part) {
  PlaneAssociation planes;
  planes.begin = {0};
  for (std::size_t p = 0; p < whole.planes.size(); ++p) {
    for (std::size_t k = whole.begin[p]; k < whole.begin[p + 1]; ++k) {
      const SensorCalibration& lidar = part.whole.lidars[whole.observations[k].lidar];
      if (!part.Contains(lidar, whole.observations[k].time)) continue;
      planes.observations.push_back(whole.observations[k]);
      planes.observations.back().time = part.Shifted(lidar, whole.observations[k].time);
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

LandmarkSet LandmarksOf(const LandmarkSet& whole, const Part& part) {
  LandmarkSet landmarks;
  landmarks.begin = {0};
  for (std::size_t p = 0; p < whole.points.size(); ++p) {
    const bool on_map = whole.IsOnMap(p);
    LidarPointObservation measured;
    if (!whole.lidar_points.empty()) measured = whole.lidar_points[p];
    if (on_map) {
      const SensorCalibration& lidar = part.whole.lidars[measured.lidar];
      if (!part.Contains(lidar, measured.time)) continue;
      measured.time = part.Shifted(lidar, measured.time);
    }
    for (std::size_t k = whole.begin[p]; k < whole.begin[p + 1]; ++k) {
      const LandmarkObservation& observation = whole.observations[k];
      const SensorCalibration& camera = part.whole.cameras[observation.camera].sensor;
      if (!part.Contains(camera, observation.time)) continue;
      landmarks.observations.push_back(observation);
      landmarks.observations.back().time = part.Shifted(camera, observation.time);
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

PartialProblem::PartialProblem(const JointProblem& whole, const CalibrationState& whole_state,
                               const std::vector<TimeInterval>& stretches)
    : state(whole_state) {
  problem.lidars = whole.lidars;
  problem.cameras = whole.cameras;
  problem.estimate_imu_matrices = whole.estimate_imu_matrices;
  problem.imu = whole.imu;
  problem.held_translations = whole.held_translations;
  problem.dataset = &dataset;
  for (std::size_t d = 0; d < stretches.size(); ++d) {
    SplitSpline& trajectory = state.drives[d].trajectory;
    Part part{whole_state, stretches[d], trajectory.Middle(), 0.0};
    trajectory.rotation = CutSpline(trajectory.rotation, part.stretch);
    trajectory.position = CutSpline(trajectory.position, part.stretch);
    part.part_middle = trajectory.Middle();
    const Drive& drive = whole.dataset->drives[d];
    dataset.drives.emplace_back().epoch = drive.epoch;
    std::copy_if(drive.imu.begin(), drive.imu.end(), std::back_inserter(dataset.drives.back().imu),
                 [&](const ImuSample& sample) { return part.stretch.Contains(sample.time); });
    DriveTerms& terms = problem.drives.emplace_back();
    terms.imu_sigma = whole.drives[d].imu_sigma;
    terms.planes = PlanesOf(whole.drives[d].planes, part);
    terms.landmarks = LandmarksOf(whole.drives[d].landmarks, part);
  }
}

}  // namespace mlic
