#include "mlic_core/camera/tracks/patch.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mlic {
namespace {

constexpr int kTranslationIterations = 4;  // from: guard, ends by convergence
constexpr int kIterations = 20;            // from: guard, ends by convergence
constexpr float kConverged = 0.003f;       // px; from: derivation, a tenth of the least sigma of a place
constexpr float kLargestStep = 2.0f;       // px; from: guard
constexpr int kParts = 4;                  // of a template in each direction, for its sigma

Eigen::Vector2f Bent(const PatchBend& bend, const Eigen::Vector2f& point) {
  const float u = point.x(), v = point.y();
  return point + bend * Eigen::Vector3f(u * u, u * v, v * v);
}

cv::Mat HalfSize(const cv::Mat& image) {
  cv::Mat half(image.rows / 2, image.cols / 2, CV_8UC1);
  for (int y = 0; y < half.rows; ++y) {
    const std::uint8_t* above = image.ptr<std::uint8_t>(2 * y);
    const std::uint8_t* below = image.ptr<std::uint8_t>(2 * y + 1);
    std::uint8_t* row = half.ptr<std::uint8_t>(y);
    for (int x = 0; x < half.cols; ++x) {
      row[x] = static_cast<std::uint8_t>(
          (above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1] + 2) / 4);
    }
  }
  return half;
}

// Cubic convolution (Keys, 1981) with a = -1/2: linear interpolation would smooth, by an amount that depends
// on the fraction, and pull the fit towards certain fractions.
std::array<float, 4> CubicWeights(float f) {
  return {((-0.5f * f + 1.0f) * f - 0.5f) * f, (1.5f * f - 2.5f) * f * f + 1.0f,
          ((-1.5f * f + 2.0f) * f + 0.5f) * f, (0.5f * f - 0.5f) * f * f};
}

// What a gain that changes linearly across a template, as lenses' vignetting makes it, adds to its values:
// orthonormal columns without constant. Left to the shift, a gain that grows by the share a for each pixel
// moves a texture of structures l long by a l^2 / 2 px (the least-squares shift for the residual a x I(x),
// with l^2 the mean of I^2 over that of its gradient's), in the same pattern over all images. gray: of the
// template, row by row.
Eigen::Matrix<float, Eigen::Dynamic, 2> ShadingOf(const Eigen::VectorXf& gray, int radius) {
  const int side = 2 * radius + 1;
  Eigen::Matrix<float, Eigen::Dynamic, 2> shading(gray.size(), 2);
  for (int k = 0; k < gray.size(); ++k) {
    shading(k, 0) = gray[k] * static_cast<float>(k % side - radius);
    shading(k, 1) = gray[k] * static_cast<float>(k / side - radius);
  }
  shading.rowwise() -= shading.colwise().mean();
  shading.col(0).normalize();
  shading.col(1) -= shading.col(0) * shading.col(0).dot(shading.col(1));
  shading.col(1).normalize();
  return shading;
}

}  // namespace

std::vector<cv::Mat> AreaPyramid(const cv::Mat& gray, int levels) {
  std::vector<cv::Mat> pyramid = {gray};
  while (static_cast<int>(pyramid.size()) < levels &&
         std::min(pyramid.back().cols, pyramid.back().rows) >= 4 * Patch::kSide) {
    pyramid.push_back(HalfSize(pyramid.back()));
  }
  return pyramid;
}

int LevelOfScale(double scale, int levels) {
  const int level = static_cast<int>(std::floor(std::log2(std::max(1.0, scale / 1.2))));
  return std::clamp(level, 0, levels - 1);
}

Patch CutPatch(const std::vector<cv::Mat>& pyramid, const Eigen::Vector2f& pixel, int level) {
  const cv::Mat& image = pyramid[level];
  const Eigen::Vector2f in_level = ToLevel(pixel, level);
  Patch patch;
  patch.level = level;
  patch.corner = {static_cast<int>(std::lround(in_level.x())) - Patch::kHalf,
                  static_cast<int>(std::lround(in_level.y())) - Patch::kHalf};
  patch.feature = in_level - patch.corner.cast<float>();
  patch.first = (-patch.corner).cwiseMax(0);
  patch.last = (Eigen::Vector2i(image.cols, image.rows) - patch.corner).cwiseMin(Patch::kSide) -
               Eigen::Vector2i::Ones();
  for (int y = patch.first.y(); y <= patch.last.y(); ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(patch.corner.y() + y) + patch.corner.x();
    for (int x = patch.first.x(); x <= patch.last.x(); ++x) patch.values[y * Patch::kSide + x] = row[x];
  }
  return patch;
}

