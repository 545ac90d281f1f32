#include "mlic_core/crossmodal/sensitivity_model.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// from: structural, where the nodes are.
constexpr double kFirstRange = -1.0, kRangeStep = 0.77;  // log2 m
// from: structural, where the nodes are.
constexpr double kFirstIncidence = -4.5, kIncidenceStep = 0.5;  // log2 of the cosine
constexpr int kRounds = 6;                                      // of weights; from: guard
constexpr std::size_t kChunks = 32;                             // from: structural, parts of a sum
// What the functions are like without data, in natural logarithms.
constexpr double kSlopeSigma = 1.0;       // from node to node
constexpr double kCurvatureSigma = 0.15;  // of the slope from node to node
constexpr double kRingSigma = 0.3;
constexpr double kLevelSigma = 10.0;  // from: guard, as good as free

// Where a value lies between nodes.
void Interpolate(double position, int nodes, int* node, double* share) {
  const double clamped = std::clamp(position, 0.0, nodes - 1.0);
  *node = std::min(nodes - 2, static_cast<int>(clamped));
  *share = clamped - *node;
}

}  // namespace

SensitivityModel::SensitivityModel(const std::vector<int>& rings) : first_{0} {
  for (const int count : rings)
    first_.push_back(first_.back() + kRangeNodes + kIncidenceNodes + std::max(1, count));
  parameters_.setZero(first_.back());
}

SensitivityModel::Row SensitivityModel::RowOf(const PatchLook& look) const {
  Row row;
  const int first = first_[look.lidar];
  int node;
  double share;
  Interpolate((std::log2(std::max(0.01f, look.range)) - kFirstRange) / kRangeStep, kRangeNodes, &node,
              &share);
  row.index[0] = first + node, row.value[0] = 1.0 - share;
  row.index[1] = first + node + 1, row.value[1] = share;
  Interpolate((std::log2(std::max(0.01f, look.cos_incidence)) - kFirstIncidence) / kIncidenceStep,
              kIncidenceNodes, &node, &share);
  row.index[2] = first + kRangeNodes + node, row.value[2] = 1.0 - share;
  row.index[3] = first + kRangeNodes + node + 1, row.value[3] = share;
  const int rings = first_[look.lidar + 1] - first - kRangeNodes - kIncidenceNodes;
  row.index[4] = first + kRangeNodes + kIncidenceNodes + std::min<int>(look.ring, rings - 1);
  row.value[4] = 1.0;
  return row;
}

double SensitivityModel::LogFactor(const PatchLook& look) const {
  const Row row = RowOf(look);
  double sum = 0.0;
  for (int e = 0; e < kEntries; ++e) sum += row.value[e] * parameters_[row.index[e]];
  return sum;
}

void SensitivityModel::AddPrior(double scale, Eigen::MatrixXd* H) const {
  const auto add = [&](int first, std::initializer_list<double> row, double sigma) {
    const double weight = scale * scale / (sigma * sigma);
    int i = first;
    for (const double a : row) {
      int j = first;
      for (const double b : row) (*H)(i, j++) += weight * a * b;
      ++i;
    }
  };
  for (std::size_t l = 0; l + 1 < first_.size(); ++l) {
    const int incidence = first_[l] + kRangeNodes, rings = incidence + kIncidenceNodes;
    for (int i = first_[l]; i + 1 < rings; ++i) {
      if (i + 1 != incidence) add(i, {-1.0, 1.0}, kSlopeSigma);
      if (i + 2 < rings && i + 1 != incidence && i + 2 != incidence)
        add(i, {1.0, -2.0, 1.0}, kCurvatureSigma);
    }
    for (int i = first_[l]; i < first_[l + 1]; ++i) add(i, {1.0}, i < rings ? kLevelSigma : kRingSigma);
  }
}

void SensitivityModel::Fit(const std::vector<PatchLook>& looks, const std::vector<std::size_t>& begin) {
  const int n = first_.back();
  const std::size_t patches = begin.size() - 1;
  if (looks.empty()) return;
  std::vector<double> weights(looks.size(), 1.0), residuals(looks.size());
  double scale = 0.3;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t chunks = std::min(kChunks, patches);
    std::vector<Eigen::MatrixXd> H(chunks);
    std::vector<Eigen::VectorXd> g(chunks);
    ParallelChunks(patches, chunks, [&](std::size_t c, std::size_t first, std::size_t last) {
      H[c].setZero(n, n);
      g[c].setZero(n);
      std::vector<int> touched;
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
      for (std::size_t p = first; p < last; ++p) {
        double weight = 0.0, value = 0.0;
        touched.clear();
        for (std::size_t k = begin[p]; k < begin[p + 1]; ++k) {
          const Row row = RowOf(looks[k]);
          weight += weights[k];
          value += weights[k] * looks[k].log_intensity;
          for (int e = 0; e < kEntries; ++e) {
            if (mean[row.index[e]] == 0.0) touched.push_back(row.index[e]);
            mean[row.index[e]] += weights[k] * row.value[e] + 1e-300;
            g[c][row.index[e]] += weights[k] * row.value[e] * looks[k].log_intensity;
            for (int f = 0; f < kEntries; ++f) {
              H[c](row.index[e], row.index[f]) += weights[k] * row.value[e] * row.value[f];
            }
          }
        }
        // The patch's own brightness is eliminated.
        for (const int i : touched) {
          if (weight > 0.0) {
            g[c][i] -= mean[i] * value / weight;
            for (const int j : touched) H[c](i, j) -= mean[i] * mean[j] / weight;
          }
        }
        for (const int i : touched) mean[i] = 0.0;
      }
    });
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
    for (std::size_t c = 0; c < chunks; ++c) {
      sum += H[c];
      gradient += g[c];
    }
    AddPrior(scale, &sum);
    parameters_ = SolveSymmetric(sum, gradient);

    ParallelChunks(patches, kChunks, [&](std::size_t, std::size_t first, std::size_t last) {
      for (std::size_t p = first; p < last; ++p) {
        double weight = 1e-12, value = 0.0;
        for (std::size_t k = begin[p]; k < begin[p + 1]; ++k) {
          residuals[k] = looks[k].log_intensity - LogFactor(looks[k]);
          weight += weights[k];
          value += weights[k] * residuals[k];
        }
        for (std::size_t k = begin[p]; k < begin[p + 1]; ++k) residuals[k] -= value / weight;
      }
    });
    std::vector<float> sizes(residuals.size());
    for (std::size_t k = 0; k < sizes.size(); ++k) sizes[k] = static_cast<float>(std::abs(residuals[k]));
    scale = std::max(0.02, 1.4826 * Median(std::move(sizes)));
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const double whitened = residuals[k] / (2.0 * scale);
      weights[k] = 1.0 / ((1.0 + whitened * whitened) * (1.0 + whitened * whitened));
    }
  }
}

}  // namespace mlic
