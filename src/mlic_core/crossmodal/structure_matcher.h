#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "mlic_core/crossmodal/structure_features.h"

namespace mlic {

struct StructureMatchOptions {
  int finest_level = 0;    // as StructureOptions'; from: structural
  int cell = 24;           // px: one template in each cell of the image
  int template_half = 20;  // px at each level: half of the template's edge; a Gaussian falls off towards it
  double least_complete = 0.75;  // share of the template that must be known in the rendering
  // Share of the template that must be off edges of depth. Less gives more matches on walls with windows, and
  // a bias of some tenths of a pixel. from: measured, facades of the car: 0.3 px where edges of depth have a
  // say.
  double least_trusted = 0.55;
  double largest_search = 80.0;  // px: the search window's half-size never exceeds it; from: guard, time
  // from: derivation, 1 % of normal errors lie beyond.
  double search_sigmas = 3.0;       // of the predicted covariance
  double least_score = 0.35;        // normalised correlation, -1 to 1
  double largest_peak_ratio = 0.9;  // the second peak's score by the best one's
  // px: largest error of the way from rendering to photo and back. 0: no check.
  double largest_return_error = 1.0;
  double largest_sigma = 1.2;  // px, along the worse direction
};

// One place of the rendering found in the photo.
struct StructureMatch {
  Eigen::Vector2d rendered;      // where in the rendering, px
  Eigen::Vector2d displacement;  // to its place in the photo, px
  Eigen::Matrix2d covariance;    // of the displacement, px^2
  double score = 0.0;            // normalised correlation at the peak
  double peak_ratio = 0.0;       // second peak by best
};

// What is known of the displacement at a pixel of the rendering before looking: covariance, px^2.
using PredictedCovariance = std::function<Eigen::Matrix2d(const Eigen::Vector2d& pixel)>;

// Finds places of the rendering in the photo of the same camera: templates where the rendering has structure,
// searched by normalised correlation within what `predicted` allows, from the coarsest level that it needs
// down to full resolution, there to a fraction of a pixel. In order of cells. Places do not hang on each
// other, so a view's outliers are not consistent. Covariance: see PeakCovariance.
std::vector<StructureMatch> MatchStructure(const StructurePyramid& rendering, const StructurePyramid& photo,
                                           const PredictedCovariance& predicted,
                                           const StructureMatchOptions& options);

}  // namespace mlic
