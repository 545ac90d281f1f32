#include "mlic_core/uncertainty/adjustment.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/noise_information.h"
#include "mlic_core/uncertainty/halves_statistics.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"

namespace mlic {
namespace {

// Of a drive, what the middle of an automatic exposure moves by. from: derivation, half of what exposures of
// 5 ms change by where the light changes by 40 %; a RealSense in a room: 9 ms in 40 s (docs/method.md, 8.1)
constexpr double kExposureMoves = 1e-3;  // s
constexpr double kUnknownChange = 1e9;   // from: guard, far beyond any that counts as settled

// Of a sensor's time offset, s; zero where it was not compared.
double DifferenceOfHalves(const Adjustment& adjustment, std::size_t sensor) {
  if (sensor >= adjustment.halves.size()) return 0.0;
  for (const HalvesDifference& of : adjustment.halves[sensor].quantities) {
    if (of.quantity == HalvesDifference::Quantity::kTimeOffset) return of.difference[0];
  }
  return 0.0;
}

// No clocks of crystals drift so fast: a camera's stamps do where auto exposure moves the middle of its
// exposure against them, and go back, as what is left of them wanders. In another drive its offset is
// another, by about as much as it moves in this one: by the variance of an even move and of the course. A
// random walk leaves the slope through it the variance 6/5 of that of a second by the walk's length. What
// light does to the exposure from one end of a drive to the other is no clock's either, and slower.
void AddWanderOfExposure(const Adjustment& adjustment, ObservabilityAnalysis* analysis) {
  const CalibrationState& state = adjustment.state;
  const Layout layout(state, adjustment.problem.estimate_imu_matrices);
  const auto drives = static_cast<double>(state.drives.size());
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const std::size_t s = layout.order.PlaceOf(CameraId(c));
    const double drift = std::abs(state.cameras[c].sensor.clock_drift.value_or(0.0));
    double of_offset = 0.0, of_drift = 0.0;
    for (std::size_t d = 0; d < state.drives.size(); ++d) {
      const SplitSpline& trajectory = state.drives[d].trajectory;
      const double length = trajectory.End() - trajectory.Start();
      if (drift >= kFastestCrystals) of_offset += std::pow(drift * length, 2) / 12.0;
      of_drift += std::pow(kExposureMoves / length, 2);
      if (d >= adjustment.cameras.stamp_courses.size()) continue;
      const StampCourse& course = adjustment.cameras.stamp_courses[d][c];
      of_drift += 1.2 * course.walk / length;
    }
    if (const double wander = StampWander(adjustment, c); wander > 0.0) {
      // The trajectory may have followed a part; what the halves of the drive still differ by is more of it.
      of_offset += drives * (wander + std::pow(0.5 * DifferenceOfHalves(adjustment, s), 2));
    }
    const int offset = Layout::Sensor(s) + 6;
    analysis->covariance(offset, offset) += of_offset / drives;
    analysis->sigmas[s].time_offset = std::sqrt(analysis->covariance(offset, offset));
    if (layout.drift[s] < 0) continue;
    analysis->whole_covariance(layout.drift[s], layout.drift[s]) += of_drift / (drives * drives);
    analysis->sensors[s].drift_sigma =
        std::sqrt(analysis->whole_covariance(layout.drift[s], layout.drift[s]));
  }
}

// Of each parameter of the calibration (Layout), GrowthOfSigmas of what the parts of the drive differ by.
// Poses and offsets grow alike for all sensors, by the most of any that is given: what they share, as the
// IMU's errors, they err by together, and pairs are not to grow by it.
Eigen::VectorXd GrowthByHalves(const Adjustment& adjustment, const Layout& layout) {
  using Quantity = HalvesDifference::Quantity;
  const double by_chance = LargestByChance(adjustment.halves);
  Eigen::VectorXd growth = Eigen::VectorXd::Ones(layout.calibration);
  Eigen::Matrix<double, Layout::kOfSensor, 1> of_pose = Eigen::Matrix<double, Layout::kOfSensor, 1>::Ones();
  const auto raise = [](double by, auto&& parameters) { parameters = parameters.cwiseMax(by); };
  for (std::size_t s = 0; s < adjustment.halves.size(); ++s) {
    const SensorHalves& halves = adjustment.halves[s];
    if (WorstOf(halves) > by_chance) continue;  // it is not given
    const SensorId id = layout.order.At(s);
    for (const HalvesDifference& of : halves.quantities) {
      const double by = GrowthOfSigmas(of);
      if (of.quantity == Quantity::kRotation) {
        raise(by, of_pose.segment<3>(0));
      } else if (of.quantity == Quantity::kTranslation) {
        raise(by, of_pose.segment<3>(3));
      } else if (of.quantity == Quantity::kIntrinsics) {
        const std::vector<double>& lens = adjustment.state.cameras[id.index].intrinsics.parameters;
        raise(by, growth.segment(layout.Intrinsics(id.index), static_cast<Eigen::Index>(lens.size())));
        if (const int readout = layout.Readout(id.index); readout >= 0) growth[readout] = by;
      } else if (id.IsLidar() || StampWander(adjustment, id.index) == 0.0) {  // of others the sigma has it
        of_pose[6] = std::max(of_pose[6], by);
      }
    }
  }
  for (std::size_t s = 0; s < layout.order.size(); ++s) {
    growth.segment<Layout::kOfSensor>(Layout::Sensor(s)) = of_pose;
  }
  return growth;
}

void GrowByHalves(const Adjustment& adjustment, ObservabilityAnalysis* analysis) {
  if (adjustment.halves.empty()) return;
  const Layout layout(adjustment.state, adjustment.problem.estimate_imu_matrices);
  const Eigen::VectorXd growth = GrowthByHalves(adjustment, layout);
  for (Eigen::MatrixXd* covariance :
       {&analysis->covariance, &analysis->data_covariance, &analysis->whole_covariance}) {
    const Eigen::VectorXd of_these = growth.head(covariance->rows());
    *covariance = of_these.asDiagonal() * *covariance * of_these.asDiagonal();
  }
  for (std::size_t s = 0; s < layout.order.size(); ++s) {
    const auto of_pose = growth.segment<Layout::kOfSensor>(Layout::Sensor(s));
    PoseSigma& sigma = analysis->sigmas[s];
    sigma.rotation = sigma.rotation.cwiseProduct(of_pose.segment<3>(0));
    sigma.translation = sigma.translation.cwiseProduct(of_pose.segment<3>(3));
    sigma.time_offset *= of_pose[6];
  }
  for (std::size_t c = 0; c < analysis->cameras.size(); ++c) {
    ObservabilityAnalysis::Intrinsics& lens = analysis->cameras[c];
    for (std::size_t i = 0; i < lens.sigmas.size(); ++i) {
      lens.sigmas[i] *= growth[layout.Intrinsics(c) + static_cast<Eigen::Index>(i)];
    }
    if (layout.Readout(c) >= 0) lens.readout_sigma *= growth[layout.Readout(c)];
  }
}

// The last solve's, without what of them is the noise's where that was measured of the same parameters.
FreedOfNoise LastWithoutNoise(const Adjustment& adjustment) {
  const Eigen::MatrixXd information = LastInformation(adjustment);
  const Eigen::MatrixXd& noise = adjustment.noise_information;
  if (noise.rows() != information.rows()) {
    return {information, Eigen::MatrixXd::Identity(information.rows(), information.cols())};
  }
  const Layout layout(adjustment.state, adjustment.problem.estimate_imu_matrices);
  return WithoutNoise(information, noise, CalibrationLimits(adjustment.state, layout));
}

}  // namespace

