#include "mlic_core/crossmodal/view_matcher.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mlic_core/camera/learned/learned_matcher.h"
#include "mlic_core/camera/learned/toy_networks.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/image_stage.h"
#include "support/files.h"
#include "support/pseudo_rendering.h"
#include "support/source_directory.h"

namespace mlic::view_matcher_test {
namespace {

// A photo of the simulator's yard, and a stand-in for its map's rendering from a pose that is turned.
class Yard {
 public:
  explicit Yard(double error_deg) {
    sim::SensorSet sensors = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/paper_rig.yaml");
    sim::SimulatedCamera& camera = sensors.cameras[0];
    camera.intrinsics.width /= 2, camera.intrinsics.height /= 2;
    std::vector<double>& p = camera.intrinsics.parameters;
    p[0] *= 0.5, p[1] *= 0.5, p[2] = 0.5 * p[2] - 0.25, p[3] = 0.5 * p[3] - 0.25;
    intrinsics_ = camera.intrinsics;
    sim::SimulationOptions options;
    options.duration = 60.0;
    const sim::ImageStage stage(sensors, options);
    photo_ = stage.Render(0, 1, 5.0);
    truth_ = stage.trajectory().PoseAt(5.0) * camera.calibration.T_imu_sensor;
    RigidTransform from = truth_;
    from.rotation =
        truth_.rotation * ExpQuaternion(error_deg * M_PI / 180.0 * Eigen::Vector3d(0.6, 0.8, 0.0));
    pose_ = FixedPose(from);
    PseudoRenderingOptions drawing;
    drawing.beam_jitter = 0.2;
    drawing.hole_share = 0.02;
    const RenderedStructure drawn = PseudoRendering(stage.world(), intrinsics_, from, drawing);
    view_ = {drawn.intensity, drawn.range, drawn.normals, cv::Mat::zeros(photo_.size(), CV_32S),
             cv::Mat::zeros(photo_.size(), CV_32F)};
  }

  std::vector<MapMatch> Match(const ViewMatcher& matcher, double sigma_deg, int level) const {
    return matcher.Match({view_, intrinsics_, pose_, photo_, cv::Mat()},
                         UncertaintyOf(sigma_deg * M_PI / 180.0, 0.01), level);
  }
  // px, of each match.
  std::vector<double> Errors(const std::vector<MapMatch>& matches) const {
    std::vector<double> errors;
    for (const MapMatch& match : matches) {
      Eigen::Vector2d there;
      if (Project(intrinsics_, truth_.Inverse() * match.point, &there)) {
        errors.push_back((match.pixel - there).norm());
      }
    }
    return errors;
  }
  const CameraIntrinsics& intrinsics() const { return intrinsics_; }

 private:
  CameraIntrinsics intrinsics_;
  cv::Mat photo_;
  RigidTransform truth_;  // T_map_camera
  ViewPose pose_;
  RenderedView view_;
};

std::size_t CountBelow(const std::vector<double>& errors, double limit) {
  return static_cast<std::size_t>(
      std::count_if(errors.begin(), errors.end(), [&](double e) { return e < limit; }));
}

TEST(ViewMatcher, StructureIsMatchViewAtEachLevel) {
  const Yard yard(0.3);
  const auto matcher = MakeStructureViewMatcher();
  for (const int level : {0, 1}) {
    const std::vector<double> errors = yard.Errors(yard.Match(*matcher, 0.3, level));
    EXPECT_GT(errors.size(), 25u) << level;
    EXPECT_GT(CountBelow(errors, 2.0 * (1 << level)), 0.85 * static_cast<double>(errors.size())) << level;
  }
}

class FeatureViewMatcherTest : public ::testing::Test {
 protected:
  // A matcher through small networks that look for corners; they are computed and not trained.
  std::unique_ptr<FeatureMatcher> Learned() const {
    const std::vector<NetworkRuntime> runtimes = NetworkRuntimes();
    if (runtimes.empty()) return nullptr;
    if (runtimes.front() == NetworkRuntime::kOnnxRuntime) {
      WriteOnnxToyNetworks(directory_.Path(), PairingKind::kLightGlue);
    } else {
#ifdef MLIC_HAS_LIBTORCH
      WriteTorchToyNetworks(directory_.Path(), PairingKind::kLightGlue);
#endif
    }
    LearnedMatcherOptions options;
    options.weights = directory_.Path();
    return MakeLearnedMatcher(options);
  }
  TemporaryDirectory directory_;
};

TEST_F(FeatureViewMatcherTest, LearnedFeaturesOfARenderingAreFoundInThePhoto) {
  const auto features = Learned();
  if (!features) GTEST_SKIP() << "this build has no runtime of networks";
  const auto matcher = MakeFeatureViewMatcher(*features);
  const Yard yard(0.3);
  for (const int level : {0, 1}) {
    const std::vector<MapMatch> matches = yard.Match(*matcher, 0.3, level);
    const std::vector<double> errors = yard.Errors(matches);
    const double limit = 3.0 * (1 << level);  // px
    const std::size_t right = CountBelow(errors, limit);
    double squares = 0.0;
    for (const double error : errors) squares += error < limit ? 0.5 * error * error : 0.0;
    const double rms = std::sqrt(squares / static_cast<double>(right));
    std::printf("level %d: %zu matches, %zu right, rms %.2f px along an axis\n", level, errors.size(), right,
                rms);
    EXPECT_LT(rms, 1.2 * (1 << level));
    EXPECT_GT(right, level == 0 ? 40u : 5u) << "corners of a small image";
    EXPECT_GT(right, 0.6 * static_cast<double>(errors.size())) << level;
    for (const MapMatch& match : matches) {
      EXPECT_NEAR(std::sqrt(match.covariance(0, 0)), 0.92 * (1 << level), 1e-9);
      EXPECT_EQ(match.map_point, 0);
      EXPECT_GT(match.score, 0.0);
    }
  }
}

// Beyond what the camera may be wrong by nothing passes for a match.
TEST_F(FeatureViewMatcherTest, NothingIsFoundBeyondTheUncertainty) {
  const auto features = MakeClassicalMatcher();
  const auto matcher = MakeFeatureViewMatcher(*features);
  const Yard yard(1.0);  // 5 px
  const double px = 0.1 * M_PI / 180.0 * yard.intrinsics().parameters[0];
  for (const MapMatch& match : yard.Match(*matcher, 0.1, 0)) {
    EXPECT_LT((match.pixel - match.rendered).norm(), 3.0 * std::sqrt(2.0) * (px + 0.92 + 0.5) * 1.5);
  }
}

}  // namespace
}  // namespace mlic::view_matcher_test
