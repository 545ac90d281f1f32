#include "mlic_sim/lidar_model.h"

#include <cmath>

#include "mlic_core/common/angles.h"

namespace mlic::sim {
namespace {

using Eigen::Vector3d;

Vector3d Direction(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

std::vector<Firing> Spinning(const LidarModel& m) {
  std::vector<Firing> firings;
  firings.reserve(static_cast<std::size_t>(m.azimuth_steps) * m.rings);
  const double low = m.vertical_fov_deg[0] * kRadiansPerDegree,
               high = m.vertical_fov_deg[1] * kRadiansPerDegree;
  for (int step = 0; step < m.azimuth_steps; ++step) {
    for (int ring = 0; ring < m.rings; ++ring) {
      const double within = m.simultaneous_rings ? 0.0 : static_cast<double>(ring) / m.rings;
      const double turn = (step + within) / m.azimuth_steps;
      const double elevation = m.rings == 1 ? 0.5 * (low + high) : low + (high - low) * ring / (m.rings - 1);
      firings.push_back({turn * m.Period(), Direction((m.clockwise ? -2.0 : 2.0) * M_PI * turn, elevation),
                         static_cast<std::uint16_t>(ring)});
    }
  }
  return firings;
}

std::vector<Firing> Raster(const LidarModel& m) {
  std::vector<Firing> firings;
  const std::size_t count = static_cast<std::size_t>(m.rows) * m.columns;
  firings.reserve(count);
  for (int row = 0; row < m.rows; ++row) {
    const double elevation = m.fov_deg[1] * kRadiansPerDegree * ((row + 0.5) / m.rows - 0.5);
    for (int i = 0; i < m.columns; ++i) {
      const int column = row % 2 == 0 ? i : m.columns - 1 - i;
      const double azimuth = m.fov_deg[0] * kRadiansPerDegree * ((column + 0.5) / m.columns - 0.5);
      firings.push_back({m.Period() * static_cast<double>(firings.size()) / static_cast<double>(count),
                         Direction(azimuth, elevation), static_cast<std::uint16_t>(row)});
    }
  }
  return firings;
}

std::vector<Firing> Rosette(const LidarModel& m, std::int64_t index) {
  std::vector<Firing> firings;
  firings.reserve(static_cast<std::size_t>(m.points_per_scan));
  const double deflection = 0.25 * m.cone_fov_deg * kRadiansPerDegree;  // of each of the two prisms
  for (int i = 0; i < m.points_per_scan; ++i) {
    const double time = m.Period() * i / m.points_per_scan;
    const double t = time + m.Period() * static_cast<double>(index);
    const double a = 2.0 * M_PI * std::fmod(m.prism_rates_hz[0] * t, 1.0);
    const double b = 2.0 * M_PI * std::fmod(m.prism_rates_hz[1] * t, 1.0);
    const double u = deflection * (std::cos(a) + std::cos(b)), v = deflection * (std::sin(a) + std::sin(b));
    const double angle = std::hypot(u, v), ratio = angle < 1e-9 ? 1.0 : std::sin(angle) / angle;
    firings.push_back({time, Vector3d(std::cos(angle), ratio * u, ratio * v), 0});
  }
  return firings;
}

}  // namespace

std::vector<Firing> MakeScanPattern(const LidarModel& model, std::int64_t index) {
  std::vector<Firing> firings;
  switch (model.kind) {
    case ScanPatternKind::kSpinning:
      firings = Spinning(model);
      break;
    case ScanPatternKind::kRaster:
      firings = Raster(model);
      break;
    case ScanPatternKind::kRosette:
      firings = Rosette(model, index);
      break;
  }
  const Eigen::Matrix3d R = model.R_sensor_pattern.toRotationMatrix();
  for (Firing& firing : firings) firing.direction = (R * firing.direction).normalized();
  return firings;
}

}  // namespace mlic::sim
