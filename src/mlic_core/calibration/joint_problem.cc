#include "mlic_core/calibration/joint_problem.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/factors/imu_residual.h"
#include "mlic_core/factors/point_to_plane.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

constexpr std::size_t kChunks = 16;  // of parallel sums; fixed, so that the sums do not depend on the threads

// Huber's loss beyond this many sigmas.
constexpr double kHuber = 2.0;

double RobustCost(double whitened, double* weight) {
  const double size = std::abs(whitened);
  if (size <= kHuber) {
    *weight = 1.0;
    return whitened * whitened;
  }
  *weight = kHuber / size;
  return kHuber * (2.0 * size - kHuber);
}

// Sums of J^T J of rows that touch the same control points and LiDAR, written to the large matrices once.
class RowBuffer {
 public:
  static constexpr int kColumns = PointToPlane::kColumns + 1;  // and the residual
  static constexpr int kRows = 32;

  double* Next() { return rows_.col(count_).data(); }
  void Commit(double residual, double scale) {
    rows_.col(count_)[kColumns - 1] = residual;
    rows_.col(count_) *= scale;
    if (++count_ == kRows) Reduce();
  }
  const Eigen::Matrix<double, kColumns, kColumns>& Finish() {
    Reduce();
    return sum_;
  }
  void Clear() {
    sum_.setZero();
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
  int count_ = 0;
};

// The ties of one landmark while its observations are summed; slots are found by control point.
class TieSlots {
 public:
  explicit TieSlots(int knots) : slot_(knots / 3, -1) {}
  Eigen::Matrix3d& Block(LandmarkTies* ties, int column) {
    int& slot = slot_[column / 3];
    if (slot < 0) {
      slot = static_cast<int>(ties->columns.size());
      ties->columns.push_back(column);
      ties->blocks.push_back(Eigen::Matrix3d::Zero());
    }
    return ties->blocks[slot];
  }
  void Release(const LandmarkTies& ties) {
    for (const int column : ties.columns) slot_[column / 3] = -1;
  }

 private:
  std::vector<int> slot_;
};

PointToPlane PlaneFactor(const MapPlane& plane) {
  PointToPlane factor;
  factor.normal = plane.plane.normal;
  factor.anchor = plane.center;
  factor.tangent_u = plane.plane.normal.unitOrthogonal();
  factor.tangent_v = plane.plane.normal.cross(factor.tangent_u);
  factor.offset = plane.plane.offset - plane.plane.normal.dot(plane.center);
  return factor;
}

std::vector<PointToPlane::Extrinsic> Extrinsics(const CalibrationState& state) {
  std::vector<PointToPlane::Extrinsic> extrinsics;
  for (const SensorCalibration& lidar : state.lidars) {
    extrinsics.push_back({lidar.T_imu_sensor.rotation.toRotationMatrix(), lidar.T_imu_sensor.translation});
  }
  return extrinsics;
}

// Adds all that the problem says to sums and ties. Evaluates only the cost if ties is null.
class Linearizer {
 public:
  Linearizer(const JointProblem& problem, const CalibrationState& state, const Layout& layout)
      : problem_(problem), state_(state), layout_(layout), extrinsics_(Extrinsics(state)) {}

  Accumulator Run(std::vector<LandmarkTies>* landmarks) const {
    std::vector<Accumulator> parts;
    Accumulator sum(layout_.knots, layout_.bandwidth, layout_.calibration);
    landmarks->clear();
    for (std::size_t d = 0; d < state_.drives.size(); ++d) {
      const PlaneAssociation* planes = d < problem_.planes.size() ? &problem_.planes[d] : nullptr;
      const std::size_t first = landmarks->size();
      const std::size_t count = planes != nullptr ? planes->planes.size() : 0;
      landmarks->resize(first + count);
      // Chunks of planes with equal numbers of observations.
      std::vector<std::size_t> cut(kChunks + 1, count);
      const std::size_t total = count > 0 ? planes->begin[count] : 0;
      for (std::size_t c = 0; c < kChunks && count > 0; ++c) {
        cut[c] = std::lower_bound(planes->begin.begin(), planes->begin.end() - 1, total * c / kChunks) -
                 planes->begin.begin();
      }
      parts.assign(kChunks, Accumulator(layout_.knots, layout_.bandwidth, layout_.calibration));
      ParallelFor(kChunks, [&](std::size_t c) {
        if (count > 0) AddPlanes(d, *planes, cut[c], cut[c + 1], landmarks->data() + first, &parts[c]);
        if (!problem_.hold_trajectory) AddImu(d, c, &parts[c]);
      });
      for (const Accumulator& part : parts) sum += part;
      if (problem_.hold_trajectory) continue;
      if (d < problem_.poses.size()) AddPoses(d, &sum);
      AddGauge(d, &sum);
    }
    return sum;
  }

