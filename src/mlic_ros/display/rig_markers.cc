#include "mlic_ros/display/rig_markers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mlic_ros/display/display_messages.h"
#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr double kLeastRig = 0.15;       // m, what the rig's size counts as at least
constexpr double kAxis = 0.25;           // of the rig's size
constexpr double kText = 0.08;           // likewise
constexpr double kTextRow = 1.1;         // of a text's height, what no other one is to be in
constexpr double kOverlayText = 0.06;    // of the map's radius
constexpr double kOverlayHeight = 1.05;  // likewise: above the map's far edge as the view comes
constexpr double kRadiusBefore = 12.0;   // m, before there is a map: that of the first view

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

std_msgs::ColorRGBA Colour(float red, float green, float blue, float alpha = 1.0f) {
  std_msgs::ColorRGBA colour;
  colour.r = red, colour.g = green, colour.b = blue, colour.a = alpha;
  return colour;
}

Eigen::Isometry3d ToPose(const geometry_msgs::Transform& transform) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << transform.translation.x, transform.translation.y, transform.translation.z;
  const geometry_msgs::Quaternion& q = transform.rotation;
  pose.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  return pose;
}

// With stamp zero and locked to its frame it moves along with the frame's latest pose.
Marker MakeMarker(const std::string& frame, const std::string& space, int type) {
  Marker marker;
  marker.header.frame_id = frame;
  marker.frame_locked = true;
  marker.ns = space;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.color = Colour(1.0f, 1.0f, 1.0f);
  return marker;
}

void AddLine(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const std_msgs::ColorRGBA& colour,
             Marker* lines) {
  for (const Eigen::Vector3d& end : {from, to}) {
    lines->points.push_back(ToPoint(end));
    lines->colors.push_back(colour);
  }
}

void AddAxes(const Eigen::Isometry3d& pose, double length, bool grey, Marker* lines) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto share = [&](int of) { return grey ? 0.55f : axis == of ? 1.0f : 0.25f; };
    AddLine(pose.translation(), pose.translation() + length * pose.linear().col(axis),
            Colour(share(0), share(1), share(2)), lines);
  }
}

// To the right and up on the screen, in the view with which RViz comes (rviz/mlic.rviz) and which turns with
// the IMU's axes until the rig is found.
Eigen::Vector2d OnScreen(const Eigen::Vector3d& p) {
  constexpr double kYaw = 4.0, kPitch = 0.75;  // rad
  const Eigen::Vector3d right(-std::sin(kYaw), std::cos(kYaw), 0.0);
  const Eigen::Vector3d up(-std::cos(kYaw) * std::sin(kPitch), -std::sin(kYaw) * std::sin(kPitch),
                           std::cos(kPitch));
  return {right.dot(p), up.dot(p)};
}

// Places of names in one another's way, as seen from the side or in the first view: those that would be are
// lifted along the IMU's z.
class NamePlaces {
 public:
  explicit NamePlaces(double text) : text_(text) {}
  Eigen::Vector3d Free(Eigen::Vector3d wanted) {
    constexpr double kWidth = 6.0, kHeight = 1.6;  // of the text's height; from: structural
    const auto in_the_way = [&](const Eigen::Vector3d& other) {
      const Eigen::Vector3d between = wanted - other;
      const Eigen::Vector2d seen = OnScreen(between);
      return (between.head<2>().norm() < kWidth * text_ && std::abs(between.z()) < kHeight * text_) ||
             (std::abs(seen.x()) < kWidth * text_ && std::abs(seen.y()) < kTextRow * text_);
    };
    while (std::any_of(taken_.begin(), taken_.end(), in_the_way)) wanted.z() += kHeight * text_;
    taken_.push_back(wanted);
    return wanted;
  }

 private:
  double text_;  // height, m
  std::vector<Eigen::Vector3d> taken_;
};

}  // namespace

