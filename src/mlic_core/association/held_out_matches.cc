#include "mlic_core/association/held_out_matches.h"

#include <cmath>
#include <cstdio>

#include "mlic_core/association/map_matches.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/problem/landmark_terms.h"

namespace mlic {
namespace {

constexpr double kPart = 160.0;  // px; from: definition, docs/outputs.md
constexpr double kShare = 0.1;   // from: definition, docs/outputs.md

bool IsHeldOut(const LandmarkObservation& o) {
  const auto number = [](double value) { return static_cast<std::uint64_t>(std::llround(value)); };
  Random parts = Random(static_cast<std::uint64_t>(o.camera))
                     .Fork(number(1e3 * o.time))
                     .Fork(number(std::floor(o.pixel.x() / kPart)))
                     .Fork(number(std::floor(o.pixel.y() / kPart)));
  return parts.Uniform() < kShare;
}

}  // namespace

LandmarkSet TakeHeldOutMatches(LandmarkSet* matches) {
  LandmarkSet kept, held_out;
  kept.begin.push_back(0);
  held_out.begin.push_back(0);
  for (std::size_t p = 0; p < matches->points.size(); ++p) {
    AddMatch(*matches, p, IsHeldOut(matches->observations[matches->begin[p]]) ? &held_out : &kept);
  }
  *matches = std::move(kept);
  return held_out;
}

std::vector<HeldOutMatches> EvaluateHeldOutMatches(const std::vector<LandmarkSet>& held_out,
                                                   const CalibrationState& state) {
  std::vector<std::vector<double>> lengths(state.cameras.size());
  for (std::size_t d = 0; d < held_out.size(); ++d) {
    const LandmarkSet moved = PlacedByLidars(held_out[d], state, d);
    const std::vector<Eigen::Vector2d> residuals = LandmarkResiduals(moved, state, d);
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      if (residuals[k].allFinite()) lengths[moved.observations[k].camera].push_back(residuals[k].norm());
    }
  }
  std::vector<HeldOutMatches> errors(lengths.size());
  for (std::size_t c = 0; c < lengths.size(); ++c) {
    errors[c].count = lengths[c].size();
    double squares = 0.0;
    for (const double length : lengths[c]) squares += length * length;
    if (errors[c].count > 0) errors[c].rms = std::sqrt(squares / static_cast<double>(errors[c].count));
    errors[c].median = Median(std::move(lengths[c]));
  }
  return errors;
}

std::string DescribeHeldOut(const HeldOutMatches& matches) {
  char text[200];
  std::snprintf(text, sizeof(text),
                ": %zu matches held out of the solve are off by %.2f px in the median, %.2f px rms",
                matches.count, matches.median, matches.rms);
  return text;
}

}  // namespace mlic