 private:
  void AddPlanes(std::size_t d, const PlaneAssociation& association, std::size_t begin, std::size_t end,
                 LandmarkTies* ties, Accumulator* sum) const {
    const SplitSpline& trajectory = state_.drives[d].trajectory;
    TieSlots slots(layout_.knots);
    RowBuffer buffer;
    for (std::size_t p = begin; p < end; ++p) {
      LandmarkTies& landmark = ties[p];
      landmark.calibration = Eigen::MatrixXd::Zero(layout_.calibration, 3);
      const PointToPlane factor = PlaneFactor(association.planes[p]);
      int rotation_first = -1, position_first = -1, lidar = -1;
      for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
        const PlaneObservation& o = association.observations[k];
        const double t = o.time + state_.lidars[o.lidar].time_offset;
        if (!trajectory.Contains(t)) continue;
        const SplineBasis rb(trajectory.rotation.knots(), t);
        const SplineBasis pb(trajectory.position.knots(), t);
        if (rb.first != rotation_first || pb.first != position_first || o.lidar != lidar) {
          if (lidar >= 0) Flush(d, rotation_first, position_first, lidar, &buffer, &slots, &landmark, sum);
          rotation_first = rb.first;
          position_first = pb.first;
          lidar = o.lidar;
        }
        const double residual = factor.Evaluate(trajectory, rb, pb, extrinsics_[o.lidar],
                                                o.position.cast<double>(), buffer.Next());
        double weight;
        sum->cost += RobustCost(residual / o.sigma, &weight);
        buffer.Commit(residual, std::sqrt(weight) / o.sigma);
      }
      if (lidar >= 0) Flush(d, rotation_first, position_first, lidar, &buffer, &slots, &landmark, sum);
      slots.Release(landmark);
    }
  }

  void Flush(std::size_t d, int rotation_first, int position_first, int lidar, RowBuffer* buffer,
             TieSlots* slots, LandmarkTies* landmark, Accumulator* sum) const {
    using P = PointToPlane;
    constexpr int kResidual = P::kColumns;
    const auto& H = buffer->Finish();
    const int at = Layout::Lidar(lidar);
    sum->corner.block<7, 7>(at, at) += H.block<7, 7>(P::kExtrinsic, P::kExtrinsic);
    sum->gradient_calibration.segment<7>(at) += H.block<7, 1>(P::kExtrinsic, kResidual);
    landmark->own += H.block<3, 3>(P::kPlane, P::kPlane);
    landmark->gradient += H.block<3, 1>(P::kPlane, kResidual);
    landmark->calibration.middleRows<7>(at) += H.block<7, 3>(P::kExtrinsic, P::kPlane);
    if (!problem_.hold_trajectory) {
      int columns[8];
      for (int j = 0; j < 4; ++j) {
        columns[j] = layout_.drives[d].rotation[rotation_first + j];
        columns[4 + j] = layout_.drives[d].position[position_first + j];
      }
      for (int a = 0; a < 8; ++a) {
        sum->gradient_knots.segment<3>(columns[a]) += H.block<3, 1>(3 * a, kResidual);
        sum->border.block<7, 3>(at, columns[a]) += H.block<7, 3>(P::kExtrinsic, 3 * a);
        slots->Block(landmark, columns[a]) += H.block<3, 3>(3 * a, P::kPlane);
        for (int b = 0; b < 8; ++b) {
          if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
        }
      }
    }
    buffer->Clear();
  }

  // Rows J (columns of the 8 control points, then the calibration at the given indices) with weighted
  // residuals.
  template <typename Rows, typename Residual>
  void AddRows(std::size_t d, int rotation_first, int position_first, const std::vector<int>& calibration,
               const Rows& J, const Residual& r, Accumulator* sum) const {
    int columns[8];
    for (int j = 0; j < 4; ++j) {
      columns[j] = layout_.drives[d].rotation[rotation_first + j];
      columns[4 + j] = layout_.drives[d].position[position_first + j];
    }
    const Eigen::MatrixXd H = J * J.transpose();
    const Eigen::VectorXd g = J * r;
    for (int a = 0; a < 8; ++a) {
      sum->gradient_knots.template segment<3>(columns[a]) += g.segment<3>(3 * a);
      for (int b = 0; b < 8; ++b) {
        if (columns[a] >= columns[b]) sum->AddBand(columns[a], columns[b], H.block<3, 3>(3 * a, 3 * b));
      }
      for (std::size_t i = 0; i < calibration.size(); ++i) {
        sum->border.template block<1, 3>(calibration[i], columns[a]) += H.block<1, 3>(24 + i, 3 * a);
      }
    }
    for (std::size_t i = 0; i < calibration.size(); ++i) {
      sum->gradient_calibration[calibration[i]] += g[24 + i];
      for (std::size_t k = 0; k < calibration.size(); ++k) {
        sum->corner(calibration[i], calibration[k]) += H(24 + i, 24 + k);
      }
    }
  }

