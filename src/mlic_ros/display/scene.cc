#include "mlic_ros/display/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>

#include "mlic_core/common/order_statistics.h"
#include "mlic_ros/display/display_cameras.h"
#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr double kLargeResidual = 0.05;  // m, beyond which the colour is the same
constexpr double kLeastScatter = 1e-3;   // m, what points without noise count as
constexpr std::uint32_t kNoPlane = 0x808080;
constexpr std::uint32_t kPlainPlane = 0x6c7484;  // behind its points, whose colours say what there is to say

// Colours that keep apart on a dark ground; LiDARs and planes take them in turn.
constexpr std::array<std::uint32_t, 8> kColours{0x4dafff, 0xff7f0e, 0x5adc5a, 0xf05078,
                                                0xbe8cff, 0xffdc3c, 0x3cdcd2, 0xdcb496};

std::uint32_t InTurn(int index) {
  return kColours[static_cast<std::size_t>(std::max(0, index)) % kColours.size()];
}

// Blue before the plane, white on it, red behind.
std::uint32_t OfResidual(double residual) {
  const double share = std::clamp(residual / kLargeResidual, -1.0, 1.0);
  const auto rest = static_cast<std::uint32_t>(std::lround(235.0 * (1.0 - std::abs(share))));
  return share > 0.0 ? 0xff0000u + (rest << 8) + rest : (rest << 16) + (rest << 8) + 0xffu;
}

const PlanePatch* PlaneOf(const MapPoint& point, const Scene& scene) {
  const auto index = static_cast<std::size_t>(point.plane);
  return scene.planes_of_points && point.plane >= 0 && index < scene.planes.size() ? &scene.planes[index]
                                                                                   : nullptr;
}

double Residual(const MapPoint& point, const PlanePatch& plane) {
  return plane.normal.dot(point.position.cast<double>() - plane.center);
}

}  // namespace

void ThinOut(std::size_t most_points, Scene* scene) {
  const std::size_t stride = (scene->points.size() + most_points - 1) / most_points;
  if (stride <= 1) return;
  std::vector<MapPoint> thinned;
  for (std::size_t k = 0; k < scene->points.size(); k += stride) thinned.push_back(scene->points[k]);
  scene->points = std::move(thinned);
}

void RoundHistory::Add(Scene scene) {
  scene.round = ++rounds_;
  ThinOut(kMostPoints, &scene);
  if (scenes_.size() == kMostRounds) {
    std::vector<Scene> every_second;
    for (std::size_t k = 0; k < scenes_.size(); k += 2) every_second.push_back(std::move(scenes_[k]));
    scenes_ = std::move(every_second);
  }
  scenes_.push_back(std::move(scene));
}

const Scene* RoundHistory::At(int round) const {
  for (const Scene& scene : scenes_) {
    if (scene.round == round) return &scene;
  }
  return nullptr;
}

const Scene* RoundHistory::Find(const std::string& word, int shown) const {
  if (scenes_.empty() || word == "latest") return nullptr;
  if (word == "first") return &scenes_.front();
  // Seen from the latest state the last round is the previous one.
  const auto later = [](int round, const Scene& scene) { return round < scene.round; };
  if (word == "next") {
    const auto next = std::upper_bound(scenes_.begin(), scenes_.end(), shown, later);
    return shown == 0 || next == scenes_.end() ? nullptr : &*next;
  }
  const int wanted = word == "previous" ? (shown == 0 ? rounds_ : shown - 1) : std::atoi(word.c_str());
  const auto beyond = std::upper_bound(scenes_.begin(), scenes_.end(), wanted, later);
  return beyond == scenes_.begin() ? &scenes_.front() : &*(beyond - 1);
}

std::optional<Colouring> ColouringOf(const std::string& word) {
  for (const Colouring colouring : {Colouring::kSensor, Colouring::kResidual, Colouring::kPlane}) {
    if (word == NameOf(colouring)) return colouring;
  }
  return std::nullopt;
}

const char* NameOf(Colouring colouring) {
  switch (colouring) {
    case Colouring::kSensor:
      return "sensor";
    case Colouring::kResidual:
      return "residual";
    case Colouring::kPlane:
      return "plane";
  }
  return "";
}

std::vector<std::uint32_t> ColoursOf(const Scene& scene, Colouring colouring) {
  std::vector<std::uint32_t> colours;
  colours.reserve(scene.points.size());
  for (const MapPoint& point : scene.points) {
    const PlanePatch* plane = PlaneOf(point, scene);
    if (colouring == Colouring::kSensor) {
      colours.push_back(InTurn(point.lidar));
    } else if (colouring == Colouring::kPlane) {
      colours.push_back(point.plane < 0 ? kNoPlane : InTurn(point.plane));
    } else {
      colours.push_back(OfResidual(plane == nullptr ? 0.0 : Residual(point, *plane)));
    }
  }
  return colours;
}

