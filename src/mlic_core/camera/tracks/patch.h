#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace mlic {

// Pyramid by means over 2 x 2 pixels: pixel x of the image is (x + 0.5) / 2^level - 0.5 in a level.
std::vector<cv::Mat> AreaPyramid(const cv::Mat& gray, int levels);
inline Eigen::Vector2f ToLevel(const Eigen::Vector2f& pixel, int level) {
  return ((pixel.array() + 0.5f) / static_cast<float>(1 << level) - 0.5f).matrix();
}
inline Eigen::Vector2f FromLevel(const Eigen::Vector2f& pixel, int level) {
  return ((pixel.array() + 0.5f) * static_cast<float>(1 << level) - 0.5f).matrix();
}

// The surroundings of a feature, cut out of one level of the pyramid. Coordinates below are relative to
// `corner`.
struct Patch {
  // from: derivation.
  static constexpr int kHalf = 28;  // a template of radius 7 twice as large, turned a little, and shifted
  static constexpr int kSide = 2 * kHalf + 1;  // from: derivation
  int level = 0;
  Eigen::Vector2i corner = Eigen::Vector2i::Zero();  // px of the level, of values[0]
  Eigen::Vector2f feature = Eigen::Vector2f::Zero();
  Eigen::Vector2i first = Eigen::Vector2i::Zero(), last = Eigen::Vector2i::Zero();  // that lie in the image
  std::array<std::uint8_t, kSide * kSide> values{};

  float At(int x, int y) const { return values[y * kSide + x]; }
};

// The level in which a blob of that scale (px) has a sigma of 1.2 to 2.4 px.
int LevelOfScale(double scale, int levels);
Patch CutPatch(const std::vector<cv::Mat>& pyramid, const Eigen::Vector2f& pixel, int level);

// What a warp has beyond its affine part: (u, v) of the template becomes (u, v) + bend (u^2, u v, v^2) first.
using PatchBend = Eigen::Matrix<float, 2, 3>;

// Where the feature of a template is in another patch.
struct PatchAlignment {
  Eigen::Vector2f pixel;   // in the patch, relative to its corner
  Eigen::Matrix2f affine;  // of the template's coordinates into the patch's
  float correlation = 0.0f;
  float sigma = 0.0f;  // px of the patch's level, of each coordinate, from the residuals of the fit
};

// The reference: gradients and normal equations of a patch about the pixel nearest to its feature.
class PatchTemplate {
 public:
  // Nothing where the patch leaves the image or has no structure in some direction.
  static std::optional<PatchTemplate> Make(const Patch& patch, int radius);

  // Starts with the template's feature at `pixel` (of `other`, relative to its corner) and the given affine
  // part; the bend stays as it is. Nothing where it leaves the image or diverges.
  std::optional<PatchAlignment> Align(const Patch& other, const Eigen::Vector2f& pixel,
                                      const Eigen::Matrix2f& affine,
                                      const PatchBend& bend = PatchBend::Zero()) const;

 private:
  // Variance of each coordinate (px^2) by what each part of the template pulls at: where a patch shows more
  // than one surface, or a shadow moves over it, residuals of neighbouring pixels go together, and the sum of
  // squares alone looks too good (Liang and Zeger, Biometrika 1986, with the parts as clusters).
  float VarianceOfParts(const Eigen::VectorXf& residual, const Eigen::Matrix2f& affine) const;

  // Samples `other` at the warped template: mean and shading removed, in the template's gain.
  bool Sample(const Patch& other, const Eigen::Matrix2f& affine, const PatchBend& bend,
              const Eigen::Vector2f& centre, Eigen::VectorXf* values, float* correlation) const;

  int radius_ = 0;
  Eigen::Vector2f offset_;  // of the feature from the template's middle
  // What the values have beside a gain and its gradient across the template: of them, their derivatives and
  // what is compared with them, mean and shading are removed.
  Eigen::Matrix<float, Eigen::Dynamic, 2> shading_;
  Eigen::VectorXf values_;
  Eigen::MatrixXf jacobian_;  // of values to (translation, affine part), without what the gain explains
  Eigen::Matrix<float, 6, 6> inverse_;   // of the normal matrix
  Eigen::Matrix2f inverse_translation_;  // of its part of the translation alone
};

}  // namespace mlic
