#include "mlic_sim/lidar_scanner.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated LiDARs.

using Eigen::Vector3d;

// Echoes nearer to each other than this merge into one range between them; farther apart, the receiver tells
// them apart and reports the stronger one.
constexpr double kPulseLength = 1.5;
constexpr double kEdgeStep = 0.08;  // m: smaller steps than this are not edges but slanted surfaces

struct Echo {
  double range = 0.0;
  double near_infrared = 0.0;
  double cos_incidence = 0.0;
};

Echo EchoOf(const World& world, const RayHit& hit, const Vector3d& direction) {
  const float near_infrared =
      NearInfraredOf(hit.material, hit.position, hit.normal, hit.object, world.infrared());
  return {hit.range, near_infrared, std::abs(hit.normal.dot(direction))};
}

// A direction within the beam's cone: the beam's light is not all on its axis.
Vector3d WithinBeam(const Vector3d& direction, double divergence, Random& random) {
  const Vector3d side = direction.unitOrthogonal(), up = direction.cross(side);
  const double angle = 2.0 * M_PI * random.Uniform(), radius = 0.5 * divergence * std::sqrt(random.Uniform());
  return (direction + radius * (std::cos(angle) * side + std::sin(angle) * up)).normalized();
}

// The echo of the whole beam: the axis' own, blended with that of another part of the beam where the two
// differ.
Echo BlendEdge(const World& world, const Echo& axis, const std::optional<RayHit>& other_hit,
               const Vector3d& other_direction, Random& random) {
  const double share = random.Uniform();
  if (!other_hit || std::abs(other_hit->range - axis.range) < kEdgeStep) return axis;
  const Echo other = EchoOf(world, *other_hit, other_direction);
  if (std::abs(other.range - axis.range) > kPulseLength) return share < 0.5 ? axis : other;
  return {axis.range + share * (other.range - axis.range),
          axis.near_infrared + share * (other.near_infrared - axis.near_infrared),
          axis.cos_incidence + share * (other.cos_incidence - axis.cos_incidence)};
}

// Chance that an echo is seen: logistic in the received power relative to what a perpendicular target of
// reflectance 0.1 sends back from range_at_10_percent.
double DetectionProbability(const LidarModel& model, const Echo& echo) {
  const double ratio = model.range_at_10_percent / echo.range;
  const double power = echo.near_infrared * echo.cos_incidence / 0.1 * ratio * ratio;
  return 1.0 / (1.0 + std::pow(std::max(power, 1e-9), -4.0));
}

// Growth of the range of an echo weaker than that of a perpendicular target of reflectance 0.5, m: receivers
// trigger on a pulse's edge, later the lower it is. Range falloff is taken for compensated.
double RangeWalk(const LidarModel& model, const Echo& echo) {
  constexpr double kReference = 0.5, kWeakest = 0.005;
  const double strength = std::max(kWeakest, echo.near_infrared * echo.cos_incidence);
  return -model.range_walk * std::log10(strength / kReference);
}

// Weather and network on the way of one scan's beams. Draws from generators of its own, so that the other
// noise of a drive stays what it is.
class Losses {
 public:
  Losses(const LidarModel& model, const std::optional<Random>& noise, std::size_t beams)
      : model_(model), rain_(noise.value_or(Random(0)).Fork(1)), packet_size_(beams / kPackets + 1) {
    if (!noise || model.packet_loss == 0.0) return;
    Random draw = noise->Fork(2);
    for (std::size_t i = 0; i < kPackets; ++i) lost_.push_back(draw.Uniform() < model.packet_loss);
  }

  bool IsLost(std::size_t beam) const { return !lost_.empty() && lost_[beam / packet_size_]; }

  // The drop that sends a beam back before `range` (m).
  std::optional<Echo> Drop(double range) {
    if (model_.rain == 0.0) return std::nullopt;
    constexpr double kReflectance = 0.04;
    const double drop = -std::log(1.0 - rain_.Uniform()) / model_.rain;
    if (drop > range || drop < model_.min_range) return std::nullopt;
    return Echo{drop, kReflectance, 1.0};
  }

 private:
  static constexpr std::size_t kPackets = 100;  // of one scan
  const LidarModel& model_;
  Random rain_;
  std::size_t packet_size_;
  std::vector<bool> lost_;
};

}  // namespace

double IntensityOf(double near_infrared, double cos_incidence, double range) {
  constexpr double kFalloffRange = 50.0;  // receivers compensate range in part
  const double falloff = 1.0 / (1.0 + (range / kFalloffRange) * (range / kFalloffRange));
  return std::clamp(255.0 * near_infrared * cos_incidence * falloff, 0.0, 255.0);
}

std::vector<SimulatedPoint> CastScan(const World& world, const Trajectory& trajectory,
                                     const RigidTransform& T_imu_lidar, const LidarModel& model,
                                     const std::vector<Firing>& firings, double start,
                                     std::optional<Random> noise) {
  const bool with_noise = noise.has_value();
  Random random = noise.value_or(Random(0));
  std::vector<SimulatedPoint> points(firings.size());
  const double divergence = model.beam_divergence_deg * kRadiansPerDegree;
  RigidTransform T_map_lidar;
  Eigen::Matrix3d R_map_lidar = Eigen::Matrix3d::Identity();
  double pose_time = std::nan("");
  Losses losses(model, noise, firings.size());
  for (std::size_t i = 0; i < firings.size(); ++i) {
    const Firing& firing = firings[i];
    SimulatedPoint& point = points[i];
    point.time = firing.time;
    point.ring = firing.ring;
    if (firing.time != pose_time) {
      T_map_lidar = trajectory.PoseAt(start + firing.time) * T_imu_lidar;
      R_map_lidar = T_map_lidar.rotation.toRotationMatrix();
      pose_time = firing.time;
    }
    const Vector3d direction = R_map_lidar * firing.direction;
    const Vector3d& origin = T_map_lidar.translation;
    const Vector3d other_direction = with_noise ? WithinBeam(direction, divergence, random) : direction;
    const double detection_draw = random.Uniform(), dropout_draw = random.Uniform();
    const double range_draw = random.Normal(), speckle_draw = random.Normal();
    const double time = start + firing.time;
    const std::optional<RayHit> hit = world.CastAt(time, origin, direction, model.max_range);
    if (!hit || hit->range < model.min_range) continue;
    Echo echo = EchoOf(world, *hit, direction);
    if (with_noise) {
      if (divergence > 0.0) {
        echo = BlendEdge(world, echo, world.CastAt(time, origin, other_direction, model.max_range),
                         other_direction, random);
      }
      if (losses.IsLost(i)) continue;
      if (const std::optional<Echo> drop = losses.Drop(echo.range)) echo = *drop;
      if (detection_draw > DetectionProbability(model, echo) || dropout_draw < model.random_dropouts)
        continue;
      echo.range += model.range_noise * range_draw;
      echo.near_infrared *= std::max(0.0, 1.0 + 0.04 * speckle_draw);
    }
    if (!model.ring_bias.empty()) echo.range += model.ring_bias[firing.ring];
    if (model.range_walk != 0.0) echo.range += RangeWalk(model, echo);
    point.position = (echo.range * firing.direction).cast<float>();
    point.intensity = static_cast<float>(IntensityOf(echo.near_infrared, echo.cos_incidence, echo.range));
    point.returned = true;
  }
  return points;
}

}  // namespace mlic::sim
