#include "mlic_core/initialization/lens_search.h"

#include <cmath>

#include "mlic_core/initialization/camera_rotation.h"

namespace mlic {
namespace {

// Some 4000 matches say 8 numbers better than the unified model can hold them; more cost time; from: guard.
constexpr std::size_t kMostPairs = 40, kMostMatches = 100;
// From each of them FitLens reaches lenses of bends 0.4 away (lens_search_test). from: measured,
// lens_search_test.
constexpr double kBends[] = {0.2, 0.5};
// from: measured, lenses of docs/cameras.md, hand-held, seed 1.
constexpr double kLargestError = 8.0;  // px, of a match that agrees with a lens of the wrong bend
// With the wrong rotation or time offset a sixth of the matches agrees, as each pair's direction is free;
// with the right ones two thirds do even under a rough lens. from: guard, between the two.
constexpr double kLeastMatchShare = 0.33;

double HalfFieldOfView(const CameraIntrinsics& lens) {
  Eigen::Vector3d left, right;
  const double row = 0.5 * (lens.height - 1);
  if (!Unproject(lens, {-0.5, row}, &left) || !Unproject(lens, {lens.width - 0.5, row}, &right)) return 0.0;
  return 0.5 * (std::atan2(right.x(), right.z()) - std::atan2(left.x(), left.z()));
}

}  // namespace

std::optional<LensFit> SearchLens(const std::vector<PixelMatches>& all,
                                  const std::vector<const SplitSpline*>& T_map_imu,
                                  const LensSearch& search) {
  const std::vector<PixelMatches> pairs = Thinned(all, kMostPairs, kMostMatches);
  const CameraIntrinsics& given = search.from_field_of_view;
  const double half_field_of_view = HalfFieldOfView(given);
  std::vector<std::optional<LensFit>> fits;
  if (search.known) {
    fits.push_back(FitLens(pairs, T_map_imu, half_field_of_view, *search.known));
  } else {
    for (const double alpha : kBends) {
      const auto lens = UnifiedLens(given.width, given.height, half_field_of_view, alpha);
      if (!lens) continue;
      const auto motions = VisualMotions(pairs, *lens, kLargestError);
      const CameraRotation rotation =
          AlignCameraRotation(motions, T_map_imu, search.guess, search.time_offset);
      if (!rotation.valid) continue;
      fits.push_back(FitLens(pairs, T_map_imu, half_field_of_view,
                             {*lens, rotation.R_imu_camera, rotation.time_offset}));
    }
  }
  std::optional<LensFit> best;
  for (const auto& fit : fits) {
    if (fit && fit->inlier_share >= kLeastMatchShare && (!best || fit->cost < best->cost)) best = fit;
  }
  return best;
}

}  // namespace mlic
