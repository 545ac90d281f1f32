#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <opencv2/core.hpp>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/evaluation/birds_eye.h"
#include "mlic_core/evaluation/map_colours.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/sensors/camera_model.h"
#include "support/synthetic_images.h"

namespace mlic::map_pictures_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr TimeNs kEpoch = 1700000000000000000;
constexpr double kHeight = 1.3;                                // m, of the IMU over the ground
const Vector3d kUp = Vector3d(0.06, -0.04, 1.0).normalized();  // in the IMU's frame

// IMU with x right, y ahead; it drives ahead and turns, with a constant inclination.
RigidTransform PoseAt(double t) {
  const Eigen::Quaterniond level = Eigen::Quaterniond::FromTwoVectors(kUp, Vector3d::UnitZ());
  return {FromRollPitchYaw({0.0, 0.0, 0.5 + 0.4 * t}) * level, Vector3d(-2.0 * t, 3.0 * t, kHeight)};
}

std::vector<StampedPose> Path() {
  std::vector<StampedPose> path;
  for (int k = -50; k <= 150; ++k) path.push_back({TimeFrom(kEpoch, 0.01 * k), PoseAt(0.01 * k)});
  return path;
}

double PaintAt(double x, double y) { return 128.0 + 60.0 * std::sin(4.0 * x) + 60.0 * std::cos(3.0 * y - x); }

SensorResult Camera(const std::string& name, const CameraIntrinsics& intrinsics, double yaw, double offset) {
  Eigen::Matrix3d R_facing;  // looks along y
  R_facing << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  SensorResult camera;
  camera.name = name;
  camera.type = SensorResult::Type::kCamera;
  const Eigen::Quaterniond turned =
      FromRollPitchYaw({0.0, 0.0, yaw}) * Eigen::Quaterniond(R_facing) * FromRollPitchYaw({-0.5, 0.0, 0.0});
  camera.calibration.T_imu_sensor = {turned, turned * Vector3d(0.1, -0.05, 0.9)};
  camera.calibration.time_offset = offset;
  camera.intrinsics = intrinsics;
  return camera;
}

// The painted ground as the camera sees it, each row at its own time.
cv::Mat PhotoOfGround(const SensorResult& camera, double stamp) {
  cv::Mat photo(camera.intrinsics->height, camera.intrinsics->width, CV_8UC1, cv::Scalar(0));
  for (int v = 0; v < photo.rows; ++v) {
    const double readout = camera.rolling_shutter_readout.value_or(0.0) * v / photo.rows;
    const RigidTransform T =
        PoseAt(stamp + camera.calibration.time_offset + readout) * camera.calibration.T_imu_sensor;
    for (int u = 0; u < photo.cols; ++u) {
      Vector3d bearing;
      if (!Unproject(*camera.intrinsics, {u, v}, &bearing)) continue;
      const Vector3d ray = T.rotation * bearing;
      if (ray.z() > -0.05) continue;
      const Vector3d place = T.translation - T.translation.z() / ray.z() * ray;
      photo.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(std::lround(PaintAt(place.x(), place.y())));
    }
  }
  return photo;
}

class BirdsEyeTest : public ::testing::Test {
 protected:
  BirdsEyeTest() {
    const CameraIntrinsics pinhole{
        CameraModel::kPlumbBob, 640, 480, {330, 331, 318, 241, -0.05, 0.01, 0.001, -0.001, 0}};
    const CameraIntrinsics fisheye{
        CameraModel::kEquidistant, 640, 480, {210, 211, 318, 243, 0.02, -0.004, 0, 0}};
    calibration_.sensors = {Camera("front", pinhole, 0.0, 0.011), Camera("left", fisheye, 1.9, -0.023)};
    calibration_.sensors[1].rolling_shutter_readout = 0.03;
    calibration_.ground.emplace();
    calibration_.ground->mean.height = kHeight;
    calibration_.ground->up = kUp;
    drive_.epoch = kEpoch;
    for (const SensorResult& camera : calibration_.sensors) {
      std::vector<cv::Mat> photos;
      for (int k = 0; k < 10; ++k) photos.push_back(PhotoOfGround(camera, 0.1 * k));
      drive_.cameras.emplace_back();
      drive_.cameras.back().images = std::make_shared<MemoryImages>(photos);
    }
  }

