#include "mlic_ros/display/status_board.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mlic_core/common/join.h"
#include "mlic_ros/display/display_messages.h"

namespace mlic {
namespace {

// Of the map's points; from: structural, the few far ones do not decide what is looked at.
constexpr double kShareInside = 0.9;

template <typename Config>
SensorStatus AsGiven(const Config& config, bool is_camera) {
  SensorStatus sensor;
  sensor.name = config.name;
  sensor.frame_id = FrameName(config.frame_id, config.name);
  sensor.is_camera = is_camera;
  sensor.state = SensorStatus::WAITING;
  sensor.transform.rotation.w = sensor.guess.rotation.w = 1.0;
  sensor.has_guess = config.guess.has_value();
  if (config.guess) sensor.guess = ToMessage(config.guess->T_imu_sensor);
  return sensor;
}

double Length(const geometry_msgs::Vector3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

// About the IMU, with room for the sensors' axes and names.
void MeasureGuesses(Status* status) {
  constexpr double kLeastRadius = 0.2, kReaches = 1.6;  // m, of the farthest guess; from: structural
  double farthest = -1.0;
  for (const SensorStatus& sensor : status->sensors) {
    if (sensor.has_guess) farthest = std::max(farthest, Length(sensor.guess.translation));
  }
  if (farthest >= 0.0) status->map_radius = static_cast<float>(std::max(kLeastRadius, kReaches * farthest));
}

double LargestTranslationSigma(const std::vector<SensorStatus>& sensors) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const SensorStatus& sensor : sensors) {
    // fmax: the other one of a NaN.
    for (const double sigma : sensor.sigma_translation) {
      if (sensor.has_sigma) largest = std::fmax(largest, sigma);
    }
  }
  return largest;
}

// Mean of the points, and the radius that most of them lie within.
void MeasureMap(const std::vector<MapPoint>& points, Status* status) {
  if (points.empty()) return;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const MapPoint& point : points) center += point.position.cast<double>();
  center /= static_cast<double>(points.size());
  std::vector<float> distances;
  distances.reserve(points.size());
  for (const MapPoint& point : points) {
    distances.push_back((point.position - center.cast<float>()).norm());
  }
  const auto place = distances.begin() +
                     static_cast<std::ptrdiff_t>(kShareInside * static_cast<double>(distances.size() - 1));
  std::nth_element(distances.begin(), place, distances.end());
  status->map_center.x = center.x(), status->map_center.y = center.y(), status->map_center.z = center.z();
  status->map_radius = *place;
}

const char* NameOf(UnobservableDirection::Quantity quantity) {
  switch (quantity) {
    case UnobservableDirection::Quantity::kTranslation:
      return "translation";
    case UnobservableDirection::Quantity::kRotation:
      return "rotation";
    case UnobservableDirection::Quantity::kTimeOffset:
      return "time offset";
  }
  return "";
}

// What to know of a sensor that is given; empty: nothing.
std::string NoteOf(const SensorResult& sensor) {
  if (sensor.fixed) return "fixed as in the rig file";
  std::vector<std::string> held;
  for (const UnobservableDirection& direction : sensor.unobservable) {
    held.push_back("a direction of " + std::string(NameOf(direction.quantity)));
  }
  held.erase(std::unique(held.begin(), held.end()), held.end());
  return held.empty() ? "" : Joined(held, ", ") + " is not shown by the drive";
}

}  // namespace

StatusBoard::StatusBoard() {
  status_.state = Status::RUNNING;
  status_.stage = "starting";
  status_.seconds_left = -1.0f;
}

SensorStatus* StatusBoard::Find(const std::string& name) {
  for (SensorStatus& sensor : status_.sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

void StatusBoard::Put(const SensorStatus& sensor) {
  SensorStatus* known = Find(sensor.name);
  if (known == nullptr) {
    status_.sensors.push_back(sensor);
    return;
  }
  SensorStatus updated = sensor;
  updated.has_guess = known->has_guess;
  updated.guess = known->guess;
  *known = updated;
}

void StatusBoard::SetPlan(std::vector<PlannedStage> plan) {
  progress_ = RunProgress(std::move(plan));
  status_.stage_count = progress_.StageCount();
}

void StatusBoard::SetRig(const Rig& rig) {
  status_.sensors.clear();
  for (const LidarConfig& lidar : rig.lidars) status_.sensors.push_back(AsGiven(lidar, false));
  for (const CameraConfig& camera : rig.cameras) status_.sensors.push_back(AsGiven(camera, true));
  MeasureGuesses(&status_);
}

void StatusBoard::Tick(double now) {
  if (status_.state != Status::RUNNING) return;
  status_.stage_number = progress_.StageNumber();
  status_.run_progress = static_cast<float>(progress_.Done(now));
  status_.seconds_left = static_cast<float>(progress_.SecondsLeft(now).value_or(-1.0));
}

bool StatusBoard::SetProgress(const std::string& stage, double fraction, double now) {
  const bool is_new = stage != status_.stage;
  progress_.Report(stage, fraction, now);
  status_.stage = stage;
  status_.progress = static_cast<float>(fraction);
  Tick(now);
  return is_new;
}

void StatusBoard::AddSnapshot(const CalibrationSnapshot& snapshot) {
  if (!snapshot.after_solve) {  // the curves have no point of it, and the LiDARs keep their sigmas
    for (const SensorStatus& sensor : MakeSensorStatus(snapshot)) {
      if (sensor.is_camera) Put(sensor);
    }
    return;
  }
  status_.iteration = snapshot.iteration;
  status_.costs.push_back(snapshot.cost);
  const auto or_nan = [](std::optional<double> value) {
    return value.value_or(std::numeric_limits<double>::quiet_NaN());
  };
  status_.mean_squares.push_back(or_nan(snapshot.mean_square));
  status_.changes.push_back(or_nan(snapshot.change));
  status_.solve_stages.push_back(progress_.StageNumber());
  for (const SensorStatus& sensor : MakeSensorStatus(snapshot)) Put(sensor);
  status_.largest_sigmas.push_back(LargestTranslationSigma(status_.sensors));
  MeasureMap(snapshot.points, &status_);
}

void StatusBoard::SetResult(const CalibrationResult& result) {
  status_.state = result.Trusted() ? Status::TRUSTED : result.Usable() ? Status::PARTIAL : Status::REFUSED;
  status_.stage = "done";
  status_.progress = status_.run_progress = 1.0f;
  status_.stage_number = status_.stage_count;
  status_.seconds_left = 0.0f;
  status_.messages = result.reasons;
  status_.messages.insert(status_.messages.end(), result.warnings.begin(), result.warnings.end());
  for (const SensorStatus& sensor : MakeSensorStatus(result)) Put(sensor);
  for (const SensorResult& sensor : result.sensors) {
    SensorStatus* status = Find(sensor.name);
    status->reason = NoteOf(sensor);
    if (result.Usable()) status->state = sensor.fixed ? SensorStatus::HELD : SensorStatus::TRUSTED;
  }
  for (const RejectedSensor& rejected : result.rejected) {
    SensorStatus* status = Find(rejected.name);
    if (status == nullptr) continue;
    status->state = SensorStatus::REJECTED;
    status->reason = rejected.reason;
  }
  MeasureMap(result.map, &status_);
}

void StatusBoard::SetEnd(std::uint8_t state, const std::string& line) {
  status_.state = state;
  status_.messages = {line};
  status_.seconds_left = 0.0f;
}

}  // namespace mlic
