#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <opencv2/core/mat.hpp>

#include "mlic_core/evaluation/intrinsics_error.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/checkpoint/stage_files.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/pipeline/calibrator.h"
#include "support/files.h"
#include "support/interruption.h"
#include "support/simulated_input.h"

namespace mlic::cameras_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

// Renders every image once, however often it is asked for.
class KeptImages : public ImageSource {
 public:
  explicit KeptImages(std::shared_ptr<const ImageSource> source)
      : source_(std::move(source)), pixels_(source_->Count()), made_(source_->Count()) {}
  std::size_t Count() const override { return source_->Count(); }
  double Time(std::size_t index) const override { return source_->Time(index); }
  cv::Mat Load(std::size_t index) const override {
    std::call_once(made_.at(index), [&] { pixels_[index] = source_->Load(index); });
    return pixels_[index].clone();
  }

 private:
  std::shared_ptr<const ImageSource> source_;
  mutable std::vector<cv::Mat> pixels_;
  mutable std::vector<std::once_flag> made_;
};

// The hand-held pair of cameras with a LiDAR; images of half the size at 10 Hz, so that they are soon
// made.
sim::SensorSet SmallStereo() {
  sim::SensorSet sensors = WithHalfThePoints(ConfiguredSensors("handheld_stereo.yaml"));
  for (sim::SimulatedCamera& camera : sensors.cameras) {
    CameraIntrinsics& intrinsics = camera.intrinsics;
    intrinsics.width /= 2;
    intrinsics.height /= 2;
    for (int i = 0; i < 2; ++i) {
      intrinsics.parameters[i] *= 0.5;
      intrinsics.parameters[2 + i] = 0.5 * (intrinsics.parameters[2 + i] + 0.5) - 0.5;
    }
    camera.rate = 10.0;
  }
  return sensors;
}

struct Input : SimulatedInput {
  CalibrationResult truth;
};

const Input& Drive() {
  static const Input input = [] {
    Input made{SimulateInput(SmallStereo(), DriveOptions(sim::Scenario::kHandheld, 10.0, 3), false), {}};
    for (CameraRecording& camera : made.dataset.drives[0].cameras) {
      camera.images = std::make_shared<KeptImages>(camera.images);
    }
    const auto add = [&](const std::string& name, const SensorCalibration& calibration) {
      made.truth.sensors.emplace_back();
      made.truth.sensors.back().name = name;
      made.truth.sensors.back().calibration = calibration;
    };
    for (const auto& lidar : made.sensors.lidars) add(lidar.name, lidar.calibration);
    for (const auto& camera : made.sensors.cameras) {
      add(camera.name, camera.calibration);
      made.truth.sensors.back().type = SensorResult::Type::kCamera;
      made.truth.sensors.back().intrinsics = camera.intrinsics;
    }
    return made;
  }();
  return input;
}

// Keeps what is shown, by stage, without the points.
class Shown : public CalibrationObserver {
 public:
  void OnSnapshot(const CalibrationSnapshot& snapshot) override {
    snapshots.push_back(snapshot);
    snapshots.back().points.resize(std::min<std::size_t>(1, snapshot.points.size()));
  }
  std::vector<CalibrationSnapshot> snapshots;
};

// One run from begin to end, for all tests.
Shown shown_by_it;
const CalibrationResult& Uninterrupted() {
  static const CalibrationResult result =
      Calibrate(Drive().rig, Drive().dataset, CancellationToken(), shown_by_it);
  return result;
}

std::string YamlOf(const CalibrationResult& result) {
  const TemporaryDirectory directory;
  WriteCalibrationFile(directory.Path() / "calibration.yaml", result);
  return ReadFile(directory.Path() / "calibration.yaml");
}

// Errors by component, and their squares by the claimed variances.
struct PoseError {
  double degrees, metres, square;
};
PoseError Compare(const RigidTransform& found, const RigidTransform& truth, const PoseSigma& sigma) {
  const Eigen::Vector3d rotation = Log(found.rotation * truth.rotation.conjugate());
  const Eigen::Vector3d translation = found.translation - truth.translation;
  return {rotation.norm() / kDegree, translation.norm(),
          rotation.cwiseQuotient(sigma.rotation).squaredNorm() +
              translation.cwiseQuotient(sigma.translation).squaredNorm()};
}

