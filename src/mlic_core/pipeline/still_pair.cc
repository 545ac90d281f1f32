#include "mlic_core/pipeline/still_pair.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/angles.h"
#include "mlic_core/common/error.h"
#include "mlic_core/crossmodal/still_alignment.h"
#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// from: definition, limits of observability.
constexpr double kLargestSigmaRotation = 0.5 * kRadiansPerDegree,
                 kLargestSigmaTranslation = 0.05;  // as a drive
// from: structural, how a picture looks.
constexpr std::size_t kMostDrawnPoints = 400000;  // of a scan, in an overlay
// from: structural, how a picture looks.
constexpr double kPictureScale = 0.3;  // of the rendering, as one scan is sparse

// A photo in memory as an image source.
class OnePhoto : public ImageSource {
 public:
  explicit OnePhoto(cv::Mat photo) : photo_(std::move(photo)) {}
  std::size_t Count() const override { return 1; }
  double Time(std::size_t) const override { return 0.0; }
  cv::Mat Load(std::size_t) const override { return photo_; }

 private:
  cv::Mat photo_;
};

Matrix6d CovarianceOf(const ExtrinsicGuess& guess) {
  Vector6d variances;
  variances << guess.sigma_rotation.cwiseAbs2(), guess.sigma_translation.cwiseAbs2();
  return variances.asDiagonal();
}

struct Start {
  RigidTransform T_lidar_camera;
  Matrix6d covariance;  // of a small left rotation and translation of it
};

Start StartOf(const Rig& rig) {
  if (rig.lidars.size() != 1 || rig.cameras.size() != 1) {
    throw InputError("the rig file has " + std::to_string(rig.lidars.size()) + " LiDARs and " +
                     std::to_string(rig.cameras.size()) +
                     " cameras; expected one of each: set 'enabled: false' for the others");
  }
  const LidarConfig& lidar = rig.lidars[0];
  const CameraConfig& camera = rig.cameras[0];
  if (!camera.guess) {
    throw InputError(
        "cameras." + camera.name +
        ".T_imu_sensor is missing in the rig file; a still pair needs a first guess to within its "
        "sigma (5 degrees and 0.1 m unless given)");
  }
  Start start{camera.guess->T_imu_sensor, CovarianceOf(*camera.guess)};
  if (!lidar.guess) return start;
  const RigidTransform T_lidar_imu = lidar.guess->T_imu_sensor.Inverse();
  ExtrinsicGuess of_lidar = *lidar.guess;
  if (lidar.fixed) {
    const HeldSigma held = lidar.held_sigma.value_or(HeldSigma());
    of_lidar.sigma_translation = held.translation;
    of_lidar.sigma_rotation = held.rotation;
  }
  start.covariance += CovarianceOf(of_lidar);
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_lidar_imu.rotation.toRotationMatrix();
  start.covariance = turn * start.covariance * turn.transpose();
  start.T_lidar_camera = T_lidar_imu * camera.guess->T_imu_sensor;
  return start;
}

CameraIntrinsics IntrinsicsOf(const CameraConfig& camera, const cv::Mat& photo) {
  if (camera.intrinsics) return {camera.model, photo.cols, photo.rows, *camera.intrinsics};
  throw InputError("cameras." + camera.name +
                   ".intrinsics is missing in the rig file; one still pair does not show them: give them as "
                   "fx fy cx cy and the distortion, or calibrate from a drive");
}

double MeanNid(const std::vector<StillPair>& pairs, const CameraIntrinsics& intrinsics, double scale,
               const RigidTransform& T_lidar_camera) {
  const CameraIntrinsics small = ScaledIntrinsics(intrinsics, scale);
  double sum = 0.0;
  for (const StillPair& pair : pairs) {
    cv::Mat gray, mask;
    cv::resize(pair.gray, gray, {small.width, small.height}, 0.0, 0.0, cv::INTER_AREA);
    if (!pair.mask.empty()) cv::resize(pair.mask, mask, gray.size(), 0.0, 0.0, cv::INTER_NEAREST);
    const RenderedView view =
        ViewRenderer(*pair.map, small, RenderOptions()).Render(FixedPose(T_lidar_camera));
    sum += ViewNid(view.intensity, gray, mask, {});
  }
  return sum / static_cast<double>(pairs.size());
}

