#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace mlic {

// A point of the map, m, as the cameras see it.
struct ColouredPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  std::array<std::uint8_t, 3> bgr{};
};

}  // namespace mlic
