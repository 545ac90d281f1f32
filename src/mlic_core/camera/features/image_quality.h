#pragma once

#include <opencv2/core/mat.hpp>

namespace mlic {

// CV_8UC1 of an image as ImageSource gives it (CV_8UC1 or CV_8UC3, BGR). Green weighs most, as in luma: it is
// the channel that a Bayer sensor samples best.
cv::Mat ToGray(const cv::Mat& image);

// How well features can be found in an image.
struct ImageQuality {
  // Root mean square of the gradient along rows, relative to the mean: falls with blur, not with exposure.
  // Compares images of one scene only.
  double sharpness = 0.0;
  double contrast = 0.0;         // standard deviation of the gray values
  double saturated_share = 0.0;  // of the pixels, at least 250
  double dark_share = 0.0;       // of the pixels, at most 5
  // Neither over- nor underexposed nor without any structure.
  bool IsExposed() const { return contrast > 4.0 && saturated_share < 0.5 && dark_share < 0.6; }
};

// gray: CV_8UC1; mask as in CameraRecording, may be empty. Looks at every second row.
ImageQuality MeasureImageQuality(const cv::Mat& gray, const cv::Mat& mask);

}  // namespace mlic
