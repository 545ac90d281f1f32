#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace mlic {

// Times of the points of one revolution of a spinning LiDAR whose driver writes none: the azimuth passed
// since the start of the revolution, over a full turn, times the period. Direction and start are found from
// the order of the points, which must be the order of firing, within each ring or over all of them.
//
// rings: one for each point, or empty when unknown. Returns seconds after the start of the revolution, in
// [0, period]; 0 for points without a return (non-finite or at the origin). Good to some milliseconds: the
// lasers do not look in the same direction, and the rate is taken as constant. Returns nothing when the
// points do not look like a revolution: azimuth that covers less than 300 degrees or does not advance
// steadily.
std::optional<std::vector<float>> TimesFromAzimuth(const std::vector<Eigen::Vector3f>& points,
                                                   const std::vector<std::uint16_t>& rings, double period);

}  // namespace mlic
