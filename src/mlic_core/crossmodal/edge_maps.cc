#include "mlic_core/crossmodal/edge_maps.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/crossmodal/structure_image.h"

namespace mlic {
namespace {

// A step of depth counts half where it is this, m and share of the range: the recess of a window is a step.
constexpr float kStep = 0.03f, kStepByRange = 0.001f;
constexpr float kLeastSupport = 0.5f;  // share of the derivative's support that must be known

void Blur(const cv::Mat& in, double sigma, cv::Mat* out) {
  cv::GaussianBlur(in, *out, cv::Size(), sigma, sigma, cv::BORDER_REFLECT_101);
}

float Norm(float x, float y) { return std::sqrt(x * x + y * y); }

// Adds an edge's moments: strength r, gradient (x, y) of norm n.
void AddMoments(float r, float x, float y, float n, float* moments) {
  if (n <= 0.0f) return;
  const float c = x / n, s = y / n;
  const float c2 = c * c - s * s, s2 = 2.0f * c * s;
  moments[0] += r;
  moments[1] += r * c2;
  moments[2] += r * s2;
  moments[3] += r * (c2 * c2 - s2 * s2);
  moments[4] += r * 2.0f * c2 * s2;
}

// Mean of the positive values.
double UsualValue(const cv::Mat& values) {
  double sum = 0.0, count = 0.0;
  for (int v = 0; v < values.rows; ++v) {
    const float* row = values.ptr<float>(v);
    for (int u = 0; u < values.cols; ++u) {
      if (row[u] > 0.0f) sum += row[u], count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : 1.0;
}

// Vector from plane to point, along the plane's normal: how far b lies off a's plane, in a's own scale.
float StepOffPlane(const cv::Vec3f& a, const cv::Vec3f& normal, const cv::Vec3f& b) {
  return std::abs(normal.dot(b - a));
}

// 0 within the noise of two points on one surface, towards 1 at a step between two. Signed: where farther.
float DepthStep(const SurfaceImage& surface, int v0, int u0, int v1, int u1) {
  const float range_a = surface.range.at<float>(v0, u0), range_b = surface.range.at<float>(v1, u1);
  const auto& a = surface.points.at<cv::Vec3f>(v0, u0);
  const auto& b = surface.points.at<cv::Vec3f>(v1, u1);
  const auto& normal_a = surface.normals.at<cv::Vec3f>(v0, u0);
  const auto& normal_b = surface.normals.at<cv::Vec3f>(v1, u1);
  const float step = std::min(StepOffPlane(a, normal_a, b), StepOffPlane(b, normal_b, a));
  const float usual = kStep + kStepByRange * std::min(range_a, range_b);
  const float strength = step * step / (step * step + usual * usual);
  return range_b > range_a ? strength : -strength;
}

bool Seen(float range) { return range > 0.0f; }  // false for NaN

}  // namespace

EdgeMap IntensityEdges(const cv::Mat& image, const cv::Mat& known, double sigma) {
  EdgeMap edges;
  edges.moments = cv::Mat::zeros(image.size(), CV_32FC(StructureImage::kChannels));
  edges.known = cv::Mat::zeros(image.size(), CV_32FC1);
  edges.trust = cv::Mat::ones(image.size(), CV_32FC1);
  cv::Mat sum, support;
  Blur(image.mul(known), sigma, &sum);
  Blur(known, sigma, &support);
  cv::Mat gradient = cv::Mat::zeros(image.size(), CV_32FC2), norm = cv::Mat::zeros(image.size(), CV_32FC1);
  for (int v = 1; v + 1 < image.rows; ++v) {
    const float* value[3];
    const float* weight[3];
    for (int k = 0; k < 3; ++k)
      value[k] = sum.ptr<float>(v - 1 + k), weight[k] = support.ptr<float>(v - 1 + k);
    float* g = gradient.ptr<float>(v);
    float* n = norm.ptr<float>(v);
    float* out = edges.known.ptr<float>(v);
    for (int u = 1; u + 1 < image.cols; ++u) {
      const float least = std::min({weight[1][u - 1], weight[1][u + 1], weight[0][u], weight[2][u]});
      if (least < kLeastSupport) continue;
      g[2 * u] = 0.5f * (value[1][u + 1] / weight[1][u + 1] - value[1][u - 1] / weight[1][u - 1]);
      g[2 * u + 1] = 0.5f * (value[2][u] / weight[2][u] - value[0][u] / weight[0][u]);
      n[u] = Norm(g[2 * u], g[2 * u + 1]);
      out[u] = 1.0f;
    }
  }
  const auto usual = static_cast<float>(UsualValue(norm));
  for (int v = 0; v < image.rows; ++v) {
    const float* g = gradient.ptr<float>(v);
    const float* n = norm.ptr<float>(v);
    float* m = edges.moments.ptr<float>(v);
    for (int u = 0; u < image.cols; ++u) {
      const float r = n[u] * n[u] / (n[u] * n[u] + usual * usual);
      AddMoments(r, g[2 * u], g[2 * u + 1], n[u], m + StructureImage::kChannels * u);
    }
  }
  return edges;
}

void AddDepthEdges(const SurfaceImage& surface, double sigma, double reach, float weight, float trust,
                   EdgeMap* edges) {
  cv::Mat gradient = cv::Mat::zeros(surface.range.size(), CV_32FC2);
  for (int v = 1; v + 1 < gradient.rows; ++v) {
    const float* range[3];
    for (int k = 0; k < 3; ++k) range[k] = surface.range.ptr<float>(v - 1 + k);
    float* g = gradient.ptr<float>(v);
    for (int u = 1; u + 1 < gradient.cols; ++u) {
      if (Seen(range[1][u - 1]) && Seen(range[1][u + 1])) g[2 * u] = DepthStep(surface, v, u - 1, v, u + 1);
      if (Seen(range[0][u]) && Seen(range[2][u])) g[2 * u + 1] = DepthStep(surface, v - 1, u, v + 1, u);
    }
  }
  cv::Mat steps(gradient.size(), CV_32FC1);
  for (int v = 0; v < gradient.rows; ++v) {
    const float* g = gradient.ptr<float>(v);
    float* s = steps.ptr<float>(v);
    const float* range = surface.range.ptr<float>(v);
    const auto* normal = surface.normals.ptr<cv::Vec3f>(v);
    for (int u = 0; u < gradient.cols; ++u) {
      const bool odd = Seen(range[u]) && normal[u].dot(normal[u]) < 0.5f;
      s[u] = odd ? 1.0f : std::max(std::abs(g[2 * u]), std::abs(g[2 * u + 1]));
    }
  }
  const int width = 2 * static_cast<int>(std::ceil(reach)) + 1;
  cv::dilate(steps, steps, cv::getStructuringElement(cv::MORPH_ELLIPSE, {width, width}));
  Blur(steps, sigma, &steps);
  edges->trust = edges->trust.mul(1.0 - (1.0 - trust) * steps);
  // A step spans two places of the central difference; blurring gives its direction more than four values.
  Blur(gradient, sigma, &gradient);
  for (int v = 0; v < gradient.rows; ++v) {
    const float* g = gradient.ptr<float>(v);
    const float* k = edges->known.ptr<float>(v);
    float* m = edges->moments.ptr<float>(v);
    for (int u = 0; u < gradient.cols; ++u) {
      if (k[u] <= 0.0f) continue;
      const float n = Norm(g[2 * u], g[2 * u + 1]);
      AddMoments(weight * std::min(1.0f, 1.5f * n), g[2 * u], g[2 * u + 1], n,
                 m + StructureImage::kChannels * u);
    }
  }
}

void AddOrientationEdges(const SurfaceImage& surface, double sigma, float weight, EdgeMap* edges) {
  cv::Mat normals, support(surface.range.size(), CV_32FC1);
  for (int v = 0; v < support.rows; ++v) {
    for (int u = 0; u < support.cols; ++u) {
      support.at<float>(v, u) = surface.normals.at<cv::Vec3f>(v, u).dot(surface.normals.at<cv::Vec3f>(v, u));
    }
  }
  Blur(surface.normals, sigma, &normals);
  Blur(support, sigma, &support);
  for (int v = 1; v + 1 < normals.rows; ++v) {
    const float* k = edges->known.ptr<float>(v);
    float* m = edges->moments.ptr<float>(v);
    for (int u = 1; u + 1 < normals.cols; ++u) {
      const float s[4] = {support.at<float>(v, u - 1), support.at<float>(v, u + 1),
                          support.at<float>(v - 1, u), support.at<float>(v + 1, u)};
      if (k[u] <= 0.0f || *std::min_element(s, s + 4) < kLeastSupport) continue;
      const cv::Vec3f x =
          0.5f * (normals.at<cv::Vec3f>(v, u + 1) / s[1] - normals.at<cv::Vec3f>(v, u - 1) / s[0]);
      const cv::Vec3f y =
          0.5f * (normals.at<cv::Vec3f>(v + 1, u) / s[3] - normals.at<cv::Vec3f>(v - 1, u) / s[2]);
      for (int c = 0; c < 3; ++c) {
        const float n = Norm(x[c], y[c]);
        // from: derivation, turned by 30 deg, blurred by one pixel, the change in two components.
        constexpr float kUsual = 0.12f;  // of a change by 30 degrees
        if (n < 0.1f * kUsual) continue;
        AddMoments(weight * n * n / (n * n + kUsual * kUsual), x[c], y[c], n,
                   m + StructureImage::kChannels * u);
      }
    }
  }
}

void HalveKnown(const cv::Mat& image, const cv::Mat& known, cv::Mat* half_image, cv::Mat* half_known) {
  cv::Mat out(image.rows / 2, image.cols / 2, CV_32FC1), out_known(out.size(), CV_32FC1);
  for (int v = 0; v < out.rows; ++v) {
    for (int u = 0; u < out.cols; ++u) {
      float sum = 0.0f, weight = 0.0f;
      for (int k = 0; k < 4; ++k) {
        const float w = known.at<float>(2 * v + k / 2, 2 * u + k % 2);
        sum += w * image.at<float>(2 * v + k / 2, 2 * u + k % 2);
        weight += w;
      }
      out.at<float>(v, u) = weight > 0.0f ? sum / weight : 0.0f;
      out_known.at<float>(v, u) = 0.25f * weight;
    }
  }
  *half_image = out;
  *half_known = out_known;
}

SurfaceImage HalveNearest(const SurfaceImage& surface) {
  const cv::Size size(surface.range.cols / 2, surface.range.rows / 2);
  SurfaceImage half{cv::Mat::zeros(size, CV_32FC3), cv::Mat::zeros(size, CV_32FC3),
                    cv::Mat::zeros(size, CV_32FC1)};
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      float& nearest = half.range.at<float>(v, u);
      for (int k = 0; k < 4; ++k) {
        const int y = 2 * v + k / 2, x = 2 * u + k % 2;
        const float range = surface.range.at<float>(y, x);
        if (!Seen(range) || (nearest > 0.0f && range >= nearest)) continue;
        nearest = range;
        half.points.at<cv::Vec3f>(v, u) = surface.points.at<cv::Vec3f>(y, x);
        half.normals.at<cv::Vec3f>(v, u) = surface.normals.at<cv::Vec3f>(y, x);
      }
    }
  }
  return half;
}

}  // namespace mlic
