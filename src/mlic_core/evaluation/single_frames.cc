#include "mlic_core/evaluation/single_frames.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/angles.h"
#include "mlic_core/evaluation/map_builder.h"
#include "mlic_core/evaluation/photo_mosaic.h"
#include "mlic_core/evaluation/pose_interpolation.h"
#include "mlic_core/evaluation/sensor_colours.h"
#include "mlic_core/result/vehicle_axes.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

constexpr double kHalfWidth = 15.0;  // m, of the view from above
constexpr int kSidePixels = 1000;
constexpr double kSphere = 20.0;  // m
constexpr double kLowestDeg = -60.0, kHighestDeg = 45.0;
constexpr double kPixelsPerDegree = 4.0;
const cv::Scalar kDarkGround(30, 30, 30);

// The moment, and the vehicle then: rows forward, left and up in the map frame.
struct Moment {
  TimeNs time = 0;
  RigidTransform T_map_imu;
  Eigen::Matrix3d R_vehicle_map = Eigen::Matrix3d::Identity();
};

Moment MiddleOfDrive(const std::vector<StampedPose>& trajectory) {
  Moment moment;
  moment.time = MiddleOf(trajectory);
  std::size_t hint = 0;
  InterpolatePose(trajectory, moment.time, &hint, &moment.T_map_imu);
  CalibrationResult driven;
  driven.trajectories = {trajectory};
  moment.R_vehicle_map = VehicleAxes(driven) * moment.T_map_imu.rotation.conjugate().toRotationMatrix();
  return moment;
}

// The drive with the one scan of each LiDAR that the moment falls into.
Drive OneScanOfEach(const Drive& drive, TimeNs time) {
  Drive moment;
  moment.epoch = drive.epoch;
  const double seconds = SecondsSince(drive.epoch, time);
  for (const LidarRecording& lidar : drive.lidars) {
    moment.lidars.emplace_back();
    const auto after = std::upper_bound(lidar.scans.begin(), lidar.scans.end(), seconds,
                                        [](double t, const LidarScan& scan) { return t < scan.time; });
    if (after != lidar.scans.begin()) moment.lidars.back().scans.push_back(*(after - 1));
  }
  return moment;
}

}  // namespace

cv::Mat DrawScansFromAbove(const Drive& drive, const std::vector<std::string>& names,
                           const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory) {
  if (trajectory.empty()) return {};
  const Moment moment = MiddleOfDrive(trajectory);
  const std::vector<MapPoint> points =
      BuildMap(OneScanOfEach(drive, moment.time), names, trajectory, calibration, 1);
  if (points.empty()) return {};
  cv::Mat picture(kSidePixels, kSidePixels, CV_8UC3, kDarkGround);
  const double scale = kSidePixels / (2.0 * kHalfWidth);
  for (const MapPoint& point : points) {
    const Eigen::Vector3d p =
        moment.R_vehicle_map * (point.position.cast<double>() - moment.T_map_imu.translation);
    const cv::Point at(static_cast<int>(std::lround(scale * (kHalfWidth - p.y()))),
                       static_cast<int>(std::lround(scale * (kHalfWidth - p.x()))));
    cv::circle(picture, at, 1, ColourOfLidar(static_cast<std::size_t>(point.lidar)), cv::FILLED);
  }
  int row = 24;
  for (std::size_t s = 0; s < calibration.sensors.size(); ++s) {
    if (calibration.sensors[s].type != SensorResult::Type::kLidar) continue;
    cv::circle(picture, {16, row - 5}, 6, ColourOfLidar(s), cv::FILLED, cv::LINE_AA);
    LabelPicture(calibration.sensors[s].name, {30, row}, &picture);
    row += 22;
  }
  return picture;
}

cv::Mat DrawPanorama(const Drive& drive, const std::vector<std::string>& names,
                     const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory) {
  if (trajectory.empty()) return {};
  const Moment moment = MiddleOfDrive(trajectory);
  const cv::Size size(static_cast<int>(360.0 * kPixelsPerDegree),
                      static_cast<int>((kHighestDeg - kLowestDeg) * kPixelsPerDegree));
  const Eigen::Matrix3d R_map_vehicle = moment.R_vehicle_map.transpose();
  PhotoMosaic mosaic =
      ComposePhotos(drive, names, calibration, trajectory, moment.time, size, [&](int u, int v) {
        const double azimuth = kRadiansPerDegree * (180.0 - (u + 0.5) / kPixelsPerDegree);
        const double elevation = kRadiansPerDegree * (kHighestDeg - (v + 0.5) / kPixelsPerDegree);
        const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        return Eigen::Vector3d(moment.T_map_imu.translation + kSphere * (R_map_vehicle * ray));
      });
  if (mosaic.cameras.empty()) return {};
  for (const auto& [text, degrees] : {std::pair("behind", -178.0), std::pair("left", -92.0),
                                      std::pair("ahead", -4.0), std::pair("right", 86.0)}) {
    LabelPicture(text, {static_cast<int>((180.0 + degrees) * kPixelsPerDegree), 20}, &mosaic.picture);
  }
  return mosaic.picture;
}

}  // namespace mlic
