#include "ceres_reference/plane_cost.h"

#include "mlic_core/problem/plane_terms.h"

namespace mlic::ceres_reference {

PlaneCost::PlaneCost(EvaluationPoint* at, std::size_t drive, const PlaneObservation& observation,
                     double* plane, BlockList* blocks)
    : at_(*at),
      drive_(drive),
      observation_(observation),
      knots_(at->state.drives[drive].trajectory,
             observation.time + at->state.lidars[observation.lidar].time_offset,
             MeasurementKnots::kClockMargin) {
  SensorCalibration& lidar = at->state.lidars[observation.lidar];
  knots_.AddTo(&at->drives[drive], blocks);
  blocks->Add(lidar.T_imu_sensor.rotation.coeffs().data(), 4);
  blocks->Add(lidar.T_imu_sensor.translation.data(), 3);
  blocks->Add(&lidar.time_offset, 1);
  blocks->Add(plane, 7);
  *mutable_parameter_block_sizes() = blocks->ambients;
  set_num_residuals(1);
}

bool PlaneCost::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const SplitSpline& trajectory = at_.state.drives[drive_].trajectory;
  const PlaneObservation& o = observation_;
  const double time = o.time + at_.state.lidars[o.lidar].time_offset;
  if (!trajectory.Contains(time)) {
    residuals[0] = 0.0;
    if (jacobians != nullptr) ClearBlocks(1, parameter_block_sizes(), jacobians);
    return true;
  }
  const int rest = knots_.Count();
  const PointToPlane factor = PlaneFactor(PlaneOf(parameters[rest + 3]));
  const SplineBasis rb = knots_.rotation.Basis(trajectory.rotation.knots(), time);
  const SplineBasis pb = knots_.position.Basis(trajectory.position.knots(), time);
  Eigen::Matrix<double, PointToPlane::kColumns, 1> row;
  residuals[0] = factor.Evaluate(trajectory, rb, pb, at_.lidars[o.lidar], o.position.cast<double>(),
                                 jacobians != nullptr ? row.data() : nullptr) /
                 o.sigma;
  if (jacobians == nullptr) return true;
  row /= o.sigma;
  knots_.Write(row, rb, pb, jacobians);
  WriteBlock(row, PointToPlane::kExtrinsic, 3, 4, jacobians[rest]);
  WriteBlock(row, PointToPlane::kExtrinsic + 3, 3, 3, jacobians[rest + 1]);
  WriteBlock(row, PointToPlane::kTimeOffset, 1, 1, jacobians[rest + 2]);
  WriteBlock(row, PointToPlane::kPlane, 3, 7, jacobians[rest + 3]);
  return true;
}

}  // namespace mlic::ceres_reference
