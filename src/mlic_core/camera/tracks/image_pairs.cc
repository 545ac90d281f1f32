#include "mlic_core/camera/tracks/image_pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

constexpr int kSampleColumns = 8, kSampleRows = 6;  // from: structural

bool Before(const ImagePair& p, const ImagePair& q) { return std::tie(p.a, p.b) < std::tie(q.a, q.b); }

void SortUnique(std::vector<ImagePair>* pairs) {
  std::sort(pairs->begin(), pairs->end(), Before);
  const auto same = [](const ImagePair& p, const ImagePair& q) { return p.a == q.a && p.b == q.b; };
  pairs->erase(std::unique(pairs->begin(), pairs->end(), same), pairs->end());
}

// Bearings over a grid of the image, those of pixels without a bearing left out.
std::vector<Eigen::Vector3d> SampleBearings(const CameraIntrinsics& intrinsics) {
  std::vector<Eigen::Vector3d> bearings;
  for (int row = 0; row < kSampleRows; ++row) {
    for (int column = 0; column < kSampleColumns; ++column) {
      const Eigen::Vector2d pixel((column + 0.5) * intrinsics.width / kSampleColumns,
                                  (row + 0.5) * intrinsics.height / kSampleRows);
      Eigen::Vector3d bearing;
      if (Unproject(intrinsics, pixel, &bearing)) bearings.push_back(bearing);
    }
  }
  return bearings;
}

double SharedView(const std::vector<Eigen::Vector3d>& bearings, const PredictedView& a,
                  const PredictedView& b, const std::vector<double>& depths, double largest_view_angle) {
  if (bearings.empty() || depths.empty()) return 0.0;
  const RigidTransform T_b_a = b.T_map_camera.Inverse() * a.T_map_camera;
  const Eigen::Matrix3d R_b_a = T_b_a.rotation.toRotationMatrix();
  const double least_cosine = std::cos(largest_view_angle);
  std::vector<double> shares;
  for (const double depth : depths) {
    int seen = 0;
    for (const Eigen::Vector3d& bearing : bearings) {
      const Eigen::Vector3d ray_a = depth * (R_b_a * bearing), ray_b = ray_a + T_b_a.translation;
      if (ray_a.dot(ray_b) < least_cosine * depth * ray_b.norm()) continue;
      Eigen::Vector2d pixel;
      if (!Project(*b.intrinsics, ray_b, &pixel)) continue;
      seen += pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= b.intrinsics->width - 1 &&
              pixel.y() <= b.intrinsics->height - 1;
    }
    shares.push_back(static_cast<double>(seen) / bearings.size());
  }
  std::sort(shares.begin(), shares.end());
  return shares[shares.size() / 2];
}

// A partner that shows a point again long after, or in another camera, is worth more than one more of its
// neighbours: of each camera and of each stretch of time the best comes first, then the second best.
std::vector<int> ChoosePartners(const std::vector<Keyframe>& keyframes, const std::vector<double>& shares,
                                const PredictedPairOptions& options) {
  std::vector<std::pair<double, int>> candidates;
  for (std::size_t j = 0; j < shares.size(); ++j) {
    if (shares[j] >= options.least_overlap) candidates.emplace_back(-shares[j], static_cast<int>(j));
  }
  std::sort(candidates.begin(), candidates.end());
  std::map<std::pair<int, int>, int> taken;  // of a camera and a stretch of time
  std::vector<std::tuple<int, double, int>> ranked;
  for (const auto& [minus_share, j] : candidates) {
    const int stretch = static_cast<int>(std::floor(keyframes[j].time / options.least_time_apart));
    ranked.emplace_back(taken[{keyframes[j].camera, stretch}]++, minus_share, j);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> partners;
  for (const auto& entry : ranked) {
    if (static_cast<int>(partners.size()) >= options.most_for_keyframe) break;
    partners.push_back(std::get<2>(entry));
  }
  return partners;
}

}  // namespace

std::vector<ImagePair> SequentialPairs(const std::vector<Keyframe>& keyframes,
                                       const SequentialPairOptions& options) {
  std::vector<ImagePair> pairs;
  const int count = static_cast<int>(keyframes.size());
  for (int a = 0; a < count; ++a) {
    int interval = 1;
    while (interval <= std::max(options.window, options.largest_interval)) {
      const int b = a + interval;
      if (b >= count || keyframes[b].camera != keyframes[a].camera) break;
      pairs.push_back({a, b});
      interval = interval < options.window ? interval + 1 : 2 * interval;
    }
  }
  return pairs;
}

double SharedView(const PredictedView& a, const PredictedView& b, const std::vector<double>& depths,
                  double largest_view_angle) {
  return SharedView(SampleBearings(*a.intrinsics), a, b, depths, largest_view_angle);
}

std::vector<ImagePair> PredictedPairs(const std::vector<Keyframe>& keyframes,
                                      const std::vector<PredictedView>& views,
                                      const PredictedPairOptions& options) {
  Check(keyframes.size() == views.size(), "PredictedPairs: one view for each keyframe");
  const std::size_t count = keyframes.size();
  const std::vector<double> depths = {options.nearest, std::sqrt(options.nearest * options.farthest),
                                      options.farthest};
  std::vector<std::vector<Eigen::Vector3d>> bearings(count);
  ParallelFor(count, [&](std::size_t i) { bearings[i] = SampleBearings(*views[i].intrinsics); });
  std::vector<std::vector<int>> partners(count);
  ParallelFor(count, [&](std::size_t i) {
    std::vector<double> shares(count, 0.0);
    for (std::size_t j = 0; j < count; ++j) {
      const bool same_camera = keyframes[i].camera == keyframes[j].camera;
      if (same_camera && std::abs(keyframes[i].time - keyframes[j].time) < options.least_time_apart) continue;
      shares[j] = SharedView(bearings[i], views[i], views[j], depths, options.largest_view_angle);
    }
    partners[i] = ChoosePartners(keyframes, shares, options);
  });
  std::vector<ImagePair> pairs;
  for (std::size_t i = 0; i < count; ++i) {
    for (const int j : partners[i]) {
      const auto a = static_cast<std::int32_t>(i);
      pairs.push_back({std::min(a, j), std::max(a, j)});
    }
  }
  SortUnique(&pairs);
  return pairs;
}

std::vector<ImagePair> UnitePairs(const std::vector<ImagePair>& first, const std::vector<ImagePair>& second) {
  std::vector<ImagePair> pairs = first;
  pairs.insert(pairs.end(), second.begin(), second.end());
  SortUnique(&pairs);
  return pairs;
}

}  // namespace mlic
