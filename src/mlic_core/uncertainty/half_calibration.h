#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/common/time_interval.h"
#include "mlic_core/uncertainty/adjustment.h"
#include "mlic_core/uncertainty/camera_covariance.h"
#include "mlic_core/uncertainty/stamp_errors.h"

namespace mlic {

// What one part of a recording says of the calibration (Layout), from the whole's on.
struct HalfCalibration {
  Eigen::VectorXd moved;        // from the found state
  Eigen::MatrixXd information;  // from the data alone, of the last solve's scale; zero of what is fixed
  Eigen::MatrixXd prior;        // all that the solve knew beside the data, of the true scale
  // What of it is the guesses', and what holds the sensors at these where the whole does not show them.
  Eigen::MatrixXd guesses;
  // What of the information is the noise of the part's own trajectory; empty where the whole's was not
  // measured.
  Eigen::MatrixXd noise;
  double correlation = 1.0;  // of points
  StampSums stamps;
  CameraInflation cameras;
};

// Zero in the rows and columns of what does not move.
Eigen::MatrixXd WithoutFixed(Eigen::MatrixXd matrix, const std::vector<bool>& free_calibration);

// The calibration by the stretches (of each drive) alone. Planes and matches with the map are those of the
// whole; points of tracks are triangulated and weighed anew as the calibration moves: as the whole has them,
// where the part contradicts it, those that show it would weigh little, or be left out. scale: VarianceScale.
// Nothing where the equations have no solution.
std::optional<HalfCalibration> CalibrateHalf(const Adjustment& adjustment, double scale,
                                             const std::vector<TimeInterval>& stretches,
                                             const CancellationToken& cancellation);

}  // namespace mlic