  void AddImu(std::size_t d, std::size_t chunk, Accumulator* sum) const {
    const SplitSpline& trajectory = state_.drives[d].trajectory;
    const ImuCalibration imu = state_.Imu(d);
    const auto& samples = problem_.dataset->drives[d].imu;
    std::vector<int> calibration;
    for (int i = 0; i < 6; ++i) calibration.push_back(layout_.Bias(d) + i);
    for (int i = 0; i < 15 && layout_.matrices >= 0; ++i) calibration.push_back(layout_.matrices + i);
    const int width = 24 + static_cast<int>(calibration.size());
    const std::size_t begin = samples.size() * chunk / kChunks, end = samples.size() * (chunk + 1) / kChunks;
    ImuResidual::Jacobian J;
    for (std::size_t k = begin; k < end; ++k) {
      if (!trajectory.Contains(samples[k].time)) continue;
      const SplineBasis rb(trajectory.rotation.knots(), samples[k].time);
      const SplineBasis pb(trajectory.position.knots(), samples[k].time);
      Eigen::Matrix<double, 6, 1> r =
          ImuResidual::Evaluate(trajectory, rb, pb, imu, kGravity, samples[k], &J);
      for (int i = 0; i < 6; ++i) {
        const double sigma = i < 3 ? problem_.imu_sigma[d].gyroscope : problem_.imu_sigma[d].accelerometer;
        double weight;
        sum->cost += RobustCost(0.5 * r[i] / sigma, &weight) * 4.0;  // shocks only: beyond 4 sigma
        const double scale = std::sqrt(weight) / sigma;
        J.col(i) *= scale;
        r[i] *= scale;
      }
      AddRows(d, rb.first, pb.first, calibration, J.topRows(width), r, sum);
    }
  }

  void AddPoses(std::size_t d, Accumulator* sum) const {
    const SplitSpline& trajectory = state_.drives[d].trajectory;
    for (const PoseObservation& pose : problem_.poses[d]) {
      if (!trajectory.Contains(pose.time)) continue;
      const SplineBasis rb(trajectory.rotation.knots(), pose.time);
      const SplineBasis pb(trajectory.position.knots(), pose.time);
      So3Spline::Jacobians J;
      const So3Spline::Value value = trajectory.rotation.Evaluate(rb, false, &J);
      const Eigen::Vector3d rotation =
          Log(pose.T_map_imu.rotation.conjugate() * Eigen::Quaterniond(value.rotation));
      const Eigen::Matrix3d inverse = RightJacobianInverse(rotation);
      const Eigen::Vector4d weights = SplineBasis::Weights(pb.lambda);
      Eigen::Matrix<double, 24, 6> rows = Eigen::Matrix<double, 24, 6>::Zero();
      Eigen::Matrix<double, 6, 1> r;
      r.head<3>() = rotation / pose.sigma_rotation;
      r.tail<3>() = (trajectory.position.Position(pb) - pose.T_map_imu.translation) / pose.sigma_translation;
      for (int j = 0; j < 4; ++j) {
        rows.block<3, 3>(3 * j, 0) = (inverse * J.rotation[j]).transpose() / pose.sigma_rotation;
        rows.block<3, 3>(12 + 3 * j, 3) = (weights[j] / pose.sigma_translation) * Eigen::Matrix3d::Identity();
      }
      // The loss of the whole pose, so that a lost scan has little say.
      double weight;
      sum->cost += RobustCost(r.norm() / std::sqrt(6.0), &weight) * 6.0;
      rows *= std::sqrt(weight);
      r *= std::sqrt(weight);
      AddRows(d, rb.first, pb.first, {}, rows, r, sum);
    }
  }

