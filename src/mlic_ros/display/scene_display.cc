#include "mlic_ros/display/scene_display.h"

#include <algorithm>
#include <utility>

#include "mlic_core/common/join.h"
#include "mlic_ros/display/display_cameras.h"
#include "mlic_ros/display/display_messages.h"
#include "mlic_ros/display/frame_prefix.h"
#include "mlic_ros/display/rig_markers.h"
#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

// Of a rig's size; m, m. from: structural, no path between the rig and who looks at a sensor of it
constexpr double kRigsClear = 3.5, kLeastClear = 0.6, kMostClear = 2.5;

}  // namespace

SceneDisplay::SceneDisplay(const ros::NodeHandle& node, std::string frame_prefix)
    : node_(node),
      frame_prefix_(std::move(frame_prefix)),
      voxel_map_(node_.advertise<visualization_msgs::MarkerArray>("/mlic/voxel_map", 1, true)),
      voxel_map_points_(node_.advertise<sensor_msgs::PointCloud2>("/mlic/voxel_map_points", 1, true)),
      trajectory_(node_.advertise<nav_msgs::Path>("/mlic/trajectory", 1, true)),
      excitation_(node_.advertise<visualization_msgs::MarkerArray>("/mlic/excitation", 1, true)),
      rig_markers_(node_.advertise<visualization_msgs::MarkerArray>("/mlic/rig", 1, true)) {}

template <typename Message>
void SceneDisplay::Publish(const ros::Publisher& publisher, Message message) const {
  AddFramePrefix(frame_prefix_, &message);
  publisher.publish(message);
}
template void SceneDisplay::Publish(const ros::Publisher&, visualization_msgs::MarkerArray) const;
template void SceneDisplay::Publish(const ros::Publisher&, sensor_msgs::Image) const;

void SceneDisplay::SetRig(const Rig& rig) {
  if (!rig.imu.frame_id.empty()) imu_frame_ = FrameName(rig.imu.frame_id, "imu");
  sensors_.clear();
  for (const LidarConfig& lidar : rig.lidars) sensors_.insert(lidar.name);
  for (const CameraConfig& camera : rig.cameras) sensors_.insert(camera.name);
  if (rig.cameras.empty()) return;
  landmarks_ = node_.advertise<sensor_msgs::PointCloud2>("/mlic/landmarks", 1, true);
  cameras_ = node_.advertise<visualization_msgs::MarkerArray>("/mlic/cameras", 1, true);
}

void SceneDisplay::ShowGuesses(const std::vector<SensorStatus>& sensors) {
  latest_.sensors = sensors;
  PublishRig(latest_);
}

void SceneDisplay::AddRound(Scene scene) {
  latest_ = scene;
  has_any_ = true;
  history_.Add(std::move(scene));
  latest_.round = history_.RoundCount();
  // The round that was looked at may have made room for others.
  const Scene* shown = shown_round_ == 0 ? nullptr : history_.Find(std::to_string(shown_round_), 0);
  shown_round_ = shown == nullptr ? 0 : shown->round;
  if (shown == nullptr) Show();
}

void SceneDisplay::SetResult(Scene scene) {
  scene.frustums = latest_.frustums;
  scene.landmarks = latest_.landmarks;
  scene.planes = latest_.planes;
  scene.planes_of_points = false;
  if (scene.points.empty()) {
    scene.points = latest_.points;
    scene.lidars = latest_.lidars;
    scene.planes_of_points = latest_.planes_of_points;
  }
  latest_ = std::move(scene);
  has_any_ = true;
  Show();
}

const Scene* SceneDisplay::Chosen() const {
  if (!has_any_) return nullptr;
  if (shown_round_ != 0) return history_.At(shown_round_);
  // Residuals are to the points' own planes, which the rounds have and the result has not.
  const bool last_round =
      colouring_ == Colouring::kResidual && !latest_.planes_of_points && !history_.Scenes().empty();
  return last_round ? &history_.Scenes().back() : &latest_;
}

