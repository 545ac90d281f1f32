#include "mlic_core/crossmodal/correlation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace mlic {
namespace {

// from: structural, cut at two sigmas.
constexpr double kTaper = 0.5;  // sigma of the Gaussian by the template's half-size

using Row = Eigen::Map<const Eigen::ArrayXf>;

}  // namespace

StructureTemplate::StructureTemplate(const StructureImage& image, int column, int row, int half)
    : half_(half) {
  const int size = 2 * half + 1;
  channels_.assign(static_cast<std::size_t>(size * size * StructureImage::kChannels), 0.0f);
  weight_.assign(static_cast<std::size_t>(size * size), 0.0f);
  energy_.assign(static_cast<std::size_t>(size * size), 0.0f);
  std::vector<float> falloff;  // the Gaussian along one axis
  const double sigma = kTaper * half;
  for (int x = -half; x <= half; ++x)
    falloff.push_back(static_cast<float>(std::exp(-0.5 * x * x / (sigma * sigma))));
  double all = 0.0, known = 0.0, trusted = 0.0;
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      const float taper =
          falloff[static_cast<std::size_t>(x + half)] * falloff[static_cast<std::size_t>(y + half)];
      all += taper;
      const int u = column + x, v = row + y;
      if (u < 1 || v < 1 || u + 1 >= image.width || v + 1 >= image.height) continue;
      if (image.Known(v)[u] <= 0.0f) continue;
      known += taper;
      const float w = taper * image.Weight(v)[u];
      trusted += w;
      const auto pixel = static_cast<std::size_t>((y + half) * size + x + half);
      const float* c = image.Channels(v) + StructureImage::kChannels * u;
      weight_[pixel] = w;
      energy_[pixel] = w * image.Energy(v)[u];
      for (int k = 0; k < StructureImage::kChannels; ++k)
        channels_[pixel * StructureImage::kChannels + static_cast<std::size_t>(k)] = w * c[k];
    }
    const auto first = static_cast<std::size_t>((y + half) * size);
    row_weight_.push_back(Row(&weight_[first], size).sum());
    row_energy_.push_back(Row(&energy_[first], size).sum());
    all_weight_ += row_weight_.back();
  }
  complete_ = known / all;
  trusted_ = trusted / all;
}

Eigen::Matrix2d SharpnessOf(const StructureImage& image, const StructureTemplate& piece, int column,
                            int row) {
  Eigen::Matrix2d out = Eigen::Matrix2d::Zero();
  double sum = 0.0;
  const int half = piece.half();
  for (int v = std::max(1, row - half); v <= std::min(image.height - 2, row + half); ++v) {
    for (int u = std::max(1, column - half); u <= std::min(image.width - 2, column + half); ++u) {
      const double w = piece.Weight(u - column, v - row);
      if (w <= 0.0) continue;
      const float* c = image.Channels(v) + StructureImage::kChannels * u;
      const float* up = image.Channels(v - 1) + StructureImage::kChannels * u;
      const float* down = image.Channels(v + 1) + StructureImage::kChannels * u;
      for (int k = 0; k < StructureImage::kChannels; ++k) {
        const double dx = 0.5 * (c[k + StructureImage::kChannels] - c[k - StructureImage::kChannels]),
                     dy = 0.5 * (down[k] - up[k]);
        out(0, 0) += w * dx * dx;
        out(0, 1) += w * dx * dy;
        out(1, 1) += w * dy * dy;
      }
      sum += w * image.Energy(v)[u];
    }
  }
  out(1, 0) = out(0, 1);
  if (sum > 0.0) out /= sum;
  return out;
}

double StructureTemplate::Score(const StructureImage& image, int column, int row) const {
  const int size = 2 * half_ + 1;
  const int left = std::max(0, half_ - column), right = std::min(size, image.width - column + half_);
  const int top = std::max(0, half_ - row), bottom = std::min(size, image.height - row + half_);
  if (left >= right) return -1.0;
  const int n = right - left;
  float product = 0.0f, own = 0.0f, other = 0.0f, shared = 0.0f;
  for (int y = top; y < bottom; ++y) {
    const int v = row + y - half_, u = column + left - half_;
    const auto first = static_cast<std::size_t>(y * size + left);
    const Row weight(&weight_[first], n);
    product += (Row(&channels_[first * StructureImage::kChannels], n * StructureImage::kChannels) *
                Row(image.Channels(v) + StructureImage::kChannels * u, n * StructureImage::kChannels))
                   .sum();
    other += (weight * Row(image.Energy(v) + u, n)).sum();
    if (n == size && image.AllKnown(v, u, u + n)) {
      own += row_energy_[static_cast<std::size_t>(y)];
      shared += row_weight_[static_cast<std::size_t>(y)];
    } else {
      const Row known(image.Known(v) + u, n);
      own += (Row(&energy_[first], n) * known).sum();
      shared += (weight * known).sum();
    }
  }
  if (shared < 0.5f * all_weight_ || own <= 0.0f || other <= 0.0f) return -1.0;
  return static_cast<double>(product) / std::sqrt(static_cast<double>(own) * static_cast<double>(other));
}