namespace {

// By the rms of their points' residuals, beside that of most planes.
std::vector<std::uint32_t> ByResidual(const Scene& scene) {
  std::vector<double> squares(scene.planes.size(), 0.0);
  std::vector<int> counts(scene.planes.size(), 0);
  for (const MapPoint& point : scene.points) {
    const PlanePatch* plane = PlaneOf(point, scene);
    if (plane == nullptr) continue;
    const double residual = Residual(point, *plane);
    squares[static_cast<std::size_t>(point.plane)] += residual * residual;
    ++counts[static_cast<std::size_t>(point.plane)];
  }
  std::vector<double> scatters;
  for (std::size_t k = 0; k < squares.size(); ++k) {
    scatters.push_back(std::sqrt(squares[k] / std::max(1, counts[k])));
  }
  const double most = std::max(kLeastScatter, Median(scatters));
  std::vector<std::uint32_t> colours;
  for (const double scatter : scatters) {
    colours.push_back(
        OfResidual(kLargeResidual * std::max(0.0, scatter / most - 1.0) / (kLargeScatter - 1.0)));
  }
  return colours;
}

std::size_t LidarsWithPoints(const Scene& scene) {
  std::set<int> lidars;
  for (const MapPoint& point : scene.points) lidars.insert(point.lidar);
  return lidars.size();
}

}  // namespace

const Scene& RoundHistory::FirstOfAllLidars() const {
  return *std::max_element(scenes_.begin(), scenes_.end(), [](const Scene& a, const Scene& b) {
    return LidarsWithPoints(a) < LidarsWithPoints(b);
  });
}

std::vector<std::uint32_t> PlaneColours(const Scene& scene, Colouring colouring) {
  std::vector<std::uint32_t> colours(scene.planes.size(), kPlainPlane);
  if (!scene.planes_of_points || colouring == Colouring::kSensor) return colours;
  if (colouring == Colouring::kResidual) return ByResidual(scene);
  for (std::size_t k = 0; k < colours.size(); ++k) colours[k] = InTurn(static_cast<int>(k));
  return colours;
}

Scene WithoutHidden(const Scene& scene, const std::set<std::string>& hidden) {
  Scene visible = scene;
  if (hidden.empty()) return visible;
  const auto is_hidden = [&](const MapPoint& point) {
    const auto index = static_cast<std::size_t>(std::max(0, point.lidar));
    return index < scene.lidars.size() && hidden.count(scene.lidars[index]) > 0;
  };
  const auto end = std::remove_if(visible.points.begin(), visible.points.end(), is_hidden);
  visible.points.erase(end, visible.points.end());
  for (const SensorStatus& sensor : scene.sensors) {
    if (hidden.count(sensor.name) == 0) continue;
    for (visualization_msgs::Marker& marker : visible.frustums.markers) {
      if (marker.header.frame_id == sensor.frame_id) marker.action = visualization_msgs::Marker::DELETE;
    }
  }
  return visible;
}

Scene WithGuesses(const Scene& scene, const Scene& first) {
  Scene before = first;
  before.sensors = scene.sensors;
  before.landmarks = scene.landmarks;
  before.frustums = scene.frustums;
  for (SensorStatus& sensor : before.sensors) {
    if (sensor.has_guess && IsFound(sensor.state)) sensor.transform = sensor.guess;
  }
  return before;
}

void SetLegend(Colouring colouring, const Scene& scene, Status* status) {
  status->legend.clear();
  status->legend_colours.clear();
  const auto add = [&](const std::string& text, std::uint32_t colour) {
    status->legend.push_back(text);
    status->legend_colours.push_back(colour);
  };
  const std::string limit = std::to_string(std::lround(1e3 * kLargeResidual)) + " mm";
  switch (colouring) {
    case Colouring::kSensor:
      for (std::size_t k = 0; k < scene.lidars.size(); ++k) {
        add(scene.lidars[k], InTurn(static_cast<int>(k)));
      }
      break;
    case Colouring::kResidual:
      add("-" + limit, OfResidual(-kLargeResidual));
      add("on its plane", OfResidual(0.0));
      add("+" + limit, OfResidual(kLargeResidual));
      if (scene.planes_of_points && !scene.planes.empty()) {
        add("planes: " + std::to_string(std::lround(kLargeScatter)) + " times the usual scatter",
            OfResidual(kLargeResidual));
      }
      break;
    case Colouring::kPlane:
      add("planes in turn", InTurn(0));
      break;
  }
  if (!scene.landmarks.empty()) {
    add("landmarks on their pixels", ColourOfError(0.0f));
    add("off by " + std::to_string(std::lround(kLargeReprojectionError)) + " px or more",
        ColourOfError(kLargeReprojectionError));
  }
  if (scene.trajectory.empty()) return;
  const double scale = scene.turning.scale;
  add("path without a turn", ColourOfRate(0.0, scale));
  add("turning by " + std::to_string(std::lround(scale)) + " deg/s", ColourOfRate(scale, scale));
}

}  // namespace mlic
