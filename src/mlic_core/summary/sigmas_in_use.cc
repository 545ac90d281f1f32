#include "mlic_core/summary/sigmas_in_use.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/layout.h"
#include "mlic_core/result/vehicle_axes.h"
#include "mlic_core/sensors/camera_model.h"
#include "mlic_core/uncertainty/pair_jacobian.h"

namespace mlic {
namespace {

constexpr double kDistances[] = {10.0, 50.0};  // m; from: definition
constexpr int kColumns = 16, kRows = 10;       // pixels over the image; from: definition
constexpr int kAzimuths = 36;                  // three in each sector; from: definition
constexpr int kElevations[] = {-20, 0, 20};    // deg, what LiDARs see; from: definition

// Along the direction in which it is largest.
template <typename Matrix>
double LargestSigma(const Matrix& covariance) {
  const SymmetricEigen<Eigen::Dynamic> eigen(covariance);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()[eigen.eigenvalues().size() - 1]));
}

SigmaInUse Summarize(SigmaInUse::Where where, double distance, std::vector<double> sigmas) {
  SigmaInUse use;
  use.where = where;
  use.distance = distance;
  use.worst = *std::max_element(sigmas.begin(), sigmas.end());
  use.median = Median(std::move(sigmas));
  return use;
}

// How a point that a sees at a pixel, at a known distance, moves in the frame of a by its intrinsics.
Eigen::Matrix3Xd MovedByIntrinsics(const Eigen::Vector3d& point, const CameraPointJacobian& J_point,
                                   const CameraParameterJacobian& J_parameters) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = point.unitOrthogonal();
  across.col(1) = point.normalized().cross(across.col(0));
  return -across * (J_point * across).inverse() * J_parameters;
}

bool IsInside(const CameraIntrinsics& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= camera.width - 1.0 &&
         pixel.y() <= camera.height - 1.0;
}

// Of the pixel of b that sees this point, by pose and intrinsics as UncertainPose::covariance has them; false
// where the point is not seen by both.
bool PixelJacobian(const UncertainPose& pose, const Eigen::Vector3d& in_b, Eigen::Matrix2Xd* J) {
  Eigen::Vector2d pixel;
  CameraPointJacobian of_point;
  CameraParameterJacobian of_parameters;
  if (!Project(*pose.b, in_b, &pixel, &of_point, &of_parameters)) return false;
  const Eigen::Matrix3d R_b_a = pose.T_a_b.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d in_a = pose.T_a_b * in_b;
  const CameraPointJacobian of_point_of_a = of_point * R_b_a;
  J->resize(2, pose.covariance.rows());
  J->leftCols<3>() = of_point_of_a * Hat(in_a - pose.T_a_b.translation);
  J->middleCols<3>(3) = -of_point_of_a;
  J->rightCols(of_parameters.cols()) = of_parameters;
  if (pose.a == nullptr) return true;
  CameraPointJacobian point_in_a;
  CameraParameterJacobian parameters_of_a;
  if (!Project(*pose.a, in_a, &pixel, &point_in_a, &parameters_of_a) || !IsInside(*pose.a, pixel)) {
    return false;
  }
  J->middleCols(6, parameters_of_a.cols()) =
      of_point_of_a * MovedByIntrinsics(in_a, point_in_a, parameters_of_a);
  return true;
}

// Of these parameters out of all of the calibration.
Eigen::MatrixXd Chosen(const Eigen::MatrixXd& covariance, const std::vector<int>& places) {
  const auto count = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd chosen(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) chosen(i, k) = covariance(places[i], places[k]);
  }
  return chosen;
}

void Append(int begin, std::size_t count, std::vector<int>* places) {
  for (std::size_t i = 0; i < count; ++i) places->push_back(begin + static_cast<int>(i));
}

// Null of a LiDAR.
const CameraIntrinsics* LensOf(const CalibrationState& state, SensorId id) {
  return id.IsLidar() ? nullptr : &state.cameras[id.index].intrinsics;
}

// Covariance of the poses and offsets of the sensors at these places, in the order given, then of the
// intrinsics of those that are cameras.
Eigen::MatrixXd CovarianceOf(const CalibrationState& state, const ObservabilityAnalysis& analysis,
                             const std::vector<std::size_t>& sensors) {
  // Scale and shear of the IMU come after all intrinsics.
  const Layout layout(state, false);
  std::vector<int> places;
  for (const std::size_t s : sensors) Append(Layout::Sensor(s), Layout::kOfSensor, &places);
  const std::size_t poses = places.size();
  for (const std::size_t s : sensors) {
    const SensorId id = state.Sensors().At(s);
    if (const CameraIntrinsics* lens = LensOf(state, id)) {
      Append(layout.Intrinsics(id.index), lens->parameters.size(), &places);
    }
  }
  Eigen::MatrixXd covariance = Chosen(analysis.whole_covariance, places);
  // To which more may have been added since.
  places.resize(poses);
  const auto size = static_cast<Eigen::Index>(poses);
  covariance.topLeftCorner(size, size) = Chosen(analysis.covariance, places);
  return covariance;
}

