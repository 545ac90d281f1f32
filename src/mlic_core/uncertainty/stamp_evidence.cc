#include "mlic_core/uncertainty/stamp_evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "mlic_core/common/sizes_of_draws.h"
#include "mlic_core/factors/reprojection.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/joint_solver.h"
#include "mlic_core/problem/landmark_terms.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/problem/linearizer.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/problem/time_windows.h"
#include "mlic_core/solver/normal_equations.h"
#include "mlic_core/uncertainty/widened_equations.h"

namespace mlic {
namespace {

constexpr std::size_t kMostImages = 100;  // looked at together; from: guard, time
// Twice a logarithm of likelihoods. from: derivation, what two parameters gain by chance once in 370 times
constexpr double kShown = 11.8;
constexpr double kStartVariance =
    1e-4;  // s^2, of a walk's first shift; from: guard, no course starts 10 ms off

// What a shift of one observation's image does. image: its place behind the calibration's parameters.
void AddObservation(const LinearizationPoint& at, const ReprojectionRows& rows, Eigen::Index image,
                    LandmarkCoupling* coupling, Accumulator* sum) {
  const Eigen::RowVector2d by_time = rows.jacobian.row(Reprojection::kTimeOffset);
  sum->corner(image, image) += by_time.squaredNorm();
  sum->gradient_calibration[image] += by_time.dot(rows.residual);
  for (std::size_t i = 0; i < rows.columns.size(); ++i) {
    const double shared = by_time.dot(rows.jacobian.row(static_cast<Eigen::Index>(i)));
    const int column = rows.columns[i];
    if (column < at.layout.knots) {
      sum->border(image, sum->Local(column)) += shared;
    } else {
      sum->corner(image, column - at.layout.knots) += shared;
      sum->corner(column - at.layout.knots, image) += shared;
    }
  }
  coupling->calibration.row(image) += by_time * rows.by_point.transpose();
}

// couplings: of all drives' planes and points.
void AddImages(const LinearizationPoint& at, const ImageStamps& camera, std::size_t first, std::size_t count,
               std::vector<LandmarkCoupling>* couplings, Accumulator* sum) {
  LandmarkCoupling* of_points = couplings->data();
  for (std::size_t d = 0; d <= camera.drive; ++d) {
    of_points += at.problem.drives[d].planes.planes.size();
    if (d < camera.drive) of_points += at.problem.drives[d].landmarks.points.size();
  }
  for (std::size_t p = 0; p < at.problem.drives[camera.drive].landmarks.points.size(); ++p) {
    for (const ReprojectionRows& rows : RowsOfLandmark(at, camera.drive, p)) {
      if (rows.observation->camera != static_cast<int>(camera.camera)) continue;
      const std::size_t image = NearestImage(camera.times, rows.observation->time);
      if (image < first || image >= first + count) continue;
      AddObservation(at, rows, at.layout.calibration + static_cast<Eigen::Index>(image - first),
                     of_points + p, sum);
    }
  }
}

// The problem about the state, with what is the same for all images.
struct Ground {
  Ground(const JointProblem& given, const CalibrationState& state)
      : problem(WithShortCouplings(given, state, &origins)),
        layout(state, problem.estimate_imu_matrices),
        at{problem, state, layout},
        sum(Linearize(at, &couplings)) {
    CalibrationPrior(problem, state, layout, &prior, &prior_gradient);
    AddHeldTranslations(problem, state, &prior, &prior_gradient);
    free = FreeCalibration(problem, layout);
  }

