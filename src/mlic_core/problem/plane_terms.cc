#include "mlic_core/problem/plane_terms.h"

#include <cmath>
#include <optional>

#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

std::vector<PointToPlane::Extrinsic> Extrinsics(const CalibrationState& state) {
  std::vector<PointToPlane::Extrinsic> extrinsics;
  for (const SensorCalibration& lidar : state.lidars) {
    extrinsics.push_back({lidar.T_imu_sensor.rotation.toRotationMatrix(), lidar.T_imu_sensor.translation});
  }
  return extrinsics;
}

}  // namespace

PointToPlane PlaneFactor(const MapPlane& plane) {
  PointToPlane factor;
  factor.normal = plane.plane.normal;
  factor.anchor = plane.center;
  factor.tangent_u = plane.plane.normal.unitOrthogonal();
  factor.tangent_v = plane.plane.normal.cross(factor.tangent_u);
  factor.offset = plane.plane.offset - plane.plane.normal.dot(plane.center);
  return factor;
}

// Sums of J^T J of rows that touch the same control points and LiDAR, written to the large matrices once.
class PlaneTerms::RowBuffer {
 public:
  static constexpr int kColumns = PointToPlane::kColumns + 1;  // and the residual; from: structural
  static constexpr int kRows = 32;                             // from: structural

  double* Next() { return rows_.col(count_).data(); }
  // from_middle: s after the drive's middle, where the drift of the LiDAR's clock is estimated.
  void Commit(double residual, double scale, const std::optional<double>& from_middle) {
    auto row = rows_.col(count_);
    row[kColumns - 1] = residual;
    row *= scale;
    if (from_middle) {
      const double by_drift = *from_middle * row[PointToPlane::kTimeOffset];
      by_drift_.noalias() += by_drift * row;
      square_by_drift_ += by_drift * by_drift;
    }
    if (++count_ == kRows) Reduce();
  }
  // The sums' row of the drift: by all columns, and by itself.
  const Eigen::Matrix<double, kColumns, 1>& ByDrift() const { return by_drift_; }
  double SquareByDrift() const { return square_by_drift_; }
  const Eigen::Matrix<double, kColumns, kColumns>& Finish() {
    Reduce();
    return sum_;
  }
  void Clear() {
    sum_.setZero();
    by_drift_.setZero();
    square_by_drift_ = 0.0;
    count_ = 0;
  }

 private:
  void Reduce() {
    if (count_ == 0) return;
    sum_.noalias() += rows_.leftCols(count_) * rows_.leftCols(count_).transpose();
    count_ = 0;
  }
  Eigen::Matrix<double, kColumns, kRows> rows_;
  Eigen::Matrix<double, kColumns, kColumns> sum_ = Eigen::Matrix<double, kColumns, kColumns>::Zero();
  Eigen::Matrix<double, kColumns, 1> by_drift_ = Eigen::Matrix<double, kColumns, 1>::Zero();
  double square_by_drift_ = 0.0;
  int count_ = 0;
};

// Rows that touch the same control points and LiDAR. lidar -1: none yet.
struct PlaneTerms::Segment {
  std::size_t drive;
  int rotation_first = -1, position_first = -1, lidar = -1;
};

PlaneTerms::PlaneTerms(const LinearizationPoint& at) : at_(at), extrinsics_(Extrinsics(at.state)) {}

