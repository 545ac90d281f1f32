#include "mlic_sim/procedural_noise.h"

namespace mlic::sim {
namespace {

// Integer hash to 0..1 (the finaliser of MurmurHash3).
double Hash(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8DA6B343u ^
                    static_cast<std::uint32_t>(y) * 0xD8163841u ^
                    static_cast<std::uint32_t>(z) * 0xCB1AB31Fu ^ seed * 0x9E3779B9u;
  h ^= h >> 16;
  h *= 0x85EBCA6Bu;
  h ^= h >> 13;
  h *= 0xC2B2AE35u;
  h ^= h >> 16;
  return h * (1.0 / 4294967296.0);
}

double Smooth(double u) { return u * u * (3.0 - 2.0 * u); }

// std::floor calls a function where the processor's rounding instructions may not be used.
std::int32_t Floor(double x) {
  const auto i = static_cast<std::int32_t>(x);
  return i - static_cast<std::int32_t>(x < static_cast<double>(i));
}

double Lattice(const Eigen::Vector3d& p, std::uint32_t seed) {
  const std::int32_t x = Floor(p.x()), y = Floor(p.y()), z = Floor(p.z());
  const double u = Smooth(p.x() - x), v = Smooth(p.y() - y), w = Smooth(p.z() - z);
  const auto along_x = [&](int dy, int dz) {
    return (1.0 - u) * Hash(x, y + dy, z + dz, seed) + u * Hash(x + 1, y + dy, z + dz, seed);
  };
  const double low = (1.0 - v) * along_x(0, 0) + v * along_x(1, 0);
  const double high = (1.0 - v) * along_x(0, 1) + v * along_x(1, 1);
  return (1.0 - w) * low + w * high;
}

}  // namespace

double Fractal(const Eigen::Vector3d& p, double size, int octaves, std::uint32_t seed) {
  double sum = 0.0, weight = 0.0, amplitude = 1.0, frequency = 1.0 / size;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * Lattice(p * frequency, seed + 1000u * i);
    weight += amplitude;
    amplitude *= 0.55;
    frequency *= 2.03;
  }
  return sum / weight;
}

double Cell(const Eigen::Vector2d& p, std::uint32_t seed) {
  return Hash(Floor(p.x()), Floor(p.y()), 0, seed);
}

}  // namespace mlic::sim
