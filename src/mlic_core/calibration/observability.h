#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mlic_core/calibration/result.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// What the data show of each LiDAR, and how well everything is known (SPEC section 5).
struct ObservabilityAnalysis {
  struct Sensor {
    std::array<bool, 3> translation{true, true, true};  // along the IMU's axes
    std::array<bool, 3> rotation{true, true, true};
    bool time_offset = true;
    std::vector<UnobservableDirection> directions;
    bool RotationAndTimeShown() const { return rotation[0] && rotation[1] && rotation[2] && time_offset; }
    bool TranslationShown() const { return translation[0] && translation[1] && translation[2]; }
  };
  std::vector<Sensor> sensors;
  std::vector<PoseSigma> sigmas;    // with the guesses
  Eigen::MatrixXd covariance;       // 7 for each LiDAR as in Layout, with the guesses
  Eigen::MatrixXd data_covariance;  // without
};

// information: of the calibration vector from the data (first 7 for each LiDAR), prior of IMU parameters
// included; guess_information: the guesses' (same size). held: LiDARs that were given and do not move. A
// direction is not shown when its sigma without the guesses exceeds 0.05 m, 0.5 deg or 5 ms, or the guess's
// own sigma.
ObservabilityAnalysis AnalyzeObservability(const Eigen::MatrixXd& information,
                                           const Eigen::MatrixXd& guess_information,
                                           const std::vector<std::optional<ExtrinsicGuess>>& guesses,
                                           const std::vector<bool>& held);

// Relative pose of two LiDARs with its sigma from their joint covariance (14 x 14: a, b).
PairResult MakePair(const SensorCalibration& a, const SensorCalibration& b,
                    const Eigen::Matrix<double, 14, 14>& covariance);

}  // namespace mlic
