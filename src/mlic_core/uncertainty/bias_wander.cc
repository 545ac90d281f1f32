#include "mlic_core/uncertainty/bias_wander.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"
#include "mlic_core/uncertainty/marginal_equations.h"

namespace mlic {
namespace {

// Of the course, s. A bias that settles with a time constant of a minute is within half a hundredth of what
// it wanders by of lines so long (spacing^2 / 8 times its curvature); what the shortest have of noise, the
// prior keeps small. from: derivation
constexpr double kLongest = 10.0, kShortest = 2.5;
constexpr double kFewest = 4.0;     // intervals; from: guard, fewer do not tell wandering from a mean
constexpr double kMost = 20.0;      // intervals; from: guard, unknowns
constexpr double kRounding = 1e-9;  // of an interval; from: guard

// Of the steps between a drive's knots, all else followed: six of the first step, six of the next.
MarginalEquations EquationsOfSteps(const JointProblem& problem, const CalibrationState& state,
                                   const CalibrationEquations& equations, std::size_t drive) {
  const Layout layout(state, problem.estimate_imu_matrices);
  Eigen::MatrixXd prior;
  Eigen::VectorXd prior_gradient;
  CalibrationPrior(problem, state, layout, &prior, &prior_gradient);
  // A step moves its knot and all behind it.
  const int knots = static_cast<int>(state.drives[drive].bias.knots.size());
  Eigen::MatrixXd by_steps = Eigen::MatrixXd::Identity(layout.calibration, layout.calibration);
  std::vector<bool> is_step(static_cast<std::size_t>(layout.calibration), false);
  for (int knot = 0; knot < knots; ++knot) {
    for (int a = 0; a < Layout::kOfBias; ++a) {
      const int of_knot = layout.Bias(drive, knot) + a;
      is_step[static_cast<std::size_t>(of_knot)] = knot > 0;
      for (int earlier = 0; earlier < knot; ++earlier)
        by_steps(of_knot, layout.Bias(drive, earlier) + a) = 1.0;
    }
  }
  const std::vector<bool> moves = FreeCalibration(problem, layout);
  std::vector<int> steps, others;
  for (int i = 0; i < layout.calibration; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (moves[at]) (is_step[at] ? steps : others).push_back(i);
  }
  return MarginalOf(steps, others, by_steps.transpose() * equations.information * by_steps,
                    by_steps.transpose() * equations.gradient, by_steps.transpose() * prior * by_steps,
                    by_steps.transpose() * equations.prior_gradient, CalibrationLimits(state, layout));
}

// Twice the logarithm of the likelihood of steps with these sigmas against none.
double Gain(const MarginalEquations& equations, const BiasSteps& sigma) {
  const Eigen::Index count = equations.gradient.size();
  Eigen::VectorXd sigmas(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    sigmas[i] = i % Layout::kOfBias < 3 ? sigma.gyroscope : sigma.accelerometer;
  }
  Eigen::MatrixXd excess = sigmas.asDiagonal() * equations.information * sigmas.asDiagonal();
  excess = Eigen::MatrixXd(0.5 * (excess + excess.transpose()));
  excess.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> factor(excess);
  if (factor.info() != Eigen::Success) return 0.0;
  const Eigen::VectorXd whitened = factor.matrixL().solve(sigmas.cwiseProduct(equations.gradient));
  return whitened.squaredNorm() - 2.0 * Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
}

// Of sigmas from the finest on, the one with the largest gain.
template <typename OfSigma>
double BestSigma(double finest, double coarsest, const OfSigma& gain) {
  constexpr double kFactor = 1.2;  // from: guard, the likelihood is flat there
  double best = finest, most = gain(finest);
  for (double sigma = finest * kFactor; sigma < coarsest; sigma *= kFactor) {
    const double found = gain(sigma);
    if (found > most) {
      most = found;
      best = sigma;
    }
  }
  return best;
}

}  // namespace

std::optional<BiasCourse> CourseOf(const BiasCourse& constant, double start, double end) {
  const double duration = end - start;
  if (duration < kFewest * kShortest) return std::nullopt;
  const double longest = std::clamp(duration / kFewest, kShortest, std::max(kLongest, duration / kMost));
  const double intervals = std::ceil(duration / longest - kRounding);
  BiasCourse course = constant;
  course.start = start;
  course.spacing = duration / intervals;
  course.knots.assign(static_cast<std::size_t>(intervals) + 1, constant.Mean());
  return course;
}

BiasEvidence EvidenceOfWander(const JointProblem& problem, const CalibrationState& state,
                              const CalibrationEquations& equations, std::size_t drive, double scale) {
  BiasEvidence evidence;
  if (equations.information.size() == 0) return evidence;
  MarginalEquations steps = EquationsOfSteps(problem, state, equations, drive);
  steps.information /= scale;
  steps.gradient /= scale;
  // From a tenth of what the best gyroscopes and accelerometers wander by to beyond the worst: consumer IMUs
  // warm up by 5 mrad/s and 30 mm/s^2 within a minute.
  constexpr double kFinestGyroscope = 1e-6, kCoarsestGyroscope = 5e-3;          // rad/s; from: guard
  constexpr double kFinestAccelerometer = 1e-5, kCoarsestAccelerometer = 0.05;  // m/s^2; from: guard
  constexpr int kSweeps = 3;  // from: guard, the two hardly depend on each other
  evidence.steps = {kFinestGyroscope, kFinestAccelerometer};
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    evidence.steps.gyroscope = BestSigma(kFinestGyroscope, kCoarsestGyroscope, [&](double sigma) {
      return Gain(steps, {sigma, evidence.steps.accelerometer});
    });
    evidence.steps.accelerometer = BestSigma(kFinestAccelerometer, kCoarsestAccelerometer, [&](double sigma) {
      return Gain(steps, {evidence.steps.gyroscope, sigma});
    });
  }
  // What wanders more is no bias: an INS that filters its readings, or a trajectory that is led astray.
  constexpr double kNear = 0.8;  // of the coarsest; from: guard, the last step of the search
  const bool gyroscope = evidence.steps.gyroscope < kNear * kCoarsestGyroscope;
  const bool accelerometer = evidence.steps.accelerometer < kNear * kCoarsestAccelerometer;
  evidence.gain = Gain(steps, {gyroscope ? evidence.steps.gyroscope : 0.0,
                               accelerometer ? evidence.steps.accelerometer : 0.0});
  if (!gyroscope) evidence.steps.gyroscope = kFinestGyroscope;
  if (!accelerometer) evidence.steps.accelerometer = kFinestAccelerometer;
  return evidence;
}

}  // namespace mlic