// The directions of one quantity whose sigma from the data alone exceeds the limit, or the guess's.
void FindUnobservable(const Eigen::Matrix3d& of_data, const Eigen::Matrix3d& of_guess,
                      const Eigen::Matrix3d& claimed, UnobservableDirection::Quantity quantity, double limit,
                      SensorResult* camera, std::array<bool, 3>* axes) {
  const SymmetricEigen<3> eigen(of_data);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d direction = eigen.eigenvectors().col(k);
    const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[k]));
    if (sigma <= limit && sigma <= std::sqrt(direction.dot(of_guess * direction))) continue;
    camera->unobservable.push_back({quantity, direction, std::sqrt(direction.dot(claimed * direction))});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (std::abs(direction[static_cast<int>(axis)]) > 0.5) (*axes)[axis] = false;
    }
  }
}

SensorResult DescribeCamera(const CameraConfig& config, const CameraIntrinsics& intrinsics,
                            const Start& start, const RigidTransform& T_lidar_camera,
                            const Matrix6d& covariance_of_camera, const Matrix6d& information_of_camera) {
  SensorResult camera;
  camera.name = config.name;
  camera.type = SensorResult::Type::kCamera;
  camera.frame_id = config.frame_id.empty() ? config.name : config.frame_id;
  camera.topic = config.topic;
  camera.calibration.T_imu_sensor = T_lidar_camera;
  camera.intrinsics = intrinsics;
  camera.intrinsics_fixed.assign(intrinsics.parameters.size(), true);
  camera.time_offset_observable = false;
  camera.unobservable.push_back({UnobservableDirection::Quantity::kTimeOffset, Eigen::Vector3d::Zero(), 0.0});
  const Matrix6d claimed = CovarianceOfInverse(T_lidar_camera, covariance_of_camera);
  camera.sigma.rotation = claimed.diagonal().head<3>().cwiseSqrt();
  camera.sigma.translation = claimed.diagonal().tail<3>().cwiseSqrt();
  // A metre and a radian of prior make directions invertible that the data do not show at all. Translations
  // are held at the guess where they are not shown; rotations are judged with them so held.
  const Matrix6d of_data =
      CovarianceOfInverse(T_lidar_camera, (information_of_camera + Matrix6d::Identity()).inverse());
  Matrix6d held = information_of_camera + 1e-6 * Matrix6d::Identity();
  held.bottomRightCorner<3, 3>() += CovarianceOfInverse(start.T_lidar_camera.Inverse(), start.covariance)
                                        .bottomRightCorner<3, 3>()
                                        .inverse();
  const Matrix6d with_translation = CovarianceOfInverse(T_lidar_camera, held.inverse());
  using Quantity = UnobservableDirection::Quantity;
  FindUnobservable(with_translation.topLeftCorner<3, 3>(), start.covariance.topLeftCorner<3, 3>(),
                   claimed.topLeftCorner<3, 3>(), Quantity::kRotation, kLargestSigmaRotation, &camera,
                   &camera.rotation_observable);
  FindUnobservable(of_data.bottomRightCorner<3, 3>(), start.covariance.bottomRightCorner<3, 3>(),
                   claimed.bottomRightCorner<3, 3>(), Quantity::kTranslation, kLargestSigmaTranslation,
                   &camera, &camera.translation_observable);
  return camera;
}

// T_before, T_after: T_lidar_camera of the guess and as found.
struct PairPoses {
  const CameraIntrinsics& intrinsics;
  RigidTransform T_before, T_after;
};

// refined: may be null; match_scale: of the photo that it matched, to the photo.
CameraProjection MakeProjection(const std::string& name, const ScanPhoto& pair, const IntensityMap& map,
                                const PairPoses& poses, const CameraToMapResult* refined,
                                double match_scale) {
  const auto& [intrinsics, T_before, T_after] = poses;
  CameraProjection out;
  out.camera = name;
  out.images = std::make_shared<OnePhoto>(pair.photo);
  out.before = ProjectScan(pair.returns, intrinsics, T_before.Inverse(), kMostDrawnPoints);
  out.after = ProjectScan(pair.returns, intrinsics, T_after.Inverse(), kMostDrawnPoints);
  out.guess = out.before;
  const CameraIntrinsics small = ScaledIntrinsics(intrinsics, kPictureScale);
  out.rendering = ViewRenderer(map, small, RenderOptions()).Render(FixedPose(T_after)).intensity;
  if (refined == nullptr) return out;
  for (const MapMatch& match : refined->matches[0]) {
    Eigen::Vector2d before, after;
    if (!Project(intrinsics, T_before.Inverse() * match.point, &before) ||
        !Project(intrinsics, T_after.Inverse() * match.point, &after)) {
      continue;
    }
    const Eigen::Vector2d half(0.5, 0.5);  // a pixel's centre is a whole number at both sizes
    const Eigen::Vector2d observed = (match.pixel + half) / match_scale - half;
    out.matches.push_back({observed.cast<float>(), before.cast<float>(), after.cast<float>()});
  }
  return out;
}

