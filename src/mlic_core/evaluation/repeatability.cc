#include "mlic_core/evaluation/repeatability.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "mlic_core/common/angles.h"
#include "mlic_core/common/error.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// sigmas; from: derivation, of 500 numbers with sigmas known to a sixth (Student's t, 20 degrees of freedom)
// one is beyond in 30 calibrations
constexpr double kMostSigmas = 5.0;
const char* const kKinds[] = {"lidar-imu", "camera-imu", "lidar-lidar", "camera-camera", "lidar-camera"};

const char* NameOfType(const SensorResult& sensor) {
  return sensor.type == SensorResult::Type::kLidar ? "lidar" : "camera";
}

std::string KindOfPair(const SensorResult& a, const SensorResult& b) {
  const std::string first = NameOfType(a), second = NameOfType(b);
  return first == second || first == "lidar" ? first + "-" + second : second + "-" + first;
}

// Poses of all sensors and pairs of one calibration, pairs by the names of both, in order.
struct NamedPose {
  std::string kind, name;
  RigidTransform pose;
};

std::vector<NamedPose> PosesOf(const CalibrationResult& calibration) {
  std::vector<NamedPose> poses;
  for (const SensorResult& sensor : calibration.sensors) {
    poses.push_back({std::string(NameOfType(sensor)) + "-imu", sensor.name, sensor.calibration.T_imu_sensor});
  }
  for (const PairResult& pair : PairsOf(calibration)) {
    const SensorResult *a = FindSensor(calibration, pair.a), *b = FindSensor(calibration, pair.b);
    if (a != nullptr && b != nullptr)
      poses.push_back({KindOfPair(*a, *b), pair.a + "/" + pair.b, pair.T_a_b});
  }
  return poses;
}

// The rotation to which the small rotations from it sum to zero (Karcher mean), by its fixed point.
RigidTransform MeanOf(const std::vector<RigidTransform>& poses) {
  constexpr int kIterations = 20;  // from: guard; it converges quadratically for rotations that agree
  RigidTransform mean = poses.front();
  const double share = 1.0 / static_cast<double>(poses.size());
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  for (const RigidTransform& pose : poses) translation += share * pose.translation;
  mean.translation = translation;
  for (int i = 0; i < kIterations; ++i) {
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    for (const RigidTransform& pose : poses) {
      step += share * Log((pose.rotation * mean.rotation.conjugate()).normalized());
    }
    mean.rotation = (ExpQuaternion(step) * mean.rotation).normalized();
    if (step.norm() < 1e-14) break;
  }
  return mean;
}

PoseSpread SpreadOf(const std::string& kind, const std::string& name,
                    const std::vector<RigidTransform>& poses) {
  PoseSpread spread;
  spread.kind = kind;
  spread.name = name;
  spread.count = static_cast<int>(poses.size());
  spread.mean = MeanOf(poses);
  if (spread.count < 2) return spread;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero(), rotation = Eigen::Vector3d::Zero();
  for (const RigidTransform& pose : poses) {
    translation += (pose.translation - spread.mean.translation).cwiseAbs2();
    rotation += Log((pose.rotation * spread.mean.rotation.conjugate()).normalized()).cwiseAbs2();
  }
  spread.translation_spread = (translation / (spread.count - 1.0)).cwiseSqrt();
  spread.rotation_spread = (rotation / (spread.count - 1.0)).cwiseSqrt();
  return spread;
}

// The first calibration with the mean poses of all; offsets likewise.
CalibrationResult MeanCalibration(const std::vector<CalibrationResult>& calibrations) {
  CalibrationResult mean = calibrations.front();
  for (SensorResult& sensor : mean.sensors) {
    std::vector<RigidTransform> poses;
    double offset = 0.0;
    for (const CalibrationResult& calibration : calibrations) {
      if (const SensorResult* own = FindSensor(calibration, sensor.name)) {
        poses.push_back(own->calibration.T_imu_sensor);
        offset += own->calibration.time_offset;
      }
    }
    sensor.calibration.T_imu_sensor = MeanOf(poses);
    sensor.calibration.time_offset = offset / static_cast<double>(poses.size());
  }
  return mean;
}

// Sigmas as those of the difference of one of n calibrations to their mean.
CalibrationResult WithSigmasToMean(CalibrationResult calibration, double n) {
  const double factor = std::sqrt((n - 1.0) / n);
  const auto scale = [factor](PoseSigma* sigma) {
    sigma->translation *= factor;
    sigma->rotation *= factor;
    sigma->time_offset *= factor;
  };
  for (SensorResult& sensor : calibration.sensors) scale(&sensor.sigma);
  for (PairResult& pair : calibration.pairs) scale(&pair.sigma);
  return calibration;
}

using SquaresByName = std::map<std::string, std::pair<Eigen::Vector3d, Eigen::Vector3d>>;  // m^2, rad^2

void AddSquares(const std::vector<PoseError>& errors, double factor, SquaresByName* squares) {
  for (const PoseError& error : errors) {
    auto& [translation, rotation] =
        squares->try_emplace(error.name, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()).first->second;
    translation += factor * error.translation.cwiseAbs2();
    rotation += factor * error.rotation.cwiseAbs2();
  }
}

