#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/crossmodal/structure_features.h"

namespace mlic {

// Normalised correlation of templates of structure with another image of structure. Part of
// structure_matcher.h. Pixels here are those of one level.

// A square piece of an image, each pixel weighted by a Gaussian of its distance from the middle.
class StructureTemplate {
 public:
  // The middle must be inside the image; parts outside count as unknown.
  StructureTemplate(const StructureImage& image, int column, int row, int half);

  // Share of the template that is known, and that counts.
  double Complete() const { return complete_; }
  double Trusted() const { return trusted_; }
  // Cosine of the angle between the template's channels and the image's around (column, row), over pixels
  // that are known in both; -1 where less than half is.
  double Score(const StructureImage& image, int column, int row) const;

  int half() const { return half_; }
  float Weight(int x, int y) const {  // from the middle
    return weight_[static_cast<std::size_t>((y + half_) * (2 * half_ + 1) + x + half_)];
  }

 private:
  int half_;
  double complete_ = 0.0;
  double trusted_ = 0.0;
  std::vector<float> channels_;  // times weight
  std::vector<float> weight_;
  std::vector<float> energy_;                   // of the channels, times weight
  std::vector<float> row_weight_, row_energy_;  // sums
  float all_weight_ = 0.0f;
};

// The structure tensor of a template of `image` at (column, row): sum of weighted squared derivatives of its
// channels, by the sum of weighted squared channels, 1/px^2. Its smaller eigenvalue is 0 where the template
// can slide along itself.
Eigen::Matrix2d SharpnessOf(const StructureImage& image, const StructureTemplate& piece, int column, int row);

// Scores of displacements (u, v), |u - center_u| <= radius, likewise v.
struct ScoreMap {
  int center_u = 0, center_v = 0, radius = 0;
  std::vector<double> scores;

  int Size() const { return 2 * radius + 1; }
  double At(int u, int v) const {
    return scores[static_cast<std::size_t>((v - center_v + radius) * Size() + u - center_u + radius)];
  }
};

ScoreMap Correlate(const StructureTemplate& piece, const StructureImage& image, int column, int row,
                   int center_u, int center_v, int radius);

// The same, but only where a climb from the center to the nearest maximum looks; -1 elsewhere.
ScoreMap Climb(const StructureTemplate& piece, const StructureImage& image, int column, int row, int center_u,
               int center_v, int radius);

// The highest score; whether it lies off the window's edge.
struct ScorePeak {
  int u = 0, v = 0;
  double score = -1.0;
  bool inside = false;
};
ScorePeak HighestScore(const ScoreMap& map);

// The highest local maximum farther than `distance` from the peak, or -1.
double SecondPeak(const ScoreMap& map, const ScorePeak& peak, double distance);

// Fits a quadratic to the scores around a peak inside the window: the peak's place and the second derivatives
// there. False where it is no maximum within a pixel.
bool FitPeak(const ScoreMap& map, const ScorePeak& peak, Eigen::Vector2d* place, Eigen::Matrix2d* curvature);

}  // namespace mlic