double StampWander(const Adjustment& adjustment, std::size_t camera) {
  const std::vector<std::vector<StampCourse>>& courses = adjustment.cameras.stamp_courses;
  double sum = 0.0;
  for (const std::vector<StampCourse>& of_drive : courses) sum += of_drive[camera].MeanSquare();
  return courses.empty() ? 0.0 : sum / static_cast<double>(courses.size());
}

double MeanSquaredResidual(const Adjustment& adjustment, const Dataset& dataset) {
  const SolveSummary& solve = adjustment.last_solve;
  const double residuals =
      static_cast<double>(std::max<std::size_t>(1, solve.observations + 2 * solve.landmark_observations));
  return solve.last_cost / (residuals + 6.0 * ImuSampleCount(dataset));
}

double VarianceScale(const Adjustment& adjustment, const Dataset& dataset) {
  const double scatter = std::max(1.0, MeanSquaredResidual(adjustment, dataset));
  const double unsettled = adjustment.rounds.unsettled;
  return scatter * adjustment.scale.correlation * (1.0 + unsettled * unsettled);
}

Eigen::MatrixXd LastInformation(const Adjustment& adjustment) {
  const Eigen::MatrixXd& information = adjustment.last_solve.information;
  if (information.size() > 0) return information;
  const int size = Layout(adjustment.state, adjustment.problem.estimate_imu_matrices).calibration;
  return Eigen::MatrixXd::Zero(size, size);
}

