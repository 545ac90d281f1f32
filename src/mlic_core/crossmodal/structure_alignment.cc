#include "mlic_core/crossmodal/structure_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/cross_modal_matches.h"
#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// As StructureMatcher's kSigmaFactor: structure comes in blurred edges, not in independent pixels. Here all
// pixels of a scan share the faults of its rendering too.
constexpr double kScanSigmaFactor = 10.0;
constexpr double kAwayDegrees = 4.0;  // from: definition, StructureAlignment::elsewhere
// px: structure is blurred over more, so that every second pixel of every second row says as much as all.
constexpr int kPixelStep = 2;  // from: guard, time

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

// The log-posterior of a pose about the start, up to a constant, for steps in units of PixelMoves.
class Posterior {
 public:
  Posterior(const StructureScore& score, const RigidTransform& start, const Matrix6d& prior)
      : score_(score), start_(start), prior_information_(prior.inverse()), units_(PixelMoves(score)) {}

  // What one unit of score is worth, judged from the mismatch that is left at a pose.
  void WeighAt(const RigidTransform& pose) {
    worth_ = score_.weight() / (kScanSigmaFactor * kScanSigmaFactor * std::max(0.1, 1.0 - score_.At(pose)));
  }
  double At(const RigidTransform& pose) const {
    const Vector6d move = MoveBetween(start_, pose);
    return worth_ * score_.At(pose) - 0.5 * move.dot(prior_information_ * move);
  }
  RigidTransform Step(const RigidTransform& pose, const Vector6d& step) const {
    return Moved(pose, units_.cwiseProduct(step));
  }

  // By central differences of one unit, all evaluations in parallel.
  void Differentiate(const RigidTransform& pose, Vector6d* gradient, Matrix6d* hessian) const {
    std::vector<Vector6d> steps{Vector6d::Zero()};
    for (int i = 0; i < 6; ++i) {
      steps.push_back(Vector6d::Unit(i));
      steps.push_back(-Vector6d::Unit(i));
      for (int j = 0; j < i; ++j) {
        steps.push_back(Vector6d::Unit(i) + Vector6d::Unit(j));
        steps.push_back(-Vector6d::Unit(i) - Vector6d::Unit(j));
      }
    }
    std::vector<double> values(steps.size());
    ParallelFor(steps.size(), [&](std::size_t k) { values[k] = At(Step(pose, steps[k])); });
    Vector6d up, down;
    std::size_t k = 1;
    Matrix6d sums;
    for (int i = 0; i < 6; ++i) {
      up[i] = values[k++];
      down[i] = values[k++];
      for (int j = 0; j < i; ++j, k += 2) sums(i, j) = values[k] + values[k + 1];
    }
    *gradient = 0.5 * (up - down);
    for (int i = 0; i < 6; ++i) {
      (*hessian)(i, i) = up[i] + down[i] - 2.0 * values[0];
      for (int j = 0; j < i; ++j) {
        const double mixed = 0.5 * (sums(i, j) - up[i] - down[i] - up[j] - down[j] + 2.0 * values[0]);
        (*hessian)(i, j) = (*hessian)(j, i) = mixed;
      }
    }
  }