ScoreMap Correlate(const StructureTemplate& piece, const StructureImage& image, int column, int row,
                   int center_u, int center_v, int radius) {
  ScoreMap map{center_u, center_v, radius, {}};
  map.scores.reserve(static_cast<std::size_t>(map.Size() * map.Size()));
  for (int v = -radius; v <= radius; ++v) {
    for (int u = -radius; u <= radius; ++u) {
      map.scores.push_back(piece.Score(image, column + center_u + u, row + center_v + v));
    }
  }
  return map;
}

ScoreMap Climb(const StructureTemplate& piece, const StructureImage& image, int column, int row, int center_u,
               int center_v, int radius) {
  ScoreMap map{center_u, center_v, radius, {}};
  const int size = map.Size();
  map.scores.assign(static_cast<std::size_t>(size * size), -1.0);
  std::vector<bool> known(map.scores.size(), false);
  int u = 0, v = 0;  // from the center
  for (;;) {
    int best_u = u, best_v = v;
    const auto index = [&](int x, int y) {
      return static_cast<std::size_t>((y + radius) * size + x + radius);
    };
    for (int y = std::max(-radius, v - 1); y <= std::min(radius, v + 1); ++y) {
      for (int x = std::max(-radius, u - 1); x <= std::min(radius, u + 1); ++x) {
        const std::size_t i = index(x, y);
        if (!known[i]) map.scores[i] = piece.Score(image, column + center_u + x, row + center_v + y);
        known[i] = true;
        if (map.scores[i] > map.scores[index(best_u, best_v)]) best_u = x, best_v = y;
      }
    }
    if (best_u == u && best_v == v) return map;
    u = best_u, v = best_v;
  }
}

ScorePeak HighestScore(const ScoreMap& map) {
  ScorePeak peak;
  for (int v = map.center_v - map.radius; v <= map.center_v + map.radius; ++v) {
    for (int u = map.center_u - map.radius; u <= map.center_u + map.radius; ++u) {
      if (map.At(u, v) > peak.score) peak = {u, v, map.At(u, v), false};
    }
  }
  peak.inside = std::abs(peak.u - map.center_u) < map.radius && std::abs(peak.v - map.center_v) < map.radius;
  return peak;
}

double SecondPeak(const ScoreMap& map, const ScorePeak& peak, double distance) {
  double second = -1.0;
  const int radius = map.radius;
  for (int v = map.center_v - radius + 1; v < map.center_v + radius; ++v) {
    for (int u = map.center_u - radius + 1; u < map.center_u + radius; ++u) {
      const double score = map.At(u, v);
      if (score <= second || std::hypot(u - peak.u, v - peak.v) < distance) continue;
      bool highest = true;
      for (int k = 0; k < 9 && highest; ++k) highest = map.At(u + k % 3 - 1, v + k / 3 - 1) <= score;
      if (highest) second = score;
    }
  }
  return second;
}

bool FitPeak(const ScoreMap& map, const ScorePeak& peak, Eigen::Vector2d* place, Eigen::Matrix2d* curvature) {
  // Least squares of a + b.x + x.C.x/2 over 3 x 3 scores, in closed form.
  double s[3][3];
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) s[y][x] = map.At(peak.u + x - 1, peak.v + y - 1);
  }
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  Eigen::Matrix2d C = Eigen::Matrix2d::Zero();
  for (int k = 0; k < 3; ++k) {
    slope.x() += (s[k][2] - s[k][0]) / 6.0;
    slope.y() += (s[2][k] - s[0][k]) / 6.0;
    C(0, 0) += (s[k][0] - 2.0 * s[k][1] + s[k][2]) / 3.0;
    C(1, 1) += (s[0][k] - 2.0 * s[1][k] + s[2][k]) / 3.0;
  }
  C(0, 1) = C(1, 0) = 0.25 * (s[0][0] - s[0][2] - s[2][0] + s[2][2]);
  if (!(C(0, 0) < 0.0) || !(C.determinant() > 1e-12)) return false;
  const Eigen::Vector2d shift = -C.inverse() * slope;
  if (shift.cwiseAbs().maxCoeff() > 1.0) return false;
  *place = Eigen::Vector2d(peak.u, peak.v) + shift;
  *curvature = C;
  return true;
}

}  // namespace mlic
