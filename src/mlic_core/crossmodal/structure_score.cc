#include "mlic_core/crossmodal/structure_score.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/crossmodal/cross_modal_matches.h"
#include "mlic_core/crossmodal/renderer.h"
#include "mlic_core/crossmodal/view_selection.h"

namespace mlic {
namespace {

// px: structure is blurred over more, so that every second pixel of every second row says as much as all.
constexpr int kPixelStep = 2;  // from: guard, time

// In how many pixels a surface of a square metre is seen from a place, against one that faces it a metre
// away. Without a normal it faces every place.
double Facing(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, const Eigen::Vector3d& from) {
  constexpr double kFlattest = 0.02;  // from: guard, normals are not known better
  const Eigen::Vector3d to = from - point;
  const double distance = std::max(1e-3, to.norm());
  const double cosine = normal.isZero() ? 1.0 : std::max(kFlattest, normal.dot(to) / distance);
  return cosine / (distance * distance);
}

}  // namespace

ShrunkPhotos ShrinkPhotos(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                          double scale, const StructureOptions& options) {
  ShrunkPhotos photos{ScaledIntrinsics(intrinsics, scale), {}};
  const cv::Size size(photos.intrinsics.width, photos.intrinsics.height);
  for (const StillPair& pair : pairs) {
    cv::Mat gray, mask;
    cv::resize(pair.gray, gray, size, 0.0, 0.0, cv::INTER_AREA);
    if (!pair.mask.empty()) cv::resize(pair.mask, mask, size, 0.0, 0.0, cv::INTER_NEAREST);
    photos.structure.push_back(PhotoStructure(gray, mask, options));
  }
  return photos;
}

StructureScore::StructureScore(const std::vector<StillPair>& pairs, const ShrunkPhotos& photos,
                               const StructureOptions& options, const RigidTransform& T_body_camera)
    : photos_(&photos) {
  const CameraIntrinsics& intrinsics = photos.intrinsics;
  const ViewPose pose = FixedPose(T_body_camera);
  std::vector<float> depths;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const RenderedView view = ViewRenderer(*pairs[i].map, intrinsics, RenderOptions()).Render(pose);
    const StructurePyramid rendering = MapStructure(StructureOf(view, intrinsics, pose), options);
    const StructureImage& image = rendering[0];
    for (int v = 0; v < image.height; v += kPixelStep) {
      for (int u = 0; u < image.width; u += kPixelStep) {
        Sample sample;
        if (!(image.Weight(v)[u] > 0.0f) || !(image.Energy(v)[u] > 0.0f)) continue;
        if (!SurfaceAt(view, intrinsics, pose, Eigen::Vector2d(u, v), &sample.point)) continue;
        for (int k = 0; k < StructureImage::kChannels; ++k) {
          sample.structure[k] = image.Channels(v)[u * StructureImage::kChannels + k];
        }
        const cv::Vec3f& n = view.normal.at<cv::Vec3f>(v, u);
        sample.normal = Eigen::Vector3d(n[0], n[1], n[2]);
        sample.area =
            kPixelStep * kPixelStep / Facing(sample.point, sample.normal, T_body_camera.translation);
        sample.weight = image.Weight(v)[u];
        sample.pair = i;
        samples_.push_back(sample);
        depths.push_back(view.depth.at<float>(v, u));
      }
    }
  }
  if (depths.empty()) return;
  typical_depth_ = Median(std::move(depths));
}

StructureScore::Value StructureScore::At(const RigidTransform& T_camera_body) const {
  constexpr int kChannels = StructureImage::kChannels;  // from: structural
  using Channels = Eigen::Matrix<float, kChannels, 1>;
  const Eigen::Matrix3d R = T_camera_body.rotation.toRotationMatrix();
  const Eigen::Vector3d camera = T_camera_body.Inverse().translation;
  Value value;
  double both = 0.0, of_samples = 0.0, of_photo = 0.0;
  for (const Sample& sample : samples_) {
    const double weight = sample.weight * sample.area * Facing(sample.point, sample.normal, camera);
    value.weight += weight;
    of_samples += weight * sample.structure.squaredNorm();
    Eigen::Vector2d pixel;
    if (!Project(intrinsics(), R * sample.point + T_camera_body.translation, &pixel)) continue;
    const int u = static_cast<int>(std::floor(pixel.x())), v = static_cast<int>(std::floor(pixel.y()));
    const StructureImage& photo = photos_->structure[sample.pair][0];
    if (u < 0 || v < 0 || u + 1 >= photo.width || v + 1 >= photo.height) continue;
    const auto a = static_cast<float>(pixel.x() - u), b = static_cast<float>(pixel.y() - v);
    const float* upper = photo.Channels(v) + u * kChannels;
    const float* lower = photo.Channels(v + 1) + u * kChannels;
    using Map = Eigen::Map<const Channels>;
    const Channels seen = (1.0f - b) * ((1.0f - a) * Map(upper) + a * Map(upper + kChannels)) +
                          b * ((1.0f - a) * Map(lower) + a * Map(lower + kChannels));
    both += weight * seen.dot(sample.structure);
    of_photo += weight * seen.squaredNorm();
  }
  value.correlation = both / std::sqrt(of_samples * of_photo + 1e-12);
  return value;
}

}  // namespace mlic