std::string PoseLine(const PoseSpread& pose) {
  const Eigen::Vector3d rpy = kDegreesPerRadian * ToRollPitchYaw(pose.mean.rotation);
  const Eigen::Vector3d &p = pose.mean.translation, s = 100.0 * pose.translation_spread,
                        r = kDegreesPerRadian * pose.rotation_spread;
  char line[400];
  std::snprintf(line, sizeof(line),
                "%-13s %-30s %2d  %7.3f±%-5.2f %7.3f±%-5.2f %7.3f±%-5.2f  %8.3f±%-6.4f %8.3f±%-6.4f "
                "%8.3f±%-6.4f  %7.3f %8.4f\n",
                pose.kind.c_str(), pose.name.c_str(), pose.count, p.x(), s.x(), p.y(), s.y(), p.z(), s.z(),
                rpy.x(), r.x(), rpy.y(), r.y(), rpy.z(), r.z(), 100.0 * pose.translation_rmse.norm(),
                kDegreesPerRadian * pose.rotation_rmse.norm());
  return line;
}

}  // namespace

Repeatability MeasureRepeatability(const std::vector<CalibrationResult>& given,
                                   const CalibrationResult* truth) {
  if (given.empty() || (truth == nullptr && given.size() < 2)) {
    throw InputError("one calibration says nothing of its errors: give more of the same rig, or the truth");
  }
  std::vector<CalibrationResult> calibrations;
  for (const CalibrationResult& calibration : given)
    calibrations.push_back(InAxesOf(given.front(), calibration));
  const auto n = static_cast<double>(calibrations.size());
  Repeatability result;
  result.against_truth = truth != nullptr;
  const CalibrationResult mean = truth != nullptr ? *truth : MeanCalibration(calibrations);
  SquaresByName squares;
  for (std::size_t i = 0; i < given.size(); ++i) {
    CalibrationDifference error;
    error.poses = truth != nullptr ? CompareWithTruth(given[i], *truth)
                                   : CompareWithTruth(WithSigmasToMean(calibrations[i], n), mean);
    const LargestDifference largest = LargestOf(error);
    if (largest.sigmas > result.worst.sigmas) result.worst = largest;
    const double factor = truth != nullptr ? 1.0 : n / (n - 1.0);
    AddSquares(error.poses.sensors, factor, &squares);
    AddSquares(error.poses.pairs, factor, &squares);
  }
  std::map<std::pair<std::string, std::string>, std::vector<RigidTransform>> poses;
  for (const CalibrationResult& calibration : calibrations) {
    for (const NamedPose& named : PosesOf(calibration)) poses[{named.kind, named.name}].push_back(named.pose);
  }
  for (const char* kind : kKinds) {
    for (const auto& [of, several] : poses) {
      if (of.first != kind || squares.count(of.second) == 0) continue;
      PoseSpread spread = SpreadOf(of.first, of.second, several);
      const auto& [translation, rotation] = squares.at(of.second);
      spread.translation_rmse = (translation / spread.count).cwiseSqrt();
      spread.rotation_rmse = (rotation / spread.count).cwiseSqrt();
      result.poses.push_back(spread);
    }
  }
  if (result.poses.empty()) {
    throw InputError("the calibrations have no sensor in common; sensors are matched by name");
  }
  return result;
}

std::string Conclusion(const LargestDifference& worst) {
  if (worst.of.empty()) return "no sigma is claimed: whether errors are as large as claimed cannot be said\n";
  char line[200];
  std::snprintf(line, sizeof(line), "%s: worst %.1f sigma (%s), the limit is %.0f\n",
                worst.sigmas <= kMostSigmas ? "errors agree with the claims" : "ERRORS EXCEED THE CLAIMS",
                worst.sigmas, worst.of.c_str(), kMostSigmas);
  return line;
}

std::string TableOf(const Repeatability& repeatability) {
  char header[300];
  std::snprintf(header, sizeof(header), "%-13s %-30s %2s  %-13s %-13s %-13s  %-15s %-15s %-15s  %7s %8s\n",
                "pose", "", "n", "x m±cm", "y m±cm", "z m±cm", "roll deg±deg", "pitch deg±deg", "yaw deg±deg",
                "cm", "deg");
  std::string table = header;
  for (const PoseSpread& pose : repeatability.poses) table += PoseLine(pose);
  table +=
      "± standard deviation of one calibration, of rotations about the first frame's x, y, z; last: root "
      "mean "
      "squares of the distance and the angle to the ";
  table += repeatability.against_truth ? "truth\n" : "mean of all\n";
  return table + Conclusion(repeatability.worst);
}

std::string CsvOf(const Repeatability& repeatability) {
  std::string csv =
      "kind,name,n,x,y,z,roll_deg,pitch_deg,yaw_deg,spread_x,spread_y,spread_z,spread_rotation_x_deg,"
      "spread_rotation_y_deg,spread_rotation_z_deg,rmse_x,rmse_y,rmse_z,rmse_rotation_x_deg,"
      "rmse_rotation_y_deg,rmse_rotation_z_deg\n";
  for (const PoseSpread& pose : repeatability.poses) {
    csv += pose.kind + "," + pose.name + "," + std::to_string(pose.count);
    const Eigen::Vector3d rpy = kDegreesPerRadian * ToRollPitchYaw(pose.mean.rotation);
    const Eigen::Vector3d turned = kDegreesPerRadian * pose.rotation_spread;
    Eigen::Matrix<double, 18, 1> values;
    values << pose.mean.translation, rpy, pose.translation_spread, turned, pose.translation_rmse,
        kDegreesPerRadian * pose.rotation_rmse;
    char text[32];
    for (const double value : values) {
      std::snprintf(text, sizeof(text), ",%.9g", value);
      csv += text;
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace mlic
