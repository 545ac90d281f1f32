#include "mlic_ros/display/path_turning.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_ros/display/display_messages.h"
#include "mlic_ros/display/rig_markers.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr TimeNs kHalfSpan = 250'000'000;           // ns, before and after a pose
constexpr double kLeastScale = 5.0;                 // deg/s
constexpr double kShareWithinScale = 0.95;          // of the path; a single jolt does not make the rest dull
constexpr std::size_t kMostPlaces = 5000;           // of the line
constexpr double kLineWidth = 0.01;                 // of the path's extent
constexpr double kNarrowest = 0.06, kWidest = 0.3;  // m

constexpr std::uint32_t kStill = 0x5078a0, kTurning = 0xffe040;

std::uint32_t Between(std::uint32_t from, std::uint32_t to, double share, int shift) {
  const double a = from >> shift & 0xffu, b = to >> shift & 0xffu;
  return static_cast<std::uint32_t>(std::lround(a + share * (b - a))) << shift;
}

// The least of 1, 2, 5, 10, ... that is no less.
double RoundedUp(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (value <= digit * power * (1.0 + 1e-9)) return digit * power;
  }
  return 10.0 * power;
}

double Extent(const std::vector<StampedPose>& trajectory) {
  Eigen::Vector3d low = trajectory.front().pose.translation, high = low;
  for (const StampedPose& pose : trajectory) {
    low = low.cwiseMin(pose.pose.translation);
    high = high.cwiseMax(pose.pose.translation);
  }
  return (high - low).norm();
}

}  // namespace

PathTurning TurningAlong(const std::vector<StampedPose>& trajectory) {
  PathTurning turning;
  std::size_t before = 0, after = 0;
  for (const StampedPose& pose : trajectory) {
    while (trajectory[before].time < pose.time - kHalfSpan) ++before;
    while (after + 1 < trajectory.size() && trajectory[after].time < pose.time + kHalfSpan) ++after;
    const double seconds = 1e-9 * static_cast<double>(trajectory[after].time - trajectory[before].time);
    const double angle = AngleBetween(trajectory[before].pose.rotation, trajectory[after].pose.rotation);
    turning.rates.push_back(seconds > 0.0 ? angle / seconds : 0.0);
  }
  if (turning.rates.empty()) return turning;
  std::vector<double> sorted = turning.rates;
  const auto most = sorted.begin() +
                    static_cast<std::ptrdiff_t>(kShareWithinScale * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), most, sorted.end());
  turning.scale = RoundedUp(std::max(kLeastScale, kDegreesPerRadian * *most));
  return turning;
}

std::uint32_t ColourOfRate(double rate, double scale) {
  const double share = std::clamp(kDegreesPerRadian * rate / scale, 0.0, 1.0);
  return Between(kStill, kTurning, share, 16) | Between(kStill, kTurning, share, 8) |
         Between(kStill, kTurning, share, 0);
}

visualization_msgs::MarkerArray MakeTurningMarkers(const std::vector<StampedPose>& trajectory,
                                                   const PathTurning& turning, double clearance) {
  if (trajectory.empty()) return {};
  visualization_msgs::MarkerArray array = NoMarkers("map");  // of pieces that are no longer there
  visualization_msgs::Marker line;
  line.header.frame_id = "map";
  line.ns = "path";
  line.type = visualization_msgs::Marker::LINE_STRIP;
  line.action = visualization_msgs::Marker::ADD;
  line.pose.orientation.w = 1.0;
  line.scale.x = std::clamp(kLineWidth * Extent(trajectory), kNarrowest, kWidest);
  line.color.a = 1.0f;
  const auto end_piece = [&] {
    if (line.points.size() > 1) array.markers.push_back(line);
    line.id = static_cast<int>(array.markers.size());
    line.points.clear(), line.colors.clear();
  };
  const Eigen::Vector3d rig = trajectory.back().pose.translation;
  const std::size_t stride = (trajectory.size() + kMostPlaces - 1) / kMostPlaces;
  for (std::size_t k = 0; k < trajectory.size(); k += stride) {
    const Eigen::Vector3d& place = trajectory[k].pose.translation;
    if ((place - rig).norm() < clearance) {
      end_piece();
      continue;
    }
    line.points.push_back(ToPoint(place));
    line.colors.push_back(ToColour(ColourOfRate(turning.rates[k], turning.scale), 1.0f));
  }
  end_piece();
  return array;
}

}  // namespace mlic