TEST(CameraEndToEnd, AHandHeldPairOfCamerasWithALidarNeedsNoGuess) {
  const CalibrationResult& result = Uninterrupted();
  for (const std::string& reason : result.reasons) std::printf("  reason: %s\n", reason.c_str());
  ASSERT_TRUE(result.Trusted());
  ASSERT_EQ(result.sensors.size(), 3u);
  double square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const SensorResult& sensor = result.sensors[i];
    const SensorCalibration& truth = Drive().truth.sensors[i].calibration;
    ASSERT_EQ(sensor.name, Drive().truth.sensors[i].name);
    const PoseError error = Compare(sensor.calibration.T_imu_sensor, truth.T_imu_sensor, sensor.sigma);
    const double offset = sensor.calibration.time_offset - truth.time_offset;
    std::printf("  %s: %.4f deg, %.2f mm, %.4f ms, %.1f of 6\n", sensor.name.c_str(), error.degrees,
                1e3 * error.metres, 1e3 * offset, error.square);
    EXPECT_LT(error.degrees, 0.05) << sensor.name;
    EXPECT_LT(error.metres, 5e-3) << sensor.name;
    EXPECT_LT(std::abs(offset), 1e-4) << sensor.name;
    EXPECT_LT(std::abs(offset), 5.0 * sensor.sigma.time_offset) << sensor.name;
    // Claims neither too good nor worthless.
    EXPECT_LT(sensor.sigma.rotation.maxCoeff(), 0.05 * kDegree) << sensor.name;
    EXPECT_LT(sensor.sigma.translation.maxCoeff(), 5e-3) << sensor.name;
    square += error.square;
  }
  EXPECT_LT(square, 3.0 * 18.0);
}

TEST(CameraEndToEnd, ThePairOfCamerasAndTheIntrinsicsAreFound) {
  const CalibrationResult& result = Uninterrupted();
  ASSERT_TRUE(result.Trusted());
  const std::vector<SensorResult>& truth = Drive().truth.sensors;
  bool seen = false;
  for (const PairResult& pair : result.pairs) {
    if (pair.a != "cam_left" || pair.b != "cam_right") continue;
    seen = true;
    const PoseError error =
        Compare(pair.T_a_b, truth[1].calibration.T_imu_sensor.Inverse() * truth[2].calibration.T_imu_sensor,
                pair.sigma);
    std::printf("  pair: %.4f deg, %.2f mm, %.1f of 6\n", error.degrees, 1e3 * error.metres, error.square);
    EXPECT_LT(error.degrees, 0.05);
    EXPECT_LT(error.metres, 3e-3);
    EXPECT_LT(error.square, 30.0);
  }
  EXPECT_TRUE(seen);
  const std::vector<IntrinsicsError> errors = CompareIntrinsics(result, Drive().truth);
  ASSERT_EQ(errors.size(), 2u);
  for (const IntrinsicsError& error : errors) {
    std::printf("  %s: %.3f px, %.3f px after rotation\n", error.name.c_str(), error.mean,
                error.mean_after_rotation);
    EXPECT_GT(error.covered, 0.95) << error.name;
    EXPECT_LT(error.mean, 0.3) << error.name;
  }
}

// Images of a camera whose cap was left on.
class DarkImages : public ImageSource {
 public:
  explicit DarkImages(std::shared_ptr<const ImageSource> source) : source_(std::move(source)) {}
  std::size_t Count() const override { return source_->Count(); }
  double Time(std::size_t index) const override { return source_->Time(index); }
  cv::Mat Load(std::size_t index) const override { return 0 * source_->Load(index); }

 private:
  std::shared_ptr<const ImageSource> source_;
};

TEST(CameraEndToEnd, CamerasAreShownFromTheirFirstPosesOn) {
  Uninterrupted();
  const std::vector<CalibrationSnapshot>& shown = shown_by_it.snapshots;
  const auto first = std::find_if(shown.begin(), shown.end(), [](const auto& s) { return !s.views.empty(); });
  ASSERT_NE(first, shown.end());
  EXPECT_EQ(first->stage, "camera initialisation");
  std::vector<std::string> before_the_first_solve;
  for (auto snapshot = first; snapshot->stage != "joint adjustment with cameras"; ++snapshot) {
    before_the_first_solve.push_back(snapshot->stage);
    EXPECT_FALSE(snapshot->after_solve);
    EXPECT_EQ(snapshot->views.size(), 2u);
    EXPECT_EQ(snapshot->view_poses.size(), 2u);
    EXPECT_FALSE(snapshot->points.empty());
    EXPECT_FALSE(snapshot->landmarks.empty());
    ASSERT_EQ(snapshot->sensors.size(), 3u);
    for (std::size_t i = 1; i < 3; ++i) {
      const RigidTransform& pose = snapshot->sensors[i].T_imu_sensor;
      const RigidTransform& truth = Drive().truth.sensors[i].calibration.T_imu_sensor;
      EXPECT_LT(Log(pose.rotation * truth.rotation.conjugate()).norm(), kDegree);
    }
  }
  EXPECT_EQ(before_the_first_solve,
            (std::vector<std::string>{"camera initialisation", "cameras on first shared tracks",
                                      "cameras on shared tracks"}));
}

