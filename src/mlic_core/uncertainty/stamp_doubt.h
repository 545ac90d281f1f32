#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/uncertainty/adjustment.h"
#include "mlic_core/uncertainty/stamp_evidence.h"

namespace mlic {

// Of each drive and camera whose offset is estimated, as recorded, where they are enough to say something.
std::vector<ImageStamps> StampsOfImages(const Adjustment& adjustment);

// Their stamps as the courses have them.
std::vector<ImageStamps> OnCourse(std::vector<ImageStamps> all, const AdjustedCameras& cameras);

// The tracks of each drive with their cameras' stamps as the courses have them.
std::vector<TrackSet> OnTime(const AdjustedCameras& cameras);

// What the errors of the courses that stamps follow add to the scatter of the gradient (ScatterOfPoints).
// scale: by which covariances exceed the information's.
Eigen::MatrixXd ScatterOfStamps(const Adjustment& adjustment, double scale);

}  // namespace mlic