  // Median difference between the picture and the paint, where a camera sees the ground.
  double DifferenceTo(const BirdsEye& view, const BirdsEyeOptions& options) const {
    const RigidTransform T_map_imu = PoseAt(view.seconds);
    // The way that is driven, as a direction of the IMU, is the same at all times.
    const Vector3d ahead_in_map = T_map_imu.rotation * Vector3d(AheadInImu());
    std::vector<double> differences;
    for (int v = 0; v < view.picture.rows; v += 3) {
      for (int u = 0; u < view.picture.cols; u += 3) {
        const auto& colour = view.picture.at<cv::Vec3b>(v, u);
        if (colour == cv::Vec3b(30, 30, 30)) continue;
        const double right = (u + 0.5) * options.pixel - options.half_width;
        const double ahead = options.half_width - (v + 0.5) * options.pixel;
        const Vector3d place =
            T_map_imu.translation + ahead * ahead_in_map + right * ahead_in_map.cross(Vector3d::UnitZ());
        differences.push_back(std::abs(colour[0] - PaintAt(place.x(), place.y())));
      }
    }
    EXPECT_GT(differences.size(), 5000u);
    return Median(differences);
  }

  // What VehicleAxes calls the front: the mean velocity in the IMU's frame, level.
  static Vector3d AheadInImu() {
    Vector3d sum = Vector3d::Zero();
    const std::vector<StampedPose> path = Path();
    for (std::size_t i = 1; i < path.size(); ++i) {
      sum += path[i].pose.rotation.conjugate() * (path[i].pose.translation - path[i - 1].pose.translation);
    }
    return (sum - kUp * kUp.dot(sum)).normalized();
  }

  CalibrationResult calibration_;
  Drive drive_;
};

TEST_F(BirdsEyeTest, ShowsTheGroundWhereItIs) {
  BirdsEyeOptions options;
  options.half_width = 6.0;
  const BirdsEye view = DrawBirdsEye(drive_, {"front", "left"}, calibration_, Path(), options);
  EXPECT_EQ(view.cameras, (std::vector<std::string>{"front", "left"}));
  EXPECT_EQ(view.picture.size(), cv::Size(600, 600));
  EXPECT_NEAR(view.seconds, 0.5, 1e-9);
  EXPECT_LT(DifferenceTo(view, options), 4.0);
  // A camera that is turned shows it elsewhere.
  CalibrationResult turned = calibration_;
  for (SensorResult& camera : turned.sensors) {
    Eigen::Quaterniond& R = camera.calibration.T_imu_sensor.rotation;
    R = ExpQuaternion(Vector3d(0.0, 0.0, 0.05)) * R;
  }
  EXPECT_GT(DifferenceTo(DrawBirdsEye(drive_, {"front", "left"}, turned, Path(), options), options), 15.0);
}

TEST_F(BirdsEyeTest, LeavesOutWhatIsMasked) {
  drive_.cameras[0].mask = cv::Mat(480, 640, CV_8UC1, cv::Scalar(0));
  const BirdsEye view = DrawBirdsEye(drive_, {"front", "left"}, calibration_, Path(), BirdsEyeOptions());
  EXPECT_EQ(view.cameras, std::vector<std::string>{"left"});
}

TEST_F(BirdsEyeTest, IsOfVehicles) {
  EXPECT_TRUE(StandsOnTheGround(calibration_));
  calibration_.ground->scatter.pitch = 0.1;
  EXPECT_FALSE(StandsOnTheGround(calibration_));
  calibration_.ground.reset();
  EXPECT_FALSE(StandsOnTheGround(calibration_));
}

