#include "mlic_sim/lighting.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mlic_sim/procedural_noise.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated light.

using Eigen::Vector3f;

constexpr float kFar = 200.0f;
constexpr float kLift = 4e-3f;  // m: rays start above the surface
constexpr int kAmbientRays = 40;

// Directions about +z with density proportional to the cosine (a Fibonacci spiral on the disc, lifted).
const std::array<Vector3f, kAmbientRays>& AmbientDirections() {
  static const std::array<Vector3f, kAmbientRays> directions = [] {
    std::array<Vector3f, kAmbientRays> d;
    for (int i = 0; i < kAmbientRays; ++i) {
      const double radius = std::sqrt((i + 0.5) / kAmbientRays), angle = 2.399963229728653 * i;
      d[i] = Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                             std::sqrt(1.0 - radius * radius))
                 .cast<float>();
    }
    return d;
  }();
  return directions;
}

}  // namespace

Lighting YardLighting() {
  Lighting lighting;
  lighting.to_sun.normalize();
  return lighting;
}

Lighting HallLighting() {
  Lighting lighting;
  lighting.outdoors = false;
  lighting.bounce = Vector3f(0.16f, 0.155f, 0.145f);
  for (float x : {-9.5f, -5.7f, 0.0f, 5.7f, 9.5f}) {
    for (float y : {-4.2f, 4.2f}) lighting.lamps.emplace_back(x, y, 5.3f);
  }
  return lighting;
}

Vector3f SkyRadiance(const Lighting& lighting, const Vector3f& direction) {
  if (!lighting.outdoors) return Vector3f(0.02f, 0.02f, 0.02f);
  const float up = std::max(0.0f, direction.z());
  const Vector3f horizon(0.62f, 0.68f, 0.76f), zenith(0.24f, 0.40f, 0.68f);
  Vector3f sky = horizon + std::sqrt(up) * (zenith - horizon);
  if (direction.z() > 0.03f) {
    // Clouds on a plane far above.
    const Eigen::Vector3d place(direction.x() / (direction.z() + 0.12f),
                                direction.y() / (direction.z() + 0.12f), 0.0);
    const float cloud =
        std::clamp(static_cast<float>(2.6 * (Fractal(place, 1.1, 4, 201) - 0.5)), 0.0f, 0.75f);
    sky += cloud * (Vector3f(0.92f, 0.93f, 0.95f) - sky);
  }
  return sky;
}

Vector3f AmbientLight(const World& world, const Lighting& lighting, const Vector3f& p,
                      const Vector3f& normal) {
  const Vector3f side = normal.unitOrthogonal(), other = normal.cross(side);
  const Vector3f origin = p + kLift * normal;
  // Indoors the ceiling shuts everything out: only what is near darkens a corner.
  const float reach = lighting.outdoors ? kFar : 1.5f;
  const Vector3f open(0.19f, 0.185f, 0.175f);
  Vector3f sum = Vector3f::Zero();
  for (const Vector3f& d : AmbientDirections()) {
    const Vector3f direction = d.x() * side + d.y() * other + d.z() * normal;
    if (lighting.outdoors && direction.z() < -0.02f) {
      sum += lighting.bounce;
    } else if (world.IsOccluded(origin, direction, reach)) {
      sum += lighting.outdoors ? lighting.bounce : Vector3f(0.3f * lighting.bounce);
    } else {
      sum += lighting.outdoors
                 ? Vector3f(0.55f * (Vector3f(0.62f, 0.68f, 0.76f) +
                                     std::sqrt(std::max(0.0f, direction.z())) * Vector3f(-0.3f, -0.2f, 0.0f)))
                 : open;
    }
  }
  return sum / static_cast<float>(kAmbientRays);
}

Vector3f DirectLight(const World& world, const Lighting& lighting, const Vector3f& p,
                     const Vector3f& normal) {
  const Vector3f origin = p + kLift * normal;
  if (lighting.outdoors) {
    const float facing = normal.dot(lighting.to_sun);
    if (facing <= 0.0f || world.IsOccluded(origin, lighting.to_sun, kFar)) return Vector3f::Zero();
    return facing * lighting.sun;
  }
  float sum = 0.0f;
  for (const Vector3f& lamp : lighting.lamps) {
    const Vector3f to_lamp = lamp - origin;
    const float distance = to_lamp.norm(), facing = normal.dot(to_lamp) / distance;
    if (facing <= 0.0f || world.IsOccluded(origin, to_lamp / distance, distance - 0.05f)) continue;
    sum += facing / (distance * distance);
  }
  return sum * lighting.lamp;
}

}  // namespace mlic::sim
