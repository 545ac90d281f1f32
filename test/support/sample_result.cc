#include "support/sample_result.h"

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

Eigen::Vector3d NormalVector(Random& random, double sigma) {
  const double x = random.Normal(), y = random.Normal(), z = random.Normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

SensorResult SampleSensor(const std::string& name, const Eigen::Vector3d& position,
                          const Eigen::Vector3d& rpy) {
  SensorResult sensor;
  sensor.name = name;
  sensor.frame_id = name + "_link";
  sensor.calibration.T_imu_sensor = {FromRollPitchYaw(rpy), position};
  sensor.calibration.time_offset = 0.0123456789 + 0.001 * position.x();
  sensor.sigma.translation = {0.0012, 0.0014, 0.1};
  sensor.sigma.rotation = {1.1e-4, 1.3e-4, 0.9e-4};
  sensor.sigma.time_offset = 8.5e-5;
  sensor.bound = PoseSigma{0.8 * sensor.sigma.translation, 0.9 * sensor.sigma.rotation, 8e-5};
  sensor.translation_observable = {true, true, false};
  sensor.unobservable = {
      {UnobservableDirection::Quantity::kTranslation, Eigen::Vector3d(0.0, 0.02, 1.0).normalized(), 0.1}};
  return sensor;
}

std::vector<SigmaInUse> SampleUse(bool camera) {
  std::vector<SigmaInUse> uses;
  for (const double distance : {10.0, 50.0}) {
    SigmaInUse use;
    use.where = camera ? SigmaInUse::Where::kImage : SigmaInUse::Where::kSpace;
    use.distance = distance;
    use.median = (camera ? 0.25 : 0.0015) * (1.0 + 0.01 * distance);
    use.worst = 2.0 * use.median;
    for (int k = 0; k < kUseSectors && !camera; ++k) {
      use.sectors.push_back(use.median * (1.5 + 0.5 * std::sin(k)));
    }
    uses.push_back(use);
  }
  return uses;
}

// A figure of eight, 60 s at 10 Hz, in a yard with two walls and the ground.
void AddDrive(CalibrationResult& result) {
  Random random(7);
  std::vector<StampedPose> poses;
  for (int i = 0; i <= 600; ++i) {
    const double phase = 2.0 * M_PI * i / 300.0;
    const Eigen::Vector3d position(12.0 * std::sin(phase), 7.0 * std::sin(2.0 * phase),
                                   0.02 * std::sin(9 * phase));
    const double yaw = std::atan2(14.0 * std::cos(2.0 * phase), 12.0 * std::cos(phase));
    poses.push_back({1700000000000000000 + i * 100000000LL, {FromRollPitchYaw({0.0, 0.0, yaw}), position}});
  }
  result.trajectories.push_back(poses);
  for (int i = 0; i < 20000; ++i) {
    MapPoint point;
    point.lidar = i % 3;
    point.plane = i % 4;
    point.intensity = static_cast<float>(random.Uniform(0.0, 255.0));
    const float along = static_cast<float>(random.Uniform(-20.0, 20.0));
    const float up = static_cast<float>(random.Uniform(0.0, 4.0));
    const float noise = static_cast<float>(0.02 * random.Normal());
    const float side = point.lidar == 0 ? 1.0f : -1.0f;
    if (point.plane == 0) point.position = {along, 15.0f * side + noise, up};
    if (point.plane == 1) point.position = {22.0f * side + noise, 0.7f * along, up};
    if (point.plane == 2)
      point.position = {along, static_cast<float>(random.Uniform(-14.0, 14.0)), noise - 1.7f};
    if (point.plane == 3) {
      point.position = {3.0f + 0.05f * along, 4.0f + noise, up};
      point.plane = -1;
    }
    result.map.push_back(point);
  }
}

ResidualSummary SampleResidual(const std::string& sensor, const std::string& unit, double sigma,
                               double width) {
  ResidualSummary summary;
  summary.sensor = sensor;
  summary.unit = unit;
  summary.sigma = sigma;
  summary.inlier_share = 0.97;
  for (int bin = 0; bin < 50; ++bin) {
    const double x = (-5.0 + 0.2 * (bin + 0.5)) / width;
    summary.histogram.push_back(std::round(40000.0 * std::exp(-0.5 * x * x)));
  }
  for (int i = 0; i < 60; ++i) {
    summary.over_time_seconds.push_back(i + 0.5);
    summary.over_time_rms.push_back(sigma * width * (1.0 + 0.15 * std::sin(0.7 * i)));
  }
  return summary;
}

// A camera that sees a checkerboard of gray squares, always the same.
class SampleImages : public ImageSource {
 public:
  std::size_t Count() const override { return 3; }
  double Time(std::size_t index) const override { return 0.1 * static_cast<double>(index); }
  cv::Mat Load(std::size_t /*index*/) const override {
    cv::Mat image(800, 1280, CV_8UC1);
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        image.at<std::uint8_t>(row, column) = (row / 100 + column / 100) % 2 == 0 ? 90 : 150;
      }
    }
    return image;
  }
};

