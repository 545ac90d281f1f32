#include "mlic_core/summary/ground.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

constexpr double kRadius = 2.5;           // m about a place, a vehicle's length; from: definition
constexpr double kSpacing = 1.0;          // m, between places; from: definition
constexpr std::size_t kMostPlaces = 300;  // from: guard
constexpr std::size_t kLeastPlaces = 3;   // from: definition
constexpr double kCell = 0.25;            // m, in which points count once; from: structural
constexpr double kLayer = 0.2;            // m, in height; from: structural
// m, what ground is off from a plane within the radius; from: guard, between a kerb and the noise of ranges
constexpr double kThickness = 0.05;
constexpr double kSteepest = 0.3;     // rad, against the horizon; from: guard, steeper than ramps
constexpr int kTries = 200;           // from: guard
constexpr int kLeastPatches = 40;     // of the 314 cells within the radius; from: guard
constexpr double kShareOfBest = 0.5;  // of the largest plane's area: more is no clutter; from: guard

using Patches = std::vector<Eigen::Vector3d>;

// The map's points by squares as wide as the radius.
class Tiles {
 public:
  explicit Tiles(const std::vector<MapPoint>& map) {
    for (const MapPoint& point : map) {
      const Eigen::Vector3d position = point.position.cast<double>();
      tiles_[{Index(position.x()), Index(position.y())}].push_back(position);
    }
  }

  // Mean points of cells and layers about a place and below it.
  Patches PatchesBelow(const Eigen::Vector3d& place) const {
    struct Sum {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
    };
    std::map<std::array<int, 3>, Sum> sums;
    for (int x = Index(place.x()) - 1; x <= Index(place.x()) + 1; ++x) {
      for (int y = Index(place.y()) - 1; y <= Index(place.y()) + 1; ++y) {
        const auto tile = tiles_.find({x, y});
        if (tile == tiles_.end()) continue;
        for (const Eigen::Vector3d& point : tile->second) {
          const Eigen::Vector3d off = point - place;
          if (off.z() > 0.0 || off.head<2>().norm() > kRadius) continue;
          Sum& sum = sums[{static_cast<int>(std::floor(off.x() / kCell)),
                           static_cast<int>(std::floor(off.y() / kCell)),
                           static_cast<int>(std::floor(off.z() / kLayer))}];
          sum.sum += off;
          ++sum.count;
        }
      }
    }
    Patches patches;
    for (const auto& [cell, sum] : sums) patches.push_back(sum.sum / sum.count);
    return patches;
  }

 private:
  static int Index(double coordinate) { return static_cast<int>(std::floor(coordinate / kRadius)); }

  std::map<std::pair<int, int>, std::vector<Eigen::Vector3d>> tiles_;
};

// z = slope . (x, y) + level, about a place.
struct Ground {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  double level = 0.0;

  double Above(const Eigen::Vector3d& point) const { return point.z() - level - slope.dot(point.head<2>()); }
  bool Has(const Eigen::Vector3d& point) const { return std::abs(Above(point)) < kThickness; }
};

int CountOn(const Ground& ground, const Patches& patches) {
  return static_cast<int>(
      std::count_if(patches.begin(), patches.end(), [&](const Eigen::Vector3d& p) { return ground.Has(p); }));
}

// Least squares through these points; none where they are on a line, or too steep.
std::optional<Ground> Fit(const Patches& patches) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : patches) {
    const Eigen::Vector3d row(p.x(), p.y(), 1.0);
    normal += row * row.transpose();
    right += row * p.z();
  }
  if (normal.determinant() < 1e-6) return std::nullopt;  // from: guard, m^4
  const Eigen::Vector3d solution = SolveSymmetric3(normal, right);
  const Ground ground{solution.head<2>(), solution.z()};
  if (ground.slope.norm() > std::tan(kSteepest)) return std::nullopt;
  return ground;
}

