#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// A camera with k1 k2 p1 p2 alone (plumb_bob with k3 = 0), as some formats have no more.
struct RadtanFit {
  CameraIntrinsics intrinsics;
  double mean = 0.0;  // px, of the distances between the two models' pixels of one ray, over the image
  double largest = 0.0;
};

// The one that is nearest to the given camera by least squares over the whole image. Meant for plumb_bob and
// rational_polynomial: the result starts from their focal lengths and first coefficients.
RadtanFit FitRadtan(const CameraIntrinsics& camera);

// A pinhole camera for programs that know k1 k2 p1 p2 alone.
struct RadtanCamera {
  std::vector<double> pinhole;     // fx fy cx cy
  std::vector<double> distortion;  // k1 k2 p1 p2
  std::string remark;              // what is not exact; empty: nothing
};

// A plumb_bob or rational_polynomial as it is where it has no more terms than that, else the nearest such
// camera where that is good to 0.2 px in the mean; none for others.
std::optional<RadtanCamera> AsRadtan(const CameraIntrinsics& camera);

}  // namespace mlic
