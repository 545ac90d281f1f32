#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "mlic_sim/material.h"

namespace mlic::sim {

struct Triangle {
  std::array<std::uint32_t, 3> vertices;
  Material material;
  std::uint32_t object;
};

// A triangle soup with materials. Metres, map frame. Vertices are floats because Embree's are.
class Mesh {
 public:
  void AddTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   Material material, std::uint32_t object = 0);
  // Corners in order around the quadrilateral.
  void AddQuad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
               const Eigen::Vector3d& d, Material material, std::uint32_t object = 0);
  // A box from -half to +half in its own frame.
  void AddBox(const Eigen::Isometry3d& T_map_box, const Eigen::Vector3d& half, Material material,
              std::uint32_t object = 0);
  // A box between two corners, edges along the axes.
  void AddBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high, Material material,
              std::uint32_t object = 0);
  // A prism: a polygon in the (x, z) plane of its own frame, extruded from y = -half_width to +half_width.
  void AddPrism(const Eigen::Isometry3d& T_map_prism, const std::vector<Eigen::Vector2d>& profile,
                double half_width, Material material, std::uint32_t object = 0);
  // A closed cylinder about the z axis of its own frame, from z = 0 to height.
  void AddCylinder(const Eigen::Isometry3d& T_map_cylinder, double radius, double height, int sides,
                   Material material, std::uint32_t object = 0);
  // A height field over a rectangle, sampled every `step` metres: the ground.
  void AddHeightField(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double step,
                      const std::function<double(double, double)>& height, Material material);

  // All of another mesh, moved; not what it knows of the ground.
  void Append(const Mesh& other, const Eigen::Vector3d& offset);

  const std::vector<Eigen::Vector3f>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  // Height of the ground at (x, y), m; none where it is level.
  const std::function<double(double, double)>& ground_height() const { return ground_height_; }

 private:
  std::uint32_t AddVertex(const Eigen::Vector3d& p);

  std::vector<Eigen::Vector3f> vertices_;
  std::vector<Triangle> triangles_;
  std::function<double(double, double)> ground_height_;
};

// The pose of an object that stands at (x, y, z), turned by yaw (rad).
Eigen::Isometry3d Upright(double x, double y, double z, double yaw);

}  // namespace mlic::sim
