#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/problem/observations.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// One way of putting observations together whose errors may be shared: columns are groups, rows quantities
// that follow the residuals (parameters of the calibration, and what is made of them).
struct ObservationGroups {
  Eigen::MatrixXd moves;     // of the quantities, by the residuals of the group
  Eigen::MatrixXd variance;  // of these, for white residuals

  void Resize(Eigen::Index quantities, Eigen::Index groups) {
    moves = variance = Eigen::MatrixXd::Zero(quantities, groups);
  }
  void Add(Eigen::Index group, const Eigen::VectorXd& move, const Eigen::VectorXd& of_white) {
    moves.col(group) += move;
    variance.col(group) += of_white;
  }
  void Add(const ObservationGroups& other) {
    moves += other.moves;
    variance += other.variance;
  }
};

// The variance of each quantity by the scatter of groups; that of single observations where they are too few.
// variances: as claimed, of all observations.
Eigen::VectorXd ScatterOfGroups(const ObservationGroups& groups, const Eigen::VectorXd& variances,
                                const Eigen::VectorXd& of_observations);

// Which group an observation of a camera belongs to: stretches of 3 s of each drive, and cells of each image,
// 6 along its longer side.
class ImageGroups {
 public:
  static constexpr int kCells = 6;  // from: structural, parts of the image

  explicit ImageGroups(const CalibrationState& state);

  Eigen::Index Stretches() const { return first_stretch_.back(); }
  Eigen::Index Cells() const { return cells_; }
  // time: IMU clock, s. later: by which stretches begin later, in stretches, 0 to 1.
  Eigen::Index Stretch(std::size_t drive, double time, double later) const;
  // One of kCells * kCells for each camera, one camera's after the other's.
  static Eigen::Index Cell(const LandmarkObservation& o, const CameraIntrinsics& intrinsics);

 private:
  std::vector<Eigen::Index> first_stretch_;  // of each drive, and the end
  std::vector<double> start_;                // of each drive
  Eigen::Index cells_ = 0;
};

}  // namespace mlic