  std::vector<std::vector<std::size_t>> origins;
  JointProblem problem;
  Layout layout;
  LinearizationPoint at;
  std::vector<LandmarkCoupling> couplings;
  Accumulator sum;
  Eigen::MatrixXd prior;
  Eigen::VectorXd prior_gradient;
  std::vector<bool> free;
};

// False where the equations have no solution.
bool EvidenceOf(const Ground& ground, const ImageStamps& camera, std::size_t first, std::size_t images,
                StampEvidence* evidence) {
  const Eigen::Index calibration = ground.layout.calibration;
  const auto count = static_cast<Eigen::Index>(images);
  std::vector<LandmarkCoupling> couplings = ground.couplings;
  Accumulator sum = ground.sum;
  Widen(count, &sum, &couplings);
  AddImages(ground.at, camera, first, images, &couplings, &sum);
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(calibration + count, calibration + count);
  prior.topLeftCorner(calibration, calibration) = ground.prior;
  Eigen::VectorXd prior_gradient = Eigen::VectorXd::Zero(calibration + count);
  prior_gradient.head(calibration) = ground.prior_gradient;
  std::vector<bool> free = ground.free;
  free.insert(free.end(), images, false);
  const NormalSolution solution =
      SolveNormalEquations(sum, couplings, prior, prior_gradient, free, 0.0, false);
  if (!solution.solved) return false;
  Eigen::MatrixXd own = solution.information.topLeftCorner(calibration, calibration) + ground.prior;
  Eigen::MatrixXd following(calibration, count + 1);
  following.leftCols(count) = solution.information.topRightCorner(calibration, count);
  following.rightCols<1>() = solution.gradient.head(calibration) + ground.prior_gradient;
  HoldFixed(ground.free, &own);
  for (Eigen::Index i = 0; i < calibration; ++i) {
    if (!ground.free[static_cast<std::size_t>(i)]) following.row(i).setZero();
  }
  const Eigen::MatrixXd steps = SolveSymmetric(own, following);
  evidence->first = first;
  evidence->coupling = following.leftCols(count);
  evidence->information = solution.information.bottomRightCorner(count, count) -
                          evidence->coupling.transpose() * steps.leftCols(count);
  evidence->gradient = evidence->coupling.transpose() * steps.rightCols<1>() - solution.gradient.tail(count);
  return true;
}

// Square root of the covariance of a course before it is seen.
Eigen::MatrixXd RootOfPrior(const double* stamps, Eigen::Index count, double walk, double jitter) {
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      covariance(i, j) = kStartVariance + walk * (stamps[std::min(i, j)] - stamps[0]);
    }
    covariance(i, i) += jitter;
  }
  // Without walk or jitter it is singular. from: guard, a nanosecond
  covariance.diagonal().array() += 1e-18;
  return covariance.llt().matrixL();
}

// A course given the evidence.
struct Posterior {
  Eigen::VectorXd mean;     // s
  Eigen::MatrixXd root;     // of the covariance
  double likelihood = 0.0;  // twice its logarithm, but for a constant
};

// gradient: by all of the shift, also what the stamps were shifted by already.
Posterior PosteriorOf(const StampEvidence& evidence, const Eigen::VectorXd& gradient,
                      const Eigen::MatrixXd& prior_root) {
  const Eigen::Index count = gradient.size();
  const Eigen::LLT<Eigen::MatrixXd> seen(Eigen::MatrixXd::Identity(count, count) +
                                         prior_root.transpose() * evidence.information * prior_root);
  const Eigen::VectorXd whitened = seen.matrixL().solve(prior_root.transpose() * gradient);
  Posterior posterior;
  posterior.likelihood = whitened.squaredNorm() - 2.0 * seen.matrixLLT().diagonal().array().log().sum();
  posterior.root = seen.matrixL().solve(prior_root.transpose()).transpose();
  posterior.mean = posterior.root * whitened;
  return posterior;
}

// Takes what is known of mean and slope off the root of a course's covariance. (Longer courses, in stretches,
// show both beside the other stretches.)
void HoldMeanAndSlope(const std::vector<double>& times, Eigen::MatrixXd* root) {
  Eigen::MatrixXd held(root->rows(), 2);
  held.col(0).setOnes();
  for (Eigen::Index k = 0; k < held.rows(); ++k) held(k, 1) = times[static_cast<std::size_t>(k)] - times[0];
  const Eigen::MatrixXd known = root->transpose() * held;
  *root -= *root * known * SolveSymmetric(known.transpose() * known, known.transpose().eval());
}

void RemoveMeanAndSlope(StampCourse* course) {
  const auto count = static_cast<double>(course->times.size());
  double mean_time = 0.0, mean = 0.0;
  for (std::size_t k = 0; k < course->times.size(); ++k) {
    mean_time += course->times[k] / count;
    mean += course->shifts[k] / count;
  }
  double moment = 0.0, product = 0.0;
  for (std::size_t k = 0; k < course->times.size(); ++k) {
    const double from_mean = course->times[k] - mean_time;
    moment += from_mean * from_mean;
    product += from_mean * course->shifts[k];
  }
  for (std::size_t k = 0; k < course->times.size(); ++k) {
    course->shifts[k] -= mean + product / moment * (course->times[k] - mean_time);
  }
}

}  // namespace

