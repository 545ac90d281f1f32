#include "mlic_core/crossmodal/structure_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// As StructureMatcher's kSigmaFactor: structure comes in blurred edges, not in independent pixels. Here all
// pixels of a scan share the faults of its rendering too.
constexpr double kScanSigmaFactor = 10.0;

// A small rotation (rad, left) and translation of T_camera_body.
RigidTransform Moved(const RigidTransform& T_camera_body, const Vector6d& move) {
  return {(ExpQuaternion(move.head<3>()) * T_camera_body.rotation).normalized(),
          T_camera_body.translation + move.tail<3>()};
}

Vector6d MoveBetween(const RigidTransform& from, const RigidTransform& to) {
  Vector6d move;
  move.head<3>() = Log(to.rotation * from.rotation.conjugate());
  move.tail<3>() = to.translation - from.translation;
  return move;
}

// Moves that shift the picture by about a pixel each.
Vector6d PixelMoves(const StructureScore& score) {
  const double focal = score.intrinsics().parameters[0];
  Vector6d moves;
  moves << 1.0 / focal, 1.0 / focal, 4.0 / score.intrinsics().width,
      Eigen::Vector3d::Constant(score.typical_depth() / focal);
  return moves;
}

// What climbs.
enum class Free { kRotation, kPose };

int CountOf(Free free) { return free == Free::kRotation ? 3 : 6; }

// The log-posterior of a pose about the start, up to a constant, for steps in units of PixelMoves.
class Posterior {
 public:
  Posterior(const StructureScore& score, const RigidTransform& start, const Matrix6d& prior)
      : score_(score), start_(start), prior_information_(prior.inverse()), units_(PixelMoves(score)) {}

  // What one pixel is worth, judged from the mismatch that is left.
  void WeighBy(double correlation) {
    worth_ = 1.0 / (kScanSigmaFactor * kScanSigmaFactor * std::max(0.1, 1.0 - correlation));
  }
  double At(const RigidTransform& pose) const { return Of(pose, score_.At(pose)); }
  // value: what any rendering scores at the pose.
  double Of(const RigidTransform& pose, const StructureScore::Value& value) const {
    const Vector6d move = MoveBetween(start_, pose);
    return worth_ * value.weight * value.correlation - 0.5 * move.dot(prior_information_ * move);
  }
  RigidTransform Step(const RigidTransform& pose, const Vector6d& step) const {
    return Moved(pose, units_.cwiseProduct(step));
  }

  // By central differences of one unit, all evaluations in parallel; zero of what is not free.
  void Differentiate(const RigidTransform& pose, Free free, Vector6d* gradient, Matrix6d* hessian) const {
    const int count = CountOf(free);
    std::vector<Vector6d> steps{Vector6d::Zero()};
    for (int i = 0; i < count; ++i) {
      steps.push_back(Vector6d::Unit(i));
      steps.push_back(-Vector6d::Unit(i));
      for (int j = 0; j < i; ++j) {
        steps.push_back(Vector6d::Unit(i) + Vector6d::Unit(j));
        steps.push_back(-Vector6d::Unit(i) - Vector6d::Unit(j));
      }
    }
    std::vector<double> values(steps.size());
    ParallelFor(steps.size(), [&](std::size_t k) { values[k] = At(Step(pose, steps[k])); });
    Vector6d up = Vector6d::Zero(), down = Vector6d::Zero();
    std::size_t k = 1;
    Matrix6d sums;
    for (int i = 0; i < count; ++i) {
      up[i] = values[k++];
      down[i] = values[k++];
      for (int j = 0; j < i; ++j, k += 2) sums(i, j) = values[k] + values[k + 1];
    }
    *gradient = 0.5 * (up - down);
    hessian->setZero();
    for (int i = 0; i < count; ++i) {
      (*hessian)(i, i) = up[i] + down[i] - 2.0 * values[0];
      for (int j = 0; j < i; ++j) {
        const double mixed = 0.5 * (sums(i, j) - up[i] - down[i] - up[j] - down[j] + 2.0 * values[0]);
        (*hessian)(i, j) = (*hessian)(j, i) = mixed;
      }
    }
  }

  // Newton steps of the rotation or of both, each shortened until it climbs; directions that are not concave
  // go along the gradient.
  RigidTransform Climb(RigidTransform pose, Free free) const {
    const int count = CountOf(free);
    constexpr double kLeastCurvature = 1e-3, kLongest = 4.0, kSettled = 0.02;  // from: guard
    for (int i = 0; i < 12; ++i) {
      Vector6d gradient;
      Matrix6d hessian;
      Differentiate(pose, free, &gradient, &hessian);
      const SymmetricEigen<Eigen::Dynamic> eigen(-hessian.topLeftCorner(count, count));
      const double largest = std::max(1e-12, eigen.eigenvalues().cwiseAbs().maxCoeff());
      const Eigen::VectorXd curvature = eigen.eigenvalues().cwiseAbs().cwiseMax(kLeastCurvature * largest);
      Vector6d step = Vector6d::Zero();
      step.head(count) = eigen.eigenvectors() *
                         (eigen.eigenvectors().transpose() * gradient.head(count)).cwiseQuotient(curvature);
      step *= std::min(1.0, kLongest / std::max(1e-12, step.norm()));
      const double here = At(pose);
      while (step.norm() > kSettled && At(Step(pose, step)) <= here) step *= 0.5;
      if (step.norm() <= kSettled) break;
      pose = Step(pose, step);
    }
    return pose;
  }

