#include "mlic_core/association/match_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <utility>

#include "mlic_core/common/sizes_of_draws.h"
#include "mlic_core/problem/landmark_terms.h"

namespace mlic {
namespace {

constexpr double kBlock = 160.0;  // px; from: definition, docs/method.md
// Of a match's covariance that is its own at least, whatever its photo shares. from: guard, rounding
constexpr double kLeastOwn = 1e-6;

// One match at a state.
struct MatchError {
  std::size_t point;         // in its set
  Eigen::Vector2d error;     // px, of the photo against where the LiDAR saw it
  Eigen::Vector2d velocity;  // px/s, of the image
};
// Of each photo, by its camera and time.
using PhotoErrors = std::map<std::pair<int, double>, std::vector<MatchError>>;

PhotoErrors PhotosOf(const LandmarkSet& matches, const CalibrationState& state, std::size_t drive) {
  constexpr double kStep = 1e-3;  // s; from: guard, motion is even for so long
  const LandmarkSet placed = PlacedByLidars(matches, state, drive);
  // later: s, by which images are taken for later than they are
  const auto errors_when = [&](double later) {
    LandmarkSet moved = placed;
    for (LandmarkObservation& observation : moved.observations) observation.time += later;
    return LandmarkResiduals(moved, state, drive);
  };
  const std::vector<Eigen::Vector2d> errors = errors_when(0.0);
  const std::vector<Eigen::Vector2d> before = errors_when(-kStep), after = errors_when(kStep);
  PhotoErrors photos;
  for (std::size_t p = 0; p < matches.points.size(); ++p) {
    if (!matches.IsOnMap(p)) continue;
    const std::size_t k = matches.begin[p];
    const LandmarkObservation& o = matches.observations[k];
    const Eigen::Vector2d velocity = (after[k] - before[k]) / (2.0 * kStep);
    if (errors[k].allFinite() && velocity.allFinite()) {
      photos[{o.camera, o.time}].push_back({p, errors[k], velocity});
    }
  }
  return photos;
}

Eigen::Matrix2d Shared(const MatchNoise& noise, const Eigen::Vector2d& velocity) {
  return noise.shift * noise.shift * Eigen::Matrix2d::Identity() +
         noise.smear * noise.smear * velocity * velocity.transpose();
}

Eigen::Matrix2d WholeCovariance(const LandmarkObservation& o) {
  const Eigen::Matrix2d whitening = o.shape.cast<double>() / o.sigma;
  return (whitening.transpose() * whitening).inverse();
}

// What the matches of one photo seem to share, were they independent else: the shift (px) and by how much
// later the image was exposed (s), with their covariance.
struct SharedOfPhoto {
  Eigen::Vector3d error;
  Eigen::Matrix3d covariance;
};

// Sums over blocks of photos.
struct BlockSums {
  double squares = 0.0;   // whitened, of the blocks' sums
  double expected = 0.0;  // the same of independent matches
};

// Sums over the matches of a block, whitened: their errors, and these by what their photo shares.
struct Block {
  Eigen::Vector2d error = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_shared = Eigen::Matrix<double, 2, 3>::Zero();
  double count = 0.0;
};

// Also adds what the photo's blocks scatter about it. made_with: by which the matches were weakened.
SharedOfPhoto SharedErrorOf(const LandmarkSet& set, const std::vector<MatchError>& matches,
                            const MatchNoise& made_with, BlockSums* sums) {
  // px and s: a photo in which everything moves alike does not tell the two from each other. from: guard
  const Eigen::Vector3d widest(100.0, 100.0, 1.0);
  Eigen::Matrix3d information = widest.cwiseAbs2().cwiseInverse().asDiagonal();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  std::map<std::pair<int, int>, Block> blocks;
  for (const MatchError& match : matches) {
    const LandmarkObservation& o = set.observations[set.begin[match.point]];
    const Eigen::Matrix2d whole = WholeCovariance(o);
    const Eigen::Matrix2d rest =
        whole - static_cast<double>(matches.size()) * Shared(made_with, match.velocity);
    const bool is_rest = rest.determinant() > kLeastOwn * whole.determinant() && rest.trace() > 0.0;
    const Eigen::Matrix2d own = is_rest ? rest : Eigen::Matrix2d(kLeastOwn * whole);
    const Eigen::Matrix2d L = own.llt().matrixL();
    Eigen::Matrix<double, 2, 3> by_shared;
    by_shared << Eigen::Matrix2d::Identity(), match.velocity;
    by_shared = L.inverse() * by_shared;
    const Eigen::Vector2d error = L.inverse() * match.error;
    information += by_shared.transpose() * by_shared;
    gradient += by_shared.transpose() * error;
    Block& block = blocks[{static_cast<int>(o.pixel.x() / kBlock), static_cast<int>(o.pixel.y() / kBlock)}];
    block.error += error;
    block.by_shared += by_shared;
    block.count += 1.0;
  }
  SharedOfPhoto shared;
  shared.covariance = information.inverse();
  shared.error = shared.covariance * gradient;
  for (const auto& [place, block] : blocks) {
    sums->squares += (block.error - block.by_shared * shared.error).squaredNorm();
    sums->expected +=
        2.0 * block.count - (block.by_shared * shared.covariance * block.by_shared.transpose()).trace();
  }
  return shared;
}

// Twice the logarithm of the likelihood of what photos share, but for a constant.
double LikelihoodOfShared(const std::vector<SharedOfPhoto>& photos, const MatchNoise& noise) {
  const Eigen::Vector3d variances = Eigen::Vector3d(noise.shift, noise.shift, noise.smear).cwiseAbs2();
  double sum = 0.0;
  for (const SharedOfPhoto& photo : photos) {
    Eigen::Matrix3d expected = photo.covariance;
    expected.diagonal() += variances;
    sum -= photo.error.dot(expected.inverse() * photo.error) + std::log(expected.determinant());
  }
  return sum;
}

}  // namespace

LandmarkSet PlacedByLidars(LandmarkSet matches, const CalibrationState& state, std::size_t drive) {
  const SplitSpline& trajectory = state.drives[drive].trajectory;
  for (std::size_t p = 0; p < matches.points.size(); ++p) {
    if (!matches.IsOnMap(p)) continue;
    const LidarPointObservation& observation = matches.lidar_points[p];
    const SensorCalibration& lidar = state.lidars[observation.lidar];
    const double t = lidar.OnImuClock(observation.time, trajectory.Middle());
    if (!trajectory.Contains(t)) continue;
    matches.points[p].position = trajectory.Pose(t) * lidar.T_imu_sensor * observation.position;
  }
  return matches;
}

std::vector<MatchNoise> MeasureMatchNoise(const std::vector<DriveTerms>& drives,
                                          const CalibrationState& state,
                                          const std::vector<MatchNoise>& made_with) {
  std::vector<MatchNoise> noise = made_with;
  std::vector<BlockSums> blocks(noise.size());
  std::vector<std::vector<SharedOfPhoto>> shared(noise.size());
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const LandmarkSet& set = drives[d].landmarks;
    for (const auto& [photo, matches] : PhotosOf(set, state, d)) {
      const auto c = static_cast<std::size_t>(photo.first);
      shared[c].push_back(SharedErrorOf(set, matches, made_with[c], &blocks[c]));
    }
  }
  // From what no photo shows to what no match is off by. from: guard
  static const std::vector<double> shifts = SizesFromNone(0.02, 5.0, 1.25),
                                   smears = SizesFromNone(2e-5, 2e-2, 1.3);
  for (std::size_t c = 0; c < noise.size(); ++c) {
    if (!(blocks[c].expected > 0.0)) continue;
    const double more = blocks[c].squares / blocks[c].expected;
    for (SharedOfPhoto& photo : shared[c]) photo.covariance *= more;
    double best = -std::numeric_limits<double>::infinity();
    for (const double shift : shifts) {
      for (const double smear : smears) {
        const MatchNoise own{made_with[c].scale * std::sqrt(more), shift, smear};
        const double likelihood = LikelihoodOfShared(shared[c], own);
        if (likelihood > best) best = likelihood, noise[c] = own;
      }
    }
  }
  return noise;
}

void WeakenMatches(const std::vector<MatchNoise>& noise, const CalibrationState& state, std::size_t drive,
                   LandmarkSet* matches) {
  for (const auto& [photo, of_photo] : PhotosOf(*matches, state, drive)) {
    const MatchNoise& own = noise[static_cast<std::size_t>(photo.first)];
    for (const MatchError& match : of_photo) {
      LandmarkObservation& o = matches->observations[matches->begin[match.point]];
      const Eigen::Matrix2d covariance =
          WholeCovariance(o) + static_cast<double>(of_photo.size()) * Shared(own, match.velocity);
      const Eigen::Matrix2d L = covariance.llt().matrixL();
      o.shape = Eigen::Matrix2d(L.inverse() * o.sigma).cast<float>();
    }
  }
}

std::string DescribeMatchNoise(const MatchNoise& noise) {
  char text[200];
  std::snprintf(text, sizeof(text),
                ": matches err by %.1f of their claimed sigmas; those of one photo share %.2f px and %.2f ms "
                "of its motion",
                noise.scale, noise.shift, 1e3 * noise.smear);
  return text;
}

}  // namespace mlic
