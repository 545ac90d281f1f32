#include "mlic_core/camera/learned/learned_pairing.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/camera/two_view/two_view.h"
#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// Indices of the features with descriptors: those that were only followed have zeros.
std::vector<int> Described(const FeatureSet& features) {
  const std::size_t size = features.descriptor_size;
  std::vector<int> described;
  for (std::size_t i = 0; i < features.Count(); ++i) {
    const auto first = features.float_descriptors.begin() + static_cast<std::ptrdiff_t>(i * size);
    if (std::any_of(first, first + static_cast<std::ptrdiff_t>(size), [](float v) { return v != 0.0f; })) {
      described.push_back(static_cast<int>(i));
    }
  }
  return described;
}

// Both are trained on images of all sizes, so it does not matter that the network saw a smaller image.
Tensor NormalizedKeypoints(const FeatureSet& features, const std::vector<int>& of, PairingKind kind) {
  const float longer = static_cast<float>(std::max(features.width, features.height));
  const float unit = kind == PairingKind::kLightGlue ? 0.5f * longer : 0.7f * longer;
  Tensor tensor{{1, static_cast<std::int64_t>(of.size()), 2}, {}};
  for (const int i : of) {
    tensor.values.push_back((features.pixels[i].x() - 0.5f * static_cast<float>(features.width)) / unit);
    tensor.values.push_back((features.pixels[i].y() - 0.5f * static_cast<float>(features.height)) / unit);
  }
  return tensor;
}

Tensor Scores(const FeatureSet& features, const std::vector<int>& of) {
  Tensor tensor{{1, static_cast<std::int64_t>(of.size())}, {}};
  for (const int i : of) tensor.values.push_back(features.scores[i]);
  return tensor;
}

Tensor Descriptors(const FeatureSet& features, const std::vector<int>& of, PairingKind kind) {
  const std::size_t size = features.descriptor_size, count = of.size();
  const bool by_row = kind == PairingKind::kLightGlue;
  const auto rows = static_cast<std::int64_t>(count), columns = static_cast<std::int64_t>(size);
  Tensor tensor{{1, by_row ? rows : columns, by_row ? columns : rows}, std::vector<float>(count * size)};
  for (std::size_t i = 0; i < count; ++i) {
    const float* descriptor = &features.float_descriptors[static_cast<std::size_t>(of[i]) * size];
    for (std::size_t k = 0; k < size; ++k)
      tensor.values[by_row ? i * size + k : k * count + i] = descriptor[k];
  }
  return tensor;
}

// From the network's two forms of output to one: indices into the features that it was given.
std::vector<FeatureMatch> Candidates(const std::vector<Tensor>& outputs, std::size_t count_a,
                                     std::size_t count_b, const std::string& file) {
  const std::vector<float>&matches = outputs[0].values, &scores = outputs[1].values;
  const bool pairs =
      matches.size() == 2 * scores.size() && !outputs[0].shape.empty() && outputs[0].shape.back() == 2;
  if (!pairs && (matches.size() != count_a || scores.size() != count_a)) {
    throw InputError(file +
                     ": matches0 and mscores0 must have the shapes [K, 2] and [K], or [1, M] and [1, M]" +
                     " for M features; they have " + std::to_string(matches.size()) + " and " +
                     std::to_string(scores.size()) + " numbers for " + std::to_string(count_a) + " features");
  }
  std::vector<FeatureMatch> candidates;
  for (std::size_t k = 0; k < scores.size(); ++k) {
    const float a = pairs ? matches[2 * k] : static_cast<float>(k),
                b = pairs ? matches[2 * k + 1] : matches[k];
    if (!pairs && b < 0.0f) continue;
    if (!(a >= 0.0f && a < static_cast<float>(count_a) && b >= 0.0f && b < static_cast<float>(count_b))) {
      throw InputError(file + ": matches0 holds an index that no feature has");
    }
    candidates.push_back({static_cast<int>(a), static_cast<int>(b), scores[k]});
  }
  return candidates;
}

