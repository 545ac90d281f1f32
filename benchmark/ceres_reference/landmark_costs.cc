#include "ceres_reference/landmark_costs.h"

#include <algorithm>

#include "mlic_core/factors/lidar_point.h"
#include "mlic_core/factors/reprojection.h"
#include "mlic_core/problem/landmark_terms.h"

namespace mlic::ceres_reference {
namespace {

constexpr double kLostSigmas = 100.0;  // as in landmark_terms.cc

double TimeOf(const LandmarkObservation& o, const Reprojection& factor, const CalibrationState& state) {
  const CameraCalibration& camera = state.cameras[o.camera];
  return factor.Time(o.time + camera.sensor.time_offset, camera.readout);
}

void AddPose(SensorCalibration* sensor, BlockList* blocks) {
  blocks->Add(sensor->T_imu_sensor.rotation.coeffs().data(), 4);
  blocks->Add(sensor->T_imu_sensor.translation.data(), 3);
  blocks->Add(&sensor->time_offset, 1);
}

}  // namespace

ReprojectionCost::ReprojectionCost(EvaluationPoint* at, std::size_t drive,
                                   const LandmarkObservation& observation, double* point, BlockList* blocks)
    : at_(*at),
      drive_(drive),
      observation_(observation),
      factor_(Reprojection::Of(observation.pixel, at->state.cameras[observation.camera].intrinsics)),
      knots_(at->state.drives[drive].trajectory, TimeOf(observation, factor_, at->state),
             MeasurementKnots::kClockMargin) {
  CameraCalibration& camera = at->state.cameras[observation.camera];
  knots_.AddTo(&at->drives[drive], blocks);
  AddPose(&camera.sensor, blocks);
  if (camera.rolling_shutter) blocks->Add(&camera.readout, 1);
  std::vector<double>& intrinsics = camera.intrinsics.parameters;
  blocks->Add(intrinsics.data(), static_cast<int>(intrinsics.size()));
  blocks->Add(point, 6);
  *mutable_parameter_block_sizes() = blocks->ambients;
  set_num_residuals(2);
}

bool ReprojectionCost::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const SplitSpline& trajectory = at_.state.drives[drive_].trajectory;
  const CameraCalibration& camera = at_.state.cameras[observation_.camera];
  const double time = TimeOf(observation_, factor_, at_.state);
  std::fill_n(residuals, 2, 0.0);
  if (jacobians != nullptr) ClearBlocks(2, parameter_block_sizes(), jacobians);
  if (!trajectory.Contains(time)) return true;
  const SplineBasis rb = knots_.rotation.Basis(trajectory.rotation.knots(), time);
  const SplineBasis pb = knots_.position.Basis(trajectory.position.knots(), time);
  const int last = static_cast<int>(parameter_block_sizes().size()) - 1;
  const PointLandmark point = PointOf(parameters[last]);
  Eigen::Vector2d error;
  Reprojection::Jacobian J;
  if (!factor_.Evaluate(trajectory, rb, pb, at_.cameras[observation_.camera], point.position, &error,
                        jacobians != nullptr ? &J : nullptr)) {
    residuals[0] = kLostSigmas;
    return true;
  }
  const Eigen::Matrix2d whitening = observation_.shape.cast<double>() / observation_.sigma;
  Eigen::Map<Eigen::Vector2d>(residuals, 2) = whitening * error;
  if (jacobians == nullptr) return true;
  J.middleRows<3>(Reprojection::kPoint) =
      (PointChartJacobian(point).transpose() * J.middleRows<3>(Reprojection::kPoint)).eval();
  J *= whitening.transpose();
  knots_.Write(J, rb, pb, jacobians);
  double** block = jacobians + knots_.Count();
  WriteBlock(J, Reprojection::kExtrinsic, 3, 4, *block++);
  WriteBlock(J, Reprojection::kExtrinsic + 3, 3, 3, *block++);
  WriteBlock(J, Reprojection::kTimeOffset, 1, 1, *block++);
  if (camera.rolling_shutter) WriteBlock(J, Reprojection::kReadout, 1, 1, *block++);
  const int intrinsics = parameter_block_sizes()[last - 1];
  WriteBlock(J, Reprojection::kIntrinsics, intrinsics, intrinsics, *block++);
  WriteBlock(J, Reprojection::kPoint, 3, 6, *block);
  return true;
}

LidarPointCost::LidarPointCost(EvaluationPoint* at, std::size_t drive,
                               const LidarPointObservation& observation, double* point, BlockList* blocks)
    : at_(*at),
      drive_(drive),
      observation_(observation),
      knots_(at->state.drives[drive].trajectory,
             observation.time + at->state.lidars[observation.lidar].time_offset,
             MeasurementKnots::kClockMargin) {
  knots_.AddTo(&at->drives[drive], blocks);
  AddPose(&at->state.lidars[observation.lidar], blocks);
  blocks->Add(point, 6);
  *mutable_parameter_block_sizes() = blocks->ambients;
  set_num_residuals(3);
}

bool LidarPointCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const SplitSpline& trajectory = at_.state.drives[drive_].trajectory;
  const SensorCalibration& lidar = at_.state.lidars[observation_.lidar];
  const double time = observation_.time + lidar.time_offset;
  std::fill_n(residuals, 3, 0.0);
  if (jacobians != nullptr) ClearBlocks(3, parameter_block_sizes(), jacobians);
  if (!trajectory.Contains(time)) return true;
  const int rest = knots_.Count();
  const PointLandmark point = PointOf(parameters[rest + 3]);
  const SplineBasis rb = knots_.rotation.Basis(trajectory.rotation.knots(), time);
  const SplineBasis pb = knots_.position.Basis(trajectory.position.knots(), time);
  LidarPointResidual::Jacobian J;
  const LidarPointResidual factor{observation_.position, observation_.sigma_along, observation_.sigma_across};
  Eigen::Map<Eigen::Vector3d>(residuals, 3) =
      factor.Evaluate(trajectory, rb, pb, lidar, point.position, jacobians != nullptr ? &J : nullptr);
  if (jacobians == nullptr) return true;
  J.middleRows<3>(LidarPointResidual::kPoint) =
      (PointChartJacobian(point).transpose() * J.middleRows<3>(LidarPointResidual::kPoint)).eval();
  knots_.Write(J, rb, pb, jacobians);
  WriteBlock(J, LidarPointResidual::kExtrinsic, 3, 4, jacobians[rest]);
  WriteBlock(J, LidarPointResidual::kExtrinsic + 3, 3, 3, jacobians[rest + 1]);
  WriteBlock(J, LidarPointResidual::kTimeOffset, 1, 1, jacobians[rest + 2]);
  WriteBlock(J, LidarPointResidual::kPoint, 3, 6, jacobians[rest + 3]);
  return true;
}

}  // namespace mlic::ceres_reference
