#include "mlic_core/crossmodal/structure_matcher.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/correlation.h"

namespace mlic {
namespace {

constexpr int kCoarsestRadius =
    5;                            // px of its level: the search starts at the level where the window is this
constexpr int kReturnRadius = 3;  // from: guard, largest_return_error decides
// from: measured, eight views of matcher_test: halved or doubled, one match of 528 differs.
constexpr double kPeakDistance = 3.0;  // px of its level: a second peak is farther off
// from: measured, eight views of matcher_test: halved, the same 528 matches; doubled, together with
// kSurroundings, the weights of edges and kStep (edge_maps.cc), 708 with errors as large.
constexpr double kLeastSharpness = 2e-3;  // 1/px^2, of a template's worse direction

// Structure comes in blurred edges, not in independent pixels: the sigma of a peak, by what the mismatch of
// template and photo and the peak's curvature would give if each pixel were independent. Measured on
// simulated views with truth (crossmodal_matcher_test.cc).
constexpr double kSigmaFactor = 4.3;  // from: measured
constexpr double kLeastSigma = 0.08;  // px: rendering and photo are sampled

struct Place {
  int column = 0, row = 0;
  bool any = false;
};

double SmallerEigenvalue(const Eigen::Matrix2d& m) {
  return 0.5 * (m.trace() - std::hypot(m(0, 0) - m(1, 1), 2.0 * m(0, 1)));
}

// The covariance of a peak: the score near it is score + x.C.x/2; a mismatch of (1 - score) shared by n
// pixels moves it with covariance (1 - score) / n * (-C)^-1.
Eigen::Matrix2d PeakCovariance(double score, const Eigen::Matrix2d& curvature, double pixels) {
  const Eigen::Matrix2d information = -curvature * pixels / std::max(1e-3, 1.0 - score);
  return kSigmaFactor * kSigmaFactor * information.inverse() +
         kLeastSigma * kLeastSigma * Eigen::Matrix2d::Identity();
}

class Matcher {
 public:
  Matcher(const StructurePyramid& rendering, const StructurePyramid& photo,
          const PredictedCovariance& predicted, const StructureMatchOptions& options)
      : rendering_(rendering), photo_(photo), predicted_(predicted), options_(options) {}

  Place PlaceIn(int left, int top) const;
  bool Match(const Place& place, StructureMatch* match) const;

 private:
  bool Search(const Place& place, StructureMatch* match) const;
  bool Returns(const Place& place, const Eigen::Vector2d& displacement) const;

