#include "mlic_core/crossmodal/structure_features.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/error.h"
#include "mlic_core/crossmodal/edge_maps.h"

namespace mlic {
namespace {

// Edge strength is compared with that of this much wider a neighbourhood. from: measured, eight views of
// matcher_test: halved, 512 matches with errors of 0.44 px (rms) for 528 of 0.43 px; doubled as
// kLeastSharpness (structure_matcher.cc).
constexpr double kSurroundings = 6.0;

// Coefficients count by these factors: orientation tells more than strength.
constexpr float kHarmonicWeights[StructureImage::kChannels] = {0.5f, 1.0f, 1.0f, 0.7f, 0.7f};

// Sigmas of the blurs as far as which an edge is felt around it. from: measured, facades of the car at 8 to
// 15 m: biased within 2 px of a step, not from 4 px on.
constexpr double kReach = 2.0;

// From edge moments of one level to features: blurred, and relative to the strength around.
StructureImage ToStructure(const EdgeMap& edges, const StructureOptions& options) {
  const double sigma = options.channel_sigma;
  const int relative = options.relative_orientation ? StructureImage::kChannels : 1;
  const cv::Mat& moments = edges.moments;
  const cv::Mat& known = edges.known;
  StructureImage out;
  out.width = moments.cols, out.height = moments.rows;
  const auto count = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  out.channels.assign(count * StructureImage::kChannels, 0.0f);
  out.energy.assign(count, 0.0f);
  out.known.assign(count, 0.0f);
  out.weight.assign(count, 0.0f);
  // Channels that are to be relative, and last what of them is known.
  cv::Mat near, strength(moments.size(), CV_32FC(relative + 1)), around;
  cv::GaussianBlur(moments, near, cv::Size(), sigma, sigma, cv::BORDER_REFLECT_101);
  for (int v = 0; v < out.height; ++v) {
    const float* m = near.ptr<float>(v);
    const float* k = known.ptr<float>(v);
    float* s = strength.ptr<float>(v);
    for (int u = 0; u < out.width; ++u, s += relative + 1) {
      for (int i = 0; i < relative; ++i) s[i] = k[u] * m[StructureImage::kChannels * u + i];
      s[relative] = k[u];
    }
  }
  // Two box filters make nearly a Gaussian, at a cost that does not hang on its width.
  const int width = 2 * static_cast<int>(0.5 * std::sqrt(6.0) * kSurroundings * sigma) + 1;
  cv::blur(strength, around, {width, width}, {-1, -1}, cv::BORDER_REFLECT_101);
  cv::blur(around, around, {width, width}, {-1, -1}, cv::BORDER_REFLECT_101);
  for (int v = 0; v < out.height; ++v) {
    const float* m = near.ptr<float>(v);
    const float* a = around.ptr<float>(v);
    const float* k = known.ptr<float>(v);
    for (int u = 0; u < out.width; ++u, a += relative + 1) {
      if (k[u] <= 0.0f) continue;
      const auto pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(out.width) + static_cast<std::size_t>(u);
      float* c = &out.channels[pixel * StructureImage::kChannels];
      const float share = 1.0f / std::max(1e-6f, a[relative]);
      const float scale = 1.0f / (share * a[0] + 0.05f);
      for (int i = 0; i < StructureImage::kChannels; ++i) {
        const float value = m[StructureImage::kChannels * u + i] - (i < relative ? share * a[i] : 0.0f);
        c[i] = kHarmonicWeights[i] * scale * value;
        out.energy[pixel] += c[i] * c[i];
      }
      out.known[pixel] = 1.0f;
      out.weight[pixel] = edges.trust.at<float>(v, u);
    }
  }
  for (int v = 0; v < out.height; ++v) {
    out.known_before.push_back(0);
    for (int u = 0; u < out.width; ++u) {
      out.known_before.push_back(out.known_before.back() + (out.Known(v)[u] > 0.0f ? 1 : 0));
    }
  }
  return out;
}

}  // namespace

StructurePyramid PhotoStructure(const cv::Mat& gray, const cv::Mat& mask, const StructureOptions& options) {
  Check(gray.type() == CV_8UC1, "PhotoStructure: expected CV_8UC1");
  cv::Mat image, known(gray.size(), CV_32FC1, cv::Scalar(1.0f));
  gray.convertTo(image, CV_32F);
  if (!mask.empty()) {
    Check(mask.type() == CV_8UC1 && mask.size() == gray.size(), "PhotoStructure: mask of another size");
    known.setTo(0.0f, mask == 0);
  }
  StructurePyramid pyramid;
  for (int level = 0; level < options.levels; ++level) {
    if (level > 0) HalveKnown(image, known, &image, &known);
    const EdgeMap edges = IntensityEdges(image, known, options.gradient_sigma);
    pyramid.push_back(ToStructure(edges, options));
  }
  return pyramid;
}

StructurePyramid MapStructure(const RenderedStructure& rendering, const StructureOptions& options) {
  Check(rendering.intensity.type() == CV_32FC1, "MapStructure: expected an intensity image CV_32FC1");
  cv::Mat intensity = rendering.intensity.clone();
  cv::Mat known(intensity.size(), CV_32FC1, cv::Scalar(1.0f));
  for (int v = 0; v < intensity.rows; ++v) {
    for (int u = 0; u < intensity.cols; ++u) {
      if (std::isfinite(intensity.at<float>(v, u))) continue;
      intensity.at<float>(v, u) = 0.0f;
      known.at<float>(v, u) = 0.0f;
    }
  }
  SurfaceImage surface{rendering.points, rendering.normals, rendering.range};
  StructurePyramid pyramid;
  for (int level = 0; level < options.levels; ++level) {
    if (level > 0) {
      HalveKnown(intensity, known, &intensity, &known);
      if (!surface.range.empty()) surface = HalveNearest(surface);
    }
    EdgeMap edges = IntensityEdges(intensity, known, options.gradient_sigma);
    if (!surface.range.empty()) {
      const double trust = level == options.finest_level ? options.depth_trust : 1.0;
      const double reach = kReach * std::hypot(options.gradient_sigma, options.channel_sigma);
      AddDepthEdges(surface, options.gradient_sigma, reach, static_cast<float>(options.depth_weight),
                    static_cast<float>(trust), &edges);
      AddOrientationEdges(surface, options.gradient_sigma, static_cast<float>(options.normal_weight), &edges);
    }
    pyramid.push_back(ToStructure(edges, options));
  }
  return pyramid;
}

}  // namespace mlic
