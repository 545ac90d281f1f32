#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/uncertainty/adjustment.h"
#include "mlic_core/uncertainty/stamp_evidence.h"

namespace mlic {

// One camera's images in one drive.
struct CameraImages {
  std::size_t drive, camera;
  std::vector<double> stamps;  // their own, ascending
};

// Of each drive and camera whose offset is estimated, where they are enough to say something.
std::vector<CameraImages> ImagesOfCameras(const Adjustment& adjustment);

// Their stamps as the courses have them.
std::vector<ImageStamps> OnCourse(const std::vector<CameraImages>& all, const AdjustedCameras& cameras);

// What the errors of the courses that stamps follow add to the scatter of the gradient (ScatterOfPoints).
// scale: by which covariances exceed the information's.
Eigen::MatrixXd ScatterOfStamps(const Adjustment& adjustment, double scale);

}  // namespace mlic
