#include "mlic_core/camera/tracks/patch_surface.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <vector>

#include "mlic_core/geometry/so3.h"
#include "support/synthetic_images.h"

namespace mlic::patch_surface_test {
namespace {

// Two wide cameras over a floor, z = 0, that they see obliquely.
class Floor : public ::testing::Test {
 protected:
  static constexpr double kTexels = 60.0;  // for each metre

  Floor() {
    lens_.model = CameraModel::kEquidistant;
    lens_.width = 320;
    lens_.height = 240;
    lens_.parameters = {150.0, 151.0, 159.0, 121.0, 0.02, -0.01, 0.002, 0.0};
    Eigen::Matrix3d forward;  // x right, y down, z forward, of a map with x forward and z up
    forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    const Eigen::Quaterniond level(forward);
    reference_ = {{level * ExpQuaternion({-0.45, 0.0, 0.05}), {0.0, 0.0, 1.5}}, &lens_};
    other_ = {{level * ExpQuaternion({-0.5, -0.35, 0.0}), {0.7, 0.8, 1.4}}, &lens_};
  }

  // Where on the floor a pixel looks; false above the horizon and far away.
  bool OnFloor(const PredictedView& view, const Eigen::Vector2d& pixel, Eigen::Vector3d* point) const {
    Eigen::Vector3d ray;
    if (!Unproject(lens_, pixel, &ray)) return false;
    ray = view.T_map_camera.rotation * ray;
    if (ray.z() > -0.25) return false;
    *point = view.T_map_camera.translation - view.T_map_camera.translation.z() / ray.z() * ray;
    return true;
  }
  bool InOther(const Eigen::Vector2d& pixel, Eigen::Vector2d* there) const {
    Eigen::Vector3d point;
    return OnFloor(reference_, pixel, &point) &&
           Project(lens_, other_.T_map_camera.Inverse() * point, there) && there->x() > 25.0 &&
           there->y() > 25.0 && there->x() < 295.0 && there->y() < 215.0;
  }
  // On a grid of that many pixels, those whose surroundings both views see.
  std::vector<Eigen::Vector2d> Pixels(double step) const {
    std::vector<Eigen::Vector2d> pixels;
    for (double y = 80.0; y < 220.0; y += step) {
      for (double x = 30.0; x < 300.0; x += step) {
        const Eigen::Vector2d pixel(x, y);
        Eigen::Vector2d there;
        bool seen = true;
        for (const auto& reach : {Eigen::Vector2d(12, 0), Eigen::Vector2d(-12, 0), Eigen::Vector2d(0, -12),
                                  Eigen::Vector2d(0, 12)}) {
          seen = seen && InOther(pixel + reach, &there);
        }
        if (seen) pixels.push_back(pixel);
      }
    }
    return pixels;
  }
  Eigen::Matrix2d Affine(const Eigen::Vector2d& pixel) const {
    Eigen::Vector2d right, left, below, above;
    EXPECT_TRUE(InOther(pixel + Eigen::Vector2d(1, 0), &right) &&
                InOther(pixel - Eigen::Vector2d(1, 0), &left));
    EXPECT_TRUE(InOther(pixel + Eigen::Vector2d(0, 1), &below) &&
                InOther(pixel - Eigen::Vector2d(0, 1), &above));
    Eigen::Matrix2d affine;
    affine << 0.5 * (right - left), 0.5 * (below - above);
    return affine;
  }
  cv::Mat Picture(const PredictedView& view, std::uint64_t seed) const {
    const auto warp = [&](const Eigen::Vector2d& pixel) -> Eigen::Vector2d {
      Eigen::Vector3d point;
      if (!OnFloor(view, pixel, &point))
        return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
      return kTexels * point.head<2>();
    };
    return RenderTexture(SyntheticTexture(3), lens_.width, lens_.height, warp, 1.0, seed);
  }
  // The piece of the floor at a pixel of the reference, its slant found from the warp into the other view.
  SurfacePiece Piece(const Eigen::Vector2d& pixel) const {
    Eigen::Vector3d point;
    EXPECT_TRUE(OnFloor(reference_, pixel, &point));
    auto piece = SurfacePiece::Make(reference_, pixel, point);
    EXPECT_TRUE(piece.has_value());
    piece->AddWarp(other_, Affine(pixel), 0.01);
    piece->EstimateSlant();
    return *piece;
  }

