#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/result/result.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic {

// One picture put together from the photos that all cameras took at one moment.
struct PhotoMosaic {
  cv::Mat picture;  // CV_8UC3; gray 30 where no photo shows the place
  // Those whose photos take part, with their centres in the map frame, m.
  std::vector<std::pair<std::string, Eigen::Vector3d>> cameras;
};

// place: of each pixel of the picture, in the map frame, m. A pixel has the mean of what the photos show at
// its place, near cameras counting more and borders less (PhotoPose::WeightOf); of each camera the photo
// nearest to `time` (IMU clock) is taken, at its own time. drive.cameras[i] is the camera of that name in
// `names`.
PhotoMosaic ComposePhotos(const Drive& drive, const std::vector<std::string>& names,
                          const CalibrationResult& calibration, const std::vector<StampedPose>& trajectory,
                          TimeNs time, const cv::Size& size,
                          const std::function<Eigen::Vector3d(int u, int v)>& place);

// White with a black rim, so that it can be read on anything. place: px, of its lower left corner.
void LabelPicture(const std::string& text, const cv::Point& place, cv::Mat* picture);

}  // namespace mlic
