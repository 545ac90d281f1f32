#include "mlic_sim/surface_textures.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mlic::sim::surface_textures_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kBrick = 0.25, kCourse = 0.077;  // m

// Sky light only: no shadows.
Lighting Overcast() {
  Lighting lighting;
  lighting.sun.setZero();
  return lighting;
}

// By how much the upright joints of a brick wall that begins at x = `begin` are displaced in the mean, m.
double MeanShiftOfJoints(float begin, float footprint) {
  Mesh mesh;
  mesh.AddQuad({begin, 3, 0}, {begin + 4, 3, 0}, {begin + 4, 3, 2}, {begin, 3, 2}, Material::kBrick, 0);
  const World world(std::move(mesh));
  const SurfaceTextures textures(world, Overcast());
  constexpr double kStep = 5e-4, kReach = 0.04, kBeside = 0.02;  // m
  double light = 0.0, albedo = 0.0, light_moment = 0.0, albedo_moment = 0.0, beside = 0.0;
  double places = 0.0, places_beside = 0.0;
  for (int course = 2; course < 24; course += 2) {
    for (int joint = -6; joint <= 6; ++joint) {
      for (double x = -kReach; x <= kReach + 0.5 * kStep; x += kStep) {
        const Vector3d p(kBrick * joint + x, 3.0, kCourse * (course + 0.5));
        const double seen = textures.Radiance(0, p.cast<float>(), Vector3f::UnitY(), footprint)[2];
        const double true_albedo = ReflectanceOf(Material::kBrick, p, -Vector3d::UnitY(), 0).albedo[2];
        light += seen, albedo += true_albedo;
        light_moment += x * seen, albedo_moment += x * true_albedo;
        places += 1.0;
        if (std::abs(x) > kBeside) beside += true_albedo, places_beside += 1.0;
      }
    }
  }
  const double of_joints = albedo - beside / places_beside * places;
  return (light_moment * albedo / light - albedo_moment) / of_joints;
}

TEST(SurfaceTextures, ShowAPatternAtOnePlaceFromNearAndFar) {
  for (const float begin : {-2.0f, -2.0009f, -2.0021f, -2.0033f}) {
    for (const float footprint : {0.003f, 0.0085f, 0.017f}) {
      EXPECT_LT(std::abs(MeanShiftOfJoints(begin, footprint)), 2e-4) << begin << " " << footprint;
    }
  }
}

}  // namespace
}  // namespace mlic::sim::surface_textures_test