void PlaneTerms::Add(std::size_t d, std::size_t begin, std::size_t end, LandmarkCoupling* couplings,
                     Accumulator* sum) const {
  const PlaneAssociation& association = at_.problem.drives[d].planes;
  const SplitSpline& trajectory = at_.state.drives[d].trajectory;
  const double middle = trajectory.Middle();
  CouplingSlots slots(at_.layout.knots);
  RowBuffer buffer;
  for (std::size_t p = begin; p < end; ++p) {
    LandmarkCoupling& landmark = couplings[p];
    landmark.calibration = Eigen::MatrixXd::Zero(at_.layout.calibration, 3);
    const PointToPlane factor = PlaneFactor(association.planes[p]);
    Segment segment{d};
    for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
      const PlaneObservation& o = association.observations[k];
      const double t = at_.state.lidars[o.lidar].OnImuClock(o.time, middle);
      if (!trajectory.Contains(t)) continue;
      const SplineBasis rb(trajectory.rotation.knots(), t);
      const SplineBasis pb(trajectory.position.knots(), t);
      if (rb.first != segment.rotation_first || pb.first != segment.position_first ||
          o.lidar != segment.lidar) {
        if (segment.lidar >= 0) Flush(segment, &buffer, &slots, &landmark, sum);
        segment = {d, rb.first, pb.first, o.lidar};
      }
      const double residual =
          factor.Evaluate(trajectory, rb, pb, extrinsics_[o.lidar], o.position.cast<double>(), buffer.Next());
      double weight;
      sum->cost += o.weight * RobustCost(residual / o.sigma, &weight);
      std::optional<double> from_middle;
      if (at_.layout.Drift(LidarId(o.lidar)) >= 0) from_middle = o.time - middle;
      buffer.Commit(residual, std::sqrt(weight * o.weight) / o.sigma, from_middle);
    }
    if (segment.lidar >= 0) Flush(segment, &buffer, &slots, &landmark, sum);
    slots.Finish(&landmark);
  }
}

double PlaneTerms::Cost(std::size_t d, std::size_t begin, std::size_t end) const {
  const PlaneAssociation& association = at_.problem.drives[d].planes;
  const SplitSpline& trajectory = at_.state.drives[d].trajectory;
  const double middle = trajectory.Middle();
  double cost = 0.0;
  for (std::size_t p = begin; p < end; ++p) {
    const PointToPlane factor = PlaneFactor(association.planes[p]);
    for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
      const PlaneObservation& o = association.observations[k];
      const double t = at_.state.lidars[o.lidar].OnImuClock(o.time, middle);
      if (!trajectory.Contains(t)) continue;
      const double residual = factor.Evaluate(trajectory, SplineBasis(trajectory.rotation.knots(), t),
                                              SplineBasis(trajectory.position.knots(), t),
                                              extrinsics_[o.lidar], o.position.cast<double>(), nullptr);
      double weight;
      cost += o.weight * RobustCost(residual / o.sigma, &weight);
    }
  }
  return cost;
}

void PlaneTerms::Flush(const Segment& segment, RowBuffer* buffer, CouplingSlots* slots,
                       LandmarkCoupling* landmark, Accumulator* sum) const {
  using P = PointToPlane;
  constexpr int kResidual = P::kColumns;  // from: structural
  const auto& H = buffer->Finish();
  const int at = Layout::Lidar(segment.lidar);
  sum->corner.block<7, 7>(at, at) += H.block<7, 7>(P::kExtrinsic, P::kExtrinsic);
  sum->gradient_calibration.segment<7>(at) += H.block<7, 1>(P::kExtrinsic, kResidual);
  landmark->own += H.block<3, 3>(P::kPlane, P::kPlane);
  landmark->gradient += H.block<3, 1>(P::kPlane, kResidual);
  landmark->calibration.middleRows<7>(at) += H.block<7, 3>(P::kExtrinsic, P::kPlane);
  const int drift = at_.layout.Drift(LidarId(segment.lidar));
  const auto& D = buffer->ByDrift();
  if (drift >= 0) {
    sum->corner(drift, drift) += buffer->SquareByDrift();
    sum->corner.block<7, 1>(at, drift) += D.segment<7>(P::kExtrinsic);
    sum->corner.block<1, 7>(drift, at) += D.segment<7>(P::kExtrinsic).transpose();
    sum->gradient_calibration[drift] += D[kResidual];
    landmark->calibration.row(drift) += D.segment<3>(P::kPlane).transpose();
  }
  if (!at_.problem.fix_trajectory) {
    int columns[8];
    for (int j = 0; j < 4; ++j) {
      columns[j] = at_.layout.drives[segment.drive].rotation[segment.rotation_first + j];
      columns[4 + j] = at_.layout.drives[segment.drive].position[segment.position_first + j];
    }
    for (int a = 0; a < 8; ++a) {
      sum->gradient_knots.segment<3>(sum->Local(columns[a])) += H.block<3, 1>(3 * a, kResidual);
      sum->border.block<7, 3>(at, sum->Local(columns[a])) += H.block<7, 3>(P::kExtrinsic, 3 * a);
      if (drift >= 0) {
        sum->border.block<1, 3>(drift, sum->Local(columns[a])) += D.segment<3>(3 * a).transpose();
      }
      slots->Block(columns[a]) += H.block<3, 3>(3 * a, P::kPlane);
      for (int b = 0; b < 8; ++b) {
        if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
      }
    }
  }
  buffer->Clear();
}