void SceneDisplay::Show() {
  const Scene* chosen = Chosen();
  if (chosen == nullptr) return;
  Scene whole = shows_guess_ ? WithGuesses(*chosen, history_.FirstOfAllLidars()) : *chosen;
  // Else the map that has more points would stand out, and not what has changed.
  if (blinks_) ThinOut(RoundHistory::kMostPoints, &whole);
  const Scene scene = WithoutHidden(whole, hidden_);
  const ros::Time now = ros::Time::now();
  if (!scene.planes.empty()) {
    // Hidden LiDARs' points count, too: the planes are everybody's.
    Publish(voxel_map_, MakePlaneMarkers(scene.planes, PlaneColours(whole, colouring_), now));
  }
  if (!scene.lidars.empty()) {
    Publish(voxel_map_points_, MakeMapCloud(scene.points, ColoursOf(scene, colouring_), now));
  }
  if (!scene.trajectory.empty()) {
    Publish(trajectory_, MakePath(scene.trajectory, now));
    const double clearance = std::clamp(kRigsClear * RigSize(scene.sensors), kLeastClear, kMostClear);
    Publish(excitation_, MakeTurningMarkers(scene.trajectory, scene.turning, clearance));
  }
  if (landmarks_) Publish(landmarks_, MakeLandmarkCloud(scene.landmarks, now));
  if (cameras_) Publish(cameras_, scene.frustums.markers.empty() ? NoMarkers(imu_frame_) : scene.frustums);
  PublishRig(scene);
}

void SceneDisplay::PublishRig(const Scene& scene) {
  const ros::Time now = ros::Time::now();
  std::vector<geometry_msgs::TransformStamped> frames;
  const RigidTransform T_map_imu = scene.trajectory.empty() ? RigidTransform() : scene.trajectory.back().pose;
  frames.push_back(MakeFrame("map", imu_frame_, ToMessage(T_map_imu), now));
  Status shown;
  for (const SensorStatus& sensor : scene.sensors) {
    if (hidden_.count(sensor.name) == 0) shown.sensors.push_back(sensor);
    if (!IsFound(sensor.state) || sensor.frame_id == imu_frame_) continue;
    frames.push_back(MakeFrame(imu_frame_, sensor.frame_id, sensor.transform, now));
  }
  for (geometry_msgs::TransformStamped& frame : frames) AddFramePrefix(frame_prefix_, &frame);
  broadcaster_.sendTransform(frames);
  Publish(rig_markers_, MakeRigMarkers(shown, imu_frame_));
}

Answer SceneDisplay::SetShown(const std::string& sensor, bool shown) {
  if (sensors_.count(sensor) == 0) {
    return {false, "no sensor " + sensor + "; there are: " +
                       Joined(std::vector<std::string>(sensors_.begin(), sensors_.end()), ", ")};
  }
  if (shown) {
    hidden_.erase(sensor);
  } else {
    hidden_.insert(sensor);
  }
  Show();
  return {true, sensor + (shown ? " is shown" : " is hidden")};
}

Answer SceneDisplay::ColourBy(const std::string& word) {
  const std::optional<Colouring> colouring = ColouringOf(word);
  if (!colouring) return {false, "no colouring " + word + "; there are: sensor, residual, plane"};
  colouring_ = *colouring;
  Show();
  return {true, "coloured by " + word};
}

Answer SceneDisplay::GoToRound(const std::string& word) {
  const bool number = !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
  const std::set<std::string> words{"first", "previous", "next", "latest"};
  if (!number && words.count(word) == 0) {
    return {false, "no round " + word + "; there are: first, previous, next, latest, and numbers"};
  }
  if (history_.Scenes().empty()) return {false, "there is no round yet"};
  const Scene* scene = history_.Find(word, shown_round_);
  shown_round_ = scene == nullptr ? 0 : scene->round;
  Show();
  return {true, scene == nullptr ? "the latest state is shown"
                                 : "round " + std::to_string(shown_round_) + " is shown"};
}

Answer SceneDisplay::SetBlinking(bool blinks) {
  if (blinks && history_.Scenes().empty()) return {false, "there is no round yet"};
  blinks_ = blinks;
  shows_guess_ = false;
  Show();
  return {true, blinks ? "guess and first map by turns with what is shown" : "blinking has ended"};
}

void SceneDisplay::Blink() {
  if (!blinks_) return;
  shows_guess_ = !shows_guess_;
  Show();
}

void SceneDisplay::Describe(Status* status) const {
  status->frame_prefix = frame_prefix_;
  status->hidden.assign(hidden_.begin(), hidden_.end());
  status->colour_by = NameOf(colouring_);
  const Scene* chosen = Chosen();
  if (chosen != nullptr) SetLegend(colouring_, *chosen, status);
  status->rounds = history_.RoundCount();
  status->shown_round = shown_round_;
  status->blinks = blinks_;
}

}  // namespace mlic