// With J for the first parameters and the rest as they are.
Eigen::MatrixXd Carried(const Eigen::MatrixXd& J, const Eigen::MatrixXd& covariance) {
  const Eigen::Index rest = covariance.rows() - J.cols();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(J.rows() + rest, covariance.rows());
  all.topLeftCorner(J.rows(), J.cols()) = J;
  all.bottomRightCorner(rest, rest).setIdentity();
  return all * covariance * all.transpose();
}

std::vector<SigmaInUse> SigmasOf(const UncertainPose& pose, const Eigen::Matrix3d& R_a_vehicle) {
  return pose.b == nullptr ? SigmasInSpace(pose, R_a_vehicle) : SigmasInImage(pose);
}

// Of the sensor at a place, against the IMU.
std::vector<SigmaInUse> SigmasOfSensor(const CalibrationState& state, const ObservabilityAnalysis& analysis,
                                       std::size_t sensor, const Eigen::Matrix3d& R_vehicle_imu) {
  const SensorId id = state.Sensors().At(sensor);
  const Eigen::MatrixXd pose_only = Eigen::MatrixXd::Identity(6, Layout::kOfSensor);
  return SigmasOf({state.Sensor(id).T_imu_sensor, nullptr, LensOf(state, id),
                   Carried(pose_only, CovarianceOf(state, analysis, {sensor}))},
                  R_vehicle_imu.transpose());
}

}  // namespace

std::vector<SigmaInUse> SigmasInSpace(const UncertainPose& pose, const Eigen::Matrix3d& R_a_vehicle) {
  std::vector<SigmaInUse> uses;
  for (const double distance : kDistances) {
    std::vector<double> sigmas, sectors(kUseSectors, 0.0);
    for (int k = 0; k < kAzimuths; ++k) {
      const double azimuth = 2.0 * M_PI * (k + 0.5) / kAzimuths;
      for (const int degrees : kElevations) {
        const double elevation = degrees * M_PI / 180.0;
        const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        Eigen::Matrix<double, 3, 6> J;
        J << -Hat(distance * (R_a_vehicle * direction)), Eigen::Matrix3d::Identity();
        sigmas.push_back(
            LargestSigma<Eigen::Matrix3d>(J * pose.covariance.topLeftCorner<6, 6>() * J.transpose()));
        double& sector = sectors[static_cast<std::size_t>(k * kUseSectors / kAzimuths)];
        sector = std::max(sector, sigmas.back());
      }
    }
    uses.push_back(Summarize(SigmaInUse::Where::kSpace, distance, std::move(sigmas)));
    uses.back().sectors = std::move(sectors);
  }
  return uses;
}

std::vector<SigmaInUse> SigmasInImage(const UncertainPose& pose) {
  std::vector<SigmaInUse> uses;
  for (const double distance : kDistances) {
    std::vector<double> sigmas;
    for (int k = 0; k < kColumns * kRows; ++k) {
      const Eigen::Vector2d pixel((k % kColumns + 0.5) * pose.b->width / kColumns - 0.5,
                                  (k / kColumns + 0.5) * pose.b->height / kRows - 0.5);
      Eigen::Vector3d bearing;
      Eigen::Matrix2Xd J;
      if (!Unproject(*pose.b, pixel, &bearing) || !PixelJacobian(pose, distance * bearing, &J)) continue;
      sigmas.push_back(LargestSigma<Eigen::Matrix2d>(J * pose.covariance * J.transpose()));
    }
    if (sigmas.empty()) continue;
    uses.push_back(Summarize(SigmaInUse::Where::kImage, distance, std::move(sigmas)));
  }
  return uses;
}

std::vector<SigmaInUse> SigmasOfPair(const CalibrationState& state, const ObservabilityAnalysis& analysis,
                                     std::size_t a, std::size_t b, const Eigen::Matrix3d& R_vehicle_body) {
  const SensorId id_a = state.Sensors().At(a), id_b = state.Sensors().At(b);
  const SensorCalibration &of_a = state.Sensor(id_a), &of_b = state.Sensor(id_b);
  const RigidTransform T_a_body = of_a.T_imu_sensor.Inverse();
  return SigmasOf({T_a_body * of_b.T_imu_sensor, LensOf(state, id_a), LensOf(state, id_b),
                   Carried(PairJacobian(of_a, of_b).topRows<6>(), CovarianceOf(state, analysis, {a, b}))},
                  T_a_body.rotation.toRotationMatrix() * R_vehicle_body.transpose());
}

void AddSigmasInUse(const Rig& rig, const CalibrationState& state, const ObservabilityAnalysis& analysis,
                    CalibrationResult* result) {
  const Eigen::Matrix3d R_vehicle_imu = VehicleAxes(*result);
  std::vector<std::string> names;
  for (const LidarConfig& lidar : rig.lidars) names.push_back(lidar.name);
  for (const CameraConfig& camera : rig.cameras) names.push_back(camera.name);
  const auto place = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  for (SensorResult& sensor : result->sensors) {
    sensor.in_use = SigmasOfSensor(state, analysis, place(sensor.name), R_vehicle_imu);
  }
  for (PairResult& pair : result->pairs) {
    pair.in_use = SigmasOfPair(state, analysis, place(pair.a), place(pair.b), R_vehicle_imu);
  }
}

}  // namespace mlic
