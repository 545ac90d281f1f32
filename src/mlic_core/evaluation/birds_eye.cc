#include "mlic_core/evaluation/birds_eye.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/angles.h"
#include "mlic_core/evaluation/photo_mosaic.h"
#include "mlic_core/evaluation/pose_interpolation.h"
#include "mlic_core/result/vehicle_axes.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

using Eigen::Vector3d;

constexpr double kMostScatterDeg = 2.0;  // of a vehicle's inclination
constexpr int kNameHeight = 16;          // px
const cv::Scalar kMark(255, 255, 255);

// The ground at one moment: its point below the IMU and its axes, in the map frame.
struct GroundFrame {
  Vector3d origin, right, ahead;

  Vector3d At(double to_the_right, double to_the_front) const {
    return origin + to_the_right * right + to_the_front * ahead;
  }
};

GroundFrame FrameAt(const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory,
                    TimeNs time) {
  RigidTransform T_map_imu;
  std::size_t hint = 0;
  InterpolatePose(trajectory, time, &hint, &T_map_imu);
  CalibrationResult driven;
  driven.trajectories = {trajectory};
  const Vector3d up = calibration.ground->up.normalized();
  const Vector3d forward = VehicleAxes(driven).row(0).transpose();
  const Vector3d ahead = (forward - up * up.dot(forward)).normalized();
  GroundFrame frame;
  frame.origin = T_map_imu * Vector3d(-calibration.ground->mean.height * up);
  frame.ahead = T_map_imu.rotation * ahead;
  frame.right = T_map_imu.rotation * ahead.cross(up);
  return frame;
}

// A cross where the IMU is, rings of whole metres, and the cameras' names where they are.
void DrawMarks(const std::vector<std::pair<std::string, Vector3d>>& cameras, const GroundFrame& frame,
               const BirdsEyeOptions& options, cv::Mat* picture) {
  const auto at = [&](const Vector3d& p_in_map) {
    const Vector3d from_origin = p_in_map - frame.origin;
    return cv::Point(static_cast<int>((options.half_width + frame.right.dot(from_origin)) / options.pixel),
                     static_cast<int>((options.half_width - frame.ahead.dot(from_origin)) / options.pixel));
  };
  const cv::Point centre = at(frame.origin);
  for (double radius = 5.0; radius < options.half_width; radius += 5.0) {
    const int in_pixels = static_cast<int>(radius / options.pixel);
    cv::circle(*picture, centre, in_pixels, kMark, 1, cv::LINE_AA);
    LabelPicture(std::to_string(static_cast<int>(radius)) + " m", {centre.x + 4, centre.y - in_pixels - 4},
                 picture);
  }
  cv::drawMarker(*picture, centre, kMark, cv::MARKER_CROSS, 14, 2);
  std::vector<int> rows[2];  // of the names to either side: one each
  for (const auto& [name, place] : cameras) {
    const cv::Point dot = at(place);
    cv::circle(*picture, dot, 4, kMark, cv::FILLED, cv::LINE_AA);
    const bool to_the_left = dot.x < centre.x - kNameHeight;
    int row = dot.y + 4;
    const auto is_near = [&](int taken) { return std::abs(taken - row) < kNameHeight; };
    std::vector<int>& taken_rows = rows[to_the_left ? 1 : 0];
    while (std::any_of(taken_rows.begin(), taken_rows.end(), is_near)) row += kNameHeight / 2;
    taken_rows.push_back(row);
    const int width = cv::getTextSize(name, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width;
    LabelPicture(name, {to_the_left ? dot.x - 8 - width : dot.x + 8, row}, picture);
  }
  cv::arrowedLine(*picture, {24, 70}, {24, 20}, kMark, 2, cv::LINE_AA, 0, 0.25);
  LabelPicture("ahead", {36, 36}, picture);
}

}  // namespace

bool StandsOnTheGround(const CalibrationResult& calibration) {
  return calibration.ground && std::max(calibration.ground->scatter.roll, calibration.ground->scatter.pitch) <
                                   kRadiansPerDegree * kMostScatterDeg;
}

BirdsEye DrawBirdsEye(const Drive& drive, const std::vector<std::string>& names,
                      const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory,
                      const BirdsEyeOptions& options) {
  const TimeNs time = MiddleOf(trajectory);
  const GroundFrame frame = FrameAt(calibration, trajectory, time);
  const int size = static_cast<int>(std::lround(2.0 * options.half_width / options.pixel));
  PhotoMosaic mosaic =
      ComposePhotos(drive, names, calibration, trajectory, time, {size, size}, [&](int u, int v) {
        return frame.At((u + 0.5) * options.pixel - options.half_width,
                        options.half_width - (v + 0.5) * options.pixel);
      });
  BirdsEye view;
  view.seconds = SecondsSince(drive.epoch, time);
  view.picture = std::move(mosaic.picture);
  for (const auto& [name, centre] : mosaic.cameras) view.cameras.push_back(name);
  DrawMarks(mosaic.cameras, frame, options, &view.picture);
  return view;
}

}  // namespace mlic