  // The map's position and yaw are free: they are held where they are, at the start (4 rows with zero
  // residual), with a sigma so small that it holds and so large that it does not spoil the conditioning.
  void AddGauge(std::size_t d, Accumulator* sum) const {
    const SplitSpline& trajectory = state_.drives[d].trajectory;
    const double t = trajectory.Start();
    const SplineBasis rb(trajectory.rotation.knots(), t);
    const SplineBasis pb(trajectory.position.knots(), t);
    So3Spline::Jacobians J;
    const So3Spline::Value value = trajectory.rotation.Evaluate(rb, false, &J);
    const Eigen::Vector4d weights = SplineBasis::Weights(pb.lambda);
    constexpr double kScale = 1e4;
    Eigen::Matrix<double, 24, 4> rows = Eigen::Matrix<double, 24, 4>::Zero();
    for (int j = 0; j < 4; ++j) {
      rows.block<3, 3>(12 + 3 * j, 0) = weights[j] * kScale * Eigen::Matrix3d::Identity();
      rows.block<3, 1>(3 * j, 3) = kScale * (value.rotation * J.rotation[j]).row(2).transpose();
    }
    AddRows(d, rb.first, pb.first, {}, rows, Eigen::Vector4d::Zero().eval(), sum);
    // Control points near the ends of a span have next to no data; a little keeps them from wandering.
    sum->band.row(0).array() += 1e-6;
  }

  const JointProblem& problem_;
  const CalibrationState& state_;
  const Layout& layout_;
  const std::vector<PointToPlane::Extrinsic> extrinsics_;
};

// The planes' own step after the control points' and the calibration's.
void UpdatePlanes(const std::vector<LandmarkTies>& ties, const Eigen::VectorXd& delta,
                  JointProblem* problem) {
  std::size_t at = 0;
  for (PlaneAssociation& association : problem->planes) {
    for (MapPlane& plane : association.planes) {
      const LandmarkTies& tie = ties[at++];
      Eigen::Vector3d right = tie.gradient + tie.calibration.transpose() * delta.tail(tie.calibration.rows());
      for (std::size_t b = 0; b < tie.columns.size(); ++b) {
        right += tie.blocks[b].transpose() * delta.segment<3>(tie.columns[b]);
      }
      Eigen::Matrix3d own = tie.own;
      own.diagonal().array() += 1e-9;
      const Eigen::Vector3d step = -own.ldlt().solve(right);
      const PointToPlane factor = PlaneFactor(plane);
      const double offset = factor.offset + step[2];
      plane.plane.normal =
          (factor.normal + step[0] * factor.tangent_u + step[1] * factor.tangent_v).normalized();
      plane.plane.offset = offset + plane.plane.normal.dot(plane.center);
    }
  }
}

}  // namespace

void CalibrationPrior(const JointProblem& problem, const CalibrationState& state, const Layout& layout,
                      Eigen::MatrixXd* information, Eigen::VectorXd* gradient) {
  *information = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
  *gradient = Eigen::VectorXd::Zero(layout.calibration);
  for (std::size_t i = 0; i < state.lidars.size(); ++i) {
    if (!problem.guesses[i]) continue;
    const ExtrinsicGuess& guess = *problem.guesses[i];
    const RigidTransform& T = state.lidars[i].T_imu_sensor;
    const Eigen::Vector3d rotation = Log(T.rotation * guess.T_imu_sensor.rotation.conjugate());
    const Eigen::Vector3d translation = T.translation - guess.T_imu_sensor.translation;
    const int at = Layout::Lidar(i);
    for (int a = 0; a < 3; ++a) {
      const double rotation_weight = 1.0 / (guess.sigma_rotation[a] * guess.sigma_rotation[a]);
      const double translation_weight = 1.0 / (guess.sigma_translation[a] * guess.sigma_translation[a]);
      (*information)(at + a, at + a) = rotation_weight;
      (*information)(at + 3 + a, at + 3 + a) = translation_weight;
      (*gradient)[at + a] = rotation_weight * rotation[a];
      (*gradient)[at + 3 + a] = translation_weight * translation[a];
    }
  }
  // An accelerometer bias of 0.2 m/s^2 and a gyroscope bias of 0.05 rad/s are large for any IMU in use.
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const int at = layout.Bias(d);
    for (int a = 0; a < 3; ++a) {
      (*information)(at + a, at + a) = 1.0 / (0.05 * 0.05);
      (*gradient)[at + a] = state.drives[d].gyroscope_bias[a] / (0.05 * 0.05);
      (*information)(at + 3 + a, at + 3 + a) = 1.0 / (0.2 * 0.2);
      (*gradient)[at + 3 + a] = state.drives[d].accelerometer_bias[a] / (0.2 * 0.2);
    }
  }
  if (layout.matrices < 0) return;
  // Scale and misalignment of a per cent or two (0.02) are the rule; only what the motion shows moves
  // further.
  constexpr double kMatrixWeight = 1.0 / (0.02 * 0.02);
  int lower = layout.matrices + 9;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const double identity = r == c ? 1.0 : 0.0;
      (*information)(layout.matrices + 3 * r + c, layout.matrices + 3 * r + c) = kMatrixWeight;
      (*gradient)[layout.matrices + 3 * r + c] = kMatrixWeight * (state.gyroscope_matrix(r, c) - identity);
      if (c > r) continue;
      (*information)(lower, lower) = kMatrixWeight;
      (*gradient)[lower++] = kMatrixWeight * (state.accelerometer_matrix(r, c) - identity);
    }
  }
}

