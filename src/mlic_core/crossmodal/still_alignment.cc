#include "mlic_core/crossmodal/still_alignment.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kLeastScore = 0.15;  // of structure
// Share of the score that poses degrees off may have. from: measured, parked in streets, yards and car parks,
// three of each: 0.2 to 0.4 where the pose is right, 0.7 to 0.8 in a street where it is not.
constexpr double kMostElsewhere = 0.6;
constexpr double kMostFromGuess = 22.5;  // from: derivation, chi-square, 6 degrees of freedom, 1 in 1000
// from: guard, the covariance decides.
constexpr std::size_t kFewestMatches = 60;  // that refine what all pixels together have found

// Refines by single matches where scans are dense enough for them: of one pair that is one scan by itself.
std::optional<CameraToMapResult> RefineByMatches(const std::vector<StillPair>& pairs,
                                                 const CameraIntrinsics& intrinsics,
                                                 const StructureAlignment& found) {
  if (pairs.size() != 1) return std::nullopt;
  const CameraIntrinsics small = ScaledIntrinsics(intrinsics, found.last_scale);
  PhotoOnMap photo;
  cv::resize(pairs[0].gray, photo.gray, {small.width, small.height}, 0.0, 0.0, cv::INTER_AREA);
  if (!pairs[0].mask.empty()) {
    cv::resize(pairs[0].mask, photo.mask, photo.gray.size(), 0.0, 0.0, cv::INTER_NEAREST);
  }
  photo.T_map_body = [](double) { return RigidTransform(); };
  CameraUncertainty uncertainty;
  uncertainty.pose = found.covariance;
  return AlignCameraToMap(*pairs[0].map, small, {photo}, found.T_body_camera, uncertainty, {});
}

// Whether the matches agree with what all pixels together have found, and say more.
bool IsBetter(const CameraToMapResult& refined, const StructureAlignment& found) {
  if (!refined.settled || refined.matches[0].size() < kFewestMatches) return false;
  if (refined.covariance.determinant() >= found.covariance.determinant()) return false;
  const RigidTransform a = found.T_body_camera.Inverse(), b = refined.T_body_camera.Inverse();
  Vector6d move;
  move << Log(b.rotation * a.rotation.conjugate()), b.translation - a.translation;
  return SquaredMahalanobis(found.covariance, move) < 9.0 * 6.0;
}

}  // namespace

std::string StillAlignment::Doubt() const {
  char text[160] = "";
  if (!(found.score_after >= kLeastScore)) {
    std::snprintf(text, sizeof(text), "their score is %.2f; at least %.2f is needed", found.score_after,
                  kLeastScore);
  } else if (!(found.elsewhere <= kMostElsewhere * found.score_after)) {
    std::snprintf(text, sizeof(text),
                  "their score is %.2f, and %.2f turned %.0f deg away; at most %.2f is allowed",
                  found.score_after, found.elsewhere, kAwayDegrees, kMostElsewhere * found.score_after);
  } else if (!(found.squared_distance <= kMostFromGuess)) {
    std::snprintf(text, sizeof(text), "they fit best %.1f sigmas of the guess away; at most %.1f are allowed",
                  std::sqrt(found.squared_distance), std::sqrt(kMostFromGuess));
  }
  return text;
}

StillAlignment AlignStill(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                          const RigidTransform& T_body_camera, const Matrix6d& prior) {
  StillAlignment out;
  out.found = AlignByStructure(pairs, intrinsics, T_body_camera, prior, {});
  out.T_body_camera = out.found.T_body_camera;
  out.covariance = out.found.covariance;
  out.information = out.found.information;
  auto refined = RefineByMatches(pairs, intrinsics, out.found);
  if (!refined || !IsBetter(*refined, out.found)) return out;
  out.T_body_camera = refined->T_body_camera;
  out.covariance = refined->covariance;
  out.information = refined->covariance.inverse();
  out.refined = std::move(refined);
  return out;
}

Matrix6d CovarianceOfInverse(const RigidTransform& T, const Matrix6d& covariance) {
  const Eigen::Matrix3d R = T.rotation.toRotationMatrix();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = -R;
  J.bottomLeftCorner<3, 3>() = Hat(T.translation) * R;
  J.bottomRightCorner<3, 3>() = -R;
  return J * covariance * J.transpose();
}

}  // namespace mlic
