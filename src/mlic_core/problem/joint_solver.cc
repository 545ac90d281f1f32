#include "mlic_core/problem/joint_solver.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "mlic_core/common/error.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/settle_points.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"
#include "mlic_core/solver/submatrix.h"

namespace mlic {
namespace {

// By how much of it priors may rightly raise the data's cost; more than that is a step too far.
constexpr double kAllowedIncrease = 1e-3;  // from: guard
// Of an undamped step, halved until it lowers the cost by a share of what the linear problem says (Armijo,
// 1966): damping, the same for strong and weak directions, would leave next to nothing of it along weak ones.
constexpr double kLeastShare = 0.25;  // from: guard, below it damping leads to better directions
constexpr double kSufficient = 0.25;  // from: guard
// A step that lowers the cost by less than this share of it is the last one. from: guard, rounds follow until
// the calibration stands still.
constexpr double kNegligibleDecrease = 1e-4;

std::vector<LandmarkGeometry> GeometryOf(const JointProblem& problem) {
  std::vector<LandmarkGeometry> landmarks;
  for (const DriveTerms& drive : problem.drives) {
    landmarks.push_back({drive.planes.planes, drive.landmarks.points});
  }
  return landmarks;
}

SolveSummary CountedObservations(const JointProblem& problem) {
  SolveSummary summary;
  for (const DriveTerms& drive : problem.drives) {
    summary.observations += drive.planes.observations.size();
    summary.landmark_observations += drive.landmarks.observations.size();
  }
  return summary;
}

// Landmarks a share of the way from where they were to where they are.
std::vector<LandmarkGeometry> Between(const std::vector<LandmarkGeometry>& before,
                                      std::vector<LandmarkGeometry> after, double share) {
  const auto between = [share](const auto& a, const auto& b) { return a + share * (b - a); };
  for (std::size_t d = 0; d < after.size(); ++d) {
    for (std::size_t p = 0; p < after[d].planes.size(); ++p) {
      const MapPlane& last = before[d].planes[p];
      MapPlane& plane = after[d].planes[p];
      const double offset =
          between(last.plane.SignedDistance(plane.center), plane.plane.SignedDistance(plane.center));
      plane.plane.normal = Eigen::Vector3d(between(last.plane.normal, plane.plane.normal)).normalized();
      plane.plane.offset = plane.plane.normal.dot(plane.center) - offset;
    }
    for (std::size_t p = 0; p < after[d].points.size(); ++p) {
      Eigen::Vector3d& position = after[d].points[p].position;
      position = Eigen::Vector3d(between(before[d].points[p].position, position));
    }
  }
  return after;
}

// The landmarks of a problem with short couplings as those of the given one. origins: of the points, empty
// where none was split.
std::vector<LandmarkGeometry> WithPointsWhole(const JointProblem& given, JointProblem problem,
                                              const std::vector<std::vector<std::size_t>>& origins) {
  std::vector<LandmarkGeometry> landmarks;
  for (std::size_t d = 0; d < problem.drives.size(); ++d) {
    LandmarkSet& points = problem.drives[d].landmarks;
    landmarks.push_back({std::move(problem.drives[d].planes.planes),
                         origins.empty()
                             ? std::move(points.points)
                             : MergePoints(given.drives[d].landmarks.points, points, origins[d])});
  }
  return landmarks;
}

// All that the problem says beside the data.
struct Priors {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

Priors PriorsAt(const JointProblem& problem, const CalibrationState& state, const Layout& layout) {
  Priors priors;
  CalibrationPrior(problem, state, layout, &priors.information, &priors.gradient);
  AddHeldTranslations(problem, state, &priors.information, &priors.gradient);
  return priors;
}

// The IMU's scale and shear where a solve probes them: part of its equations, held, so that they say where it
// would go.
class HeldMatrices {
 public:
  // free_calibration: of the solve, theirs included; they are held in it.
  HeldMatrices(bool probed, const Layout& layout, std::vector<bool>* free_calibration) : probed_(probed) {
    for (int i = 0; i < layout.calibration; ++i) {
      const bool held = probed && i >= layout.matrices && i < layout.matrices + Layout::kOfMatrices;
      if (held) (*free_calibration)[static_cast<std::size_t>(i)] = false;
      if (!held) kept_.push_back(i);
    }
  }
  // What is left of parameters without them.
  Eigen::VectorXd RowsWithout(const Eigen::VectorXd& given) const { return SelectRows(given, kept_); }
  // Of a symmetric matrix of the parameters.
  Eigen::MatrixXd Without(const Eigen::MatrixXd& matrix) const { return Submatrix(matrix, kept_); }
  CalibrationEquations Look(const NormalSolution& solution, const Priors& priors) const {
    if (!probed_) return {};
    return {solution.information, solution.gradient, priors.gradient};
  }

