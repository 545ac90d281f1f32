// Whether the sigmas that a calibration claims are true: over seeds, squared errors normalised by the claimed
// covariance must be distributed as chi-square, neither too large nor too small.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/initialization/lidar_imu.h"
#include "mlic_core/pipeline/joint_adjustment.h"
#include "mlic_core/pipeline/lidar_adjustment.h"
#include "support/simulated_input.h"

namespace mlic::consistency_test {
namespace {

// Places in the seven numbers of a sensor.
const std::vector<int> kRotation{0, 1, 2}, kTranslation{3, 4, 5}, kTimeOffset{6}, kAll{0, 1, 2, 3, 4, 5, 6};

// Sum of normalised squared errors and of their degrees of freedom.
struct NormalisedErrors {
  double sum = 0.0;
  int degrees = 0;

  // Of those components whose place in a sensor's seven is among `places`.
  void Add(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance, const std::vector<int>& places) {
    std::vector<int> chosen;
    for (int i = 0; i < error.size(); ++i) {
      if (std::count(places.begin(), places.end(), i % 7) > 0) chosen.push_back(i);
    }
    const int count = static_cast<int>(chosen.size());
    Eigen::MatrixXd select = Eigen::MatrixXd::Zero(count, error.size());
    for (int i = 0; i < count; ++i) select(i, chosen[i]) = 1.0;
    const Eigen::VectorXd e = select * error;
    sum += e.dot((select * covariance * select.transpose()).ldlt().solve(e));
    degrees += count;
  }
};

// Quantile of chi-square at `deviate` of the standard normal (Wilson and Hilferty, 1931).
double ChiSquare(int degrees, double deviate) {
  const double v = 2.0 / (9.0 * degrees);
  return degrees * std::pow(std::max(0.0, 1.0 - v + deviate * std::sqrt(v)), 3);
}

// Beyond these bounds lies one of a thousand samples on either side.
void ExpectChiSquare(const NormalisedErrors& errors, const char* what) {
  constexpr double kDeviate = 3.09;
  EXPECT_LT(errors.sum, ChiSquare(errors.degrees, kDeviate)) << what << ": sigmas are too small";
  EXPECT_GT(errors.sum, ChiSquare(errors.degrees, -kDeviate)) << what << ": sigmas are too large";
  std::printf("%s: %.2f of %d, bounds %.2f and %.2f\n", what, errors.sum, errors.degrees,
              ChiSquare(errors.degrees, -kDeviate), ChiSquare(errors.degrees, kDeviate));
}

// Errors of all LiDARs as in Layout (small left rotation, translation, time offset) with their covariance.
struct Errors {
  std::vector<SensorCalibration> truth;
  Eigen::VectorXd error;
  Eigen::MatrixXd covariance;
};

Errors CalibrationErrors(const sim::SensorSet& sensors, sim::Scenario scenario, double duration,
                         std::uint64_t seed, bool with_guess) {
  const SimulatedInput input = SimulateInput(sensors, DriveOptions(scenario, duration, seed), with_guess);
  const Rig& rig = input.rig;
  const Dataset& dataset = input.dataset;
  const CancellationToken never;
  CalibrationObserver nobody;
  const std::vector<DriveOdometry> odometry{RunDriveOdometry(rig, dataset.drives[0], never, [](double) {})};
  Initialization start = Initialize(rig, dataset, odometry, never);
  if (start.state.drives.empty()) throw std::runtime_error("no start");
  const AdjustmentContext context{rig, dataset, nobody, {never}};
  Adjustment adjustment = StartAdjustment(rig, dataset, std::move(start));
  if (rig.lidars.size() > 1) adjustment = AdjustEachLidar(std::move(adjustment), context);
  adjustment = AdjustJointly(std::move(adjustment), context, {});
  MeasureUncertainty(context, &adjustment);
  Errors errors;
  errors.truth = sim::TrueCalibrations(input.sensors);
  errors.error.resize(7 * errors.truth.size());
  for (std::size_t l = 0; l < errors.truth.size(); ++l) {
    const SensorCalibration &found = adjustment.state.lidars[l], &truth = errors.truth[l];
    errors.error.segment<3>(7 * l) =
        Log(found.T_imu_sensor.rotation * truth.T_imu_sensor.rotation.conjugate());
    errors.error.segment<3>(7 * l + 3) = found.T_imu_sensor.translation - truth.T_imu_sensor.translation;
    errors.error[7 * l + 6] = found.time_offset - truth.time_offset;
  }
  errors.covariance = Analyze(adjustment, dataset).covariance;
  return errors;
}

// How the relative pose of two LiDARs a and b (small left rotation in a, translation in a) and the difference
// of their offsets change with the errors of a and of b.
Eigen::Matrix<double, 7, 14> PairJacobian(const RigidTransform& T_imu_a, const RigidTransform& T_imu_b) {
  const Eigen::Matrix3d R_a_imu = T_imu_a.rotation.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 7, 14> J = Eigen::Matrix<double, 7, 14>::Zero();
  J.block<3, 3>(0, 0) = J.block<3, 3>(3, 3) = -R_a_imu;
  J.block<3, 3>(0, 7) = J.block<3, 3>(3, 10) = R_a_imu;
  J.block<3, 3>(3, 0) = R_a_imu * Hat(T_imu_b.translation - T_imu_a.translation);
  J(6, 6) = -1.0;
  J(6, 13) = 1.0;
  return J;
}

TEST(CalibrationConsistency, HandHeldErrorsAreAsClaimed) {
  NormalisedErrors all, rotation, translation, offset;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Errors e =
        CalibrationErrors(ConfiguredSensors("handheld.yaml"), sim::Scenario::kHandheld, 12.0, seed, false);
    all.Add(e.error, e.covariance, kAll);
    rotation.Add(e.error, e.covariance, kRotation);
    translation.Add(e.error, e.covariance, kTranslation);
    offset.Add(e.error, e.covariance, kTimeOffset);
  }
  ExpectChiSquare(all, "hand-held");
  ExpectChiSquare(rotation, "hand-held rotation");
  ExpectChiSquare(translation, "hand-held translation");
  ExpectChiSquare(offset, "hand-held time offset");
}

TEST(CalibrationConsistency, ErrorsOfACarAndOfItsPairsAreAsClaimed) {
  NormalisedErrors to_imu, to_imu_offset, pairs, pair_rotation, pair_translation, pair_offset;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Errors e = CalibrationErrors(WithFirstLidars(ConfiguredSensors("paper_rig_lidars.yaml"), 2),
                                       sim::Scenario::kFigureEight, 15.0, seed, true);
    const int lidars = static_cast<int>(e.truth.size());
    // Without the height: it may be held at the guess, whose error was not drawn from its sigma.
    to_imu.Add(e.error.head<7>(), e.covariance.topLeftCorner<7, 7>(), {0, 1, 2, 3, 4, 6});
    to_imu_offset.Add(e.error.head<7>(), e.covariance.topLeftCorner<7, 7>(), kTimeOffset);
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(7 * (lidars - 1), 7 * lidars);
    for (int l = 1; l < lidars; ++l) {
      const auto pair = PairJacobian(e.truth[0].T_imu_sensor, e.truth[l].T_imu_sensor);
      J.block<7, 7>(7 * (l - 1), 0) = pair.leftCols<7>();
      J.block<7, 7>(7 * (l - 1), 7 * l) = pair.rightCols<7>();
    }
    const Eigen::VectorXd of_pairs = J * e.error;
    const Eigen::MatrixXd covariance = J * e.covariance * J.transpose();
    pairs.Add(of_pairs, covariance, kAll);
    pair_rotation.Add(of_pairs, covariance, kRotation);
    pair_translation.Add(of_pairs, covariance, kTranslation);
    pair_offset.Add(of_pairs, covariance, kTimeOffset);
  }
  ExpectChiSquare(to_imu, "car, LiDAR to IMU");
  ExpectChiSquare(to_imu_offset, "car, time offset of LiDAR to IMU");
  ExpectChiSquare(pairs, "car, pairs");
  ExpectChiSquare(pair_rotation, "car, rotation of pairs");
  ExpectChiSquare(pair_translation, "car, translation of pairs");
  ExpectChiSquare(pair_offset, "car, time offset of pairs");
}

}  // namespace
}  // namespace mlic::consistency_test