// Errors that turn about the image's centre, and a few landmarks.
void AddCameraResiduals(CalibrationResult& result) {
  ResidualSummary summary = SampleResidual("cam_front", "px", 0.4, 1.0);
  summary.rms = 0.41;
  summary.over_image.columns = 16;
  summary.over_image.rows = 10;
  for (int row = 0; row < 10; ++row) {
    for (int column = 0; column < 16; ++column) {
      summary.over_image.mean.emplace_back(0.01f * (row - 4.5f), -0.01f * (column - 7.5f));
      summary.over_image.counts.push_back(10 * ((row + column) % 7));
    }
  }
  result.residuals.push_back(summary);
  CameraView view{"cam_front", std::make_shared<SampleImages>(), 1, {}};
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2f pixel(40.0f + 20.0f * i, 60.0f + 11.0f * i), step(4.0f, -3.0f);
    view.observations.push_back(
        {pixel, pixel + Eigen::Vector2f(0.3f, 0.2f), {pixel - step, pixel, pixel + 2.0f * step}});
  }
  result.views = {view};
  result.keyframes = {{"cam_front", {1700000000000000000, 1700000000100000001}}};
  SensorResult initial = result.sensors[3];
  initial.calibration.T_imu_sensor.translation.x() += 0.02;
  result.initial_sensors = {initial};
}

// A wall of LiDAR points on the photo, 12 px to the left with the poses of the guess.
void AddProjection(CalibrationResult& result) {
  CameraProjection projection;
  projection.camera = "cam_front";
  projection.images = std::make_shared<SampleImages>();
  projection.image = 1;
  projection.rendering = cv::Mat(100, 160, CV_32FC1, cv::Scalar(0.5));
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2f pixel(20.0f * static_cast<float>(i % 64), 12.5f * static_cast<float>(i / 64));
    projection.after.push_back({pixel, 4.0f + 0.01f * pixel.x(), 0.5f});
    projection.before.push_back({pixel - Eigen::Vector2f(4.0f, 0.0f), 4.0f + 0.01f * pixel.x(), 0.5f});
    projection.guess.push_back({pixel - Eigen::Vector2f(12.0f, 0.0f), 4.0f + 0.01f * pixel.x(), 0.5f});
  }
  projection.matches = {{{100.0f, 100.0f}, {96.0f, 100.0f}, {100.2f, 100.1f}}};
  result.projections = {projection};
}

}  // namespace

