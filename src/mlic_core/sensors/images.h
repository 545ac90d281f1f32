#pragma once

#include <cstddef>
#include <memory>
#include <opencv2/core/mat.hpp>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// The images of one camera, in order of time, read one at a time when asked for: a drive's images do not fit
// into memory. All functions may be called by several threads at once.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  virtual std::size_t Count() const = 0;
  // Stamp on the camera's own clock, seconds since the drive's epoch.
  virtual double Time(std::size_t index) const = 0;
  // CV_8UC1 (gray) or CV_8UC3 (BGR), as recorded; Bayer images are interpolated. One that cannot be decoded
  // is black, as if there was nothing to see; throws InputError where these are too many.
  virtual cv::Mat Load(std::size_t index) const = 0;
  // How many of those loaded so far could not be decoded.
  virtual std::size_t Undecodable() const { return 0; }
};

// The image whose stamp is nearest to the time. images: at least one.
inline std::size_t NearestImage(const ImageSource& images, double time) {
  std::size_t low = 0, high = images.Count() - 1;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (images.Time(middle) + images.Time(middle + 1) < 2.0 * time) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

// What one camera recorded in one drive.
struct CameraRecording {
  std::shared_ptr<const ImageSource> images;
  int width = 0;  // pixels
  int height = 0;
  cv::Mat mask;  // CV_8UC1, 0: ignore; empty: all pixels count
};

}  // namespace mlic
