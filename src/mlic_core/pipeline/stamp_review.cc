#include "mlic_core/pipeline/stamp_review.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "mlic_core/uncertainty/stamp_doubt.h"
#include "mlic_core/uncertainty/stamp_evidence.h"

namespace mlic {
namespace {

// A step smaller than this share of the course, or than this, is not taken. from: guard, what is left is far
// within what a course is known to, and an image moves by less than a thousandth of a pixel meanwhile
constexpr double kNegligible = 0.05, kLeastStep = 2e-6;  // , s

constexpr int kMostSteps = 4;  // of one review; from: guard, Gauss-Newton steps
// Of the observations, which stand where `from` has them.
void Shift(const ImageStamps& from, const std::vector<double>& to, LandmarkSet* landmarks) {
  for (LandmarkObservation& o : landmarks->observations) {
    if (o.camera == static_cast<int>(from.camera)) o.time = to[NearestImage(from.times, o.time)];
  }
}

// Whether stamps lie on another course than before.
bool IsAnother(const StampCourse& course, const StampCourse& before, const std::vector<double>& stamps) {
  double square = 0.0;
  for (const double stamp : stamps) square += std::pow(course.At(stamp) - before.At(stamp), 2);
  const double step = std::sqrt(square / static_cast<double>(stamps.size()));
  return step >= std::max(kLeastStep, kNegligible * std::sqrt(course.MeanSquare()));
}

// False where the course stays.
bool MoveStamps(const ImageStamps& images, const ImageStamps& now, const std::vector<StampEvidence>& evidence,
                Adjustment* adjustment) {
  StampCourse& course = adjustment->cameras.stamp_courses[images.drive][images.camera];
  StampCourse next = LikeliestCourse(images.times, course, evidence);
  if (!IsAnother(next, course, images.times)) return false;
  course = std::move(next);
  const std::vector<double> times = OnCourse({images}, adjustment->cameras)[0].times;
  Shift(now, times, &adjustment->problem.drives[images.drive].landmarks);
  if (images.drive < adjustment->map.held_out.size()) {
    Shift(now, times, &adjustment->map.held_out[images.drive]);
  }
  return true;
}

void Describe(const AdjustmentContext& context, const Adjustment& adjustment, std::size_t camera) {
  double square = 0.0;
  for (const auto& of_drive : adjustment.cameras.stamp_courses) {
    square = std::max(square, of_drive[camera].MeanSquare());
  }
  char text[120] = ": its stamps do not wander any more";
  if (square > 0.0) {
    std::snprintf(text, sizeof(text), ": its stamps wander by %.3f ms (rms): followed",
                  1e3 * std::sqrt(square));
  }
  context.monitor.line(context.rig.cameras[camera].name + text);
}

}  // namespace

bool ReviewStamps(const AdjustmentContext& context, bool probe_matrices, Adjustment* adjustment) {
  const std::size_t cameras = adjustment->state.cameras.size();
  adjustment->cameras.stamp_courses.resize(adjustment->problem.drives.size(),
                                           std::vector<StampCourse>(cameras));
  const std::vector<std::vector<StampCourse>> before = adjustment->cameras.stamp_courses;
  const std::vector<ImageStamps> all = StampsOfImages(*adjustment);
  std::vector<ImageStamps> images = all;
  for (int step = 0; step < kMostSteps && !images.empty(); ++step) {
    const std::vector<ImageStamps> now = OnCourse(images, adjustment->cameras);
    const auto evidence = EvidenceOfStamps(adjustment->problem, adjustment->state, now);
    std::vector<ImageStamps> again;
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      if (!MoveStamps(images[i], now[i], evidence[i], adjustment)) continue;
      again.push_back(std::move(images[i]));
    }
    images = std::move(again);
    if (images.empty()) break;
    adjustment->last_solve = SolveAdjustment(context.monitor.cancellation, adjustment, probe_matrices);
  }
  // A course that came and went within the review is as it was, or reviews would never end.
  std::vector<bool> moved(cameras, false);
  for (const ImageStamps& of : all) {
    const StampCourse& course = adjustment->cameras.stamp_courses[of.drive][of.camera];
    if (IsAnother(course, before[of.drive][of.camera], of.times)) moved[of.camera] = true;
  }
  for (std::size_t c = 0; c < cameras; ++c) {
    if (moved[c]) Describe(context, *adjustment, c);
  }
  const bool any = std::find(moved.begin(), moved.end(), true) != moved.end();
  adjustment->rounds.stamps_settled = !any;
  return any;
}

}  // namespace mlic
