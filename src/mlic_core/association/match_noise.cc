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
#include "mlic_core/problem/layout.h"

namespace mlic {
namespace {

constexpr double kBlock = 160.0;  // px; from: definition, docs/method.md
// Of a match's covariance that is its own at least, whatever its photo shares. from: guard, rounding
constexpr double kLeastOwn = 1e-6;

// What the matches of one photo share: a shift (px) and by how much later the image was exposed (s).
constexpr int kOfPhoto = 3;  // from: definition
// What those of one camera share in all photos: what the camera's pose and offset are off by at the state,
// and its focal lengths and centre.
constexpr int kOfLens = 4;                              // from: definition
constexpr int kOfCamera = Layout::kOfSensor + kOfLens;  // from: definition
using OfPhoto = Eigen::Matrix<double, kOfPhoto, 1>;
using OfCamera = Eigen::Matrix<double, kOfCamera, 1>;
using PhotoByCamera = Eigen::Matrix<double, kOfPhoto, kOfCamera>;
using CameraInformation = Eigen::Matrix<double, kOfCamera, kOfCamera>;
using ErrorByPhoto = Eigen::Matrix<double, 2, kOfPhoto>;
using ErrorByCamera = Eigen::Matrix<double, 2, kOfCamera>;

// One match at a state.
struct MatchError {
  std::size_t point;         // in its set
  Eigen::Vector2d error;     // px, of the photo against where the LiDAR saw it
  Eigen::Vector2d velocity;  // px/s, of the image
};
// Of each photo, by its camera and time.
using PhotoErrors = std::map<std::pair<int, double>, std::vector<MatchError>>;

// placed: PlacedByLidars.
PhotoErrors PhotosOf(const LandmarkSet& placed, const CalibrationState& state, std::size_t drive) {
  constexpr double kStep = 1e-3;  // s; from: guard, motion is even for so long
  // later: s, by which images are taken for later than they are
  const auto errors_when = [&](double later) {
    LandmarkSet moved = placed;
    for (LandmarkObservation& observation : moved.observations) observation.time += later;
    return LandmarkResiduals(moved, state, drive);
  };
  const std::vector<Eigen::Vector2d> errors = errors_when(0.0);
  const std::vector<Eigen::Vector2d> before = errors_when(-kStep), after = errors_when(kStep);
  PhotoErrors photos;
  for (std::size_t p = 0; p < placed.points.size(); ++p) {
    const std::size_t k = placed.begin[p];
    const LandmarkObservation& o = placed.observations[k];
    const Eigen::Vector2d velocity = (after[k] - before[k]) / (2.0 * kStep);
    if (errors[k].allFinite() && velocity.allFinite()) {
      photos[{o.camera, o.time}].push_back({p, errors[k], velocity});
    }
  }
  return photos;
}

// Errors of all observations of one drive by what each one's camera is off by. placed: PlacedByLidars.
std::vector<ErrorByCamera> ErrorsByCamera(const LandmarkSet& placed, const CalibrationState& state,
                                          std::size_t drive) {
  // rad, m, s and px: small against what bends the errors, large against rounding. from: guard
  constexpr double kPoseStep = 1e-4, kLensStep = 1e-2;
  const Layout layout(state, false);
  const auto errors_at = [&](int parameter, double step) {
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(layout.Total());
    for (std::size_t c = 0; c < state.cameras.size(); ++c) {
      const int first =
          parameter < Layout::kOfSensor ? layout.Camera(c) : layout.Intrinsics(c) - Layout::kOfSensor;
      delta[layout.knots + first + parameter] = step;
    }
    CalibrationState moved = state;
    layout.Update(delta, &moved);
    return LandmarkResiduals(placed, moved, drive);
  };
  std::vector<ErrorByCamera> by_camera(placed.observations.size());
  for (int parameter = 0; parameter < kOfCamera; ++parameter) {
    const double step = parameter < Layout::kOfSensor ? kPoseStep : kLensStep;
    const std::vector<Eigen::Vector2d> before = errors_at(parameter, -step),
                                       after = errors_at(parameter, step);
    for (std::size_t k = 0; k < by_camera.size(); ++k) {
      by_camera[k].col(parameter) = (after[k] - before[k]) / (2.0 * step);
    }
  }
  return by_camera;
}

Eigen::Matrix2d Shared(const MatchNoise& noise, const Eigen::Vector2d& velocity) {
  return noise.shift * noise.shift * Eigen::Matrix2d::Identity() +
         noise.smear * noise.smear * velocity * velocity.transpose();
}

Eigen::Matrix2d WholeCovariance(const LandmarkObservation& o) {
  const Eigen::Matrix2d whitening = o.shape.cast<double>() / o.sigma;
  return (whitening.transpose() * whitening).inverse();
}

// Sums over the matches of a block, whitened: their errors, and these by what their photo and camera share.
struct Block {
  Eigen::Vector2d error = Eigen::Vector2d::Zero();
  ErrorByPhoto by_photo = ErrorByPhoto::Zero();
  ErrorByCamera by_camera = ErrorByCamera::Zero();
  double count = 0.0;
};

// What the matches of one photo seem to share, were they independent else: with its covariance, and by what
// the camera is off by. within: what they tell of the camera by their differences.
struct PhotoSums {
  OfPhoto error;
  Eigen::Matrix3d covariance;
  PhotoByCamera by_camera;
  CameraInformation within;
  OfCamera within_gradient;
  std::vector<Block> blocks;
};

// made_with: by which the matches were weakened.
PhotoSums SumPhoto(const LandmarkSet& set, const std::vector<MatchError>& matches,
                   const std::vector<ErrorByCamera>& errors_by_camera, const MatchNoise& made_with) {
  // px and s: a photo in which everything moves alike does not tell the two from each other. from: guard
  const OfPhoto widest(100.0, 100.0, 1.0);
  Eigen::Matrix3d information = widest.cwiseAbs2().cwiseInverse().asDiagonal();
  OfPhoto gradient = OfPhoto::Zero();
  PhotoByCamera cross = PhotoByCamera::Zero();
  PhotoSums sums;
  sums.within.setZero();
  sums.within_gradient.setZero();
  std::map<std::pair<int, int>, Block> blocks;
  for (const MatchError& match : matches) {
    const std::size_t k = set.begin[match.point];
    const LandmarkObservation& o = set.observations[k];
    if (!errors_by_camera[k].allFinite()) continue;
    const Eigen::Matrix2d whole = WholeCovariance(o);
    const Eigen::Matrix2d rest =
        whole - static_cast<double>(matches.size()) * Shared(made_with, match.velocity);
    const bool is_rest = rest.determinant() > kLeastOwn * whole.determinant() && rest.trace() > 0.0;
    const Eigen::Matrix2d own = is_rest ? rest : Eigen::Matrix2d(kLeastOwn * whole);
    const Eigen::Matrix2d whitening = Eigen::Matrix2d(own.llt().matrixL()).inverse();
    ErrorByPhoto by_photo;
    by_photo << Eigen::Matrix2d::Identity(), match.velocity;
    by_photo = whitening * by_photo;
    const ErrorByCamera by_camera = whitening * errors_by_camera[k];
    const Eigen::Vector2d error = whitening * match.error;
    information += by_photo.transpose() * by_photo;
    gradient += by_photo.transpose() * error;
    cross += by_photo.transpose() * by_camera;
    sums.within += by_camera.transpose() * by_camera;
    sums.within_gradient += by_camera.transpose() * error;
    Block& block = blocks[{static_cast<int>(o.pixel.x() / kBlock), static_cast<int>(o.pixel.y() / kBlock)}];
    block.error += error;
    block.by_photo += by_photo;
    block.by_camera += by_camera;
    block.count += 1.0;
  }
  sums.covariance = information.inverse();
  sums.error = sums.covariance * gradient;
  sums.by_camera = sums.covariance * cross;
  sums.within -= cross.transpose() * sums.by_camera;
  sums.within_gradient -= cross.transpose() * sums.error;
  for (const auto& [place, block] : blocks) sums.blocks.push_back(block);
  return sums;
}

// Of what the camera is off by, beyond what any is. from: guard
CameraInformation LeastInformation() {
  OfCamera widest;  // rad, m, s and px
  widest << 1.0, 1.0, 1.0, 10.0, 10.0, 10.0, 1.0, OfCamera::Constant(1000.0).head<kOfLens>();
  return widest.cwiseAbs2().cwiseInverse().asDiagonal();
}

// The variance of what blocks of photos err by over that of independent matches, apart from what photos and
// the camera share.
double ScatterOfBlocks(const std::vector<PhotoSums>& photos) {
  CameraInformation information = LeastInformation();
  OfCamera gradient = OfCamera::Zero();
  for (const PhotoSums& photo : photos) {
    information += photo.within;
    gradient += photo.within_gradient;
  }
  const CameraInformation covariance = information.inverse();
  const OfCamera off = covariance * gradient;
  double squares = 0.0, expected = 0.0;
  for (const PhotoSums& photo : photos) {
    for (const Block& block : photo.blocks) {
      const ErrorByCamera by_camera = block.by_camera - block.by_photo * photo.by_camera;
      squares += (block.error - block.by_photo * photo.error - by_camera * off).squaredNorm();
      expected += 2.0 * block.count -
                  (block.by_photo * photo.covariance * block.by_photo.transpose()).trace() -
                  (by_camera * covariance * by_camera.transpose()).trace();
    }
  }
  return expected > 0.0 ? squares / expected : 0.0;
}

// Twice the logarithm of the likelihood of what photos share, but for a constant: restricted, as what the
// camera is off by is to pass for no noise (Patterson and Thompson, Biometrika 1971).
double LikelihoodOfShared(const std::vector<PhotoSums>& photos, double scatter, const MatchNoise& noise) {
  const OfPhoto variances = OfPhoto(noise.shift, noise.shift, noise.smear).cwiseAbs2();
  CameraInformation information = LeastInformation();
  OfCamera gradient = OfCamera::Zero();
  double sum = 0.0;
  for (const PhotoSums& photo : photos) {
    Eigen::Matrix3d expected = scatter * photo.covariance;
    expected.diagonal() += variances;
    const Eigen::Matrix3d weights = expected.inverse();
    sum -= photo.error.dot(weights * photo.error) + std::log(expected.determinant());
    const PhotoByCamera weighted = weights * photo.by_camera;
    information += photo.within / scatter + photo.by_camera.transpose() * weighted;
    gradient += photo.within_gradient / scatter + weighted.transpose() * photo.error;
  }
  const Eigen::LDLT<CameraInformation> solver(information);
  return sum + gradient.dot(solver.solve(gradient)) - solver.vectorD().array().log().sum();
}

}  // namespace

void AddMatch(const LandmarkSet& from, std::size_t point, LandmarkSet* to) {
  to->points.push_back(from.points[point]);
  to->lidar_points.push_back(from.lidar_points[point]);
  to->observations.push_back(from.observations[from.begin[point]]);
  to->begin.push_back(to->observations.size());
}

LandmarkSet PointsOnMap(const LandmarkSet& landmarks) {
  LandmarkSet on_map;
  on_map.begin.push_back(0);
  for (std::size_t p = 0; p < landmarks.points.size(); ++p) {
    if (landmarks.IsOnMap(p)) AddMatch(landmarks, p, &on_map);
  }
  return on_map;
}

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
  std::vector<std::vector<PhotoSums>> photos(noise.size());
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const LandmarkSet set = PlacedByLidars(PointsOnMap(drives[d].landmarks), state, d);
    const std::vector<ErrorByCamera> by_camera = ErrorsByCamera(set, state, d);
    for (const auto& [photo, matches] : PhotosOf(set, state, d)) {
      const auto c = static_cast<std::size_t>(photo.first);
      photos[c].push_back(SumPhoto(set, matches, by_camera, made_with[c]));
    }
  }
  // From what no photo shows to what no match is off by. from: guard
  static const std::vector<double> shifts = SizesFromNone(0.02, 5.0, 1.25),
                                   smears = SizesFromNone(2e-5, 2e-2, 1.3);
  for (std::size_t c = 0; c < noise.size(); ++c) {
    const double scatter = ScatterOfBlocks(photos[c]);
    if (!(scatter > 0.0)) continue;
    double best = -std::numeric_limits<double>::infinity();
    for (const double shift : shifts) {
      for (const double smear : smears) {
        const MatchNoise own{made_with[c].scale * std::sqrt(scatter), shift, smear};
        const double likelihood = LikelihoodOfShared(photos[c], scatter, own);
        if (likelihood > best) best = likelihood, noise[c] = own;
      }
    }
  }
  return noise;
}

void WeakenMatches(const std::vector<MatchNoise>& noise, const CalibrationState& state, std::size_t drive,
                   LandmarkSet* matches) {
  for (const auto& [photo, of_photo] : PhotosOf(PlacedByLidars(*matches, state, drive), state, drive)) {
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