  const StructurePyramid& rendering_;
  const StructurePyramid& photo_;
  const PredictedCovariance& predicted_;
  const StructureMatchOptions& options_;
};

// The place with the strongest structure of a cell.
Place Matcher::PlaceIn(int left, int top) const {
  constexpr int kStep = 2;  // from: guard, time
  const int level = options_.finest_level;
  const StructureImage& image = rendering_[static_cast<std::size_t>(level)];
  Place best;
  float most = 0.0f;
  const int right = std::min(image.width, (left + options_.cell) >> level);
  const int bottom = std::min(image.height, (top + options_.cell) >> level);
  for (int v = top >> level; v < bottom; v += kStep) {
    for (int u = left >> level; u < right; u += kStep) {
      const float energy = image.Weight(v)[u] * image.Energy(v)[u];
      if (energy <= most) continue;
      most = energy;
      best = {static_cast<int>(FromLevel(u, level)), static_cast<int>(FromLevel(v, level)), true};
    }
  }
  return best;
}

// From the coarsest level that the window needs down to level 0.
bool Matcher::Search(const Place& place, StructureMatch* match) const {
  const Eigen::Matrix2d prior = predicted_(match->rendered);
  const double window = std::min(
      options_.largest_search, options_.search_sigmas * std::sqrt(std::max(prior(0, 0), prior(1, 1))) + 1.0);
  int level = options_.finest_level;
  while (level + 1 < static_cast<int>(rendering_.size()) && window / (1 << level) > kCoarsestRadius) ++level;
  const int radius = static_cast<int>(std::ceil(window / (1 << level)));
  bool coarsest = true;
  int u = 0, v = 0;
  for (; level >= options_.finest_level; --level) {
    const int column = static_cast<int>(std::lround(ToLevel(place.column, level)));
    const int row = static_cast<int>(std::lround(ToLevel(place.row, level)));
    const StructureImage& image = rendering_[static_cast<std::size_t>(level)];
    if (column < 0 || row < 0 || column >= image.width || row >= image.height) return false;
    const StructureTemplate piece(image, column, row, options_.template_half);
    if (piece.Complete() < options_.least_complete || piece.Trusted() < options_.least_trusted) return false;
    if (level == options_.finest_level &&
        SmallerEigenvalue(SharpnessOf(image, piece, column, row)) < kLeastSharpness)
      return false;
    const ScoreMap map = Correlate(piece, photo_[static_cast<std::size_t>(level)], column, row, u, v, radius);
    const ScorePeak peak = HighestScore(map);
    if (!peak.inside || peak.score < options_.least_score) return false;
    if (coarsest) match->peak_ratio = SecondPeak(map, peak, kPeakDistance) / peak.score;
    if (match->peak_ratio > options_.largest_peak_ratio) return false;
    u = peak.u, v = peak.v;
    if (level == options_.finest_level) {
      Eigen::Matrix2d curvature;
      if (!FitPeak(map, peak, &match->displacement, &curvature)) return false;
      match->score = peak.score;
      const double taper = 0.5 * options_.template_half;
      match->covariance = PeakCovariance(peak.score, curvature, piece.Trusted() * 2.0 * M_PI * taper * taper);
      match->displacement *= 1 << level;
      match->covariance *= 1 << (2 * level);
      return true;
    }
    u *= 2, v *= 2, coarsest = false;
  }
  return false;
}

bool Matcher::Returns(const Place& place, const Eigen::Vector2d& displacement) const {
  const int level = options_.finest_level;
  const double scale = 1 << level;
  const StructureImage& rendering = rendering_[static_cast<std::size_t>(level)];
  const StructureImage& photo = photo_[static_cast<std::size_t>(level)];
  const int u = static_cast<int>(std::lround(displacement.x() / scale));
  const int v = static_cast<int>(std::lround(displacement.y() / scale));
  const int column = static_cast<int>(std::lround(ToLevel(place.column, level))) + u;
  const int row = static_cast<int>(std::lround(ToLevel(place.row, level))) + v;
  if (column < 0 || row < 0 || column >= photo.width || row >= photo.height) return false;
  const StructureTemplate piece(photo, column, row, options_.template_half);
  const ScoreMap map = Climb(piece, rendering, column, row, -u, -v, kReturnRadius);
  const ScorePeak peak = HighestScore(map);
  Eigen::Vector2d back;
  Eigen::Matrix2d curvature;
  return peak.inside && FitPeak(map, peak, &back, &curvature) &&
         (scale * back + displacement).norm() <= scale * options_.largest_return_error;
}

bool Matcher::Match(const Place& place, StructureMatch* match) const {
  match->rendered = Eigen::Vector2d(place.column, place.row);
  if (!Search(place, match)) return false;
  const Eigen::Matrix2d& C = match->covariance;
  const double largest = C.trace() - SmallerEigenvalue(C);
  const double limit = options_.largest_sigma * (1 << options_.finest_level);
  return largest <= limit * limit &&
         (options_.largest_return_error <= 0.0 || Returns(place, match->displacement));
}

}  // namespace

std::vector<StructureMatch> MatchStructure(const StructurePyramid& rendering, const StructurePyramid& photo,
                                           const PredictedCovariance& predicted,
                                           const StructureMatchOptions& options) {
  const Matcher matcher(rendering, photo, predicted, options);
  const int columns = (rendering[0].width + options.cell - 1) / options.cell;
  const int rows = (rendering[0].height + options.cell - 1) / options.cell;
  const auto count = static_cast<std::size_t>(columns * rows);
  std::vector<StructureMatch> found(count);
  std::vector<char> matched(count, 0);
  ParallelFor(count, [&](std::size_t i) {
    const int cell = static_cast<int>(i);
    const Place place = matcher.PlaceIn(cell % columns * options.cell, cell / columns * options.cell);
    matched[i] = place.any && matcher.Match(place, &found[i]);
  });
  std::vector<StructureMatch> matches;
  for (std::size_t i = 0; i < count; ++i) {
    if (matched[i]) matches.push_back(found[i]);
  }
  return matches;
}

}  // namespace mlic
