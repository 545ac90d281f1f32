// COLMAP for cameras that cannot be started from their fields of view, here because their pixels are not
// square, which the search for a lens takes for granted. On tracks of known points: no image is matched.

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <set>

#include "mlic_core/io/text_file.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_sim/image_stage.h"
#include "support/files.h"
#include "support/interruption.h"
#include "support/simulated_input.h"
#include "support/synthetic_tracks.h"
#include "support/true_spline.h"

namespace mlic::colmap_stage_test {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = M_PI / 180.0;

bool HasColmap() { return std::system("command -v colmap > /dev/null") == 0; }

// As they are before any camera's pose is known: no track has observations of two cameras.
TrackSet OfEachCamera(const TrackSet& shared) {
  TrackSet split{shared.keyframes, {}};
  for (const Track& track : shared.tracks) {
    std::map<int, Track> by_camera;
    for (const TrackObservation& seen : track.observations) {
      by_camera[shared.keyframes[seen.keyframe].camera].observations.push_back(seen);
    }
    for (const auto& [camera, part] : by_camera) {
      if (part.observations.size() >= 2) split.tracks.push_back(part);
    }
  }
  return split;
}

// Has the tracks as if an earlier run had found them, and keeps what is found of the cameras.
class GivenTracks : public StageStore {
 public:
  explicit GivenTracks(const TrackSet& shared) : shared_(shared), of_each_camera_(OfEachCamera(shared)) {}

  bool Load(const std::string& /*stage*/, DriveOdometry* /*odometry*/) override { return false; }
  bool Load(const std::string& /*stage*/, Initialization* /*start*/) override { return false; }
  bool Load(const std::string& /*stage*/, Adjustment* /*adjustment*/) override { return false; }
  bool Load(const std::string& /*stage*/, CameraInitialization* /*cameras*/) override { return false; }
  bool Load(const std::string& /*stage*/, ImageFeatures* features) override {
    *features = {};
    return true;
  }
  bool Load(const std::string& stage, TrackSet* tracks) override {
    *tracks = stage == "tracks_1" ? of_each_camera_ : shared_;
    return true;
  }

  void Save(const std::string& /*stage*/, const DriveOdometry& /*odometry*/) override {}
  void Save(const std::string& /*stage*/, const Initialization& /*start*/) override {}
  void Save(const std::string& /*stage*/, const Adjustment& /*adjustment*/) override {}
  void Save(const std::string& /*stage*/, const ImageFeatures& /*features*/) override {}
  void Save(const std::string& /*stage*/, const TrackSet& /*tracks*/) override {}
  void Save(const std::string& stage, const CameraInitialization& cameras) override {
    cameras_[stage] = cameras;
  }

  const CameraInitialization& Cameras(const std::string& stage) const { return cameras_.at(stage); }

 private:
  TrackSet shared_, of_each_camera_;
  std::map<std::string, CameraInitialization> cameras_;
};

// A hand-held drive and its tracks, with 0.5 px of noise.
struct TrackedDrive : SimulatedInput {
  TrackSet tracks;
};

// The pixels of the last camera are this many times as wide as high.
TrackedDrive MakeDrive(sim::SensorSet sensors, double duration, double pixel_ratio, int points = 3000) {
  sensors.cameras.back().intrinsics.parameters[1] *= pixel_ratio;
  const auto options = DriveOptions(sim::Scenario::kHandheld, duration, 3);
  TrackedDrive drive{SimulateInput(sensors, options, false), {}};
  std::vector<CameraCalibration> cameras;
  for (const sim::SimulatedCamera& camera : sensors.cameras) {
    cameras.emplace_back();
    cameras.back().sensor = camera.calibration;
    cameras.back().intrinsics = camera.intrinsics;
  }
  SyntheticTracksOptions of_tracks;
  of_tracks.duration = duration;
  of_tracks.noise = 0.5;
  of_tracks.points = points;
  drive.tracks = MakeTracks(TrueSpline(*sim::MakeTrajectory(sensors, options), duration), cameras, of_tracks);
  return drive;
}

// What COLMAP was asked for.
std::set<std::string> FoldersIn(const fs::path& directory) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory)) names.insert(entry.path().filename());
  return names;
}

void ExpectNear(const sim::SimulatedCamera& truth, const SensorCalibration& sensor,
                const CameraIntrinsics& intrinsics) {
  const RigidTransform &found = sensor.T_imu_sensor, &expected = truth.calibration.T_imu_sensor;
  EXPECT_LT(AngleBetween(found.rotation, expected.rotation), 0.1 * kDegree) << truth.name;
  EXPECT_LT((found.translation - expected.translation).norm(), 0.01) << truth.name;
  EXPECT_NEAR(sensor.time_offset, truth.calibration.time_offset, 3e-4) << truth.name;
  // px; the centre trades with the rotation where pixels are high.
  EXPECT_LT(MeanDisplacement(truth.intrinsics, intrinsics), 3.0) << truth.name;
}

TEST(ColmapFallback, StartsOnlyTheCameraThatIsLostBesideALidar) {
  if (!HasColmap()) GTEST_SKIP() << "no colmap on this machine";
  const TrackedDrive drive = MakeDrive(ConfiguredSensors("handheld_stereo.yaml"), 10.0, 0.2);
  const TemporaryDirectory directory;
  CalibrationOptions options;
  options.colmap_directory = directory.Path();
  GivenTracks store(drive.tracks);
  CancellationToken token;
  Interruption interruption("first tracks across cameras", -1, &token);
  EXPECT_THROW(Calibrate(drive.rig, drive.dataset, token, interruption, &store, options), Cancelled);
  EXPECT_EQ(store.Cameras("cameras").found, std::vector<bool>({true, false}));
  EXPECT_EQ(FoldersIn(directory.Path()), std::set<std::string>{"cam_right"});
  EXPECT_EQ(store.Cameras("colmap").found, std::vector<bool>({false, true}));
  const CameraInitialization& started = store.Cameras("cameras_from_colmap");
  ASSERT_EQ(started.found, std::vector<bool>(2, true));
  for (std::size_t c = 0; c < 2; ++c) {
    ExpectNear(drive.sensors.cameras[c], started.cameras[c].sensor, started.cameras[c].intrinsics);
  }
}