// Why the result cannot be used; none: it can.
std::vector<std::string> ReasonsAgainst(const StillAlignment& still, const SensorResult& camera) {
  std::vector<std::string> reasons;
  const std::string doubt = still.Doubt();
  if (!doubt.empty()) {
    reasons.push_back("the photo does not show the scan's structure at one clear place (" + doubt +
                      "); check that cloud and image are of one moment and the guess is within its sigma");
  } else if (!camera.rotation_observable[0] || !camera.rotation_observable[1] ||
             !camera.rotation_observable[2]) {
    reasons.push_back(
        "the scan has too little structure in the photo to fix the camera's rotation; give more pairs");
  }
  return reasons;
}

}  // namespace

std::vector<ProjectedPoint> ProjectScan(const std::vector<MapReturn>& returns, const CameraIntrinsics& camera,
                                        const RigidTransform& T_camera_body, std::size_t largest) {
  std::vector<ProjectedPoint> points;
  const std::size_t stride = std::max<std::size_t>(1, (returns.size() + largest - 1) / largest);
  for (std::size_t i = 0; i < returns.size(); i += stride) {
    const Eigen::Vector3d p = T_camera_body * returns[i].position.cast<double>();
    Eigen::Vector2d pixel;
    if (!Project(camera, p, &pixel)) continue;
    if (pixel.x() < -0.5 || pixel.y() < -0.5 || pixel.x() > camera.width - 0.5 ||
        pixel.y() > camera.height - 0.5) {
      continue;
    }
    points.push_back({pixel.cast<float>(), static_cast<float>(p.norm()), returns[i].intensity});
  }
  return points;
}

PairRegistration RegisterPairs(const Rig& rig, const std::vector<ScanPhoto>& pairs) {
  Check(!pairs.empty(), "RegisterPairs: no pairs");
  const Start start = StartOf(rig);
  const CameraIntrinsics intrinsics = IntrinsicsOf(rig.cameras[0], pairs[0].photo);
  std::vector<IntensityMap> maps;
  std::vector<StillPair> stills(pairs.size());
  IntensityMapOptions map_options;
  map_options.remove_moving = false;  // a single look cannot tell
  for (const ScanPhoto& pair : pairs) maps.push_back(BuildIntensityMap(pair.returns, map_options));
  for (std::size_t i = 0; i < pairs.size(); ++i)
    stills[i] = {&maps[i], ToGray(pairs[i].photo), pairs[i].mask};

  const Matrix6d prior = CovarianceOfInverse(start.T_lidar_camera.Inverse(), start.covariance);
  const StillAlignment still = AlignStill(stills, intrinsics, start.T_lidar_camera, prior);
  const StructureAlignment& found = still.found;
  const RigidTransform& T_lidar_camera = still.T_body_camera;

  PairRegistration out;
  out.score_before = found.score_before;
  out.score_after = found.score_after;
  out.score_elsewhere = found.elsewhere;
  out.matched = still.refined.has_value();
  out.nid_before = MeanNid(stills, intrinsics, kPictureScale, start.T_lidar_camera);
  out.nid_after = MeanNid(stills, intrinsics, kPictureScale, T_lidar_camera);

  const LidarConfig& lidar = rig.lidars[0];
  SensorResult base;
  base.name = lidar.name;
  base.type = SensorResult::Type::kLidar;
  base.frame_id = lidar.frame_id.empty() ? lidar.name : lidar.frame_id;
  base.topic = lidar.topic;
  SensorResult camera =
      DescribeCamera(rig.cameras[0], intrinsics, start, T_lidar_camera, still.covariance, still.information);

  CalibrationResult& result = out.result;
  result.imu_frame_id = base.frame_id;
  result.reasons = ReasonsAgainst(still, camera);
  result.verdict = result.reasons.empty() ? Verdict::kTrusted : Verdict::kRefused;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::string name = camera.name + (i == 0 ? "" : "_" + std::to_string(i + 1));
    result.projections.push_back(MakeProjection(name, pairs[i], *stills[i].map,
                                                {intrinsics, start.T_lidar_camera, T_lidar_camera},
                                                still.refined ? &*still.refined : nullptr, found.last_scale));
  }
  if (result.Trusted()) {
    result.pairs.push_back({base.name, camera.name, T_lidar_camera, camera.sigma});
    result.sensors = {base, camera};
    result.guesses = {{camera.name, start.T_lidar_camera}};
  }
  return out;
}

}  // namespace mlic
