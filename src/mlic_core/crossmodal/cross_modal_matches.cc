#include "mlic_core/crossmodal/cross_modal_matches.h"

#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {

CameraUncertainty UncertaintyOf(double sigma_rotation, double sigma_translation) {
  CameraUncertainty out;
  out.pose.topLeftCorner<3, 3>().setIdentity();
  out.pose.bottomRightCorner<3, 3>().setIdentity();
  out.pose.topLeftCorner<3, 3>() *= sigma_rotation * sigma_rotation;
  out.pose.bottomRightCorner<3, 3>() *= sigma_translation * sigma_translation;
  return out;
}

Eigen::Matrix2d DisplacementCovariance(const CameraIntrinsics& intrinsics, const Eigen::Vector3d& point,
                                       const CameraUncertainty& uncertainty) {
  Eigen::Matrix2d out = uncertainty.displacement * uncertainty.displacement * Eigen::Matrix2d::Identity();
  Eigen::Vector2d pixel;
  CameraPointJacobian J_point;
  CameraParameterJacobian J_parameters;
  if (!Project(intrinsics, point, &pixel, &J_point, &J_parameters)) return out;
  Eigen::Matrix<double, 2, 6> J;
  J.leftCols<3>() = -J_point * Hat(point);
  J.rightCols<3>() = J_point;
  out += J * uncertainty.pose * J.transpose();
  if (uncertainty.intrinsics.size() > 0) {
    Check(uncertainty.intrinsics.rows() == J_parameters.cols(), "DisplacementCovariance: size of intrinsics");
    out += J_parameters * uncertainty.intrinsics * J_parameters.transpose();
  }
  return out;
}

RenderedStructure StructureOf(const RenderedView& view, const CameraIntrinsics& intrinsics,
                              const ViewPose& pose) {
  RenderedStructure out;
  out.intensity = view.intensity;
  out.normals = view.normal;
  out.range = view.depth;
  out.points = cv::Mat::zeros(view.depth.size(), CV_32FC3);
  const RigidTransform fixed = pose.T_map_camera(0.0);
  ParallelFor(static_cast<std::size_t>(view.depth.rows), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    const RigidTransform T = pose.rolling ? pose.T_map_camera(v) : fixed;
    for (int u = 0; u < view.depth.cols; ++u) {
      Eigen::Vector3d bearing;
      const float depth = view.depth.at<float>(v, u);
      if (!(depth > 0.0f) || !Unproject(intrinsics, {u, v}, &bearing)) continue;
      const Eigen::Vector3f p = (T * (depth * bearing)).cast<float>();
      out.points.at<cv::Vec3f>(v, u) = {p.x(), p.y(), p.z()};
    }
  });
  return out;
}

std::vector<MapMatch> MatchView(const RenderedView& view, const CameraIntrinsics& intrinsics,
                                const ViewPose& pose, const cv::Mat& gray, const cv::Mat& mask,
                                const CameraUncertainty& uncertainty, const CrossModalOptions& options,
                                StructureMatchCounts* counts) {
  Check(view.intensity.size() == gray.size(), "MatchView: rendering and photo of different sizes");
  const StructurePyramid rendering = MapStructure(StructureOf(view, intrinsics, pose), options.structure);
  const StructurePyramid photo = PhotoStructure(gray, mask, options.structure);
  const auto predicted = [&](const Eigen::Vector2d& pixel) -> Eigen::Matrix2d {
    const float depth = view.depth.at<float>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
    Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();
    Unproject(intrinsics, pixel, &bearing);
    return DisplacementCovariance(intrinsics, (depth > 0.0f ? depth : 10.0) * bearing, uncertainty);
  };
  std::vector<MapMatch> matches;
  for (const StructureMatch& found : MatchStructure(rendering, photo, predicted, options.match, counts)) {
    MapMatch match;
    if (!SurfaceAt(view, intrinsics, pose, found.rendered, &match.point)) continue;
    match.map_point = view.point.at<std::int32_t>(static_cast<int>(found.rendered.y()),
                                                  static_cast<int>(found.rendered.x()));
    match.rendered = found.rendered;
    match.pixel = found.rendered + found.displacement;
    match.covariance = found.covariance;
    match.score = found.score;
    match.peak_ratio = found.peak_ratio;
    if (match.map_point >= 0) matches.push_back(match);
  }
  return matches;
}

}  // namespace mlic