 private:
  bool probed_;
  std::vector<int> kept_;  // parameters (Layout)
};

void FixCamera(const FixedCameraParameters& held, const Layout& layout, std::size_t camera,
               std::vector<bool>* free_calibration) {
  const auto hold = [&](int first, int count) {
    std::fill_n(free_calibration->begin() + first, count, false);
  };
  if (held.rotation) hold(layout.Camera(camera), 3);
  if (held.translation) hold(layout.Camera(camera) + 3, 3);
  if (held.time_offset) {
    hold(layout.Camera(camera) + 6, 1);
    if (layout.Drift(CameraId(camera)) >= 0) hold(layout.Drift(CameraId(camera)), 1);
  }
  if (held.readout && layout.Readout(camera) >= 0) hold(layout.Readout(camera), 1);
  for (std::size_t i = 0; i < held.intrinsics.size(); ++i) {
    if (held.intrinsics[i]) hold(layout.Intrinsics(camera) + static_cast<int>(i), 1);
  }
}

// A step of the solve on trial: its whole, or a share of it. The problem's landmarks are where it leads.
class StepTrial {
 public:
  // The normal equations at a state, with which their cost comes.
  using Linearize = std::function<Accumulator(const CalibrationState&)>;
  // By how much an undamped step from a state and its equations would move the accelerometer's lag, s.
  using LagStep = std::function<double(const CalibrationState&, const Accumulator&)>;

  // cost: where the step begins, as the priors. All must outlive the trial.
  StepTrial(const CalibrationState& start, double cost, const Priors& priors, const NormalSolution& solution,
            const Layout& layout, const std::vector<LandmarkCoupling>& couplings, JointProblem* problem)
      : start_(start),
        start_cost_(cost),
        priors_(priors),
        solution_(solution),
        layout_(layout),
        problem_(*problem),
        before_(GeometryOf(*problem)) {
    MoveLandmarks(LandmarkSteps(couplings, solution.delta), problem);
  }

  // False where the cost rises by too much, or is not a number. linearize: empty where the step is the last.
  bool TakeWhole(const Linearize& linearize) {
    const double least = -kAllowedIncrease * start_cost_ - 1e-9;
    Move();
    if (linearize) sum_ = linearize(state_);
    return Falls(sum_ ? sum_->cost : Cost({problem_, state_, layout_}), least) ||
           FallsWithPointsSettled(least);
  }
  // Half of it, or a quarter, after the whole: false where the cost does not fall.
  bool TakeShare() {
    const std::vector<LandmarkGeometry> after = GeometryOf(problem_);
    while (share_ > kLeastShare) {
      share_ *= 0.5;
      PlaceLandmarks(Between(before_, after, share_), &problem_);
      Move();
      const double least = kSufficient * share_ * (2.0 - share_) * solution_.predicted_decrease;
      if (Falls(Cost({problem_, state_, layout_}), least) || FallsWithPointsSettled(least)) return true;
    }
    return false;
  }
  // The whole, after TakeShare, where the cost rises by no more than the accelerometer's lag adds by itself.
  // The equation that the lag follows has the jerk's mean (ImuResidual), while the cost steps as samples pass
  // knots: of a move by less than a knot's spacing it says nothing. The next step has to be half as long at
  // most, as where Newton's method converges (Deuflhard, Newton Methods for Nonlinear Problems, 2011).
  bool TakeForLag(const Linearize& linearize, const LagStep& lag_step) {
    const double move = solution_.delta[layout_.knots + layout_.lag];
    if (move == 0.0 || problem_.fix_trajectory) return false;
    for (const DriveState& drive : start_.drives) {
      if (std::abs(move) > drive.trajectory.position.knots().spacing) return false;
    }
    CalibrationState late = start_;
    late.accelerometer_lag += move;
    // Other terms do not depend on it, wherever the landmarks are meanwhile.
    const double of_lag = Cost({problem_, late, layout_}) - Cost({problem_, start_, layout_});
    share_ = 1.0;
    Move();
    SettlePoints(state_, layout_, before_, &problem_);
    if (!Falls(Cost({problem_, state_, layout_}), -of_lag)) return false;
    sum_ = linearize(state_);
    return std::abs(lag_step(state_, *sum_)) <= 0.5 * std::abs(move);
  }
  void TakeBack() {
    share_ = 0.0;
    PlaceLandmarks(std::move(before_), &problem_);
  }