std::optional<PatchTemplate> PatchTemplate::Make(const Patch& patch, int radius) {
  const int reach = radius + 1;  // for the gradients
  if (Patch::kHalf - reach < patch.first.maxCoeff() || Patch::kHalf + reach > patch.last.minCoeff()) {
    return std::nullopt;
  }
  PatchTemplate result;
  result.radius_ = radius;
  result.offset_ = (patch.feature.array() - static_cast<float>(Patch::kHalf)).matrix();
  const int side = 2 * radius + 1, count = side * side;
  result.values_.resize(count);
  result.jacobian_.resize(count, 6);
  for (int row = 0, k = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column, ++k) {
      const int u = column - radius, v = row - radius;
      const int x = Patch::kHalf + u, y = Patch::kHalf + v;
      const float gx = 0.5f * (patch.At(x + 1, y) - patch.At(x - 1, y));
      const float gy = 0.5f * (patch.At(x, y + 1) - patch.At(x, y - 1));
      result.values_[k] = patch.At(x, y);
      result.jacobian_.row(k) << gx, gy, gx * u, gx * v, gy * u, gy * v;
    }
  }
  const Eigen::VectorXf gray = result.values_;
  result.values_.array() -= result.values_.mean();
  const float length_square = result.values_.squaredNorm();
  if (length_square < 4.0f * count) return std::nullopt;  // below 2 gray values of contrast
  result.shading_ = ShadingOf(gray, radius);
  result.values_ -= result.shading_ * (result.shading_.transpose() * result.values_);
  const float unshaded = result.values_.squaredNorm();
  for (int c = 0; c < 6; ++c) {
    auto column = result.jacobian_.col(c);
    column.array() -= column.mean();
    column -= result.shading_ * (result.shading_.transpose() * column);
    column -= result.values_ * (result.values_.dot(column) / unshaded);
  }
  const Eigen::Matrix<float, 6, 6> normal = result.jacobian_.transpose() * result.jacobian_;
  const Eigen::Matrix2f translation = normal.topLeftCorner<2, 2>();
  // Both directions must show: the smaller eigenvalue of the translation's part, for each pixel of the patch.
  const float half_trace = 0.5f * translation.trace();
  const float smaller =
      half_trace - std::sqrt(std::max(0.0f, half_trace * half_trace - translation.determinant()));
  if (!(smaller > 0.5f * count)) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix<float, 6, 6>> factor(normal);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0.0f)) return std::nullopt;
  result.inverse_ = factor.solve(Eigen::Matrix<float, 6, 6>::Identity());
  result.inverse_translation_ = translation.inverse();
  return result;
}

bool PatchTemplate::Sample(const Patch& other, const Eigen::Matrix2f& affine, const PatchBend& bend,
                           const Eigen::Vector2f& centre, Eigen::VectorXf* values, float* correlation) const {
  const int side = 2 * radius_ + 1;
  const float radius = static_cast<float>(radius_);
  // The corners of the warped template bound it; cubic interpolation reaches one further down, two further
  // up.
  const Eigen::Vector2f reach =
      affine.cwiseAbs() *
      (Eigen::Vector2f::Constant(radius) + bend.cwiseAbs() * Eigen::Vector3f::Constant(radius * radius));
  const Eigen::Vector2f lower = centre - reach, upper = centre + reach;
  if (!(lower.x() >= other.first.x() + 1 && lower.y() >= other.first.y() + 1 &&
        upper.x() < other.last.x() - 2 && upper.y() < other.last.y() - 2)) {
    return false;
  }
  for (int row = 0, k = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column, ++k) {
      const Eigen::Vector2f bent =
          Bent(bend, {static_cast<float>(column - radius_), static_cast<float>(row - radius_)});
      const float x = affine(0, 0) * bent.x() + affine(0, 1) * bent.y() + centre.x();
      const float y = affine(1, 0) * bent.x() + affine(1, 1) * bent.y() + centre.y();
      const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
      const auto wx = CubicWeights(x - x0), wy = CubicWeights(y - y0);
      const std::uint8_t* p = &other.values[(y0 - 1) * Patch::kSide + x0 - 1];
      float sum = 0.0f;
      for (int j = 0; j < 4; ++j, p += Patch::kSide) {
        sum += wy[j] * (wx[0] * p[0] + wx[1] * p[1] + wx[2] * p[2] + wx[3] * p[3]);
      }
      (*values)[k] = sum;
    }
  }
  values->array() -= values->mean();
  *values -= shading_ * (shading_.transpose() * *values);
  const float square = values->squaredNorm(), product = values->dot(values_);
  if (!(product > 0.0f) || !(square > 0.0f)) return false;
  *correlation = product / std::sqrt(square * values_.squaredNorm());
  // The gain that makes them most similar; the jacobian has no part along the template's values.
  *values *= values_.squaredNorm() / product;
  return true;
}