Eigen::MatrixXd ScaledInformation(const Adjustment& adjustment, const Dataset& dataset) {
  return LastWithoutNoise(adjustment).information / VarianceScale(adjustment, dataset);
}

ObservabilityAnalysis Analyze(const Adjustment& adjustment, const Dataset& dataset) {
  const FreedOfNoise freed = LastWithoutNoise(adjustment);
  const double scale = VarianceScale(adjustment, dataset);
  ObservabilityAnalysis analysis =
      AnalyzeCalibration(adjustment.problem, adjustment.state, freed.information / scale,
                         WithGradient(freed.by_gradient, adjustment.scale.inflation), scale);
  AddWanderOfExposure(adjustment, &analysis);
  GrowByHalves(adjustment, &analysis);
  for (std::size_t c = 0; c < adjustment.cameras.twins.size(); ++c) {
    const std::vector<double>& twin = adjustment.cameras.twins[c];
    std::vector<double>& sigmas = analysis.cameras[c].sigmas;
    for (std::size_t i = 0; i < twin.size(); ++i) sigmas[i] = std::hypot(sigmas[i], twin[i]);
  }
  return analysis;
}

ObservabilityAnalysis AnalyzeBound(const Adjustment& adjustment) {
  return AnalyzeCalibration(adjustment.problem, adjustment.state, LastWithoutNoise(adjustment).information);
}

double ChangeInSigmas(const Adjustment& adjustment, const Dataset& dataset, const CalibrationState& before) {
  if (adjustment.last_solve.information.size() == 0) return kUnknownChange;
  const CalibrationState& state = adjustment.state;
  const ObservabilityAnalysis analysis = Analyze(adjustment, dataset);
  double largest = 0.0;
  const auto compare = [&](const SensorCalibration& a, const SensorCalibration& b, const PoseSigma& sigma,
                           double drift_sigma) {
    const Eigen::Vector3d rotation = Log(b.T_imu_sensor.rotation * a.T_imu_sensor.rotation.conjugate());
    const Eigen::Vector3d translation = b.T_imu_sensor.translation - a.T_imu_sensor.translation;
    Eigen::Matrix<double, 7, 1> changes;
    changes << rotation.cwiseQuotient(sigma.rotation), translation.cwiseQuotient(sigma.translation),
        (b.time_offset - a.time_offset) / sigma.time_offset;
    const double change = changes.allFinite() ? changes.cwiseAbs().maxCoeff() : kUnknownChange;
    largest = std::max(largest, change);
    if (!b.clock_drift) return;
    const double drift = (*b.clock_drift - a.clock_drift.value_or(0.0)) / drift_sigma;
    largest = std::max(largest, std::isfinite(drift) ? std::abs(drift) : kUnknownChange);
  };
  const SensorOrder order = state.Sensors();
  const Eigen::VectorXd& refused = adjustment.last_solve.refused_step;
  for (std::size_t s = 0; s < order.size(); ++s) {
    const PoseSigma& sigma = analysis.sigmas[s];
    compare(before.Sensor(order.At(s)), state.Sensor(order.At(s)), sigma, analysis.sensors[s].drift_sigma);
    if (refused.size() == 0) continue;
    Eigen::Matrix<double, 7, 1> sigmas;
    sigmas << sigma.rotation, sigma.translation, sigma.time_offset;
    const auto step = refused.segment<7>(Layout::Sensor(s));
    largest = std::max(largest, step.cwiseQuotient(sigmas).cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace mlic
