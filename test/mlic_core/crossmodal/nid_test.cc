#include "mlic_core/crossmodal/nid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/image_stage.h"
#include "support/pseudo_rendering.h"
#include "support/source_directory.h"

namespace mlic::nid_test {
namespace {

TEST(Nid, IsZeroForTheSameAndOneForUnrelatedValues) {
  Random random(2);
  std::vector<float> a, inverted, other;
  for (int i = 0; i < 50000; ++i) {
    a.push_back(static_cast<float>(random.Uniform()));
    inverted.push_back(std::exp(-5.0f * a.back()));
    other.push_back(static_cast<float>(random.Uniform()));
  }
  // A B-spline spreads one value over four bins, so even the same values leave some distance.
  const double same = NormalizedInformationDistance(a, a, {});
  EXPECT_LT(same, 0.75);
  // Any monotonic relation is as good: ranks are compared.
  EXPECT_NEAR(NormalizedInformationDistance(a, inverted, {}), same, 1e-3);
  EXPECT_GT(NormalizedInformationDistance(a, other, {}), 0.99);
  EXPECT_EQ(NormalizedInformationDistance({1.0f}, {2.0f}, {}), 1.0);
}

// Turned about each axis of the camera, the distance is smallest at the true pose.
TEST(Nid, IsLeastAtTheTruePose) {
  const sim::SensorSet sensors = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/paper_rig.yaml");
  sim::SimulationOptions simulation;
  simulation.duration = 20.0;
  const sim::ImageStage stage(sensors, simulation);
  const sim::SimulatedCamera& camera = stage.camera(0);
  const double time = 5.0;
  const cv::Mat gray = stage.Render(0, 3, time);
  const RigidTransform T_map_camera = stage.trajectory().PoseAt(time) * camera.calibration.T_imu_sensor;
  const RenderedStructure rendering = PseudoRendering(stage.world(), camera.intrinsics, T_map_camera, {});
  std::vector<IntensitySample> samples;
  for (int v = 0; v < gray.rows; v += 2) {
    for (int u = 0; u < gray.cols; u += 2) {
      const auto& p = rendering.points.at<cv::Vec3f>(v, u);
      const float intensity = rendering.intensity.at<float>(v, u);
      if (std::isfinite(intensity)) samples.push_back({Eigen::Vector3d(p[0], p[1], p[2]), intensity});
    }
  }
  const RigidTransform truth = T_map_camera.Inverse();
  const auto nid = [&](int axis, double degrees) {
    const RigidTransform turn{ExpQuaternion(degrees * M_PI / 180.0 * Eigen::Vector3d::Unit(axis)),
                              Eigen::Vector3d::Zero()};
    return ProjectedNid(samples, gray, {}, camera.intrinsics, turn * truth, {});
  };
  const double at_truth = nid(0, 0.0);
  EXPECT_LT(at_truth, ViewNid(rendering.intensity, cv::Mat(gray.size(), CV_8UC1, cv::Scalar(100)), {}, {}));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      double last = at_truth;
      for (const double degrees : {0.3, 0.6, 1.2}) {
        const double there = nid(axis, sign * degrees);
        EXPECT_GT(there, last) << "axis " << axis << ", " << sign * degrees << " deg";
        last = there;
      }
    }
  }
  EXPECT_NEAR(at_truth, ViewNid(rendering.intensity, gray, {}, {}), 0.02);
}

}  // namespace
}  // namespace mlic::nid_test