  // Newton steps, each shortened until it climbs; directions that are not concave go along the gradient.
  RigidTransform Climb(RigidTransform pose) const {
    constexpr double kLeastCurvature = 1e-3, kLongest = 4.0, kSettled = 0.02;  // from: guard
    for (int i = 0; i < 12; ++i) {
      Vector6d gradient;
      Matrix6d hessian;
      Differentiate(pose, &gradient, &hessian);
      const SymmetricEigen<Eigen::Dynamic> eigen(-hessian);
      const double largest = std::max(1e-12, eigen.eigenvalues().cwiseAbs().maxCoeff());
      const Vector6d curvature = eigen.eigenvalues().cwiseAbs().cwiseMax(kLeastCurvature * largest);
      Vector6d step =
          eigen.eigenvectors() * (eigen.eigenvectors().transpose() * gradient).cwiseQuotient(curvature);
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
    Differentiate(pose, &gradient, &hessian);
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

// The best `most` poses that are turned by at least `apart` (rad) from better ones. ranks: negative score and
// index of each.
std::vector<RigidTransform> BestApart(const std::vector<RigidTransform>& poses,
                                      std::vector<std::pair<double, std::size_t>> ranks, std::size_t most,
                                      double apart) {
  std::sort(ranks.begin(), ranks.end());
  std::vector<RigidTransform> best;
  for (const auto& [score, k] : ranks) {
    const RigidTransform& pose = poses[k];
    const bool known = std::any_of(best.begin(), best.end(), [&](const RigidTransform& other) {
      return AngleBetween(other.rotation, pose.rotation) < apart;
    });
    if (!known && best.size() < most) best.push_back(pose);
  }
  return best;
}

double HighestElsewhere(const StructureScore& score, const RigidTransform& T_camera_body) {
  double highest = -1.0;
  for (int k = 0; k < 8; ++k) {
    const double angle = k * M_PI / 4.0;
    const Eigen::Vector3d turn(std::cos(angle), std::sin(angle), 0.0);
    Vector6d move = Vector6d::Zero();
    move.head<3>() = kAwayDegrees * M_PI / 180.0 * turn;
    highest = std::max(highest, score.At(Moved(T_camera_body, move)));
  }
  return highest;
}

}  // namespace

StructureScore::StructureScore(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                               double scale, const StructureOptions& options,
                               const RigidTransform& T_body_camera)
    : intrinsics_(ScaledIntrinsics(intrinsics, scale)) {
  const ViewPose pose = FixedPose(T_body_camera);
  std::vector<float> depths;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    cv::Mat gray, mask;
    const cv::Size size(intrinsics_.width, intrinsics_.height);
    cv::resize(pairs[i].gray, gray, size, 0.0, 0.0, cv::INTER_AREA);
    if (!pairs[i].mask.empty()) cv::resize(pairs[i].mask, mask, size, 0.0, 0.0, cv::INTER_NEAREST);
    photos_.push_back(PhotoStructure(gray, mask, options));
    const RenderedView view = ViewRenderer(*pairs[i].map, intrinsics_, RenderOptions()).Render(pose);
    const StructurePyramid rendering = MapStructure(StructureOf(view, intrinsics_, pose), options);
    const StructureImage& image = rendering[0];
    for (int v = 0; v < image.height; v += kPixelStep) {
      for (int u = 0; u < image.width; u += kPixelStep) {
        Sample sample;
        if (!(image.Weight(v)[u] > 0.0f) || !(image.Energy(v)[u] > 0.0f)) continue;
        if (!SurfaceAt(view, intrinsics_, pose, Eigen::Vector2d(u, v), &sample.point)) continue;
        for (int k = 0; k < StructureImage::kChannels; ++k) {
          sample.structure[k] = image.Channels(v)[u * StructureImage::kChannels + k];
        }
        sample.weight = image.Weight(v)[u];
        sample.pair = i;
        weight_ += kPixelStep * kPixelStep * sample.weight;
        samples_.push_back(sample);
        depths.push_back(view.depth.at<float>(v, u));
      }
    }
  }
  if (depths.empty()) return;
  typical_depth_ = Median(std::move(depths));
}

double StructureScore::At(const RigidTransform& T_camera_body) const {
  constexpr int kChannels = StructureImage::kChannels;  // from: structural
  using Channels = Eigen::Matrix<float, kChannels, 1>;
  const Eigen::Matrix3d R = T_camera_body.rotation.toRotationMatrix();
  double both = 0.0, of_samples = 0.0, of_photo = 0.0;
  for (const Sample& sample : samples_) {
    of_samples += sample.weight * sample.structure.squaredNorm();
    Eigen::Vector2d pixel;
    if (!Project(intrinsics_, R * sample.point + T_camera_body.translation, &pixel)) continue;
    const int u = static_cast<int>(std::floor(pixel.x())), v = static_cast<int>(std::floor(pixel.y()));
    const StructureImage& photo = photos_[sample.pair][0];
    if (u < 0 || v < 0 || u + 1 >= photo.width || v + 1 >= photo.height) continue;
    const auto a = static_cast<float>(pixel.x() - u), b = static_cast<float>(pixel.y() - v);
    const float* upper = photo.Channels(v) + u * kChannels;
    const float* lower = photo.Channels(v + 1) + u * kChannels;
    using Map = Eigen::Map<const Channels>;
    const Channels seen = (1.0f - b) * ((1.0f - a) * Map(upper) + a * Map(upper + kChannels)) +
                          b * ((1.0f - a) * Map(lower) + a * Map(lower + kChannels));
    both += sample.weight * seen.dot(sample.structure);
    of_photo += sample.weight * seen.squaredNorm();
  }
  return both / std::sqrt(of_samples * of_photo + 1e-12);
}

StructureAlignment AlignByStructure(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics,
                                    const RigidTransform& T_body_camera, const Matrix6d& prior,
                                    const StructureAlignmentOptions& options) {
  Check(!pairs.empty() && !options.widths.empty(), "AlignByStructure: no pairs");
  StructureOptions structure;
  structure.levels = 1;
  // Poles and kerbs are most of what one scan shows: their edges count, fattened as they are.
  structure.depth_trust = 1.0;
  structure.depth_weight = 1.0;
  const RigidTransform start = T_body_camera.Inverse();
  // Renders at the pose and climbs, `rounds` times; the score that is reached.
  const auto climb = [&](double scale, int rounds, RigidTransform* at) {
    double reached = 0.0;
    for (int round = 0; round < rounds; ++round) {
      const StructureScore score(pairs, intrinsics, scale, structure, at->Inverse());
      Posterior posterior(score, start, prior);
      posterior.WeighAt(*at);
      *at = posterior.Climb(*at);
      reached = score.At(*at);
    }
    return reached;
  };
  StructureAlignment result;
  std::vector<RigidTransform> poses;
  for (std::size_t i = 0; i < options.widths.size(); ++i) {
    const double scale = std::min(1.0, static_cast<double>(options.widths[i]) / intrinsics.width);
    if (i > 0 && scale == result.last_scale) break;
    if (i == 0) {
      const StructureScore score(pairs, intrinsics, scale, structure, T_body_camera);
      Posterior posterior(score, start, prior);
      posterior.WeighAt(start);
      poses = BestOfGrid(score, posterior, start, prior, options.candidates);
      result.first_scale = scale;
    }
    result.last_scale = scale;
    // Where the grid peaks is only as good as the rendering at the start: each peak is tried with its own. Of
    // so small photos the best may be wrong: the next size decides among the best few.
    std::vector<std::pair<double, std::size_t>> reached;
    for (std::size_t k = 0; k < poses.size(); ++k) {
      const double score = climb(scale, options.rounds, &poses[k]);
      reached.emplace_back(-score, k);
    }
    const double two_pixels = 2.0 / (scale * intrinsics.parameters[0]);
    poses = BestApart(poses, std::move(reached), i == 0 ? options.kept : 1, two_pixels);
  }
  const RigidTransform pose = poses.front();
  const StructureScore score(pairs, intrinsics, result.last_scale, structure, pose.Inverse());
  Posterior posterior(score, start, prior);
  posterior.WeighAt(pose);
  result.T_body_camera = pose.Inverse();
  result.information = posterior.Information(pose);
  result.covariance = (result.information + posterior.prior_information()).inverse();
  result.score_before =
      StructureScore(pairs, intrinsics, result.last_scale, structure, T_body_camera).At(start);
  result.score_after = score.At(pose);
  result.elsewhere = HighestElsewhere(score, pose);
  return result;
}

}  // namespace mlic
