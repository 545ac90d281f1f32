#include "mlic_core/crossmodal/camera_to_map.h"

#include <Eigen/Dense>
#include <cmath>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

struct Round {
  std::vector<std::vector<MapMatch>> matches;
  std::vector<PointCorrespondence> correspondences;  // of all photos, in order
  double nid = 1.0;
};

ViewPose PoseOf(const PhotoOnMap& photo, const RigidTransform& T_body_camera) {
  return {[&photo, T_body_camera](double row) { return photo.T_map_body(row) * T_body_camera; },
          photo.rolling};
}

// Renders and matches all photos, each by itself. structures: of the photos.
Round MatchAll(const ViewRenderer& renderer, const CameraIntrinsics& intrinsics,
               const std::vector<PhotoOnMap>& photos, const std::vector<StructurePyramid>& structures,
               const RigidTransform& T_body_camera, const CameraUncertainty& uncertainty,
               const CameraToMapOptions& options) {
  Round round;
  round.matches.resize(photos.size());
  std::vector<double> nids(photos.size());
  ParallelFor(photos.size(), [&](std::size_t i) {
    const PhotoOnMap& photo = photos[i];
    const ViewPose pose = PoseOf(photo, T_body_camera);
    const RenderedView view = renderer.Render(pose);
    nids[i] = ViewNid(view.intensity, photo.gray, photo.mask, options.nid);
    round.matches[i] = MatchView(view, intrinsics, pose, structures[i], uncertainty, options.matching);
  });
  round.nid = 0.0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    round.nid += nids[i] / static_cast<double>(photos.size());
    for (const MapMatch& match : round.matches[i]) {
      round.correspondences.push_back(
          {photos[i].T_map_body(match.pixel.y()).Inverse() * match.point, match.pixel, match.covariance});
    }
  }
  return round;
}

void KeepInliers(const std::vector<bool>& inlier, std::vector<std::vector<MapMatch>>* matches) {
  std::size_t i = 0;
  for (std::vector<MapMatch>& of_photo : *matches) {
    std::vector<MapMatch> kept;
    for (const MapMatch& match : of_photo) {
      if (inlier[i++]) kept.push_back(match);
    }
    of_photo = std::move(kept);
  }
}

// How far b is from a, in sigmas of b, along the direction where that is most.
double MoveInSigmas(const RigidTransform& a, const PnpResult& b) {
  Vector6d move;
  move.head<3>() = Log(a.rotation * b.T_camera_body.rotation.conjugate());
  move.tail<3>() = a.translation - b.T_camera_body.translation;
  return std::sqrt(SquaredMahalanobis(b.covariance, move));
}

}  // namespace

std::optional<CameraToMapResult> AlignCameraToMap(const IntensityMap& map, const CameraIntrinsics& intrinsics,
                                                  const std::vector<PhotoOnMap>& photos,
                                                  const RigidTransform& T_body_camera,
                                                  const CameraUncertainty& uncertainty,
                                                  const CameraToMapOptions& options) {
  const ViewRenderer renderer(map, intrinsics, options.render);
  std::vector<StructurePyramid> structures(photos.size());
  ParallelFor(photos.size(), [&](std::size_t i) {
    structures[i] = PhotoStructure(photos[i].gray, photos[i].mask, options.matching.structure);
  });
  CameraToMapResult result;
  result.T_body_camera = T_body_camera;
  CameraUncertainty current = uncertainty;
  for (int i = 0; i < options.most_rounds && !result.settled; ++i) {
    Round round = MatchAll(renderer, intrinsics, photos, structures, result.T_body_camera, current, options);
    if (i == 0) result.nid_before = round.nid;
    const RigidTransform before = result.T_body_camera.Inverse();
    const auto pose = EstimatePose(round.correspondences, intrinsics, options.pose, &before);
    if (!pose) return std::nullopt;
    KeepInliers(pose->inlier, &round.matches);
    result.settled = MoveInSigmas(before, *pose) < options.settled;
    result.T_body_camera = pose->T_camera_body.Inverse();
    result.covariance = pose->covariance;
    result.matches = std::move(round.matches);
    result.inlier_share = pose->inliers / static_cast<double>(round.correspondences.size());
    result.rounds = i + 1;
    // What the map and the intrinsics are wrong by is not in the covariance of a pose from many matches.
    current.pose = 9.0 * pose->covariance;
  }
  double nid = 0.0;
  std::vector<double> nids(photos.size());
  ParallelFor(photos.size(), [&](std::size_t i) {
    const RenderedView view = renderer.Render(PoseOf(photos[i], result.T_body_camera));
    nids[i] = ViewNid(view.intensity, photos[i].gray, photos[i].mask, options.nid);
  });
  for (const double of_photo : nids) nid += of_photo / static_cast<double>(photos.size());
  result.nid_after = nid;
  return result;
}

}  // namespace mlic