std::size_t NearestImage(const std::vector<double>& times, double time) {
  const auto next = std::lower_bound(times.begin(), times.end(), time);
  const bool before =
      next != times.begin() && (next == times.end() || time - *std::prev(next) < *next - time);
  return static_cast<std::size_t>(std::distance(times.begin(), before ? std::prev(next) : next));
}

std::vector<std::vector<StampEvidence>> EvidenceOfStamps(const JointProblem& given,
                                                         const CalibrationState& state,
                                                         const std::vector<ImageStamps>& cameras) {
  if (given.fix_trajectory || cameras.empty()) return {};
  const Ground ground(given, state);
  std::vector<std::vector<StampEvidence>> all;
  for (const ImageStamps& camera : cameras) {
    const std::size_t images = camera.times.size();
    const std::size_t stretches = (images + kMostImages - 1) / kMostImages;
    std::vector<StampEvidence>& own = all.emplace_back();
    for (std::size_t k = 0; k < stretches; ++k) {
      const std::size_t first = images * k / stretches, end = images * (k + 1) / stretches;
      if (!EvidenceOf(ground, camera, first, end - first, &own.emplace_back())) return {};
    }
  }
  return all;
}

StampCourse LikeliestCourse(const std::vector<double>& stamps, const StampCourse& course,
                            const std::vector<StampEvidence>& evidence) {
  std::vector<Eigen::VectorXd> gradients;
  for (const StampEvidence& part : evidence) {
    Eigen::VectorXd shifted(part.gradient.size());
    for (Eigen::Index k = 0; k < shifted.size(); ++k) {
      shifted[k] = course.At(stamps[part.first + static_cast<std::size_t>(k)]);
    }
    gradients.emplace_back(part.gradient + part.information * shifted);
  }
  const auto likelihood = [&](double walk, double jitter) {
    double sum = 0.0;
    for (std::size_t k = 0; k < evidence.size(); ++k) {
      const Eigen::Index count = gradients[k].size();
      sum +=
          PosteriorOf(evidence[k], gradients[k], RootOfPrior(&stamps[evidence[k].first], count, walk, jitter))
              .likelihood;
    }
    return sum;
  };
  // s/sqrt(s) and s; from: guard, from what no drive shows to what no camera has
  const std::vector<double> sizes = SizesFromNone(1e-5, 2e-2, 2.0);
  double best = likelihood(0.0, 0.0) + kShown;
  StampCourse found;
  for (const double walk : sizes) {
    for (const double jitter : sizes) {
      const double own = likelihood(walk * walk, jitter * jitter);
      if (own > best) best = own, found.walk = walk * walk, found.jitter = jitter * jitter;
    }
  }
  if (found.walk == 0.0 && found.jitter == 0.0) return {};
  found.times = stamps;
  for (std::size_t k = 0; k < evidence.size(); ++k) {
    const Eigen::MatrixXd root =
        RootOfPrior(&stamps[evidence[k].first], gradients[k].size(), found.walk, found.jitter);
    const Eigen::VectorXd mean = PosteriorOf(evidence[k], gradients[k], root).mean;
    found.shifts.insert(found.shifts.end(), mean.begin(), mean.end());
  }
  RemoveMeanAndSlope(&found);
  return found;
}

Eigen::MatrixXd ScatterOfCourse(const StampCourse& course, const std::vector<StampEvidence>& evidence) {
  Eigen::MatrixXd scatter;
  for (const StampEvidence& part : evidence) {
    const Eigen::MatrixXd root =
        RootOfPrior(&course.times[part.first], part.gradient.size(), course.walk, course.jitter);
    Eigen::MatrixXd errors = PosteriorOf(part, part.gradient, root).root;
    if (evidence.size() == 1) HoldMeanAndSlope(course.times, &errors);
    const Eigen::MatrixXd moves = part.coupling * errors;
    if (scatter.size() == 0) scatter = Eigen::MatrixXd::Zero(moves.rows(), moves.rows());
    scatter += moves * moves.transpose();
  }
  return scatter;
}

}  // namespace mlic