CalibrationResult SampleResult() {
  CalibrationResult result;
  result.verdict = Verdict::kTrusted;
  result.warnings = {"the common z of all LiDARs is not visible in this drive and was held at the guess"};
  QualityCheck convergence;
  convergence.name = "convergence";
  convergence.value = 0.083;
  convergence.limit = 1.0;
  convergence.unit = "sigma";
  convergence.refuses = true;
  convergence.failure = "the calibration has not converged";
  convergence.remedy = "record a longer drive";
  QualityCheck coverage;
  coverage.name = "coverage_image";
  coverage.sensor = "cam_front";
  coverage.value = 0.375;
  coverage.limit = 0.5;
  coverage.bound = QualityCheck::Bound::kLeast;
  coverage.unit = "of the image";
  coverage.failure = "cam_front: landmarks cover little of its image";
  coverage.remedy = "turn so that structure crosses all of it";
  result.checks = {convergence, coverage};
  HalvesDifference rotation;
  rotation.difference = {1e-4, -2e-4, 3e-4};
  rotation.sigma = {2e-4, 2e-4, 0.0};
  rotation.directions = 2;
  rotation.deviation = 0.6;
  rotation.largest = 1.0;
  result.halves = {{"front_lidar", DriveParts::kEnd, {rotation}}};
  result.imu_frame_id = "imu_link";
  Random random(3);
  result.imu.gyroscope_bias = NormalVector(random, 0.002);
  result.imu.accelerometer_bias = NormalVector(random, 0.05);
  result.imu.gyroscope_matrix(1, 0) = 0.0021;
  result.imu.accelerometer_matrix(1, 0) = -0.0034;
  result.alignment = ImuAlignment{ImuAxes::kGyroscope,
                                  {true, false, false},
                                  {{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}},
                                  {{0.0, 0.0, 1.0}},
                                  {1e-3, 2e-3, 1.7e-2}};
  result.gravity = {0.0, 0.0, -9.80665};
  result.sensors = {SampleSensor("front_lidar", {0.012, 1.693, 0.0}, {1.728, 1.556, 0.157}),
                    SampleSensor("left_lidar", {-0.423, 0.967, 0.1}, {3.133, -0.110, 3.138}),
                    SampleSensor("right_lidar", {0.511, 0.976, -0.1}, {-0.015, -0.087, -3.132}),
                    SampleSensor("cam_front", {0.027, 1.972, 0.2}, {-1.57, 0.0, 0.0})};
  SensorResult& camera = result.sensors[3];
  camera.type = SensorResult::Type::kCamera;
  camera.intrinsics =
      CameraIntrinsics{CameraModel::kEquidistant, 1280, 800, {369.5, 369.25, 640, 400, 0.01, 0, 0, 0}};
  camera.topic = "/cam_front/image_raw";
  camera.intrinsics_sigma = {0.11, 0.12, 0.21, 0.22, 1e-4, 2e-4, 3e-4, 4e-4};
  camera.intrinsics_fixed = {false, false, false, false, false, false, true, true};
  camera.rolling_shutter_readout = 0.0221;
  camera.readout_sigma = 1.5e-4;
  camera.held_out = HeldOutMatches{512, 0.3125, 0.4375};
  camera.unobservable.push_back(
      {UnobservableDirection::Quantity::kRotation, Eigen::Vector3d::UnitX(), 2.0 * M_PI / 180.0});
  camera.unobservable.push_back(
      {UnobservableDirection::Quantity::kTimeOffset, Eigen::Vector3d::Zero(), 0.006});
  camera.rotation_observable = {false, true, true};
  camera.time_offset_observable = false;
  for (std::size_t a = 0; a < result.sensors.size(); ++a) {
    for (std::size_t b = a + 1; b < result.sensors.size(); ++b) {
      PairResult pair{result.sensors[a].name, result.sensors[b].name, {}, {}};
      pair.T_a_b =
          result.sensors[a].calibration.T_imu_sensor.Inverse() * result.sensors[b].calibration.T_imu_sensor;
      pair.sigma.translation = Eigen::Vector3d(0.0008, 0.0009, 0.0011);
      pair.sigma.rotation = Eigen::Vector3d::Constant(5e-5);
      pair.sigma.time_offset = 3e-5;
      if (a == 0) pair.bound = pair.sigma;
      pair.in_use = SampleUse(b == 3);
      result.pairs.push_back(pair);
    }
  }
  for (SensorResult& sensor : result.sensors) {
    sensor.in_use = SampleUse(sensor.type == SensorResult::Type::kCamera);
  }
  result.ground = PoseOverGround{{1.7, 0.01, -0.02},
                                 {0.012, 0.002, 0.003},
                                 {0.1, 1e-4, 2e-4},
                                 Eigen::Vector3d(0.02, 0.01, 1.0).normalized(),
                                 57};
  AddDrive(result);
  result.stages = {
      {"load", 4.1, 5.2, {"3 LiDARs, 598 scans each, IMU 200 Hz, 60.0 s"}},
      {"odometry", 11.7, 44.1, {"front_lidar: 598 of 598 scans registered, rms 18 mm"}},
      {"initialise", 3.3, 6.0, {"time offset 12 ms by angular rates", "base LiDAR: front_lidar"}},
      {"joint", 24.9, 90.5, {"1423 planes, 612000 points", "converged after 5 rounds"}}};
  result.residuals = {
      SampleResidual("front_lidar", "m", 0.02, 1.0), SampleResidual("left_lidar", "m", 0.02, 1.1),
      SampleResidual("right_lidar", "m", 0.02, 0.9), SampleResidual("gyroscope", "rad/s", 0.004, 1.0),
      SampleResidual("accelerometer", "m/s^2", 0.05, 1.4)};
  // A gyroscope whose bias jumps about its z axis in the last third of the drive.
  ResidualSummary& gyroscope = result.residuals[3];
  for (int i = 0; i < 60; ++i) {
    gyroscope.bias_over_time.emplace_back(1e-4 * std::sin(0.9 * i), 0.0, i < 40 ? 0.0 : 2e-3);
    gyroscope.bias_sigma_over_time.push_back(Eigen::Vector3d::Constant(3e-4));
  }
  result.rounds = {{"joint", 812.0},
                   {"joint", 3.1},
                   {"joint", 0.4},
                   {"joint with cameras", 5.2},
                   {"joint with cameras", 0.083}};
  result.run = RunRecord{"1.2.0",
                         "calibrate --rig rig.yaml --bag 'drive <1>.bag'",
                         {{"/data/drive <1>.bag", "0f3c"}, {"/data/rig.yaml", "a719"}},
                         {{"intrinsics", "trajectory"}}};
  AddCameraResiduals(result);
  AddProjection(result);
  for (const SensorResult& sensor : result.sensors) {
    RigidTransform guess = sensor.calibration.T_imu_sensor;
    guess.translation += Eigen::Vector3d(0.1, -0.05, 0.02);
    guess.rotation = FromRollPitchYaw({0.0, 0.0, 0.07}) * guess.rotation;
    result.guesses.push_back({sensor.name, guess});
  }
  result.peak_memory_megabytes = 1834.0;
  return result;
}

}  // namespace mlic