SolveSummary SolveJointProblem(const JointProblem& given, int iterations,
                               const CancellationToken& cancellation, CalibrationState* state) {
  JointProblem problem = given;  // the planes move with the solve
  const Layout layout(*state, problem.estimate_imu_matrices);
  std::vector<bool> free_calibration(layout.calibration, true);
  for (std::size_t i = 0; i < problem.lidar_held.size(); ++i) {
    if (problem.lidar_held[i]) std::fill_n(free_calibration.begin() + Layout::Lidar(i), 7, false);
  }
  if (problem.hold_trajectory) {
    std::fill(free_calibration.begin() + 7 * state->lidars.size(), free_calibration.end(), false);
  }
  SolveSummary summary;
  for (const PlaneAssociation& association : problem.planes)
    summary.observations += association.observations.size();
  std::vector<LandmarkTies> ties;
  const auto linearize = [&](const CalibrationState& at) {
    return Linearizer(problem, at, layout).Run(&ties);
  };
  Eigen::MatrixXd prior;
  Eigen::VectorXd prior_gradient;
  Accumulator sum = linearize(*state);
  summary.first_cost = summary.last_cost = sum.cost;
  double damping = 0.0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    cancellation.ThrowIfCancelled();
    CalibrationPrior(problem, *state, layout, &prior, &prior_gradient);
    const NormalSolution solution = SolveNormalEquations(sum, ties, prior, prior_gradient, free_calibration,
                                                         damping, problem.hold_trajectory);
    ++summary.iterations;
    if (!solution.solved) {
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    summary.information = solution.information;
    CalibrationState moved = *state;
    const JointProblem before = problem;
    layout.Update(solution.delta, &moved);
    if (problem.hold_trajectory) moved.drives = state->drives;
    UpdatePlanes(ties, solution.delta, &problem);
    Accumulator next = linearize(moved);
    if (next.cost > sum.cost * (1.0 + 1e-3) + 1e-9 && iteration + 1 < iterations) {
      // Priors may rightly raise the data's cost a little; more than that is a step too far.
      problem = before;
      damping = std::max(1e-4, 10.0 * damping);
      sum = linearize(*state);
      continue;
    }
    damping *= 0.1;
    if (damping < 1e-6) damping = 0.0;
    *state = std::move(moved);
    summary.last_cost = next.cost;
    summary.last_step = solution.delta.segment(layout.knots, 7 * state->lidars.size()).cwiseAbs().maxCoeff();
    sum = std::move(next);
  }
  return summary;
}

ImuResiduals EvaluateImuResiduals(const Dataset& dataset, const CalibrationState& state, std::size_t drive) {
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  const ImuCalibration imu = state.Imu(drive);
  ImuResiduals residuals;
  for (const ImuSample& sample : dataset.drives[drive].imu) {
    if (!trajectory.Contains(sample.time)) continue;
    residuals.times.push_back(sample.time);
    residuals.values.push_back(ImuResidual::Evaluate(
        trajectory, SplineBasis(trajectory.rotation.knots(), sample.time),
        SplineBasis(trajectory.position.knots(), sample.time), imu, kGravity, sample, nullptr));
  }
  return residuals;
}

std::vector<float> PlaneResiduals(const PlaneAssociation& association, const CalibrationState& state,
                                  std::size_t drive) {
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  const auto extrinsics = Extrinsics(state);
  std::vector<float> residuals(association.observations.size(), 0.0f);
  ParallelFor(association.planes.size(), [&](std::size_t p) {
    const PointToPlane factor = PlaneFactor(association.planes[p]);
    for (std::size_t k = association.begin[p]; k < association.begin[p + 1]; ++k) {
      const PlaneObservation& o = association.observations[k];
      const double t = o.time + state.lidars[o.lidar].time_offset;
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
