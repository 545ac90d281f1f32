#include "mlic_core/camera/colmap/colmap.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "mlic_core/camera/colmap/colmap_camera.h"
#include "mlic_core/camera/colmap/colmap_database.h"
#include "mlic_core/camera/colmap/colmap_process.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic::colmap_test {
namespace {

namespace fs = std::filesystem;

constexpr int kKeyframes = 14;
constexpr int kPoints = 1200;

bool HasColmap() { return std::system("command -v colmap > /dev/null") == 0; }

class TemporaryPlace {
 public:
  explicit TemporaryPlace(const std::string& name)
      : path_(fs::temp_directory_path() / ("mlic_colmap_" + name + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~TemporaryPlace() { fs::remove_all(path_); }
  const fs::path& Path() const { return path_; }

 private:
  fs::path path_;
};

// A camera that moves on an arc inside a shell of points and turns a little.
struct Scene {
  std::vector<RigidTransform> T_world_camera;
  TrackSet tracks;
};

Scene MakeScene(const CameraIntrinsics& camera, double pixel_noise) {
  Scene scene;
  Random random(5);
  for (int k = 0; k < kKeyframes; ++k) {
    const double s = static_cast<double>(k) / (kKeyframes - 1) - 0.5;
    scene.T_world_camera.push_back(
        {FromRollPitchYaw({0.3 * std::sin(5.0 * s), 0.25 * s, 0.2 * std::cos(7.0 * s)}),
         {6.0 * s, 1.5 * std::sin(4.0 * s), 2.0 * std::cos(3.0 * s)}});
    scene.tracks.keyframes.push_back({0, static_cast<std::size_t>(k), 0.1 * k});
  }
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d direction(random.Uniform(-1.5, 1.5), random.Uniform(-1.2, 1.2), 1.0);
    const Eigen::Vector3d point = direction.normalized() * random.Uniform(5.0, 18.0);
    Track track;
    for (int k = 0; k < kKeyframes; ++k) {
      Eigen::Vector2d pixel;
      const Eigen::Vector3d in_camera = scene.T_world_camera[static_cast<std::size_t>(k)].Inverse() * point;
      if (!Project(camera, in_camera, &pixel) || in_camera.z() < 0.1) continue;
      pixel += pixel_noise * Eigen::Vector2d(random.Normal(), random.Normal());
      if (pixel.x() < 0.0 || pixel.y() < 0.0 || pixel.x() > camera.width - 1 || pixel.y() > camera.height - 1)
        continue;
      track.observations.push_back({k, pixel.cast<float>(), 0.5f});
    }
    if (track.observations.size() >= 2) scene.tracks.tracks.push_back(track);
  }
  return scene;
}

double MeanDisplacement(const CameraIntrinsics& a, const CameraIntrinsics& b, double largest_angle) {
  double sum = 0.0;
  int count = 0;
  for (double x = 0.0; x < a.width; x += 40.0) {
    for (double y = 0.0; y < a.height; y += 40.0) {
      Eigen::Vector3d bearing;
      Eigen::Vector2d pixel;
      if (!Unproject(a, {x, y}, &bearing) || std::acos(bearing.z()) > largest_angle) continue;
      if (!Project(b, bearing, &pixel)) return 1e9;
      sum += (pixel - Eigen::Vector2d(x, y)).norm();
      ++count;
    }
  }
  return sum / count;
}

// Largest angle between true and found relative rotations, deg; largest angle between directions of travel.
void ExpectPoses(const Scene& scene, const ColmapModel& model, double degrees) {
  for (int k = 1; k < kKeyframes; ++k) {
    ASSERT_TRUE(model.T_world_camera[static_cast<std::size_t>(k)].has_value()) << k;
    const RigidTransform found =
        model.T_world_camera[0]->Inverse() * *model.T_world_camera[static_cast<std::size_t>(k)];
    const RigidTransform truth =
        scene.T_world_camera[0].Inverse() * scene.T_world_camera[static_cast<std::size_t>(k)];
    EXPECT_LT(AngleBetween(found.rotation, truth.rotation) * 180.0 / M_PI, degrees) << k;
    const double cosine = found.translation.normalized().dot(truth.translation.normalized());
    EXPECT_GT(cosine, 0.9995) << k;
  }
}

void ExpectRecovered(const CameraIntrinsics& truth, double fov_deg, double largest_angle) {
  if (!HasColmap()) GTEST_SKIP() << "no colmap on this machine";
  const TemporaryPlace place(std::to_string(static_cast<int>(truth.model)));
  const Scene scene = MakeScene(truth, 0.3);
  const CameraIntrinsics start = IntrinsicsFromFieldOfView(truth.model, truth.width, truth.height, fov_deg);
  const ColmapInput input = ColmapInputFromTracks(scene.tracks, 0, start);
  const ColmapOutcome outcome = RunColmap(input, {}, place.Path() / "0", CancellationToken());
  ASSERT_TRUE(outcome.model.has_value()) << outcome.problem;
  const ColmapModel& model = *outcome.model;
  EXPECT_TRUE(model.problems.empty()) << model.problems[0];
  EXPECT_EQ(model.registered_share, 1.0);
  EXPECT_NEAR(model.reprojection_rms, 0.3 * std::sqrt(2.0), 0.06);
  EXPECT_GT(model.coverage, 0.6);
  EXPECT_EQ(model.intrinsics.model, truth.model);
  std::printf("start off by %.2f px, result by %.3f px\n", MeanDisplacement(truth, start, largest_angle),
              MeanDisplacement(truth, model.intrinsics, largest_angle));
  EXPECT_GT(MeanDisplacement(truth, start, largest_angle), 5.0);
  EXPECT_LT(MeanDisplacement(truth, model.intrinsics, largest_angle), 1.0);
  ExpectPoses(scene, model, 0.1);
}

TEST(Colmap, RecoversPlumbBob) {
  ExpectRecovered({CameraModel::kPlumbBob, 1280, 800, {640, 642, 648, 393, -0.1, 0.02, 5e-4, -4e-4, 0.0}}, 95,
                  1.5);
}

TEST(Colmap, RecoversEquidistant) {
  ExpectRecovered({CameraModel::kEquidistant, 1280, 960, {380, 381, 645, 474, 0.02, -0.005, 0.001, 0.0}}, 180,
                  1.3);
}

TEST(Colmap, RecoversDoubleSphere) {
  ExpectRecovered({CameraModel::kDoubleSphere, 1280, 960, {380, 381, 645, 474, 0.12, 0.58}}, 190, 1.3);
}

TEST(Colmap, SameInputSameOutput) {
  if (!HasColmap()) GTEST_SKIP() << "no colmap on this machine";
  const TemporaryPlace place("same");
  const CameraIntrinsics truth{CameraModel::kPlumbBob, 1280, 800, {640, 640, 640, 400, 0, 0, 0, 0, 0}};
  const Scene scene = MakeScene(truth, 0.3);
  const ColmapInput input = ColmapInputFromTracks(
      scene.tracks, 0, IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 1280, 800, 95));
  ColmapInput named = input;
  named.folder = "cam_left";
  std::vector<double> progress;
  const auto outcomes = RunColmap({input, named}, {}, place.Path(), CancellationToken(),
                                  [&](double fraction) { progress.push_back(fraction); });
  EXPECT_TRUE(fs::exists(place.Path() / "0" / "colmap.log"));
  EXPECT_TRUE(fs::exists(place.Path() / "cam_left" / "colmap.log"));
  EXPECT_TRUE(std::is_sorted(progress.begin(), progress.end()));
  ASSERT_GE(progress.size(), 2u);
  EXPECT_EQ(progress.back(), 1.0);
  ASSERT_TRUE(outcomes[0].model && outcomes[1].model) << outcomes[0].problem;
  EXPECT_EQ(outcomes[0].model->intrinsics.parameters, outcomes[1].model->intrinsics.parameters);
  EXPECT_EQ(outcomes[0].model->points, outcomes[1].model->points);
}

TEST(Colmap, MissingProgramNamesThePackage) {
  const TemporaryPlace place("missing");
  const CameraIntrinsics truth{CameraModel::kPlumbBob, 1280, 800, {640, 640, 640, 400, 0, 0, 0, 0, 0}};
  ColmapOptions options;
  options.program = "no_such_program_as_colmap";
  const ColmapInput input = ColmapInputFromTracks(MakeScene(truth, 0.3).tracks, 0, truth);
  const ColmapOutcome outcome = RunColmap(input, options, place.Path() / "0", CancellationToken());
  EXPECT_FALSE(outcome.model.has_value());
  EXPECT_FALSE(outcome.installed);
  EXPECT_NE(outcome.problem.find("apt-get install colmap"), std::string::npos) << outcome.problem;
}

TEST(Colmap, ImagesWithoutParallaxAreExplained) {
  if (!HasColmap()) GTEST_SKIP() << "no colmap on this machine";
  const TemporaryPlace place("still");
  const CameraIntrinsics truth{CameraModel::kPlumbBob, 1280, 800, {640, 640, 640, 400, 0, 0, 0, 0, 0}};
  Scene scene = MakeScene(truth, 0.0);
  for (Track& track : scene.tracks.tracks) {  // a camera that never moves
    const Eigen::Vector2f pixel = track.observations[0].pixel;
    track.observations.clear();
    for (int k = 0; k < kKeyframes; ++k) track.observations.push_back({k, pixel, 0.5f});
  }
  const ColmapInput input = ColmapInputFromTracks(scene.tracks, 0, truth);
  const ColmapOutcome outcome = RunColmap(input, {}, place.Path() / "0", CancellationToken());
  EXPECT_FALSE(outcome.model.has_value());
  EXPECT_NE(outcome.problem.find("parallax"), std::string::npos) << outcome.problem;
  scene.tracks.tracks.resize(3);
  const ColmapInput few = ColmapInputFromTracks(scene.tracks, 0, truth);
  EXPECT_NE(RunColmap(few, {}, place.Path() / "1", CancellationToken()).problem.find("too few"),
            std::string::npos);
}

TEST(ColmapProcess, IsKilledWhenCancelled) {
  const TemporaryPlace place("cancel");
  CancellationToken token;
  std::thread other([&] {
    while (!fs::exists(place.Path() / "started")) std::this_thread::yield();
    token.Cancel();
  });
  const std::string command = "echo $$ > '" + (place.Path() / "started").string() + "'; exec sleep 600";
  EXPECT_THROW(RunProcess({"/bin/sh", "-c", command}, place.Path() / "log", token), Cancelled);
  other.join();
}

TEST(ColmapProcess, StatusAndLastLine) {
  const TemporaryPlace place("status");
  const ProcessEnd end = RunProcess({"/bin/sh", "-c", "echo first; echo last >&2; echo; exit 3"},
                                    place.Path() / "log", CancellationToken());
  EXPECT_EQ(end.status, 3);
  EXPECT_EQ(end.last_line, "last");
}

// Where SIGCHLD is ignored the system does not keep how a child ended: that is no success.
TEST(ColmapProcess, AnEndThatCannotBeLearnedIsAnError) {
  const TemporaryPlace place("ignored");
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  EXPECT_THROW(RunProcess({"/bin/sh", "-c", "exit 3"}, place.Path() / "log", CancellationToken()),
               InputError);
  std::signal(SIGCHLD, before);
}

TEST(ColmapCamera, ParametersGoThereAndBack) {
  const CameraIntrinsics camera{
      CameraModel::kRationalPolynomial, 640, 480, {300, 301, 320, 240, 1, 2, 3, 4, 5, 6, 7, 8}};
  const std::vector<double> there = ToColmapParameters(camera);
  EXPECT_EQ(there[2], 320.5);
  EXPECT_EQ(there[4], 1.0);
  const CameraIntrinsics back = FromColmapParameters(ColmapModelId::kFullOpenCv, 640, 480, there);
  EXPECT_EQ(back.parameters, camera.parameters);
  EXPECT_EQ(back.model, camera.model);
}

TEST(ColmapCamera, ModelsFitEachOther) {
  const CameraIntrinsics sphere{CameraModel::kDoubleSphere, 1280, 960, {380, 381, 645, 474, 0.12, 0.58}};
  const CameraIntrinsics fisheye = FitCameraModel(sphere, CameraModel::kEquidistant, 1.39);
  EXPECT_LT(MeanDisplacement(sphere, fisheye, 1.39), 0.05);
  const CameraIntrinsics again = FitCameraModel(fisheye, CameraModel::kDoubleSphere, 1.39);
  EXPECT_LT(MeanDisplacement(sphere, again, 1.39), 0.05);
}

}  // namespace
}  // namespace mlic::colmap_test