TEST(CameraEndToEnd, ADarkCameraIsRejectedAndAFixedLensStays) {
  Rig rig = Drive().rig;
  const std::vector<double> lens = Drive().truth.sensors[1].intrinsics->parameters;
  rig.cameras[0].intrinsics = lens;
  rig.cameras[0].intrinsics_fixed = true;
  Dataset dataset = Drive().dataset;
  CameraRecording& right = dataset.drives[0].cameras[1];
  right.images = std::make_shared<DarkImages>(right.images);
  CalibrationObserver observer;
  const CalibrationResult result = Calibrate(rig, dataset, CancellationToken(), observer);
  EXPECT_EQ(result.verdict, Verdict::kPartial);
  ASSERT_EQ(result.rejected.size(), 1u);
  EXPECT_EQ(result.rejected[0].name, "cam_right");
  ASSERT_EQ(result.sensors.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const SensorResult& sensor = result.sensors[i];
    const PoseError error = Compare(sensor.calibration.T_imu_sensor,
                                    Drive().truth.sensors[i].calibration.T_imu_sensor, sensor.sigma);
    EXPECT_LT(error.degrees, 0.05) << sensor.name;
    EXPECT_LT(error.metres, 5e-3) << sensor.name;
    EXPECT_LT(error.square, 36.0) << sensor.name;
  }
  EXPECT_EQ(result.sensors[1].intrinsics->parameters, lens);
  EXPECT_EQ(result.sensors[1].intrinsics_fixed, std::vector<bool>(lens.size(), true));
}

TEST(CameraEndToEnd, CamerasDoWithoutALidarThatCannotBeFollowed) {
  Dataset dataset = Drive().dataset;
  // The driver sends its first scan again and again.
  std::vector<LidarScan>& scans = dataset.drives[0].lidars[0].scans;
  for (LidarScan& scan : scans) scan.points = scans.front().points;
  CalibrationObserver observer;
  const CalibrationResult result = Calibrate(Drive().rig, dataset, CancellationToken(), observer);
  EXPECT_EQ(result.verdict, Verdict::kPartial);
  ASSERT_EQ(result.rejected.size(), 1u);
  EXPECT_EQ(result.rejected[0].name, "lidar");
  EXPECT_NE(result.rejected[0].reason.find("cannot be followed"), std::string::npos);
  ASSERT_EQ(result.sensors.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const SensorResult& sensor = result.sensors[i];
    const PoseError error = Compare(sensor.calibration.T_imu_sensor,
                                    Drive().truth.sensors[i + 1].calibration.T_imu_sensor, sensor.sigma);
    EXPECT_LT(error.degrees, 0.1) << sensor.name;
    EXPECT_LT(error.metres, 0.02) << sensor.name;
    EXPECT_LT(error.square, 36.0) << sensor.name;
  }
}

TEST(CameraEndToEnd, ARunThatWasKilledGoesOnToTheSameBytes) {
  const TemporaryDirectory directory;
  std::vector<std::string> lines;
  StageFiles files(directory.Path(), "inputs", [&](const std::string& line) { lines.push_back(line); });
  struct Outcome {
    std::string yaml;  // empty: interrupted
    int feature_steps, track_steps;
  };
  const auto run = [&](const std::string& stage, int round) {
    CancellationToken token;
    Interruption interruption(stage, round, &token);
    std::string yaml;
    try {
      yaml = YamlOf(Calibrate(Drive().rig, Drive().dataset, token, interruption, &files));
    } catch (const Cancelled&) {
    }
    return Outcome{yaml, interruption.Steps("image features"), interruption.Steps("tracks across cameras")};
  };
  const Outcome first = run("tracks of each camera", -1);
  EXPECT_EQ(first.yaml, "");
  EXPECT_GT(first.feature_steps, 0);
  const Outcome second = run("joint adjustment with cameras", 1);
  EXPECT_EQ(second.yaml, "");
  EXPECT_EQ(second.feature_steps, 0) << "features are not found again";
  EXPECT_GT(second.track_steps, 0);
  const Outcome third = run("joint calibration on the map", -1);
  EXPECT_EQ(third.yaml, "");
  EXPECT_EQ(third.track_steps, 0) << "images are not matched again";
  EXPECT_EQ(run("", -1).yaml, YamlOf(Uninterrupted()));
  EXPECT_TRUE(lines.empty()) << lines.front();
}

}  // namespace
}  // namespace mlic::cameras_test