MarkerArray NoMarkers(const std::string& frame) {
  MarkerArray array;
  array.markers.push_back(MakeMarker(frame, "", Marker::LINE_LIST));
  array.markers.back().action = Marker::DELETEALL;
  return array;
}

double RigSize(const std::vector<SensorStatus>& sensors) {
  double size = kLeastRig;
  for (const SensorStatus& sensor : sensors) {
    if (IsFound(sensor.state)) size = std::max(size, ToPose(sensor.transform).translation().norm());
    if (sensor.has_guess) size = std::max(size, ToPose(sensor.guess).translation().norm());
  }
  return size;
}

MarkerArray MakeRigMarkers(const Status& status, const std::string& imu_frame) {
  const double size = RigSize(status.sensors);
  Marker axes = MakeMarker(imu_frame, "sensors", Marker::LINE_LIST);
  Marker guesses = MakeMarker(imu_frame, "guesses", Marker::LINE_LIST);
  axes.scale.x = 0.02 * size;
  guesses.scale.x = 0.01 * size;
  MarkerArray array = NoMarkers(imu_frame);  // of sensors that are no longer shown
  const std_msgs::ColorRGBA grey = Colour(0.55f, 0.55f, 0.55f);
  NamePlaces places(kText * size);
  const auto name = [&](const std::string& text, const Eigen::Vector3d& place) -> Marker& {
    Marker label = MakeMarker(imu_frame, "names", Marker::TEXT_VIEW_FACING);
    label.id = static_cast<int>(array.markers.size());
    label.text = text;
    label.scale.z = kText * size;
    label.pose.position = ToPoint(places.Free(place));
    array.markers.push_back(label);
    return array.markers.back();
  };
  AddAxes(Eigen::Isometry3d::Identity(), 0.7 * kAxis * size, false, &axes);
  name("IMU", -kText * size * Eigen::Vector3d::UnitZ());
  for (const SensorStatus& sensor : status.sensors) {
    const bool found = IsFound(sensor.state);
    if (!found && !sensor.has_guess) continue;
    const Eigen::Isometry3d guess = ToPose(sensor.guess), pose = found ? ToPose(sensor.transform) : guess;
    // Outwards from the IMU, where the others' names are not.
    const Eigen::Vector3d& p = pose.translation();
    const Eigen::Vector3d outwards = p.norm() > 0.0 ? p.normalized() : Eigen::Vector3d::UnitZ();
    Marker& label = name(sensor.name, p + kText * size * outwards);
    if (found) {
      AddAxes(pose, kAxis * size, false, &axes);
    } else {
      label.color = grey;
    }
    if (!sensor.has_guess) continue;
    AddAxes(guess, kAxis * size, true, &guesses);
    if (found) AddLine(guess.translation(), p, grey, &guesses);
  }
  array.markers.push_back(axes);
  if (!guesses.points.empty()) array.markers.push_back(guesses);
  return array;
}

MarkerArray MakeOverlay(const Status& status) {
  MarkerArray array;
  const double radius = status.map_radius > 0.0f ? status.map_radius : kRadiusBefore;
  Marker text = MakeMarker("map", "overlay", Marker::TEXT_VIEW_FACING);
  text.text = StageLine(status);
  if (status.state == Status::RUNNING && !status.paused) {
    const std::size_t colon =
        text.text.find(": ");  // long names of stages would not fit beside their numbers
    if (colon != std::string::npos) text.text.replace(colon, 2, "\n");
    text.text += "\n" + ProgressLine(status);
  }
  if (status.paused) text.text = VerdictWord(status) + "\n" + text.text;
  if (const std::string shown = ShownRoundLine(status); !shown.empty()) text.text += "\n" + shown;
  const std::array<float, 3> colour = VerdictColour(status);
  text.color = Colour(colour[0], colour[1], colour[2]);
  text.scale.z = kOverlayText * radius;
  text.pose.position = status.map_center;
  text.pose.position.z += kOverlayHeight * radius;
  array.markers.push_back(text);
  return array;
}

}  // namespace mlic
