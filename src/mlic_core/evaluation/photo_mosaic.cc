#include "mlic_core/evaluation/photo_mosaic.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/parallel.h"
#include "mlic_core/evaluation/fresh_matches.h"
#include "mlic_core/evaluation/photo_pose.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

const cv::Scalar kUnseenPlace(30, 30, 30), kLabel(255, 255, 255), kLabelRim(0, 0, 0);

// What one photo shows of each place, and with what weight.
struct LaidPhoto {
  cv::Mat colour;  // CV_8UC3
  cv::Mat weight;  // CV_32F, 0 where it does not see the place
};

LaidPhoto LayOut(const cv::Mat& photo, const cv::Mat& mask, const PhotoPose& pose, const cv::Size& size,
                 const std::function<Eigen::Vector3d(int u, int v)>& place) {
  cv::Mat x(size, CV_32F, cv::Scalar(-1)), y = x.clone();
  LaidPhoto laid{cv::Mat(), cv::Mat(size, CV_32F, cv::Scalar(0))};
  ParallelFor(static_cast<std::size_t>(size.height), [&](std::size_t row) {
    const int v = static_cast<int>(row);
    for (int u = 0; u < size.width; ++u) {
      Eigen::Vector2d pixel;
      double distance = 0.0;
      if (!pose.See(place(u, v), &pixel, &distance)) continue;
      const cv::Point nearest(static_cast<int>(std::lround(pixel.x())),
                              static_cast<int>(std::lround(pixel.y())));
      if (!mask.empty() && mask.at<std::uint8_t>(nearest) == 0) continue;
      x.at<float>(v, u) = static_cast<float>(pixel.x());
      y.at<float>(v, u) = static_cast<float>(pixel.y());
      laid.weight.at<float>(v, u) = static_cast<float>(pose.WeightOf(pixel, distance));
    }
  });
  cv::Mat colour = photo;
  if (photo.channels() == 1) cv::cvtColor(photo, colour, cv::COLOR_GRAY2BGR);
  cv::remap(colour, laid.colour, x, y, cv::INTER_LINEAR);
  return laid;
}

}  // namespace

PhotoMosaic ComposePhotos(const Drive& drive, const std::vector<std::string>& names,
                          const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory,
                          TimeNs time, const cv::Size& size,
                          const std::function<Eigen::Vector3d(int u, int v)>& place) {
  PhotoMosaic mosaic;
  cv::Mat sum(size, CV_32FC3, cv::Scalar::all(0)), weight(size, CV_32F, cv::Scalar(0));
  for (std::size_t c = 0; c < names.size() && c < drive.cameras.size(); ++c) {
    const SensorResult* camera = FindCamera(calibration, names[c]);
    if (camera == nullptr) continue;
    const CameraRecording& recording = drive.cameras[c];
    const std::optional<std::size_t> image = NearestPhoto(recording, *camera, drive, trajectory, time);
    if (!image) continue;
    const std::optional<PhotoPose> pose =
        PhotoPose::Of(*camera, trajectory, TimeFrom(drive.epoch, recording.images->Time(*image)));
    if (!pose) continue;
    const LaidPhoto laid = LayOut(recording.images->Load(*image), recording.mask, *pose, size, place);
    if (cv::countNonZero(laid.weight) == 0) continue;
    cv::Mat colour, weights;
    laid.colour.convertTo(colour, CV_32FC3);
    cv::merge(std::vector<cv::Mat>(3, laid.weight), weights);
    sum += colour.mul(weights);
    weight += laid.weight;
    mosaic.cameras.emplace_back(camera->name, pose->Centre());
  }
  cv::Mat weights, mean;
  cv::merge(std::vector<cv::Mat>(3, cv::max(weight, 1e-12)), weights);
  cv::divide(sum, weights, mean);
  mean.convertTo(mosaic.picture, CV_8UC3);
  mosaic.picture.setTo(kUnseenPlace, weight == 0.0f);
  return mosaic;
}

void LabelPicture(const std::string& text, const cv::Point& place, cv::Mat* picture) {
  cv::putText(*picture, text, place, cv::FONT_HERSHEY_SIMPLEX, 0.5, kLabelRim, 3, cv::LINE_AA);
  cv::putText(*picture, text, place, cv::FONT_HERSHEY_SIMPLEX, 0.5, kLabel, 1, cv::LINE_AA);
}

}  // namespace mlic