  double Share() const { return share_; }  // of the step that was taken
  double CostThere() const { return cost_; }
  CalibrationState& State() { return state_; }
  std::optional<Accumulator>& Equations() { return sum_; }  // where they were made

 private:
  void Move() {
    sum_.reset();
    state_ = start_;
    layout_.Update(share_ * solution_.delta, &state_);
    if (problem_.fix_trajectory) state_.drives = start_.drives;
  }
  bool Falls(double cost, double least) {
    cost_ = cost;
    // Priors are squares: the trapezoid over their gradient is what the step adds to them.
    const Eigen::VectorXd moves = solution_.delta.segment(layout_.knots, layout_.calibration);
    const double of_priors =
        share_ * (priors_.gradient + PriorsAt(problem_, state_, layout_).gradient).dot(moves);
    return cost_ + of_priors <= start_cost_ - least;
  }
  bool FallsWithPointsSettled(double least) {
    const bool any = std::any_of(problem_.drives.begin(), problem_.drives.end(), [](const DriveTerms& drive) {
      return !drive.landmarks.observations.empty();
    });
    if (!any) return false;
    sum_.reset();
    SettlePoints(state_, layout_, before_, &problem_);
    return Falls(Cost({problem_, state_, layout_}), least);
  }

  const CalibrationState& start_;
  double start_cost_;
  const Priors& priors_;
  const NormalSolution& solution_;
  const Layout& layout_;
  JointProblem& problem_;
  std::vector<LandmarkGeometry> before_;
  double share_ = 1.0, cost_ = 0.0;
  CalibrationState state_;
  std::optional<Accumulator> sum_;
};

}  // namespace

std::vector<bool> FreeCalibration(const JointProblem& problem, const Layout& layout) {
  std::vector<bool> free_calibration(layout.calibration, true);
  for (std::size_t i = 0; i < problem.lidars.size(); ++i) {
    if (problem.lidars[i].fixed) {
      std::fill_n(free_calibration.begin() + Layout::Lidar(i), Layout::kOfSensor, false);
      if (layout.Drift(LidarId(i)) >= 0) free_calibration[layout.Drift(LidarId(i))] = false;
    }
  }
  if (problem.imu.gravity_sigma == 0.0) free_calibration[layout.gravity] = false;
  if (problem.imu.lag_sigma == 0.0) free_calibration[layout.lag] = false;
  if (problem.imu.alignment_sigma == 0.0) {
    std::fill_n(free_calibration.begin() + layout.alignment, 3, false);
  }
  if (problem.fix_trajectory) {
    std::fill(free_calibration.begin() + layout.gravity, free_calibration.end(), false);
  }
  for (std::size_t c = 0; c < problem.cameras.size(); ++c) {
    FixCamera(problem.cameras[c].fixed, layout, c, &free_calibration);
  }
  return free_calibration;
}

SolveSummary SolveJointProblem(const JointProblem& given, int iterations,
                               const CancellationToken& cancellation, CalibrationState* state,
                               bool probe_matrices) {
  Check(given.drives.size() == state->drives.size() && given.lidars.size() == state->lidars.size() &&
            given.cameras.size() == state->cameras.size(),
        "the joint problem and its state differ in their drives or sensors");
  std::vector<std::vector<std::size_t>> origins;
  JointProblem problem = WithShortCouplings(given, *state, &origins);  // the landmarks move with the solve
  probe_matrices &= !problem.estimate_imu_matrices;
  const Layout layout(*state, problem.estimate_imu_matrices || probe_matrices);
  std::vector<bool> free_calibration = FreeCalibration(problem, layout);
  const HeldMatrices held(probe_matrices, layout, &free_calibration);
  SolveSummary summary = CountedObservations(problem);
  std::vector<LandmarkCoupling> couplings;
  const StepTrial::Linearize linearize = [&](const CalibrationState& at) {
    return Linearize({problem, at, layout}, &couplings);
  };
  const auto solve = [&](const Accumulator& equations, const Priors& priors, double damping) {
    return SolveNormalEquations(equations, couplings, priors.information, priors.gradient, free_calibration,
                                damping, problem.fix_trajectory);
  };
  const StepTrial::LagStep lag_step = [&](const CalibrationState& at, const Accumulator& equations) {
    const NormalSolution next = solve(equations, PriorsAt(problem, at, layout), 0.0);
    return next.solved ? next.delta[layout.knots + layout.lag] : std::numeric_limits<double>::infinity();
  };
  Accumulator sum = linearize(*state);
  Check(std::isfinite(sum.cost), "the joint problem's cost is not a number where its solve starts");
  summary.first_cost = summary.last_cost = sum.cost;
  double damping = 0.0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    cancellation.ThrowIfCancelled();
    const Priors priors = PriorsAt(problem, *state, layout);
    const NormalSolution solution = solve(sum, priors, damping);
    ++summary.iterations;
    if (!solution.solved) {
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    summary.solved = true;
    // Damping holds the trajectory, which would look like information.
    if (damping == 0.0) {
      summary.information = held.Without(solution.information);
      summary.imu_matrices = held.Look(solution, priors);
    }
    const double step = solution.delta.segment(layout.knots, layout.poses).cwiseAbs().maxCoeff();
    const Eigen::VectorXd moves = solution.delta.segment(layout.knots, layout.calibration);
    // A prior that draws the calibration away lets the data's cost grow.
    const double expected =
        std::max(std::abs(solution.predicted_decrease), std::abs(priors.gradient.dot(moves)));
    const bool settled = damping == 0.0 && expected < kNegligibleDecrease * sum.cost;
    const bool last = settled || iteration + 1 == iterations;
    StepTrial trial(*state, sum.cost, priors, solution, layout, couplings, &problem);
    const bool accepted = trial.TakeWhole(last ? nullptr : linearize) ||
                          (damping == 0.0 && (trial.TakeShare() || trial.TakeForLag(linearize, lag_step)));
    if (!accepted) trial.TakeBack();
    if (damping == 0.0) {
      summary.refused_step = trial.Share() == 1.0
                                 ? Eigen::VectorXd()
                                 : Eigen::VectorXd((1.0 - trial.Share()) * held.RowsWithout(moves));
    }
    if (!accepted) {
      damping = std::max(1e-4, 10.0 * damping);
      if (!last) sum = linearize(*state);
      continue;
    }
    const double actual = sum.cost - trial.CostThere();
    *state = std::move(trial.State());
    summary.last_cost = trial.CostThere();
    summary.last_step = trial.Share() * step;
    if (last) break;
    damping = DampingAfter(damping, actual / std::max(1e-9, solution.predicted_decrease));
    sum = trial.Equations() ? std::move(*trial.Equations()) : linearize(*state);
  }
  summary.landmarks = WithPointsWhole(given, std::move(problem), origins);
  return summary;
}

CalibrationEquations EquationsOfCalibration(const JointProblem& given, const CalibrationState& state) {
  std::vector<std::vector<std::size_t>> origins;
  const JointProblem problem = WithShortCouplings(given, state, &origins);
  const Layout layout(state, problem.estimate_imu_matrices);
  std::vector<LandmarkCoupling> couplings;
  const Accumulator sum = Linearize({problem, state, layout}, &couplings);
  const Priors priors = PriorsAt(problem, state, layout);
  const NormalSolution solution =
      SolveNormalEquations(sum, couplings, priors.information, priors.gradient,
                           FreeCalibration(problem, layout), 0.0, problem.fix_trajectory);
  if (!solution.solved) return {};
  return {solution.information, solution.gradient, priors.gradient};
}

void PlaceLandmarks(std::vector<LandmarkGeometry> landmarks, JointProblem* problem) {
  for (std::size_t d = 0; d < landmarks.size(); ++d) {
    problem->drives[d].planes.planes = std::move(landmarks[d].planes);
    problem->drives[d].landmarks.points = std::move(landmarks[d].points);
  }
}

}  // namespace mlic
