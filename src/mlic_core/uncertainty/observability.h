#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/result/result.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_core/uncertainty/camera_covariance.h"

namespace mlic {

// By what covariances grow beyond the inverse of the information. Empty where nothing was measured.
struct Inflation {
  CameraInflation cameras;
  Eigen::MatrixXd points;  // ScatterOfPoints
};

// The inflation of equations whose gradient is by_gradient * g, g being the one that it was measured of.
Inflation WithGradient(const Eigen::MatrixXd& by_gradient, Inflation inflation);

// What the inflation adds to a covariance whose variances are `scale` times those of the solve.
Eigen::MatrixXd VarianceOfInflation(const Eigen::MatrixXd& covariance, const Inflation& inflation,
                                    double scale);

// What the data show of each LiDAR and then each camera, and how well everything is known (docs/method.md,
// section 10).
struct ObservabilityAnalysis {
  // The direction of a quantity that the data show least, in terms of its limit: m, rad, s.
  struct LeastShown {
    double sigma = 0.0;
    double limit = 1.0;
  };
  struct Sensor {
    std::array<bool, 3> translation{true, true, true};  // along the IMU's axes
    std::array<bool, 3> rotation{true, true, true};
    bool time_offset = true;
    std::vector<UnobservableDirection> directions;
    LeastShown least_translation, least_rotation, least_time_offset;
    double drift_sigma = 0.0;  // s/s, with the guesses; 0 where the drift is not estimated
  };
  std::vector<Sensor> sensors;      // in the SensorOrder, as all that follow
  std::vector<PoseSigma> sigmas;    // with the guesses
  Eigen::MatrixXd covariance;       // 7 for each LiDAR and camera as in Layout, with the guesses
  Eigen::MatrixXd data_covariance;  // without
  // Of all parameters of the calibration (Layout), of which `covariance` is the beginning.
  Eigen::MatrixXd whole_covariance;
  Eigen::VectorXd inner_sigmas;  // of the calibration's other parameters, in the order of Layout
  // Of all parameters (Layout), with the guesses, all that was held taken as known and without the inflation.
  Eigen::MatrixXd solved_covariance;

  struct Intrinsics {
    std::vector<double> sigmas;  // of each parameter; 0 where held
    std::vector<bool> held;      // as it was given
    double readout_sigma = 0.0;  // s
  };
  std::vector<Intrinsics> cameras;
};

// information: of the last solve of a joint problem with LiDARs and cameras, the residuals' scatter and
// correlation taken out. A direction is not shown when its sigma without the guesses exceeds the limits of
// observability_limits.h or the guess's own sigma. inflation: by which covariances grow, of variances that
// are `scale` times those of the solve.
ObservabilityAnalysis AnalyzeCalibration(const JointProblem& problem, const CalibrationState& state,
                                         const Eigen::MatrixXd& information, const Inflation& inflation = {},
                                         double scale = 1.0);

// Covariance of all parameters (Layout) from the data alone, without the guesses, where the accelerometer's
// rotation to the gyroscope has this prior (information, 1/rad^2).
struct FreeAlignment {
  Eigen::MatrixXd covariance;
  std::vector<bool> fixed;  // of each sensor (SensorOrder): it is given, or takes no part
};
FreeAlignment CovarianceWithAlignment(const JointProblem& problem, const CalibrationState& state,
                                      const Eigen::MatrixXd& information, const Eigen::Matrix3d& prior);

// Of the poses and offsets of the sensors at two places, out of ObservabilityAnalysis::covariance or
// data_covariance.
Eigen::Matrix<double, 14, 14> JointCovariance(const Eigen::MatrixXd& covariance, std::size_t a,
                                              std::size_t b);

// Of the relative pose T_a_b and the difference of the offsets, from their joint covariance (14 x 14: a, b),
// as PairJacobian has them.
Eigen::Matrix<double, 7, 7> PairCovariance(const SensorCalibration& a, const SensorCalibration& b,
                                           const Eigen::Matrix<double, 14, 14>& covariance);

// Relative pose of two sensors with its sigma from their joint covariance (14 x 14: a, b).
PairResult MakePair(const SensorCalibration& a, const SensorCalibration& b,
                    const Eigen::Matrix<double, 14, 14>& covariance);

// How well each camera is known against one LiDAR.
std::vector<PoseSigma> SigmasAgainstLidar(const ObservabilityAnalysis& analysis,
                                          const CalibrationState& state, std::size_t lidar);

}  // namespace mlic
