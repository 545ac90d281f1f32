#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace mlic::sim {

// What a surface is made of. Its look is a procedural function of the place, so that there is detail at every
// scale from a centimetre to metres without any image.
enum class Material : std::uint8_t {
  kYardGround,  // asphalt with repairs, parking stripes, zebra crossings and arrows
  kKerb,
  kBrick,
  kPlaster,
  kConcrete,
  kGlass,
  kWindowFrame,
  kDoor,
  kRoofTiles,
  kMetal,
  kCarPaint,
  kRubber,
  kBark,
  kFoliage,
  kHallFloor,
  kHallWall,  // painted, with posters
  kWood,
  kCardboard,
  kSignBoard,
  kAsphalt,  // without the yard's markings
  kGrass
};

// What a world's ground is made of.
inline bool IsGround(Material material) {
  return material == Material::kYardGround || material == Material::kAsphalt || material == Material::kGrass;
}

// Shares of light that a surface sends back, 0 to 1: visible red, green, blue, and near infrared at the
// LiDARs' wavelength. The two are related (a stain or a joint shows in both) but not proportional: paint,
// foliage and glass differ.
struct Reflectance {
  Eigen::Vector3f albedo = Eigen::Vector3f::Constant(0.5f);
  float near_infrared = 0.5f;
};

// How a world's near infrared goes with its visible light.
enum class InfraredLook : std::uint8_t {
  kRelated,      // what is bright to the eye is mostly bright to a LiDAR
  kInvertedHalf  // on every other object and material it is the other way round: 1 - reflectance
};

// p: place in the map frame, m; normal: unit, either sign; object: tells objects of one material apart (the
// colour of a car or a poster). A pure function.
Reflectance ReflectanceOf(Material material, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                          std::uint32_t object);

// What the LiDARs see of it in a world of the given look.
float NearInfraredOf(Material material, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                     std::uint32_t object, InfraredLook look);

}  // namespace mlic::sim