float PatchTemplate::VarianceOfParts(const Eigen::VectorXf& residual, const Eigen::Matrix2f& affine) const {
  const int side = 2 * radius_ + 1;
  std::array<Eigen::Matrix<float, 6, 1>, kParts * kParts> gradients;
  gradients.fill(Eigen::Matrix<float, 6, 1>::Zero());
  for (int row = 0, k = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column, ++k) {
      gradients[row * kParts / side * kParts + column * kParts / side] +=
          residual[k] * jacobian_.row(k).transpose();
    }
  }
  const Eigen::Matrix<float, 2, 6> to_pixel = affine * inverse_.topRows<2>();
  float variance = 0.0f;
  for (const Eigen::Matrix<float, 6, 1>& gradient : gradients)
    variance += (to_pixel * gradient).squaredNorm();
  // The fit takes up six of the parts.
  constexpr float kLeft = 1.0f - 6.0f / (kParts * kParts);  // from: derivation
  return 0.5f * variance / kLeft;
}

std::optional<PatchAlignment> PatchTemplate::Align(const Patch& other, const Eigen::Vector2f& pixel,
                                                   const Eigen::Matrix2f& first,
                                                   const PatchBend& bend) const {
  const Eigen::Vector2f feature = Bent(bend, offset_);
  Eigen::Matrix2f affine = first;
  Eigen::Vector2f centre = pixel - affine * feature;
  Eigen::VectorXf values(values_.size()), residual;
  PatchAlignment result;
  bool converged = false;
  for (int i = 0; i < kIterations && !converged; ++i) {
    if (!Sample(other, affine, bend, centre, &values, &result.correlation)) return std::nullopt;
    residual = values - values_;
    const Eigen::Matrix<float, 6, 1> gradient = jacobian_.transpose() * residual;
    if (i < kTranslationIterations) {
      const Eigen::Vector2f step = affine * (inverse_translation_ * gradient.head<2>());
      if (!(step.norm() < kLargestStep)) return std::nullopt;
      centre -= step;
      continue;
    }
    const Eigen::Matrix<float, 6, 1> step = inverse_ * gradient;
    Eigen::Matrix2f change;
    change << 1.0f + step[2], step[3], step[4], 1.0f + step[5];
    if (!(step.head<2>().norm() < kLargestStep) || !(change.determinant() > 0.25f)) return std::nullopt;
    affine = affine * change.inverse();
    centre -= affine * step.head<2>();
    converged = step.head<2>().norm() < kConverged;
  }
  if (!converged || !Sample(other, affine, bend, centre, &values, &result.correlation)) return std::nullopt;
  residual = values - values_;
  const float variance = residual.squaredNorm() / (static_cast<float>(residual.size()) - 10.0f);
  const Eigen::Matrix2f covariance = variance * affine * inverse_.topLeftCorner<2, 2>() * affine.transpose();
  result.sigma = std::sqrt(std::max(0.5f * covariance.trace(), VarianceOfParts(residual, affine)));
  result.pixel = centre + affine * feature;
  result.affine = affine;
  return result;
}

}  // namespace mlic
