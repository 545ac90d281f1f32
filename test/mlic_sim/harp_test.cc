#include "mlic_sim/harp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "mlic_core/evaluation/harp.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic::sim::harp_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

SimulatedCamera CameraWith(CameraModel model, double fov_deg, const std::vector<double>& distortion) {
  SimulatedCamera camera;
  camera.name = "camera";
  camera.fov_deg = fov_deg;
  camera.intrinsics = IntrinsicsFromFieldOfView(model, 640, 480, fov_deg);
  camera.intrinsics.parameters[2] += 3.3;
  camera.intrinsics.parameters[3] -= 2.2;
  std::copy(distortion.begin(), distortion.end(), camera.intrinsics.parameters.begin() + 4);
  return camera;
}

// Where the bar's edge that is nearest to a found place truly is seen.
Vector2d TruePlace(const Harp& harp, const CameraIntrinsics& intrinsics, std::size_t photo,
                   const Vector2d& found) {
  const RigidTransform& T_map_camera = harp.Pose(photo);
  Vector3d bearing;
  EXPECT_TRUE(Unproject(intrinsics, found, &bearing));
  const Vector3d ray = T_map_camera.rotation * bearing;
  Vector3d point = T_map_camera.translation - T_map_camera.translation.y() / ray.y() * ray;
  const auto edge = std::min_element(harp.edges().begin(), harp.edges().end(), [&](double a, double b) {
    return std::abs(a - point.x()) < std::abs(b - point.x());
  });
  point.x() = *edge;
  Vector2d pixel;
  EXPECT_TRUE(Project(intrinsics, T_map_camera.Inverse() * point, &pixel));
  return pixel;
}

struct Measured {
  HarpMeasurement with_truth, with_error, known_error;
  double covered = 0.0;  // share of the cells of the image, 40 x 40 px, with places
};

// The harp's photos by the camera, under its own intrinsics and under wrong ones.
Measured Measure(const SimulatedCamera& camera, const CameraIntrinsics& wrong) {
  const Harp harp(camera);
  std::vector<std::string> names;
  std::vector<std::vector<HarpEdge>> edges;
  std::vector<cv::Mat> photos;
  LitPart lit;
  for (std::size_t k = 0; k < harp.PhotoCount(); ++k) {
    names.push_back(std::to_string(k));
    photos.push_back(harp.Render(k, true, 1));
    lit.Add(photos.back());
  }
  for (const cv::Mat& photo : photos) edges.push_back(FindHarpEdges(photo, lit.Mask()));
  Measured measured;
  measured.with_truth = MeasureHarp(names, edges, camera.intrinsics);
  measured.with_error = MeasureHarp(names, edges, wrong);
  std::vector<std::vector<HarpEdge>> true_edges(names.size());
  std::vector<bool> seen(16 * 12, false);
  for (std::size_t k = 0; k < names.size(); ++k) {
    for (const HarpLine& line : measured.with_error.photos[k].lines) {
      true_edges[k].emplace_back();
      for (const Vector2d& place : line.places) {
        true_edges[k].back().push_back(TruePlace(harp, camera.intrinsics, k, place));
        seen[static_cast<std::size_t>(static_cast<int>(place.y()) / 40 * 16 +
                                      static_cast<int>(place.x()) / 40)] = true;
      }
    }
  }
  measured.known_error = MeasureHarp(names, true_edges, wrong);
  measured.covered =
      static_cast<double>(std::count(seen.begin(), seen.end(), true)) / static_cast<double>(seen.size());
  return measured;
}

void Expect(const Measured& measured) {
  EXPECT_LT(measured.with_truth.all.rms, 0.15);
  EXPECT_LT(measured.with_truth.all.largest, 1.0);
  EXPECT_GT(measured.with_truth.all.lines, 100u);
  EXPECT_GT(measured.known_error.all.rms, 1.0);
  EXPECT_NEAR(measured.with_error.all.rms / measured.known_error.all.rms, 1.0, 0.05);
  EXPECT_NEAR(measured.with_error.all.largest / measured.known_error.all.largest, 1.0, 0.1);
}

TEST(Harp, KnownDistortionIsMeasured) {
  const SimulatedCamera camera = CameraWith(CameraModel::kPlumbBob, 100.0, {-0.05, 0.01, 1e-3, -5e-4});
  CameraIntrinsics wrong = camera.intrinsics;
  wrong.parameters[4] = 0.0;
  const Measured measured = Measure(camera, wrong);
  Expect(measured);
  EXPECT_EQ(measured.covered, 1.0);
}

TEST(Harp, KnownDistortionOfAFisheyeIsMeasuredPastNinetyDegrees) {
  const SimulatedCamera camera = CameraWith(CameraModel::kEquidistant, 190.0, {0.02, -0.004});
  CameraIntrinsics wrong = camera.intrinsics;
  wrong.parameters[4] = -0.01;
  const Measured measured = Measure(camera, wrong);
  Expect(measured);
  EXPECT_GT(measured.covered, 0.9);
}

}  // namespace
}  // namespace mlic::sim::harp_test