void MovePlane(const Eigen::Vector3d& step, MapPlane* plane) {
  const PointToPlane factor = PlaneFactor(*plane);
  const double offset = factor.offset + step[2];
  plane->plane.normal =
      (factor.normal + step[0] * factor.tangent_u + step[1] * factor.tangent_v).normalized();
  plane->plane.offset = offset + plane->plane.normal.dot(plane->center);
}

PlaneRows RowsOfPlane(const PlaneAssociation& association, const CalibrationState& state, std::size_t drive,
                      std::size_t plane) {
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  const auto extrinsics = Extrinsics(state);
  const PointToPlane factor = PlaneFactor(association.planes[plane]);
  const double middle = trajectory.Middle();
  PlaneRows rows;
  for (std::size_t k = association.begin[plane]; k < association.begin[plane + 1]; ++k) {
    const PlaneObservation& o = association.observations[k];
    if (trajectory.Contains(state.lidars[o.lidar].OnImuClock(o.time, middle))) rows.observations.push_back(k);
  }
  const auto count = static_cast<Eigen::Index>(rows.observations.size());
  rows.jacobian.resize(PointToPlane::kColumns, count);
  rows.residuals.resize(count);
  rows.units.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PlaneObservation& o = association.observations[rows.observations[i]];
    const double t = state.lidars[o.lidar].OnImuClock(o.time, middle);
    const double residual = factor.Evaluate(trajectory, SplineBasis(trajectory.rotation.knots(), t),
                                            SplineBasis(trajectory.position.knots(), t), extrinsics[o.lidar],
                                            o.position.cast<double>(), rows.jacobian.col(i).data());
    double weight;
    RobustCost(residual / o.sigma, &weight);
    rows.units[i] = std::sqrt(weight * o.weight);
    rows.jacobian.col(i) *= rows.units[i] / o.sigma;
    rows.residuals[i] = rows.units[i] * residual / o.sigma;
  }
  return rows;
}

std::vector<Eigen::Index> GroupBegins(const PlaneAssociation& association,
                                      const std::vector<std::size_t>& observations) {
  constexpr double kGroup = 1.0;  // s; from: structural
  const auto of = [&](std::size_t i) -> const PlaneObservation& {
    return association.observations[observations[i]];
  };
  std::vector<Eigen::Index> begins;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const bool same =
        !begins.empty() && of(i).lidar == of(begin).lidar && of(i).time <= of(begin).time + kGroup;
    if (same) continue;
    begin = i;
    begins.push_back(static_cast<Eigen::Index>(i));
  }
  begins.push_back(static_cast<Eigen::Index>(observations.size()));
  return begins;
}

Eigen::LDLT<Eigen::Matrix3d> PlaneInformation(const PlaneRows& rows) {
  constexpr double kRidge = 1e-9;  // from: guard
  const auto by_plane = rows.jacobian.bottomRows<3>();
  Eigen::Matrix3d information = by_plane * by_plane.transpose();
  information.diagonal().array() += kRidge;
  return Eigen::LDLT<Eigen::Matrix3d>(information);
}

std::vector<float> PlaneResiduals(const PlaneAssociation& association, const CalibrationState& state,
                                  std::size_t drive) {
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  const auto extrinsics = Extrinsics(state);
  const double middle = trajectory.Middle();
  std::vector<float> residuals(association.observations.size(), 0.0f);
  ParallelFor(association.planes.size(), [&](std::size_t p) {
    const PointToPlane factor = PlaneFactor(association.planes[p]);
    for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
      const PlaneObservation& o = association.observations[k];
      const double t = state.lidars[o.lidar].OnImuClock(o.time, middle);
      if (!trajectory.Contains(t)) continue;
      residuals[k] =
          static_cast<float>(factor.Evaluate(trajectory, SplineBasis(trajectory.rotation.knots(), t),
                                             SplineBasis(trajectory.position.knots(), t), extrinsics[o.lidar],
                                             o.position.cast<double>(), nullptr));
    }
  });
  return residuals;
}

}  // namespace mlic
