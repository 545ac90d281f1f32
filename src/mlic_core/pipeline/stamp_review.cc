#include "mlic_core/pipeline/stamp_review.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "mlic_core/uncertainty/stamp_wander.h"

namespace mlic {
namespace {

// A step smaller than this share of the course is not taken. from: guard, what is left is far within what a
// course is known to.
constexpr double kNegligible = 0.05;

constexpr int kMostSteps = 12;  // of one review; from: guard, time

// By how much more a step is taken than the errors say, as the trajectory has followed most of them: dynamic
// relaxation (Irons and Tuck, 1969), from how the steps before it have shortened.
struct Relaxation {
  std::vector<double> last;  // step, before it was relaxed
  double factor = 1.0;

  double Next(const std::vector<double>& step) {
    constexpr double kMost = 8.0;  // from: guard, a trajectory that follows nine tenths
    if (last.size() == step.size()) {
      double product = 0.0, square = 0.0;
      for (std::size_t k = 0; k < step.size(); ++k) {
        product += last[k] * (step[k] - last[k]);
        square += (step[k] - last[k]) * (step[k] - last[k]);
      }
      if (square > 0.0) factor = std::clamp(-factor * product / square, 1.0, kMost);
    }
    last = step;
    return factor;
  }
};

// `step` is by the times as `course` has moved them.
StampCourse Sum(const StampCourse& course, const StampCourse& step) {
  StampCourse sum = step;
  if (!course.IsEmpty()) {
    sum.times = course.times;
    sum.shifts.clear();
    for (const double time : course.times) {
      const double shift = course.At(time);
      sum.shifts.push_back(shift + step.At(time + shift));
    }
  }
  sum.walk = std::max(course.walk, step.walk);
  return sum;
}

void Shift(const StampCourse& step, int camera, LandmarkSet* landmarks) {
  for (LandmarkObservation& o : landmarks->observations) {
    if (o.camera == camera) o.time += step.At(o.time);
  }
}

// One camera in one drive. False where nothing is left to move.
bool MoveStamps(const ScanSums& images, std::size_t d, std::size_t c, Relaxation* relaxation,
                Adjustment* adjustment) {
  StampCourse& course = adjustment->cameras.stamp_courses[d][c];
  std::optional<StampCourse> step = FindStampCourse(images, !course.IsEmpty());
  if (!step) return false;
  const double factor = relaxation->Next(step->shifts);
  for (double& shift : step->shifts) shift *= factor;
  if (step->MeanSquare() < kNegligible * kNegligible * course.MeanSquare()) return false;
  course = Sum(course, *step);
  Shift(*step, static_cast<int>(c), &adjustment->problem.drives[d].landmarks);
  if (d < adjustment->map.held_out.size()) {
    Shift(*step, static_cast<int>(c), &adjustment->map.held_out[d]);
  }
  return true;
}

}  // namespace

std::vector<TrackSet> OnTime(const AdjustedCameras& cameras) {
  std::vector<TrackSet> tracks = cameras.tracks;
  for (std::size_t d = 0; d < cameras.stamp_courses.size(); ++d) {
    for (Keyframe& keyframe : tracks[d].keyframes) {
      keyframe.time += cameras.stamp_courses[d][static_cast<std::size_t>(keyframe.camera)].At(keyframe.time);
    }
  }
  return tracks;
}

bool ReviewStamps(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment) {
  const std::size_t drives = adjustment->problem.drives.size(), cameras = adjustment->state.cameras.size();
  adjustment->cameras.stamp_courses.resize(drives, std::vector<StampCourse>(cameras));
  std::vector<std::vector<Relaxation>> relaxations(drives, std::vector<Relaxation>(cameras));
  std::vector<bool> moved(cameras, false);
  bool again = true;
  for (int iteration = 0; again && iteration < kMostSteps; ++iteration) {
    again = false;
    const StampSums sums = SumStampErrors(adjustment->problem, adjustment->state);
    for (std::size_t d = 0; d < drives; ++d) {
      for (std::size_t c = 0; c < cameras; ++c) {
        if (!adjustment->cameras.found[c] || adjustment->problem.cameras[c].fixed.time_offset) continue;
        const std::size_t place = adjustment->state.Sensors().PlaceOf(CameraId(c));
        if (!MoveStamps(sums[d][place], d, c, &relaxations[d][c], adjustment)) continue;
        again = moved[c] = true;
      }
    }
    if (again) {
      adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, probe_matrices);
    }
  }
  for (std::size_t c = 0; c < cameras; ++c) {
    if (!moved[c]) continue;
    double square = 0.0;
    for (const auto& of_drive : adjustment->cameras.stamp_courses) {
      square = std::max(square, of_drive[c].MeanSquare());
    }
    char text[120];
    std::snprintf(text, sizeof(text), ": its stamps wander by %.3f ms (rms): followed",
                  1e3 * std::sqrt(square));
    context.monitor.line(context.rig.cameras[c].name + text);
  }
  return std::find(moved.begin(), moved.end(), true) != moved.end();
}

}  // namespace mlic
