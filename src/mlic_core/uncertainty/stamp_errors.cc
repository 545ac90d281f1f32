#include "mlic_core/uncertainty/stamp_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic {
namespace {

constexpr double kStep = 5e-4;  // s, of the numeric derivative; from: structural
// from: derivation, 0.3 % of normal errors lie beyond.
constexpr double kOutlier = 3.0;  // sigmas: what robust losses hardly count
constexpr double kWindow = 3.0;   // s, of the means that show wander
// from: guard, chance gives one, a few windows seldom more than three.
constexpr double kWandering = 6.0;         // mean square of windows
constexpr std::size_t kFewestScans = 20;   // that say something; from: guard
constexpr std::size_t kFewestWindows = 4;  // from: guard

void Add(double residual, double derivative, double sigma, double weight, ScanSum* sum) {
  if (std::abs(residual) > kOutlier * sigma) return;
  sum->gradient -= weight * derivative * residual / (sigma * sigma);
  sum->information += weight * derivative * derivative / (sigma * sigma);
}

CalibrationState Shifted(const CalibrationState& state, double step) {
  CalibrationState shifted = state;
  for (SensorCalibration& lidar : shifted.lidars) lidar.time_offset += step;
  for (CameraCalibration& camera : shifted.cameras) camera.sensor.time_offset += step;
  return shifted;
}

double ScanTime(const LidarRecording& lidar, double point_time) {
  const auto next = std::upper_bound(lidar.scans.begin(), lidar.scans.end(), point_time + 1e-6,
                                     [](double t, const LidarScan& scan) { return t < scan.time; });
  return next == lidar.scans.begin() ? lidar.scans.front().time : (next - 1)->time;
}

void AddPlanes(const JointProblem& problem, const CalibrationState& state, std::size_t d,
               std::vector<ScanSums>* sums) {
  const PlaneAssociation& planes = problem.drives[d].planes;
  const std::vector<float> at = PlaneResiduals(planes, state, d);
  const std::vector<float> before = PlaneResiduals(planes, Shifted(state, -kStep), d);
  const std::vector<float> after = PlaneResiduals(planes, Shifted(state, kStep), d);
  for (std::size_t k = 0; k < at.size(); ++k) {
    const PlaneObservation& o = planes.observations[k];
    const double time = ScanTime(problem.dataset->drives[d].lidars[o.lidar], o.time);
    Add(at[k], (after[k] - before[k]) / (2.0 * kStep), o.sigma, o.weight, &(*sums)[o.lidar][time]);
  }
}

void AddLandmarks(const JointProblem& problem, const CalibrationState& state, std::size_t d,
                  std::vector<ScanSums>* sums) {
  const LandmarkSet& landmarks = problem.drives[d].landmarks;
  const std::vector<Eigen::Vector2d> at = LandmarkResiduals(landmarks, state, d);
  const std::vector<Eigen::Vector2d> before = LandmarkResiduals(landmarks, Shifted(state, -kStep), d);
  const std::vector<Eigen::Vector2d> after = LandmarkResiduals(landmarks, Shifted(state, kStep), d);
  for (std::size_t k = 0; k < at.size(); ++k) {
    const LandmarkObservation& o = landmarks.observations[k];
    const Eigen::Vector2d derivative = (after[k] - before[k]) / (2.0 * kStep);
    if (!at[k].allFinite() || !derivative.allFinite()) continue;
    const Eigen::Matrix2d shape = o.shape.cast<double>();
    const Eigen::Vector2d residual = shape * at[k], slope = shape * derivative;
    ScanSum& sum = (*sums)[state.Sensors().PlaceOf(CameraId(o.camera))][o.time];
    for (int a = 0; a < 2; ++a) Add(residual[a], slope[a], o.sigma, 1.0, &sum);
  }
}

// The mean of the squares of time errors over their sigmas, of the scans or of stretches of them; one or less
// where the noise explains them.
double MeanSquare(const std::vector<ScanSum>& sums) {
  double squares = 0.0;
  for (const ScanSum& sum : sums) squares += sum.gradient * sum.gradient / sum.information;
  return squares / static_cast<double>(sums.size());
}

// Scans of kWindow each as one.
std::vector<ScanSum> InWindows(const ScanSums& scans) {
  std::vector<ScanSum> windows;
  double begin = -std::numeric_limits<double>::infinity();
  for (const auto& [time, sum] : scans) {
    if (time - begin > kWindow) {
      begin = time;
      windows.emplace_back();
    }
    windows.back().gradient += sum.gradient;
    windows.back().information += sum.information;
  }
  return windows;
}

// Of one sensor, all drives together.
StampErrors Judge(const std::vector<ScanSums>& drives) {
  const auto without = [](const ScanSum& sum) { return sum.information <= 0.0; };
  std::vector<ScanSum> scans, windows;
  for (const ScanSums& drive : drives) {
    for (const auto& entry : drive) scans.push_back(entry.second);
    for (const ScanSum& window : InWindows(drive)) windows.push_back(window);
  }
  scans.erase(std::remove_if(scans.begin(), scans.end(), without), scans.end());
  windows.erase(std::remove_if(windows.begin(), windows.end(), without), windows.end());
  StampErrors errors;
  if (scans.size() < kFewestScans || windows.size() < kFewestWindows) return errors;
  const double of_scans = MeanSquare(scans);
  // A common error of a few windows is no wander: their mean square must be well above one to be believed.
  const double of_windows = MeanSquare(windows);
  errors.excess = std::max({1.0, of_scans, of_windows});
  errors.wanders = of_windows > kWandering && of_windows > 2.0 * of_scans;
  std::vector<double> informations;
  for (const ScanSum& scan : scans) informations.push_back(scan.information);
  errors.jitter = std::sqrt(std::max(0.0, of_scans - 1.0) / Median(std::move(informations)));
  return errors;
}

}  // namespace

StampSums SumStampErrors(const JointProblem& problem, const CalibrationState& state) {
  StampSums drives;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    std::vector<ScanSums>& sums = drives.emplace_back(state.Sensors().size());
    AddPlanes(problem, state, d, &sums);
    AddLandmarks(problem, state, d, &sums);
  }
  return drives;
}

std::vector<StampErrors> JudgeStampErrors(const StampSums& drives) {
  std::vector<StampErrors> errors;
  for (std::size_t s = 0; !drives.empty() && s < drives[0].size(); ++s) {
    std::vector<ScanSums> of_sensor;
    for (const std::vector<ScanSums>& drive : drives) of_sensor.push_back(drive[s]);
    errors.push_back(Judge(of_sensor));
  }
  return errors;
}

std::vector<StampErrors> MeasureStampErrors(const JointProblem& problem, const CalibrationState& state) {
  return JudgeStampErrors(SumStampErrors(problem, state));
}

}  // namespace mlic