  // Of the data alone, where it is concave.
  Matrix6d Information(const RigidTransform& pose) const {
    Vector6d gradient;
    Matrix6d hessian;
    Differentiate(pose, Free::kPose, &gradient, &hessian);
    const Vector6d per_unit = units_.cwiseInverse();
    const Matrix6d data = per_unit.asDiagonal() * (-hessian) * per_unit.asDiagonal();
    const SymmetricEigen<Eigen::Dynamic> eigen(units_.asDiagonal() * (data - prior_information_) *
                                               units_.asDiagonal());
    const Matrix6d concave = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                             eigen.eigenvectors().transpose();
    return per_unit.asDiagonal() * concave * per_unit.asDiagonal();
  }

  const Matrix6d& prior_information() const { return prior_information_; }

 private:
  const StructureScore& score_;
  const RigidTransform start_;
  const Matrix6d prior_information_;
  const Vector6d units_;
  double worth_ = 1.0;
};

// The best rotations of a grid over 2.5 sigmas about each of the camera's axes: those that no neighbour
// exceeds, the best `most` of them, best first.
std::vector<RigidTransform> BestOfGrid(const StructureScore& score, const Posterior& posterior,
                                       const RigidTransform& start, const Matrix6d& prior, std::size_t most) {
  // from: derivation, 1 % of normal errors lie beyond; peaks are climbed.
  constexpr double kReach = 2.5, kStep = 4.0;  // sigmas; px
  constexpr int kMost = 12;                    // steps to either side; from: guard, time
  Eigen::Vector3i reach;
  const Vector6d units = PixelMoves(score);
  for (int k = 0; k < 3; ++k) {
    const double pixels = kReach * std::sqrt(prior(k, k)) / units[k];
    reach[k] = std::min(kMost, static_cast<int>(std::ceil(pixels / kStep)));
  }
  const Eigen::Vector3i size = 2 * reach + Eigen::Vector3i::Ones();
  const auto at = [&](int i) {
    return Eigen::Vector3i(i % size[0], i / size[0] % size[1], i / size[0] / size[1]);
  };
  const auto pose_at = [&](int i) {
    Vector6d step = Vector6d::Zero();
    step.head<3>() = kStep * (at(i) - reach).cast<double>();
    return posterior.Step(start, step);
  };
  std::vector<double> values(static_cast<std::size_t>(size.prod()));
  ParallelFor(values.size(), [&](std::size_t i) { values[i] = posterior.At(pose_at(static_cast<int>(i))); });
  std::vector<std::pair<double, int>> peaks;
  for (int i = 0; i < size.prod(); ++i) {
    bool peak = true;
    for (int k = 0, stride = 1; k < 3; stride *= size[k], ++k) {
      for (const int side : {-1, 1}) {
        const int place = at(i)[k] + side;
        if (place < 0 || place >= size[k]) continue;
        peak = peak &&
               values[static_cast<std::size_t>(i)] >= values[static_cast<std::size_t>(i + side * stride)];
      }
    }
    if (peak) peaks.emplace_back(-values[static_cast<std::size_t>(i)], i);
  }
  std::sort(peaks.begin(), peaks.end());
  std::vector<RigidTransform> best;
  for (std::size_t i = 0; i < std::min(most, peaks.size()); ++i) best.push_back(pose_at(peaks[i].second));
  return best;
}

double HighestElsewhere(const StructureScore& score, const RigidTransform& T_camera_body) {
  double highest = -1.0;
  for (int k = 0; k < 8; ++k) {
    const double angle = k * M_PI / 4.0;
    const Eigen::Vector3d turn(std::cos(angle), std::sin(angle), 0.0);
    Vector6d move = Vector6d::Zero();
    move.head<3>() = kAwayDegrees * M_PI / 180.0 * turn;
    highest = std::max(highest, score.At(Moved(T_camera_body, move)).correlation);
  }
  return highest;
}

// A pose and the rendering there.
struct RenderedPose {
  RigidTransform T_camera_body;
  StructureScore score;
  StructureScore::Value value;  // there
};

// What AlignByStructure is about.
struct StillProblem {
  const std::vector<StillPair>& pairs;
  const RigidTransform start;  // T_camera_body
  const Matrix6d& prior;
  StructureOptions structure;
  ShrunkPhotos photos;  // at the size at hand

  RenderedPose Render(const RigidTransform& T_camera_body) const {
    StructureScore score(pairs, photos, structure, T_camera_body.Inverse());
    const StructureScore::Value value = score.At(T_camera_body);
    return {T_camera_body, std::move(score), value};
  }
  Posterior PosteriorAt(const RenderedPose& at) const {
    Posterior posterior(at.score, start, prior);
    posterior.WeighBy(at.value.correlation);
    return posterior;
  }
};

