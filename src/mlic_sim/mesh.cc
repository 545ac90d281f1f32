#include "mlic_sim/mesh.h"

#include <cmath>

namespace mlic::sim {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::uint32_t Mesh::AddVertex(const Vector3d& p) {
  vertices_.push_back(p.cast<float>());
  return static_cast<std::uint32_t>(vertices_.size() - 1);
}

void Mesh::AddTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, Material material,
                       std::uint32_t object) {
  const std::uint32_t i = AddVertex(a), j = AddVertex(b), k = AddVertex(c);
  triangles_.push_back({{i, j, k}, material, object});
}

void Mesh::AddQuad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
                   Material material, std::uint32_t object) {
  const std::uint32_t i = AddVertex(a), j = AddVertex(b), k = AddVertex(c), l = AddVertex(d);
  triangles_.push_back({{i, j, k}, material, object});
  triangles_.push_back({{i, k, l}, material, object});
}

void Mesh::AddPrism(const Eigen::Isometry3d& T, const std::vector<Vector2d>& profile, double half_width,
                    Material material, std::uint32_t object) {
  const auto corner = [&](std::size_t i, double y) {
    const Vector2d& p = profile[i % profile.size()];
    return Vector3d(T * Vector3d(p.x(), y, p.y()));
  };
  for (std::size_t i = 0; i < profile.size(); ++i) {
    AddQuad(corner(i, -half_width), corner(i + 1, -half_width), corner(i + 1, half_width),
            corner(i, half_width), material, object);
  }
  for (std::size_t i = 1; i + 1 < profile.size(); ++i) {
    AddTriangle(corner(0, -half_width), corner(i, -half_width), corner(i + 1, -half_width), material, object);
    AddTriangle(corner(0, half_width), corner(i + 1, half_width), corner(i, half_width), material, object);
  }
}

void Mesh::AddBox(const Eigen::Isometry3d& T, const Vector3d& half, Material material, std::uint32_t object) {
  const double x = half.x(), z = half.z();
  AddPrism(T, {{-x, -z}, {x, -z}, {x, z}, {-x, z}}, half.y(), material, object);
}

void Mesh::AddBox(const Vector3d& low, const Vector3d& high, Material material, std::uint32_t object) {
  const Vector3d center = 0.5 * (low + high);
  AddBox(Upright(center.x(), center.y(), center.z(), 0.0), 0.5 * (high - low), material, object);
}

void Mesh::AddCylinder(const Eigen::Isometry3d& T, double radius, double height, int sides, Material material,
                       std::uint32_t object) {
  const Vector3d top = T * Vector3d(0, 0, height), bottom = T * Vector3d::Zero();
  for (int i = 0; i < sides; ++i) {
    const double a = 2.0 * M_PI * i / sides, b = 2.0 * M_PI * (i + 1) / sides;
    const auto rim = [&](double angle, double z) {
      return Vector3d(T * Vector3d(radius * std::cos(angle), radius * std::sin(angle), z));
    };
    AddQuad(rim(a, 0), rim(b, 0), rim(b, height), rim(a, height), material, object);
    AddTriangle(top, rim(a, height), rim(b, height), material, object);
    AddTriangle(bottom, rim(b, 0), rim(a, 0), material, object);
  }
}

void Mesh::AddHeightField(const Vector2d& low, const Vector2d& high, double step,
                          const std::function<double(double, double)>& height, Material material) {
  ground_height_ = height;
  const int columns = static_cast<int>(std::ceil((high.x() - low.x()) / step));
  const int rows = static_cast<int>(std::ceil((high.y() - low.y()) / step));
  const std::uint32_t first = static_cast<std::uint32_t>(vertices_.size());
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double x = low.x() + i * step, y = low.y() + j * step;
      AddVertex({x, y, height(x, y)});
    }
  }
  const std::uint32_t stride = static_cast<std::uint32_t>(columns + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j) {
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(columns); ++i) {
      const std::uint32_t a = first + j * stride + i;
      triangles_.push_back({{a, a + 1, a + stride + 1}, material, 0});
      triangles_.push_back({{a, a + stride + 1, a + stride}, material, 0});
    }
  }
}

void Mesh::Append(const Mesh& other, const Vector3d& offset) {
  const auto first = static_cast<std::uint32_t>(vertices_.size());
  for (const Eigen::Vector3f& v : other.vertices_) AddVertex(v.cast<double>() + offset);
  for (Triangle triangle : other.triangles_) {
    for (std::uint32_t& vertex : triangle.vertices) vertex += first;
    triangles_.push_back(triangle);
  }
}

Eigen::Isometry3d Upright(double x, double y, double z, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Vector3d(x, y, z)).rotate(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
  return T;
}

}  // namespace mlic::sim
