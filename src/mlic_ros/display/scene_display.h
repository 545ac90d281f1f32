#pragma once

#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <set>
#include <string>

#include "mlic/Status.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_ros/display/scene.h"

namespace mlic {

// Whether a wish was fulfilled, and in one line what is so now, or why not.
struct Answer {
  bool success = false;
  std::string message;
};

// Publishes map, planes, trajectory, landmarks, frustums, frames and the rig's markers of the state that is
// looked at: the latest one or an earlier round. Not for several threads at once.
class SceneDisplay {
 public:
  SceneDisplay(const ros::NodeHandle& node, std::string frame_prefix);

  void SetRig(const Rig& rig);
  // Where the rig file has them, until there is a round.
  void ShowGuesses(const std::vector<SensorStatus>& sensors);
  void AddRound(Scene scene);
  void SetResult(Scene scene);

  Answer ShowSensor(const std::string& name) { return SetShown(name, true); }
  Answer HideSensor(const std::string& name) { return SetShown(name, false); }
  Answer ColourBy(const std::string& word);
  Answer GoToRound(const std::string& word);
  Answer SetBlinking(bool blinks);
  // The other one of the two that it blinks between.
  void Blink();

  // hidden, colour_by, legend, rounds, shown_round, blinks, frame_prefix.
  void Describe(Status* status) const;
  template <typename Message>
  void Publish(const ros::Publisher& publisher, Message message) const;

 private:
  Answer SetShown(const std::string& sensor, bool shown);
  // That is looked at, apart from blinking; none: there is nothing yet.
  const Scene* Chosen() const;
  void Show();
  void PublishRig(const Scene& scene);

  ros::NodeHandle node_;
  std::string frame_prefix_, imu_frame_ = "imu";
  ros::Publisher voxel_map_, voxel_map_points_, trajectory_, excitation_, rig_markers_;
  ros::Publisher landmarks_, cameras_;  // of a rig with cameras
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  RoundHistory history_;
  Scene latest_;
  bool has_any_ = false;
  std::set<std::string> sensors_, hidden_;
  Colouring colouring_ = Colouring::kSensor;
  int shown_round_ = 0;  // 0: the latest state
  bool blinks_ = false, shows_guess_ = false;
};

}  // namespace mlic