bool Allows(const MatchGuide& guide, const FeatureMatch& match) {
  const Eigen::Vector3d &a = (*guide.bearings_a)[match.a], &b = (*guide.bearings_b)[match.b];
  if (a.isZero() || b.isZero()) return false;
  if (!guide.t_b_a.isZero()) {
    return std::abs(EpipolarError(guide.R_b_a, guide.t_b_a.normalized(), a, b)) <= guide.largest_error;
  }
  return b.dot(guide.R_b_a * a) >= std::cos(guide.largest_error);
}

// Those that are the best of both their features, ordered by a. Among equals the first counts.
std::vector<FeatureMatch> BestOfBoth(const std::vector<FeatureMatch>& candidates, std::size_t count_a,
                                     std::size_t count_b) {
  std::vector<int> of_a(count_a, -1), of_b(count_b, -1);
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    for (int* best : {&of_a[candidates[k].a], &of_b[candidates[k].b]}) {
      if (*best < 0 || candidates[k].score > candidates[*best].score) *best = static_cast<int>(k);
    }
  }
  std::vector<FeatureMatch> matches;
  for (const int k : of_a) {
    if (k >= 0 && of_b[candidates[k].b] == k) matches.push_back(candidates[k]);
  }
  return matches;
}

}  // namespace

NetworkSignature PairingSignature(PairingKind kind) {
  NetworkSignature signature;
  signature.inputs = {{{"kpts0", "keypoints0"}, {1, kAny, 2}}, {{"kpts1", "keypoints1"}, {1, kAny, 2}}};
  std::vector<std::int64_t> descriptors = {1, kAny, 256};
  if (kind == PairingKind::kSuperGlue) {
    signature.inputs.push_back({{"scores0"}, {1, kAny}});
    signature.inputs.push_back({{"scores1"}, {1, kAny}});
    descriptors = {1, 256, kAny};
  }
  signature.inputs.push_back({{"desc0", "descriptors0"}, descriptors});
  signature.inputs.push_back({{"desc1", "descriptors1"}, descriptors});
  signature.outputs = {{{"matches0", "matches"}, {}},
                       {{"mscores0", "matching_scores0", "scores0", "mscores", "scores"}, {}}};
  return signature;
}

std::vector<FeatureMatch> PairFeatures(const Network& network, PairingKind kind, const std::string& file,
                                       const FeatureSet& a, const FeatureSet& b, const MatchGuide* guide,
                                       float least_score) {
  for (const FeatureSet* features : {&a, &b}) {
    Check(features->float_descriptors.size() == features->Count() * features->descriptor_size,
          "PairFeatures: features of the learned detector only can be matched");
  }
  const std::vector<int> of_a = Described(a), of_b = Described(b);
  if (of_a.empty() || of_b.empty()) return {};
  std::vector<Tensor> inputs = {NormalizedKeypoints(a, of_a, kind), NormalizedKeypoints(b, of_b, kind)};
  if (kind == PairingKind::kSuperGlue) {
    inputs.push_back(Scores(a, of_a));
    inputs.push_back(Scores(b, of_b));
  }
  inputs.push_back(Descriptors(a, of_a, kind));
  inputs.push_back(Descriptors(b, of_b, kind));

  if (guide != nullptr) {
    Check(guide->bearings_a != nullptr && guide->bearings_b != nullptr &&
              guide->bearings_a->size() == a.Count() && guide->bearings_b->size() == b.Count(),
          "MatchGuide: one bearing for each feature");
  }
  std::vector<FeatureMatch> candidates;
  for (FeatureMatch match : Candidates(network.Run(inputs), of_a.size(), of_b.size(), file)) {
    match.a = of_a[match.a];
    match.b = of_b[match.b];
    if (match.score >= least_score && (guide == nullptr || Allows(*guide, match)))
      candidates.push_back(match);
  }
  return BestOfBoth(candidates, a.Count(), b.Count());
}

}  // namespace mlic