// Climbs and renders again, `rounds` times, as long as poses are better by their own renderings: that of
// another pose alone would let the camera go where the map's visible side does not show what it hides.
RenderedPose ClimbByRenderings(const StillProblem& problem, int rounds, Free free,
                               const RigidTransform& from) {
  constexpr int kHalvings = 3;  // from: guard, time
  RenderedPose here = problem.Render(from);
  for (int round = 0; round < rounds; ++round) {
    const Posterior posterior = problem.PosteriorAt(here);
    const Vector6d move = MoveBetween(here.T_camera_body, posterior.Climb(here.T_camera_body, free));
    std::optional<RenderedPose> better;
    for (int k = 0; k < kHalvings && !better; ++k) {
      RenderedPose next = problem.Render(Moved(here.T_camera_body, std::pow(0.5, k) * move));
      if (posterior.Of(next.T_camera_body, next.value) > posterior.Of(here.T_camera_body, here.value)) {
        better = std::move(next);
      }
    }
    if (!better) break;
    here = *std::move(better);
  }
  return here;
}

// The best `most` poses that are turned by at least `apart` (rad) from better ones.
std::vector<RigidTransform> BestApart(const StillProblem& problem, const std::vector<RenderedPose>& poses,
                                      std::size_t most, double apart) {
  // All by the mismatch that the best correlation leaves.
  const auto best_correlated = std::max_element(
      poses.begin(), poses.end(),
      [](const RenderedPose& a, const RenderedPose& b) { return a.value.correlation < b.value.correlation; });
  const Posterior posterior = problem.PosteriorAt(*best_correlated);
  std::vector<std::pair<double, std::size_t>> ranks;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    ranks.emplace_back(-posterior.Of(poses[k].T_camera_body, poses[k].value), k);
  }
  std::sort(ranks.begin(), ranks.end());
  std::vector<RigidTransform> best;
  for (const auto& [rank, k] : ranks) {
    const RigidTransform& pose = poses[k].T_camera_body;
    const bool known = std::any_of(best.begin(), best.end(), [&](const RigidTransform& other) {
      return AngleBetween(other.rotation, pose.rotation) < apart;
    });
    if (!known && best.size() < most) best.push_back(pose);
  }
  return best;
}

}  // namespace

StructureAlignment AlignByStructure(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                                    const RigidTransform& T_body_camera, const Matrix6d& prior,
                                    const StructureAlignmentOptions& options) {
  Check(!pairs.empty() && !options.widths.empty(), "AlignByStructure: no pairs");
  StillProblem problem{pairs, T_body_camera.Inverse(), prior, {}, {}};
  problem.structure.levels = 1;
  // Poles and kerbs are most of what one scan shows: their edges count, fattened as they are.
  problem.structure.depth_trust = 1.0;
  problem.structure.depth_weight = 1.0;
  problem.structure.relative_orientation = true;
  StructureAlignment result;
  std::vector<RigidTransform> poses;
  for (std::size_t i = 0; i < options.widths.size(); ++i) {
    const double scale = std::min(1.0, static_cast<double>(options.widths[i]) / intrinsics.width);
    if (i > 1 && scale == result.last_scale) break;
    result.last_scale = scale;
    problem.photos = ShrinkPhotos(pairs, intrinsics, scale, problem.structure);
    // The smallest photos turn the camera only: textures that they blur together would move it by metres. Of
    // them the best pose may be wrong: the next size decides among the best few.
    const bool first = i == 0;
    if (first) {
      const RenderedPose at_start = problem.Render(problem.start);
      poses =
          BestOfGrid(at_start.score, problem.PosteriorAt(at_start), problem.start, prior, options.candidates);
    }
    // Where the grid peaks is only as good as the rendering at the start: each peak is tried with its own.
    std::vector<RenderedPose> reached;
    for (const RigidTransform& pose : poses) {
      reached.push_back(
          ClimbByRenderings(problem, options.rounds, first ? Free::kRotation : Free::kPose, pose));
    }
    const double two_pixels = 2.0 / (scale * intrinsics.parameters[0]);
    poses = BestApart(problem, reached, first ? options.kept : 1, two_pixels);
  }
  const RenderedPose best = problem.Render(poses.front());
  const Posterior posterior = problem.PosteriorAt(best);
  result.T_body_camera = best.T_camera_body.Inverse();
  result.information = posterior.Information(best.T_camera_body);
  result.covariance = (result.information + posterior.prior_information()).inverse();
  result.score_before = problem.Render(problem.start).value.correlation;
  const Vector6d move = MoveBetween(problem.start, best.T_camera_body);
  result.squared_distance = move.dot(posterior.prior_information() * move);
  result.score_after = best.value.correlation;
  result.elsewhere = HighestElsewhere(best.score, best.T_camera_body);
  return result;
}

}  // namespace mlic