  CameraIntrinsics lens_;
  PredictedView reference_, other_;
};

// With the bend the warp is right to third order, without to second.
TEST_F(Floor, TheBendIsWhatTheAffineWarpLacks) {
  double flat = 0.0, bent = 0.0;
  int count = 0;
  for (const Eigen::Vector2d& pixel : Pixels(20.0)) {
    const auto bend = Piece(pixel).BendInto(other_, 0, 9.0);
    ASSERT_TRUE(bend.has_value());
    const Eigen::Matrix2d affine = Affine(pixel);
    Eigen::Vector2d middle, there;
    for (const Eigen::Vector2d& u : {Eigen::Vector2d(6, 0), Eigen::Vector2d(-4, 4), Eigen::Vector2d(0, -6)}) {
      ASSERT_TRUE(InOther(pixel, &middle) && InOther(pixel + u, &there));
      const Eigen::Vector3d squares(u.x() * u.x(), u.x() * u.y(), u.y() * u.y());
      flat += (middle + affine * u - there).norm();
      bent += (middle + affine * (u + bend->cast<double>() * squares) - there).norm();
      ++count;
    }
  }
  std::printf("warps of %d points: off by %.3f px without, %.3f px with the bend\n", count, flat / count,
              bent / count);
  EXPECT_GT(count, 30);
  EXPECT_GT(flat / count, 0.05);
  EXPECT_LT(bent, 0.1 * flat);
}

// Patches of a floor are off to one side when they are only turned, stretched and sheared.
TEST_F(Floor, AlignsWithoutTheBiasOfAnAffineWarp) {
  const auto first = AreaPyramid(Picture(reference_, 1), 1), second = AreaPyramid(Picture(other_, 2), 1);
  double flat = 0.0, bent = 0.0;
  int count = 0;
  for (const Eigen::Vector2d& pixel : Pixels(9.0)) {
    Eigen::Vector2d there;
    ASSERT_TRUE(InOther(pixel, &there));
    const auto fixed = PatchTemplate::Make(CutPatch(first, pixel.cast<float>(), 0), 9);
    const auto bend = Piece(pixel).BendInto(other_, 0, 9.0);
    if (!fixed || !bend) continue;
    const Patch patch = CutPatch(second, there.cast<float>(), 0);
    const Eigen::Matrix2f affine = Affine(pixel).cast<float>();
    const auto without = fixed->Align(patch, patch.feature, affine);
    const auto with = fixed->Align(patch, patch.feature, affine, *bend);
    if (!without || !with) continue;
    // The constant that an affine fit to the bend over the template has.
    const Eigen::Vector2f pull = affine * (bend->col(0) + bend->col(2));
    flat += pull.normalized().dot(without->pixel - patch.feature);
    bent += pull.normalized().dot(with->pixel - patch.feature);
    ++count;
  }
  std::printf("%d patches: off by %.4f px without, %.4f px with the bend\n", count, flat / count,
              bent / count);
  EXPECT_GT(count, 100);
  EXPECT_GT(flat / count, 0.03);
  EXPECT_LT(std::abs(bent / count), 0.006);
}

// Light that falls off towards the corners, over a wall that does not move: patches stay where they are.
TEST(Patch, AGainThatChangesAcrossATemplateIsNoShift) {
  constexpr int kWidth = 320, kHeight = 240, kRadius = 9;
  const auto straight = [](const Eigen::Vector2d& pixel) { return pixel; };
  const cv::Mat even = RenderTexture(SyntheticTexture(5), kWidth, kHeight, straight, 1.0, 1);
  cv::Mat darker = RenderTexture(SyntheticTexture(5), kWidth, kHeight, straight, 1.0, 2);
  const Eigen::Vector2d middle(0.5 * (kWidth - 1), 0.5 * (kHeight - 1));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double share = 1.0 - 0.5 * (Eigen::Vector2d(x, y) - middle).squaredNorm() / middle.squaredNorm();
      darker.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(share * darker.at<std::uint8_t>(y, x));
    }
  }
  const auto first = AreaPyramid(even, 1), second = AreaPyramid(darker, 1);
  double inwards = 0.0;
  int count = 0;
  for (int y = 30; y < kHeight - 30; y += 9) {
    for (int x = 30; x < kWidth - 30; x += 9) {
      const Eigen::Vector2f pixel(static_cast<float>(x), static_cast<float>(y));
      const Eigen::Vector2f from_middle = pixel - middle.cast<float>();
      if (from_middle.norm() < 80.0f) continue;
      const auto fixed = PatchTemplate::Make(CutPatch(first, pixel, 0), kRadius);
      if (!fixed) continue;
      const Patch patch = CutPatch(second, pixel, 0);
      const auto found = fixed->Align(patch, patch.feature, Eigen::Matrix2f::Identity());
      if (!found) continue;
      inwards -= from_middle.normalized().dot(found->pixel - patch.feature);
      ++count;
    }
  }
  std::printf("%d patches: %.4f px inwards\n", count, inwards / count);
  EXPECT_GT(count, 100);
  EXPECT_LT(std::abs(inwards / count), 0.005);  // 0.012 where only one gain is fitted
}

}  // namespace
}  // namespace mlic::patch_surface_test