// One camera without a LiDAR.
TrackedDrive MakeSingleDrive(double pixel_ratio, int points) {
  sim::SensorSet sensors = ConfiguredSensors("stereo_imu.yaml");
  sensors.cameras.resize(1);
  return MakeDrive(sensors, 15.0, pixel_ratio, points);
}

TEST(ColmapFallback, StartsTheOnlyCameraOfARigWithoutLidars) {
  if (!HasColmap()) GTEST_SKIP() << "no colmap on this machine";
  const TrackedDrive drive = MakeSingleDrive(2.5, 8000);
  const TemporaryDirectory directory;
  CalibrationOptions options;
  options.colmap_directory = directory.Path();
  GivenTracks store(drive.tracks);
  CalibrationObserver observer;
  const CalibrationResult result =
      Calibrate(drive.rig, drive.dataset, CancellationToken(), observer, &store, options);
  EXPECT_EQ(store.Cameras("cameras").found, std::vector<bool>{false});
  EXPECT_EQ(FoldersIn(directory.Path()), std::set<std::string>{"cam_left"});
  EXPECT_TRUE(result.Trusted());
  EXPECT_TRUE(result.reasons.empty());
  EXPECT_TRUE(result.rejected.empty());
  ASSERT_EQ(result.sensors.size(), 1u);
  ExpectNear(drive.sensors.cameras[0], result.sensors[0].calibration, *result.sensors[0].intrinsics);
}

// Programs are only found in this directory as long as it lives.
class OnlyProgramsIn {
 public:
  explicit OnlyProgramsIn(const fs::path& directory) : before_(std::getenv("PATH")) {
    setenv("PATH", directory.c_str(), 1);
  }
  ~OnlyProgramsIn() { setenv("PATH", before_.c_str(), 1); }
  OnlyProgramsIn(const OnlyProgramsIn&) = delete;
  OnlyProgramsIn& operator=(const OnlyProgramsIn&) = delete;

 private:
  std::string before_;
};

// Two cameras without a LiDAR, the right one lost. programs: where COLMAP is looked for.
CalibrationResult CalibrateWithPrograms(const fs::path& programs) {
  static const TrackedDrive drive = MakeDrive(ConfiguredSensors("stereo_imu.yaml"), 15.0, 3.0);
  const OnlyProgramsIn only(programs);
  const TemporaryDirectory directory;
  CalibrationOptions options;
  options.colmap_directory = directory.Path();
  GivenTracks store(drive.tracks);
  CalibrationObserver observer;
  const CalibrationResult result =
      Calibrate(drive.rig, drive.dataset, CancellationToken(), observer, &store, options);
  EXPECT_EQ(FoldersIn(directory.Path()), std::set<std::string>{"cam_right"});
  EXPECT_EQ(result.verdict, Verdict::kPartial);
  EXPECT_EQ(result.reasons.size(), 1u);
  if (result.rejected.size() != 1 || result.sensors.size() != 1) {
    ADD_FAILURE() << result.rejected.size() << " rejected, " << result.sensors.size() << " left";
    return result;
  }
  EXPECT_EQ(result.rejected[0].name, "cam_right");
  EXPECT_TRUE(Contains(result.rejected[0].reason, "do not turn as the IMU does"));
  ExpectNear(drive.sensors.cameras[0], result.sensors[0].calibration, *result.sensors[0].intrinsics);
  return result;
}

TEST(ColmapFallback, WithoutColmapTheCameraIsRejectedAlone) {
  const TemporaryDirectory empty;
  const CalibrationResult result = CalibrateWithPrograms(empty.Path());
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_TRUE(Contains(result.warnings[0], "apt-get install colmap"));
}

TEST(ColmapFallback, WhereColmapFailsTheCameraIsRejectedAlone) {
  const TemporaryDirectory programs;
  const fs::path failing = programs.Path() / "colmap";
  WriteFileAtomically(failing, "#!/bin/sh\nexit 1\n");
  fs::permissions(failing, fs::perms::owner_all);
  EXPECT_TRUE(CalibrateWithPrograms(programs.Path()).warnings.empty());
}

// It turns as the IMU does, but under no lens found do its points agree with the motion.
TEST(ColmapFallback, WithoutColmapARigOfOneSuchCameraIsRefused) {
  const TrackedDrive drive = MakeSingleDrive(2.3, 3000);
  const TemporaryDirectory empty;
  const OnlyProgramsIn only(empty.Path());
  GivenTracks store(drive.tracks);
  CalibrationObserver observer;
  const CalibrationResult result = Calibrate(drive.rig, drive.dataset, CancellationToken(), observer, &store);
  EXPECT_EQ(result.verdict, Verdict::kRefused);
  ASSERT_FALSE(result.reasons.empty());
  EXPECT_TRUE(Contains(result.reasons[0], "check model and field of view"));
  ASSERT_EQ(result.rejected.size(), 1u);
  EXPECT_TRUE(Contains(result.rejected[0].reason, "observations of points agree"));
}

}  // namespace
}  // namespace mlic::colmap_stage_test
