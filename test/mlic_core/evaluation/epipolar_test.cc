#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/evaluation/epipolar_error.h"
#include "mlic_core/geometry/so3.h"
#include "support/synthetic_images.h"

namespace mlic::epipolar_test {
namespace {

constexpr TimeNs kEpoch = 1700000000000000000;
constexpr double kDegree = M_PI / 180.0;

RigidTransform PoseAt(double t) {
  return {FromRollPitchYaw({0.03 * std::sin(2.0 * t), 0.02 * std::sin(3.0 * t), 0.2 * std::sin(t)}),
          {0.5 * t, 0.3 * t, 0.05 * std::sin(4.0 * t)}};
}

// IMU with x right, y ahead, z up.
std::vector<StampedPose> Path() {
  std::vector<StampedPose> path;
  for (int k = -50; k <= 200; ++k) path.push_back({TimeFrom(kEpoch, 0.01 * k), PoseAt(0.01 * k)});
  return path;
}

SensorResult Camera(const std::string& name, CameraIntrinsics intrinsics, double x, double offset) {
  Eigen::Matrix3d R;  // looks ahead
  R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  SensorResult camera;
  camera.name = name;
  camera.type = SensorResult::Type::kCamera;
  camera.calibration.T_imu_sensor = {Eigen::Quaterniond(R), {x, 0.1, 0.02}};
  camera.calibration.time_offset = offset;
  camera.intrinsics = std::move(intrinsics);
  return camera;
}

CalibrationResult Pair(const CameraIntrinsics& a, const CameraIntrinsics& b) {
  CalibrationResult result;
  result.sensors = {Camera("left", a, -0.2, 0.011), Camera("right", b, 0.25, -0.023)};
  return result;
}

void Turn(const Eigen::Vector3d& by, SensorResult* sensor) {
  Eigen::Quaterniond& R = sensor->calibration.T_imu_sensor.rotation;
  R = ExpQuaternion(by) * R;
}

const CameraIntrinsics kPinhole{
    CameraModel::kPlumbBob, 320, 240, {230, 231, 158, 121, -0.05, 0.01, 0.001, -0.001, 0}};
const CameraIntrinsics kFisheye{
    CameraModel::kEquidistant, 640, 480, {190, 191, 318, 243, 0.02, -0.004, 0.001, 0}};

// Where a point is seen in an image with this stamp, each row at its own time.
bool See(const SensorResult& camera, const std::vector<StampedPose>& path, TimeNs stamp,
         const Eigen::Vector3d& point, Eigen::Vector2d* pixel) {
  RigidTransform T_map_camera;
  *pixel = {0.0, 0.5 * camera.intrinsics->height};
  for (int iteration = 0; iteration < 10; ++iteration) {
    if (!PoseOfRow(camera, path, stamp, pixel->y(), &T_map_camera)) return false;
    if (!Project(*camera.intrinsics, T_map_camera.Inverse() * point, pixel)) return false;
  }
  return pixel->x() > 0.0 && pixel->y() > 0.0 && pixel->x() < camera.intrinsics->width - 1.0 &&
         pixel->y() < camera.intrinsics->height - 1.0;
}

std::vector<FreshMatch> TrueMatches(const CalibrationResult& truth, const std::vector<StampedPose>& path) {
  Random random(5);
  std::vector<FreshMatch> matches;
  for (int i = 0; i < 20000 && matches.size() < 400; ++i) {
    FreshMatch match{
        "left", "right", TimeFrom(kEpoch, 0.1 * (i % 10)), TimeFrom(kEpoch, 0.1 * (i % 10) + 0.04), {}, {}};
    const Eigen::Vector3d point(random.Uniform(-8.0, 8.0), random.Uniform(2.0, 12.0),
                                random.Uniform(-6.0, 6.0));
    if (See(truth.sensors[0], path, match.stamp_a, point, &match.pixel_a) &&
        See(truth.sensors[1], path, match.stamp_b, point, &match.pixel_b)) {
      matches.push_back(match);
    }
  }
  return matches;
}

// The distance of a pixel from the epipolar curve, by walking along the ray of the other camera.
double Walk(const SensorResult& from, const SensorResult& to, const std::vector<StampedPose>& path,
            TimeNs stamp_from, TimeNs stamp_to, const Eigen::Vector2d& pixel_from,
            const Eigen::Vector2d& pixel_to) {
  RigidTransform T_map_from, T_map_to;
  EXPECT_TRUE(PoseOfRow(from, path, stamp_from, pixel_from.y(), &T_map_from));
  EXPECT_TRUE(PoseOfRow(to, path, stamp_to, pixel_to.y(), &T_map_to));
  Eigen::Vector3d bearing;
  EXPECT_TRUE(Unproject(*from.intrinsics, pixel_from, &bearing));
  double nearest = 1e9;
  for (double depth = 0.5; depth < 60.0; depth *= 1.0005) {
    Eigen::Vector2d pixel;
    const Eigen::Vector3d point = T_map_to.Inverse() * (T_map_from * Eigen::Vector3d(depth * bearing));
    if (Project(*to.intrinsics, point, &pixel)) nearest = std::min(nearest, (pixel - pixel_to).norm());
  }
  return nearest;
}

TEST(EpipolarError, NoneUnderTheTruthWhateverTheTimes) {
  CalibrationResult truth = Pair(kPinhole, kFisheye);
  truth.sensors[0].rolling_shutter_readout = 0.025;
  const std::vector<StampedPose> path = Path();
  const std::vector<FreshMatch> matches = TrueMatches(truth, path);
  ASSERT_EQ(matches.size(), 400u);
  const auto errors = MeasureEpipolarErrors(matches, truth, path);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors[0].a, "left");
  EXPECT_EQ(errors[0].image_pairs, 10u);
  EXPECT_EQ(errors[0].matches, 400u);
  EXPECT_LT(errors[0].mean, 1e-4);
  CalibrationResult late = truth;
  late.sensors[1].calibration.time_offset += 0.02;
  EXPECT_GT(MeasureEpipolarErrors(matches, late, path)[0].median, 0.05) << "the exposures' times count";
}

TEST(EpipolarError, IsTheDistanceToTheEpipolarCurveInPixels) {
  const CalibrationResult truth = Pair(kPinhole, kFisheye);
  const std::vector<StampedPose> path = Path();
  CalibrationResult turned = truth;
  Turn({0.4 * kDegree, 0.2 * kDegree, 0.0}, &turned.sensors[1]);
  double walked = 0.0;
  const std::vector<FreshMatch> matches = TrueMatches(truth, path);
  for (const FreshMatch& match : matches) {
    const double in_b = Walk(turned.sensors[0], turned.sensors[1], path, match.stamp_a, match.stamp_b,
                             match.pixel_a, match.pixel_b);
    const double in_a = Walk(turned.sensors[1], turned.sensors[0], path, match.stamp_b, match.stamp_a,
                             match.pixel_b, match.pixel_a);
    walked += 0.5 * (in_a + in_b) / static_cast<double>(matches.size());
  }
  const auto errors = MeasureEpipolarErrors(matches, turned, path);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_GT(walked, 0.5);
  EXPECT_NEAR(errors[0].mean, walked, 0.03 * walked);
}

// Photos of two walls that meet in a corner.
cv::Mat Photo(const SensorResult& camera, const std::vector<StampedPose>& path, TimeNs stamp) {
  static const SyntheticTexture texture(3);
  RigidTransform T_map_camera;
  EXPECT_TRUE(PoseOfRow(camera, path, stamp, 0.0, &T_map_camera));
  const auto warp = [&](const Eigen::Vector2d& pixel) {
    Eigen::Vector3d bearing;
    if (!Unproject(*camera.intrinsics, pixel, &bearing)) return Eigen::Vector2d(NAN, NAN);
    const Eigen::Vector3d ray = T_map_camera.rotation * bearing, from = T_map_camera.translation;
    const double ahead = ray.y() > 0.0 ? (5.0 - from.y()) / ray.y() : 1e9;
    const double right = ray.x() > 0.0 ? (2.0 - from.x()) / ray.x() : 1e9;
    const Eigen::Vector3d hit = from + std::min(ahead, right) * ray;
    constexpr double kPixelsPerMetre = 60.0;
    return Eigen::Vector2d(kPixelsPerMetre * (ahead < right ? hit.x() : 50.0 + hit.y()),
                           kPixelsPerMetre * hit.z());
  };
  return RenderTexture(texture, camera.intrinsics->width, camera.intrinsics->height, warp, 1.0, 7);
}

TEST(FreshMatches, AreFoundInImagesThatWereNotUsed) {
  const CalibrationResult truth = Pair(kPinhole, kPinhole);
  const std::vector<StampedPose> path = Path();
  Drive drive;
  drive.epoch = kEpoch;
  for (const SensorResult& camera : truth.sensors) {
    std::vector<cv::Mat> images;
    for (int i = 0; i < 4; ++i) images.push_back(Photo(camera, path, TimeFrom(kEpoch, 0.1 * i)));
    drive.cameras.push_back({std::make_shared<MemoryImages>(images), 320, 240, {}});
  }
  const TimeNs used = TimeFrom(kEpoch, 0.1);
  const std::vector<CameraKeyframes> keyframes{{"right", {used}}};
  const auto matches = FindFreshMatches(drive, {"left", "right"}, truth, path, keyframes, FreshMatchOptions(),
                                        CancellationToken());
  ASSERT_GT(matches.size(), 100u);
  for (const FreshMatch& match : matches) EXPECT_NE(match.stamp_b, used);
  const auto errors = MeasureEpipolarErrors(matches, truth, path);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_LT(errors[0].median, 0.3);
  CalibrationResult turned = truth;
  Turn({0.4 * kDegree, 0.0, 0.0}, &turned.sensors[1]);
  EXPECT_GT(MeasureEpipolarErrors(matches, turned, path)[0].median, 0.8) << "0.4 deg are 1.6 px";
  EXPECT_TRUE(
      FindFreshMatches(drive, {"left", "right"}, {}, path, keyframes, {}, CancellationToken()).empty());
}

}  // namespace
}  // namespace mlic::epipolar_test
