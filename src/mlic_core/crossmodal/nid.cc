#include "mlic_core/crossmodal/nid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

// Each value's rank, 0 to 1; equal values get their mean rank.
std::vector<double> Ranks(const std::vector<float>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return values[i] != values[j] ? values[i] < values[j] : i < j;
  });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    const double rank = 0.5 * static_cast<double>(begin + end - 1) / static_cast<double>(order.size());
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = rank;
  }
  return ranks;
}

// Weights of the four bins around a value of 0 to 1; returns the first bin.
int BinWeights(double value, int bins, double (&weights)[4]) {
  const double x = 1.0 + value * (bins - 3.0);
  const int bin = std::min(bins - 3, static_cast<int>(x));
  const double t = x - bin, s = 1.0 - t;
  weights[0] = s * s * s / 6.0;
  weights[1] = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
  weights[2] = (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0;
  weights[3] = t * t * t / 6.0;
  return bin - 1;
}

double Entropy(const std::vector<double>& shares) {
  double sum = 0.0;
  for (const double share : shares) {
    if (share > 0.0) sum -= share * std::log(share);
  }
  return sum;
}

}  // namespace

double NormalizedInformationDistance(const std::vector<float>& a, const std::vector<float>& b,
                                     const NidOptions& options) {
  Check(a.size() == b.size() && options.bins >= 4,
        "NormalizedInformationDistance: pairs and 4 bins expected");
  if (static_cast<int>(a.size()) < std::max(1, options.fewest_samples)) return 1.0;
  const std::vector<double> rank_a = Ranks(a), rank_b = Ranks(b);
  const auto bins = static_cast<std::size_t>(options.bins);
  std::vector<double> joint(bins * bins, 0.0), of_a(bins, 0.0), of_b(bins, 0.0);
  const double share = 1.0 / static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    double wa[4], wb[4];
    const auto first_a = static_cast<std::size_t>(BinWeights(rank_a[i], options.bins, wa));
    const auto first_b = static_cast<std::size_t>(BinWeights(rank_b[i], options.bins, wb));
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) joint[(first_a + j) * bins + first_b + k] += share * wa[j] * wb[k];
    }
  }
  for (std::size_t j = 0; j < bins; ++j) {
    for (std::size_t k = 0; k < bins; ++k) of_a[j] += joint[j * bins + k], of_b[k] += joint[j * bins + k];
  }
  const double together = Entropy(joint);
  return together > 0.0 ? 2.0 - (Entropy(of_a) + Entropy(of_b)) / together : 1.0;
}

double ViewNid(const cv::Mat& intensity, const cv::Mat& gray, const cv::Mat& mask,
               const NidOptions& options) {
  Check(intensity.type() == CV_32FC1 && gray.type() == CV_8UC1 && intensity.size() == gray.size(),
        "ViewNid: expected images of one size, CV_32FC1 and CV_8UC1");
  std::vector<float> a, b;
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u) {
      const float value = intensity.at<float>(v, u);
      if (!std::isfinite(value) || (!mask.empty() && mask.at<std::uint8_t>(v, u) == 0)) continue;
      a.push_back(value);
      b.push_back(gray.at<std::uint8_t>(v, u));
    }
  }
  return NormalizedInformationDistance(a, b, options);
}

double ProjectedNid(const std::vector<IntensitySample>& samples, const cv::Mat& gray, const cv::Mat& mask,
                    const CameraIntrinsics& intrinsics, const RigidTransform& T_camera_body,
                    const NidOptions& options) {
  Check(gray.type() == CV_8UC1, "ProjectedNid: expected CV_8UC1");
  std::vector<float> a, b;
  for (const IntensitySample& sample : samples) {
    Eigen::Vector2d pixel;
    if (!Project(intrinsics, T_camera_body * sample.point, &pixel)) continue;
    const int u = static_cast<int>(std::floor(pixel.x())), v = static_cast<int>(std::floor(pixel.y()));
    if (u < 0 || v < 0 || u + 1 >= gray.cols || v + 1 >= gray.rows) continue;
    if (!mask.empty() && mask.at<std::uint8_t>(v, u) == 0) continue;
    const auto x = static_cast<float>(pixel.x() - u), y = static_cast<float>(pixel.y() - v);
    const std::uint8_t* upper = gray.ptr<std::uint8_t>(v) + u;
    const std::uint8_t* lower = gray.ptr<std::uint8_t>(v + 1) + u;
    a.push_back(sample.intensity);
    b.push_back((1.0f - y) * ((1.0f - x) * upper[0] + x * upper[1]) +
                y * ((1.0f - x) * lower[0] + x * lower[1]));
  }
  return NormalizedInformationDistance(a, b, options);
}

}  // namespace mlic
