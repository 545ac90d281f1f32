#include "mlic_core/pipeline/camera_placement.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/crossmodal/still_alignment.h"

namespace mlic {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kPhotos = 5;        // of a vehicle that moves; from: guard, time
constexpr double kAbout = 1.5;            // s of scans to either side of a photo; from: guard, time
constexpr std::size_t kReturns = 300000;  // of a photo's map; from: guard, time and memory
constexpr double kLeastFromEnds = 0.5;    // s that photos keep from the trajectory's ends; from: structural
// By how much more matches of one photo err than they claim. from: measured, paper rig, as kLeastMatchNoise
// of the joint rounds
constexpr double kMatchNoise = 4.0;
// px of the photo as last matched, and m: light, shade and depth edges that beams fatten move a whole photo
// by that at this distance, which no curvature of a score shows. from: measured, front camera of the paper
// rig parked in yards, streets and car parks, six of each: off by 0.6 px, root mean square, and one by 2
constexpr double kCommonError = 0.7, kDistance = 10.0;

// Images nearest to evenly spread times of the trajectory, each once.
std::vector<std::size_t> ChooseImages(const ImageSource& images, double time_offset,
                                      const SplitSpline& trajectory, std::size_t count) {
  std::vector<std::size_t> chosen;
  const double start = trajectory.Start() + kLeastFromEnds, end = trajectory.End() - kLeastFromEnds;
  const double length = std::max(0.0, end - start);
  std::size_t image = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double middle = 0.5 * (trajectory.Start() + trajectory.End());
    const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(count) - 0.5;
    const double wanted = middle + share * length - time_offset;
    while (image + 1 < images.Count() &&
           std::abs(images.Time(image + 1) - wanted) <= std::abs(images.Time(image) - wanted)) {
      ++image;
    }
    if (image < images.Count() && trajectory.Contains(images.Time(image) + time_offset) &&
        (chosen.empty() || chosen.back() != image)) {
      chosen.push_back(image);
    }
  }
  return chosen;
}

// What the LiDARs saw about a time, in the root's frame at that time.
IntensityMap MapAbout(double time, bool parked, const Drive& drive, const CalibrationState& state) {
  const SplitSpline& trajectory = state.drives[0].trajectory;
  std::optional<TimeInterval> window;
  if (!parked) window = TimeInterval{time - kAbout, time + kAbout};
  std::vector<MapReturn> returns = CollectReturns(drive, trajectory, state.lidars, kReturns, window);
  const RigidTransform T_root_map = trajectory.Pose(time).Inverse();
  const Eigen::Matrix3f R = T_root_map.rotation.toRotationMatrix().cast<float>();
  for (MapReturn& r : returns) {
    r.position = (T_root_map * r.position.cast<double>()).cast<float>();
    r.beam = R * r.beam;
  }
  IntensityMapOptions options;
  options.remove_moving = !parked;  // the same beams all the time see through nothing
  return BuildIntensityMap(returns, options);
}

// What is wrong with the time moves the camera along the way.
Matrix6d OfTime(const LidarsAlone& alone, std::size_t camera, const SplitSpline& trajectory,
                const RigidTransform& T_root_camera) {
  const Eigen::Matrix<double, 6, 1> error = alone.time_offset_sigmas[alone.rig.lidars.size() + camera] *
                                            ErrorOfOffset(trajectory, T_root_camera).head<6>();
  return error * error.transpose();
}

// The guess as of a small left rotation and translation of T_root_camera.
Matrix6d CovarianceOf(const ExtrinsicGuess& guess) {
  Eigen::Matrix<double, 6, 1> variances;
  variances << guess.sigma_rotation.cwiseAbs2(), guess.sigma_translation.cwiseAbs2();
  return variances.asDiagonal();
}

// The pose of the camera and what is known of it: by all pixels, or by single matches where these say more.
struct Found {
  RigidTransform T_root_camera;
  Matrix6d claimed, shown;  // of T_camera_root
};