// A wall 6 m ahead, its left half red and its right half blue, behind a green board 3 m ahead.
class ColouredMapTest : public ::testing::Test {
 protected:
  ColouredMapTest() {
    SensorResult camera = Camera(
        "front", {CameraModel::kPlumbBob, 640, 480, {330, 330, 319.5, 239.5, 0, 0, 0, 0, 0}}, 0.0, 0.0);
    Eigen::Matrix3d R_facing;
    R_facing << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    camera.calibration.T_imu_sensor = {Eigen::Quaterniond(R_facing), Vector3d::Zero()};
    calibration_.sensors = {camera};
    cv::Mat photo(480, 640, CV_8UC3, cv::Scalar(200, 0, 0));
    photo(cv::Rect(0, 0, 320, 480)).setTo(cv::Scalar(0, 0, 200));
    photo(cv::Rect(265, 185, 110, 110)).setTo(cv::Scalar(0, 200, 0));  // 1 m at 3 m
    drive_.epoch = kEpoch;
    drive_.cameras.emplace_back();
    drive_.cameras.back().images = std::make_shared<MemoryImages>(std::vector<cv::Mat>{photo, photo, photo});
    for (int k = -50; k <= 50; ++k) path_.push_back({TimeFrom(kEpoch, 0.01 * k), RigidTransform()});
    for (double x = -2.0; x <= 2.0; x += 0.05) {
      for (double z = -2.0; z <= 2.0; z += 0.05) {
        Add(x, 6.0, z);
        if (std::abs(x) <= 0.49 && std::abs(z) <= 0.49) Add(x, 3.0, z);
      }
    }
  }
  void Add(double x, double y, double z) {
    MapPoint point;
    point.position = Vector3d(x, y, z).cast<float>();
    map_.push_back(point);
  }

  CalibrationResult calibration_;
  Drive drive_;
  std::vector<StampedPose> path_;
  std::vector<MapPoint> map_;
};

TEST_F(ColouredMapTest, PointsHaveTheColoursOfWhatIsNotHidden) {
  const std::vector<ColouredPoint> points =
      ColourMap(map_, drive_, {"front"}, calibration_, path_, MapColourOptions(), CancellationToken());
  EXPECT_LT(points.size(), map_.size());
  EXPECT_GT(points.size(), map_.size() / 2);
  for (const ColouredPoint& point : points) {
    const bool board = point.position.y() < 4.0f;
    const bool left = point.position.x() < 0.0f;
    const std::array<std::uint8_t, 3> expected = {static_cast<std::uint8_t>(!board && !left ? 200 : 0),
                                                  static_cast<std::uint8_t>(board ? 200 : 0),
                                                  static_cast<std::uint8_t>(!board && left ? 200 : 0)};
    if (std::abs(point.position.x()) > 0.06f) {
      EXPECT_EQ(point.bgr, expected) << point.position.transpose();
    }
    // Behind the board nothing is seen.
    EXPECT_FALSE(!board && std::abs(point.position.x()) < 0.85f && std::abs(point.position.z()) < 0.85f);
  }
}

TEST_F(ColouredMapTest, IsDrawnFromAboveWithoutWhatIsHigh) {
  std::vector<ColouredPoint> points(2);
  points[0].position = {0.0f, 2.0f, -1.0f};
  points[0].bgr = {10, 220, 10};
  points[1].position = {0.0f, 2.0f, 5.0f};
  points[1].bgr = {10, 10, 220};
  const cv::Mat picture = DrawColouredMap(points, path_);
  cv::Mat green, red;
  cv::inRange(picture, cv::Scalar(10, 220, 10), cv::Scalar(10, 220, 10), green);
  cv::inRange(picture, cv::Scalar(10, 10, 220), cv::Scalar(10, 10, 220), red);
  EXPECT_GT(cv::countNonZero(green), 0);
  EXPECT_EQ(cv::countNonZero(red), 0);
  EXPECT_TRUE(DrawColouredMap({}, path_).empty());
}

}  // namespace
}  // namespace mlic::map_pictures_test
