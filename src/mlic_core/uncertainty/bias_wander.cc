#include "mlic_core/uncertainty/bias_wander.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "mlic_core/common/sizes_of_draws.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/solver/submatrix.h"
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

// From a tenth of what the best gyroscopes and accelerometers wander by to beyond the worst: consumer IMUs
// warm up by 5 mrad/s and 30 mm/s^2 within a minute.
constexpr BiasSteps kFinest{1e-6, 1e-5}, kCoarsest{5e-3, 0.05};  // rad/s, m/s^2; from: guard
// What IMUs have, from the instability of tactical ones (2 deg/h, 10 ug) to consumer ones that warm up.
constexpr BiasSteps kLeastUsual{1e-5, 1e-4}, kMostUsual{1e-3, 1e-2};  // from: standard, data sheets
constexpr double kFactor = 1.2;  // of sigmas from one to the next; from: guard, the likelihood is flat there

// The steps between a drive's knots, six of the first step, six of the next.
class StepsOfCourse {
 public:
  StepsOfCourse(const JointProblem& problem, const CalibrationState& state,
                const CalibrationEquations& equations, std::size_t drive, double scale) {
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
    std::vector<int> steps, constant, others;
    for (int i = 0; i < layout.calibration; ++i) {
      const auto at = static_cast<std::size_t>(i);
      (is_step[at] ? steps : constant).push_back(i);
      if (!is_step[at] && moves[at]) others.push_back(i);
    }
    const Eigen::MatrixXd information = by_steps.transpose() * equations.information * by_steps;
    coupling_ = Submatrix(information, constant, steps);
    marginal_ = MarginalOf(steps, others, information, by_steps.transpose() * equations.gradient,
                           by_steps.transpose() * prior * by_steps,
                           by_steps.transpose() * equations.prior_gradient, CalibrationLimits(state, layout));
    marginal_.information /= scale;
    marginal_.gradient /= scale;
  }

  // Twice the logarithm of the likelihood of steps with these sigmas against none.
  double Gain(const BiasSteps& sigma) const {
    const Eigen::VectorXd sigmas = SigmasOf(sigma);
    const Eigen::LLT<Eigen::MatrixXd> factor(Excess(sigmas));
    if (factor.info() != Eigen::Success) return 0.0;
    const Eigen::VectorXd whitened = factor.matrixL().solve(sigmas.cwiseProduct(marginal_.gradient));
    return whitened.squaredNorm() - 2.0 * Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  }

  // Of such steps, given the data: the mean of their products.
  Eigen::MatrixXd MeanSquare(const BiasSteps& sigma) const {
    const Eigen::VectorXd sigmas = SigmasOf(sigma);
    const Eigen::MatrixXd covariance =
        sigmas.asDiagonal() * SolveSymmetric(Excess(sigmas), Eigen::MatrixXd(sigmas.asDiagonal()));
    const Eigen::VectorXd mean = covariance * marginal_.gradient;
    return covariance + mean * mean.transpose();
  }

  // Information that the parameters have in common with the steps, biases being constant (parameters x
  // steps).
  const Eigen::MatrixXd& Coupling() const { return coupling_; }

 private:
  Eigen::VectorXd SigmasOf(const BiasSteps& sigma) const {
    Eigen::VectorXd sigmas(marginal_.gradient.size());
    for (Eigen::Index i = 0; i < sigmas.size(); ++i) {
      sigmas[i] = i % Layout::kOfBias < 3 ? sigma.gyroscope : sigma.accelerometer;
    }
    return sigmas;
  }
  // Of their precision over what it is without data, in these sigmas.
  Eigen::MatrixXd Excess(const Eigen::VectorXd& sigmas) const {
    Eigen::MatrixXd excess = sigmas.asDiagonal() * marginal_.information * sigmas.asDiagonal();
    excess = Eigen::MatrixXd(0.5 * (excess + excess.transpose()));
    excess.diagonal().array() += 1.0;
    return excess;
  }

  Eigen::MatrixXd coupling_;
  MarginalEquations marginal_;
};

// Of sigmas from the finest on, the one with the largest gain.
template <typename OfSigma>
double BestSigma(double finest, double coarsest, const OfSigma& gain) {
  double best = finest, most = gain(finest);
  for (const double sigma : SizesBetween(finest * kFactor, coarsest, kFactor)) {
    const double found = gain(sigma);
    if (found > most) {
      most = found;
      best = sigma;
    }
  }
  return best;
}

std::vector<BiasSteps> UsualSizes() {
  std::vector<BiasSteps> sizes;
  for (const double g : SizesBetween(kLeastUsual.gyroscope, kMostUsual.gyroscope, kFactor)) {
    for (const double a : SizesBetween(kLeastUsual.accelerometer, kMostUsual.accelerometer, kFactor))
      sizes.push_back({g, a});
  }
  return sizes;
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
  const StepsOfCourse steps(problem, state, equations, drive, scale);
  constexpr int kSweeps = 3;  // from: guard, the two hardly depend on each other
  evidence.steps = kFinest;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    evidence.steps.gyroscope = BestSigma(kFinest.gyroscope, kCoarsest.gyroscope, [&](double sigma) {
      return steps.Gain({sigma, evidence.steps.accelerometer});
    });
    evidence.steps.accelerometer =
        BestSigma(kFinest.accelerometer, kCoarsest.accelerometer, [&](double sigma) {
          return steps.Gain({evidence.steps.gyroscope, sigma});
        });
  }
  // What wanders more is no bias: an INS that filters its readings, or a trajectory that is led astray.
  constexpr double kNear = 0.8;  // of the coarsest; from: guard, the last step of the search
  const bool gyroscope = evidence.steps.gyroscope < kNear * kCoarsest.gyroscope;
  const bool accelerometer = evidence.steps.accelerometer < kNear * kCoarsest.accelerometer;
  evidence.gain = steps.Gain(
      {gyroscope ? evidence.steps.gyroscope : 0.0, accelerometer ? evidence.steps.accelerometer : 0.0});
  if (!evidence.IsShown()) return evidence;
  const std::vector<BiasSteps> sizes = UsualSizes();
  const std::vector<double> shares = LikelihoodShares(steps, sizes);
  BiasSteps squares;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    squares.gyroscope += shares[i] * sizes[i].gyroscope * sizes[i].gyroscope;
    squares.accelerometer += shares[i] * sizes[i].accelerometer * sizes[i].accelerometer;
  }
  evidence.steps.gyroscope =
      gyroscope ? std::max(evidence.steps.gyroscope, std::sqrt(squares.gyroscope)) : kFinest.gyroscope;
  evidence.steps.accelerometer =
      accelerometer ? std::max(evidence.steps.accelerometer, std::sqrt(squares.accelerometer))
                    : kFinest.accelerometer;
  return evidence;
}

Eigen::MatrixXd ScatterOfWander(const JointProblem& problem, const CalibrationState& state,
                                const CalibrationEquations& equations, std::size_t drive, double scale) {
  if (equations.information.size() == 0) {
    CalibrationState constant = state;
    constant.drives[drive].bias = {};
    const int size = Layout(constant, problem.estimate_imu_matrices).calibration;
    return Eigen::MatrixXd::Zero(size, size);
  }
  const StepsOfCourse steps(problem, state, equations, drive, scale);
  const Eigen::MatrixXd& coupling = steps.Coupling();
  const Eigen::MatrixXd square = MeanSquareOfSizes(steps, UsualSizes());
  return coupling * square * coupling.transpose() / scale;
}

}  // namespace mlic