// The lowest plane that is large.
std::optional<Ground> FindGround(const Patches& patches, Random random) {
  if (patches.size() < static_cast<std::size_t>(kLeastPatches)) return std::nullopt;
  std::vector<std::pair<int, Ground>> tries;
  int most = 0;
  const auto any = [&] { return patches[random.Next() % patches.size()]; };
  for (int k = 0; k < kTries; ++k) {
    const std::optional<Ground> ground = Fit({any(), any(), any()});
    if (!ground) continue;
    tries.emplace_back(CountOn(*ground, patches), *ground);
    most = std::max(most, tries.back().first);
  }
  const std::pair<int, Ground>* lowest = nullptr;
  for (const auto& one : tries) {
    if (one.first < std::max(kLeastPatches, static_cast<int>(kShareOfBest * most))) continue;
    // Of those at about one height the one with most on it.
    const double lower = lowest == nullptr ? 1.0 : lowest->second.level - one.second.level;
    if (lower > kThickness || (lower > -kThickness && one.first > lowest->first)) lowest = &one;
  }
  if (lowest == nullptr) return std::nullopt;
  Ground ground = lowest->second;
  for (int round = 0; round < 3; ++round) {
    Patches on;
    std::copy_if(patches.begin(), patches.end(), std::back_inserter(on),
                 [&](const Eigen::Vector3d& p) { return ground.Has(p); });
    const std::optional<Ground> fitted = Fit(on);
    if (!fitted || on.size() < static_cast<std::size_t>(kLeastPatches)) return std::nullopt;
    ground = *fitted;
  }
  return ground;
}

std::vector<RigidTransform> PlacesOn(const std::vector<StampedPose>& trajectory) {
  std::vector<RigidTransform> places;
  for (const StampedPose& pose : trajectory) {
    const bool far = places.empty() || (pose.pose.translation - places.back().translation).norm() >= kSpacing;
    if (far) places.push_back(pose.pose);
  }
  const std::size_t stride = (places.size() + kMostPlaces - 1) / kMostPlaces;
  std::vector<RigidTransform> kept;
  for (std::size_t i = 0; i < places.size(); i += stride) kept.push_back(places[i]);
  return kept;
}

// R_ground_imu = Ry(pitch) Rx(roll), whose last row is `up`.
PoseOverGround::Angles AnglesOf(double height, const Eigen::Vector3d& up) {
  return {height, std::atan2(up.y(), up.z()), -std::asin(std::clamp(up.x(), -1.0, 1.0))};
}

// What the LiDARs' places and rotations on the IMU may be off, of the one known best.
PoseOverGround::Angles SigmaOfLidars(const std::vector<SensorResult>& sensors, const Eigen::Vector3d& up) {
  double height = INFINITY, rotation = INFINITY;
  for (const SensorResult& sensor : sensors) {
    if (sensor.type != SensorResult::Type::kLidar) continue;
    height = std::min(height, sensor.sigma.translation.cwiseProduct(up).norm());
    rotation = std::min(rotation, sensor.sigma.rotation.maxCoeff());
  }
  return {height, rotation, rotation};
}

}  // namespace

std::optional<PoseOverGround> FindPoseOverGround(const std::vector<StampedPose>& trajectory,
                                                 const std::vector<MapPoint>& map,
                                                 const std::vector<SensorResult>& sensors) {
  const Tiles tiles(map);
  std::vector<double> heights;
  std::vector<Eigen::Vector3d> ups;  // in the IMU's frame
  const std::vector<RigidTransform> places = PlacesOn(trajectory);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const std::optional<Ground> ground = FindGround(tiles.PatchesBelow(places[i].translation), Random(i));
    if (!ground) continue;
    const Eigen::Vector3d up = Eigen::Vector3d(-ground->slope.x(), -ground->slope.y(), 1.0).normalized();
    heights.push_back(-ground->level * up.z());
    ups.push_back(places[i].rotation.conjugate() * up);
  }
  if (heights.size() < kLeastPlaces) return std::nullopt;
  const auto count = static_cast<double>(heights.size());
  double height = 0.0;
  PoseOverGround found;
  found.up.setZero();
  for (std::size_t i = 0; i < heights.size(); ++i) {
    height += heights[i] / count;
    found.up += ups[i];
  }
  found.up.normalize();
  found.places = heights.size();
  found.mean = AnglesOf(height, found.up);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const PoseOverGround::Angles at = AnglesOf(heights[i], ups[i]);
    squares += Eigen::Vector3d(at.height - height, std::remainder(at.roll - found.mean.roll, 2.0 * M_PI),
                               at.pitch - found.mean.pitch)
                   .cwiseAbs2();
  }
  const Eigen::Vector3d scatter = (squares / (count - 1.0)).cwiseSqrt();
  found.scatter = {scatter[0], scatter[1], scatter[2]};
  // Places share ground within twice the radius.
  const double independent = std::max(1.0, count * kSpacing / (2.0 * kRadius));
  const PoseOverGround::Angles lidars = SigmaOfLidars(sensors, found.up);
  const auto sigma = [&](double of_mean, double of_lidars) {
    return std::hypot(of_mean / std::sqrt(independent), of_lidars);
  };
  found.sigma = {sigma(scatter[0], lidars.height), sigma(scatter[1], lidars.roll),
                 sigma(scatter[2], lidars.pitch)};
  return found;
}

}  // namespace mlic