Found BestOf(const StillAlignment& still, const CameraIntrinsics& intrinsics) {
  const StructureAlignment& found = still.found;
  const double angle = kCommonError / (found.last_scale * intrinsics.parameters[0]);
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << Eigen::Vector3d::Constant(angle), Eigen::Vector3d::Constant(angle * kDistance);
  const Matrix6d common = sigmas.cwiseAbs2().asDiagonal();
  if (still.refined) {
    const Matrix6d covariance = kMatchNoise * kMatchNoise * still.refined->covariance;
    if (covariance.determinant() < found.covariance.determinant()) {
      return {still.refined->T_body_camera, covariance + common, covariance + common};
    }
  }
  // A metre and a radian make directions invertible that the data do not show at all.
  const Matrix6d shown = (found.information + Matrix6d::Identity()).inverse();
  return {found.T_body_camera, found.covariance + common, shown + common};
}

PlacedCamera PlaceCamera(const LidarsAlone& alone, std::size_t camera, const CameraStart& start,
                         const CalibrationState& state) {
  PlacedCamera placed;
  const CameraConfig& config = alone.rig.cameras[camera];
  const Drive& drive = alone.dataset.drives[0];
  const CameraRecording& recording = drive.cameras[camera];
  const SplitSpline& trajectory = state.drives[0].trajectory;
  if (!config.guess) {
    placed.problem = config.name +
                     ": without the IMU a guess alone tells where to look for it in the LiDARs' map; give "
                     "T_imu_sensor of it and of " +
                     alone.rig.lidars[alone.root].name;
    return placed;
  }
  if (alone.parked && start.from_field_of_view) {
    placed.problem = config.name +
                     ": a parked vehicle does not tell its intrinsics from its place; give intrinsics in the "
                     "rig file, or drive";
    return placed;
  }
  const double offset = config.time_offset.value_or(0.0);
  const std::vector<std::size_t> images =
      ChooseImages(*recording.images, offset, trajectory, alone.parked ? 1 : kPhotos);
  if (images.empty()) {
    placed.problem =
        config.name + ": it has no images while the LiDARs record; check its topic and its clock";
    return placed;
  }
  std::vector<IntensityMap> maps;
  for (const std::size_t image : images) {
    maps.push_back(MapAbout(recording.images->Time(image) + offset, alone.parked, drive, state));
  }
  std::vector<StillPair> pairs;
  for (std::size_t i = 0; i < images.size(); ++i) {
    pairs.push_back({&maps[i], ToGray(recording.images->Load(images[i])), recording.mask});
  }
  const RigidTransform& guess = config.guess->T_imu_sensor;
  const Matrix6d prior = CovarianceOfInverse(guess.Inverse(), CovarianceOf(*config.guess));
  const StillAlignment still = AlignStill(pairs, start.intrinsics, guess, prior);
  const std::string doubt = still.Doubt();
  if (!doubt.empty()) {
    placed.problem = config.name + ": its photos do not show the LiDARs' map at one clear place (" + doubt +
                     "); check that T_imu_sensor is within its sigma, intrinsics and stamps, or turn the "
                     "camera to what the LiDARs see";
    return placed;
  }
  const Found found = BestOf(still, start.intrinsics);
  const Matrix6d of_time =
      alone.parked ? Matrix6d(Matrix6d::Zero()) : OfTime(alone, camera, trajectory, found.T_root_camera);
  placed.place = {found.T_root_camera, CovarianceOfInverse(found.T_root_camera, found.claimed) + of_time,
                  CovarianceOfInverse(found.T_root_camera, found.shown) + of_time};
  return placed;
}

}  // namespace

std::vector<PlacedCamera> PlaceCameras(const LidarsAlone& alone, const std::vector<CameraStart>& starts,
                                       const std::vector<std::optional<CameraPlace>>& known,
                                       const CalibrationState& state, const CancellationToken& cancellation) {
  std::vector<PlacedCamera> places;
  for (std::size_t c = 0; c < alone.rig.cameras.size(); ++c) {
    cancellation.ThrowIfCancelled();
    places.push_back(known[c] ? PlacedCamera{*known[c], ""} : PlaceCamera(alone, c, starts[c], state));
  }
  return places;
}

}  // namespace mlic
