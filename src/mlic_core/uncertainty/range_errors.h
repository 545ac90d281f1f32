#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/uncertainty/range_columns.h"

namespace mlic {

using RangeVector = Eigen::Matrix<double, kRangeParameters, 1>;
using FreeRanges = std::array<bool, kRangeParameters>;  // which of them are found; the others stay

// What all ranges of LiDARs err by (RangeCorrection). It is hardly told from a LiDAR's place where the view
// is narrow, and most LiDARs have less of it than the data show, so it is no parameter of every solve: it is
// found beside one, everything else following.
struct RangeErrors {
  std::vector<RangeVector> steps;  // of each LiDAR, to add
  std::vector<double> references;  // of each LiDAR, what its walk is about (RangeCorrection)
  // Of the parameters of each LiDAR in turn, for white residuals of variance one; zero of those held.
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd coupling;  // calibration x these: the information that both share

  // Where a LiDAR's parameter stands among those of all.
  static Eigen::Index Of(std::size_t lidar, RangeParameter parameter) {
    return static_cast<Eigen::Index>(kRangeParameters * lidar) + parameter;
  }

  // Of a LiDAR's parameter. correlation: by which residuals that share errors widen variances.
  double Sigma(std::size_t lidar, RangeParameter parameter, double correlation) const {
    return std::sqrt(correlation * covariance(Of(lidar, parameter), Of(lidar, parameter)));
  }
};

// The equations of a solution, beside which errors of ranges are found by any model: linearised and reduced
// once for all of them.
class RangeEquations {
 public:
  // Both must outlive this and stay as they are.
  RangeEquations(const JointProblem& problem, const CalibrationState& state);

  // free: of each LiDAR. Where any walk is free, planes have a relief that their brightness goes with, which
  // all LiDARs see: dark windows lie deeper in a wall. Nothing where the equations have no solution, the
  // trajectory is held or none is free. docs/method.md, section 4.
  std::optional<RangeErrors> Measure(RangeModel model, const std::vector<FreeRanges>& free) const;

  // With the same parameters free of all LiDARs.
  std::optional<RangeErrors> MeasureOfAll(RangeModel model, const FreeRanges& free) const;

  std::size_t LidarCount() const { return references_.size(); }

 private:
  struct Prior {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
  };

  // Of the calibration and a model's parameters.
  Prior WidePrior(RangeModel model, std::size_t lidars) const;

  const JointProblem& problem_;
  const CalibrationState& state_;
  std::vector<double> references_;  // of each LiDAR, what its walk is about
  bool solved_ = false;
  // Of the calibration, the points' columns of each LiDAR (range_errors.cc) and the reliefs.
  Eigen::MatrixXd information_;
  Eigen::VectorXd gradient_;
  Prior of_calibration_;
  std::vector<bool> free_calibration_;
};

}  // namespace mlic
