#include "mlic_core/summary/camera_checks.h"

#include <algorithm>

#include "mlic_core/association/landmark_noise.h"
#include "mlic_core/sensors/lens_reach.h"

namespace mlic {
namespace {

using Bound = QualityCheck::Bound;

// counts: of landmarks in each cell of the image.
QualityCheck CheckCoverage(const std::string& name, const std::vector<int>& counts) {
  const auto covered = std::count_if(counts.begin(), counts.end(), [](int count) { return count > 0; });
  QualityCheck check;
  check.name = "coverage_image";
  check.sensor = name;
  check.bound = Bound::kLeast;
  check.value = static_cast<double>(covered) / static_cast<double>(counts.size());
  check.limit = 0.5;
  check.unit = "of the image";
  check.failure = name + ": landmarks cover little of its image; the lens is not shown elsewhere";
  check.remedy = "record where structure fills the image, and turn so that it crosses all of it";
  return check;
}

// spread: of the landmarks' residuals, in units of the noise of the camera's features.
QualityCheck CheckReprojection(const std::string& name, double spread) {
  QualityCheck check;
  check.name = "reprojection_spread";
  check.sensor = name;
  check.value = spread;
  check.limit = kLargestSpread;
  check.unit = "of the noise of its features";
  check.refuses = true;
  check.failure = name + ": its landmarks do not project where it sees them";
  check.remedy = "check its lens model, shutter and stamps";
  return check;
}

QualityCheck CheckMapMatches(const std::string& name, std::size_t matches) {
  QualityCheck check;
  check.name = "map_matches";
  check.sensor = name;
  check.bound = Bound::kLeast;
  check.value = static_cast<double>(matches);
  check.limit = 1.0;
  check.unit = "matches";
  check.failure = name + ": its photos do not match the LiDAR map; its result rests on image tracks alone";
  check.remedy = "record where camera and LiDARs see the same surfaces, in daylight";
  return check;
}

QualityCheck CheckHeldOut(const std::string& name, double median) {
  QualityCheck check;
  check.name = "held_out_matches";
  check.sensor = name;
  check.value = median;
  check.limit = 3.0;  // twice what good calibrations leave of such matches (SPEC: 1.6 to 1.8 px)
  check.unit = "px";
  check.failure = name + ": places of the LiDAR map that no solve used lie off in its photos";
  check.remedy = "check the lens model and the stamps of camera and LiDARs";
  return check;
}

// Terms of the rational model that hardly differ may cancel where landmarks are seen and leave a pole where
// there are none. Other models may end within the image, as wide lenses do.
QualityCheck CheckLensReach(const std::string& name, const CameraIntrinsics& lens) {
  QualityCheck check;
  check.name = "lens_reach";
  check.sensor = name;
  check.value = ReachOfLens(lens);
  check.limit = 1.0;
  check.bound = Bound::kLeast;
  check.unit = "of the way to the image's corners";
  check.failure = name + ": its lens model folds over within the image, where nothing shows the lens";
  check.remedy = "record with structure in the corners of its image, or take a model of fewer terms";
  return check;
}

// Of the camera with the LiDAR map, in all drives.
std::size_t CountMapMatches(const JointProblem& problem, std::size_t camera) {
  std::size_t matches = 0;
  for (const DriveTerms& drive : problem.drives) {
    const LandmarkSet& set = drive.landmarks;
    for (std::size_t p = 0; p < set.points.size(); ++p) {
      if (set.IsOnMap(p) && set.observations[set.begin[p]].camera == static_cast<int>(camera)) ++matches;
    }
  }
  return matches;
}

}  // namespace

std::vector<QualityCheck> MakeCameraChecks(const std::string& name, std::size_t camera,
                                           const Adjustment& adjustment,
                                           const std::vector<ResidualSummary>& residuals) {
  std::vector<QualityCheck> checks;
  for (const ResidualSummary& residual : residuals) {
    const std::vector<int>& counts = residual.over_image.counts;
    if (residual.sensor == name && !counts.empty()) checks.push_back(CheckCoverage(name, counts));
  }
  checks.push_back(CheckReprojection(name, adjustment.cameras.landmark_options.noise[camera].spread));
  if (adjustment.rounds.landmarks == Landmarks::kTracksAndMap) {
    checks.push_back(CheckMapMatches(name, CountMapMatches(adjustment.problem, camera)));
    const std::vector<HeldOutMatches>& held_out = adjustment.map.held_out_errors;
    if (camera < held_out.size() && held_out[camera].count > 0) {
      checks.push_back(CheckHeldOut(name, held_out[camera].median));
    }
  }
  const CameraIntrinsics& lens = adjustment.state.cameras[camera].intrinsics;
  if (lens.model == CameraModel::kRationalPolynomial) checks.push_back(CheckLensReach(name, lens));
  return checks;
}

}  // namespace mlic
