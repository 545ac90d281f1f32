#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/parallel.h"
#include "mlic_core/common/random.h"
#include "mlic_core/crossmodal/structure_features.h"
#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"
#include "mlic_sim/world.h"

namespace mlic {

// A stand-in for a rendered LiDAR map that needs no map: near-infrared reflectance where each pixel's ray
// ends, with the faults of maps: beams off their pixel, noise, foreground that is too wide, holes, nothing
// far away.
struct PseudoRenderingOptions {
  double beam_jitter = 0.5;  // px, of each beam's place
  double intensity_noise = 0.04;
  double range_noise = 0.01;  // m
  double hole_share = 0.1;    // of the pixels, in patches of some pixels
  bool splat = true;          // foreground one pixel too wide
  double farthest = 60.0;     // m
  bool invert_half = false;   // every other material is bright where it was dark
  std::uint64_t seed = 1;
};

inline cv::Vec3f ToVec3f(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

inline RenderedStructure PseudoRendering(const sim::World& world, const CameraIntrinsics& intrinsics,
                                         const RigidTransform& T_map_camera,
                                         const PseudoRenderingOptions& options) {
  const int width = intrinsics.width, height = intrinsics.height;
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  RenderedStructure raw{cv::Mat(height, width, CV_32FC1, cv::Scalar(nothing)),
                        cv::Mat::zeros(height, width, CV_32FC3), cv::Mat::zeros(height, width, CV_32FC3),
                        cv::Mat::zeros(height, width, CV_32FC1)};
  const Random seed(options.seed);
  ParallelFor(static_cast<std::size_t>(height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    Random random = seed.Fork(row);
    for (int u = 0; u < width; ++u) {
      const double du = options.beam_jitter * random.Normal(), dv = options.beam_jitter * random.Normal();
      const double noise = options.intensity_noise * random.Normal(),
                   error = options.range_noise * random.Normal();
      Eigen::Vector3d bearing;
      if (!Unproject(intrinsics, {u + du, v + dv}, &bearing)) continue;
      const Eigen::Vector3d direction = T_map_camera.rotation * bearing;
      const auto hit = world.Cast(T_map_camera.translation, direction, options.farthest);
      if (!hit) continue;
      float value = sim::ReflectanceOf(hit->material, hit->position, hit->normal, hit->object).near_infrared;
      if (options.invert_half && (static_cast<int>(hit->material) + hit->object) % 2 == 1)
        value = 1.0f - value;
      const Eigen::Vector3d p = hit->position + error * direction;
      raw.intensity.at<float>(v, u) = value + static_cast<float>(noise);
      raw.points.at<cv::Vec3f>(v, u) = ToVec3f(p);
      raw.normals.at<cv::Vec3f>(v, u) = ToVec3f(hit->normal);
      raw.range.at<float>(v, u) = static_cast<float>(hit->range + error);
    }
  });
  // Points are drawn larger than a pixel: the nearest of the neighbours wins where it is much nearer, unless
  // it is of the same plane (a floor seen at a slant is drawn where it is).
  RenderedStructure out{raw.intensity.clone(), raw.points.clone(), raw.normals.clone(), raw.range.clone()};
  for (int v = 1; options.splat && v + 1 < height; ++v) {
    for (int u = 1; u + 1 < width; ++u) {
      for (int k = 0; k < 9; ++k) {
        const int y = v + k / 3 - 1, x = u + k % 3 - 1;
        const float range = raw.range.at<float>(y, x), current = out.range.at<float>(v, u);
        if (!(range > 0.0f) || (current > 0.0f && range > 0.97f * current)) continue;
        const cv::Vec3f off = raw.points.at<cv::Vec3f>(y, x) - raw.points.at<cv::Vec3f>(v, u);
        if (current > 0.0f && std::abs(raw.normals.at<cv::Vec3f>(v, u).dot(off)) < 0.03f) continue;
        out.intensity.at<float>(v, u) = raw.intensity.at<float>(y, x);
        out.points.at<cv::Vec3f>(v, u) = raw.points.at<cv::Vec3f>(y, x);
        out.normals.at<cv::Vec3f>(v, u) = raw.normals.at<cv::Vec3f>(y, x);
        out.range.at<float>(v, u) = range;
      }
    }
  }
  Random holes = seed.Fork(1u << 20);
  const int count = static_cast<int>(options.hole_share * width * height / 28.0);
  for (int i = 0; i < count; ++i) {
    const cv::Point center(static_cast<int>(holes.Uniform(0, width)),
                           static_cast<int>(holes.Uniform(0, height)));
    cv::circle(out.intensity, center, 3, cv::Scalar(nothing), -1);
    cv::circle(out.range, center, 3, cv::Scalar(0.0), -1);
    cv::circle(out.normals, center, 3, cv::Scalar::all(0.0), -1);
  }
  return out;
}

}  // namespace mlic
