#include "mlic_core/problem/time_windows.h"

#include <algorithm>
#include <limits>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

// Images come at regular times: what is just so long apart must not change sides with the rounding of a clock
// offset, or the landmarks would be others in every round.
constexpr double kRounding = 1e-4;  // s; from: guard

// What is seen of a landmark from `start` on (IMU clock): observations by their index, in their old order.
struct Stretch {
  std::size_t landmark;
  double start;
  std::vector<std::size_t> observations;
};

// The stretches of one landmark. middle: of the drive.
std::vector<Stretch> CutByTime(const LandmarkSet& points, std::size_t landmark, const CalibrationState& state,
                               double middle, double longest, std::size_t fewest) {
  const std::size_t begin = points.begin[landmark], end = points.begin[landmark + 1];
  std::vector<double> times(end - begin);
  for (std::size_t k = begin; k < end; ++k) {
    const LandmarkObservation& o = points.observations[k];
    times[k - begin] = state.cameras[o.camera].sensor.OnImuClock(o.time, middle);
  }
  std::vector<double> starts = times;
  std::sort(starts.begin(), starts.end());
  std::size_t kept = 0;
  for (const double t : starts) {
    if (kept == 0 || t > starts[kept - 1] + longest + kRounding) starts[kept++] = t;
  }
  starts.resize(kept);
  std::vector<Stretch> stretches;
  for (const double start : starts) stretches.push_back({landmark, start, {}});
  for (std::size_t k = begin; k < end; ++k) {
    const auto after = std::upper_bound(starts.begin(), starts.end(), times[k - begin]);
    stretches[after - starts.begin() - 1].observations.push_back(k);
  }
  stretches.erase(
      std::remove_if(stretches.begin(), stretches.end(),
                     [&](const Stretch& stretch) { return stretch.observations.size() < fewest; }),
      stretches.end());
  return stretches;
}

// Lays the observations of all stretches of all landmarks one after the other, in order of the time at which
// they begin. Returns for each new landmark the old one.
std::vector<std::size_t> LayOut(const std::vector<std::vector<Stretch>>& landmarks,
                                const std::vector<LandmarkObservation>& observations,
                                std::vector<LandmarkObservation>* laid_out, std::vector<std::size_t>* begin) {
  std::vector<const Stretch*> order;
  for (const std::vector<Stretch>& stretches : landmarks) {
    for (const Stretch& stretch : stretches) order.push_back(&stretch);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Stretch* a, const Stretch* b) { return a->start < b->start; });
  std::vector<std::size_t> origins;
  *begin = {0};
  for (const Stretch* stretch : order) {
    begin->push_back(begin->back() + stretch->observations.size());
    origins.push_back(stretch->landmark);
  }
  laid_out->resize(begin->back());
  ParallelFor(order.size(), [&](std::size_t i) {
    std::size_t at = (*begin)[i];
    for (const std::size_t k : order[i]->observations) (*laid_out)[at++] = observations[k];
  });
  return origins;
}

}  // namespace

LandmarkSet SplitPoints(const LandmarkSet& points, const CalibrationState& state, std::size_t drive,
                        double longest, std::vector<std::size_t>* origins) {
  const double middle = state.drives[drive].trajectory.Middle();
  constexpr double kForever = std::numeric_limits<double>::infinity();  // from: structural
  std::vector<std::vector<Stretch>> stretches(points.points.size());
  ParallelFor(stretches.size(), [&](std::size_t p) {
    // What a LiDAR measured once is one landmark, and a single observation ties the camera to it.
    const bool on_map = points.IsOnMap(p);
    stretches[p] =
        CutByTime(points, p, state, middle, on_map ? kForever : longest, on_map ? 1 : kFewestOfPoint);
  });
  LandmarkSet split;
  *origins = LayOut(stretches, points.observations, &split.observations, &split.begin);
  for (const std::size_t origin : *origins) {
    split.points.push_back(points.points[origin]);
    if (!points.lidar_points.empty()) split.lidar_points.push_back(points.lidar_points[origin]);
  }
  return split;
}

JointProblem WithShortCouplings(const JointProblem& given, const CalibrationState& state,
                                std::vector<std::vector<std::size_t>>* origins) {
  JointProblem problem = given;
  if (problem.fix_trajectory) return problem;
  origins->resize(problem.drives.size());
  for (std::size_t d = 0; d < problem.drives.size(); ++d) {
    problem.drives[d].landmarks =
        SplitPoints(given.drives[d].landmarks, state, d, kLongestPointCoupling, &(*origins)[d]);
  }
  return problem;
}

std::vector<PointLandmark> MergePoints(const std::vector<PointLandmark>& old, const LandmarkSet& split,
                                       const std::vector<std::size_t>& origins) {
  std::vector<PointLandmark> merged = old;
  std::vector<std::size_t> most(old.size(), 0);
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const std::size_t count = split.begin[i + 1] - split.begin[i];
    if (count <= most[origins[i]]) continue;
    most[origins[i]] = count;
    merged[origins[i]] = split.points[i];
  }
  return merged;
}

}  // namespace mlic
