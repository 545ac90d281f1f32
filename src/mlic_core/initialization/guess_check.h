#pragma once

#include <string>

#include "mlic_core/sensors/rig.h"

namespace mlic {

// What a result says of the guess that it started from.

// A LiDAR whose odometry told nothing starts from its guess alone. Planes pull it in from nearby, but from
// afar they may tie it to the wrong ones, and then they pull the other LiDARs with it: true where it has no
// guess or has moved more than two of the guess' sigmas away from it.
bool IsLostFromGuess(const LidarConfig& config, const RigidTransform& T_imu_lidar);

// One line for people why such a LiDAR is refused.
std::string WhyRejected(const LidarConfig& config);

// How far the result is from the guess about or along the worst axis, in the guess' sigmas.
double SigmasFromGuess(const ExtrinsicGuess& guess, const RigidTransform& T_imu_sensor);

// True where the result is more than four of the guess' sigmas away from it: then it was given the wrong way
// round, or for another sensor, and says nothing of what the data do not show either. As the guess pulled the
// result to itself, fewer right guesses are taken for wrong than the four sigmas say.
bool ContradictsGuess(const ExtrinsicGuess& guess, const RigidTransform& T_imu_sensor);

// Two sensors' guesses and what was found. Where the guesses fit the other way round: the root of by how much
// less they are off then, in squared sigmas; 0 where they do not fit, or not better. Guesses that are each
// for its own sensor come out at z or more by errors of z sigmas at the least, wherever the two sensors lie:
// (2 d^2 + z^2) / (2 sqrt(2) d) is never below z, with the distance d of the guesses.
double SigmasOfExchange(const ExtrinsicGuess& guess_a, const RigidTransform& T_imu_a,
                        const ExtrinsicGuess& guess_b, const RigidTransform& T_imu_b);

// From here on the topics of two sensors look exchanged. from: derivation, errors of 3 sigmas to one side are
// one in 700, and exchanged topics more common
constexpr double kLooksExchanged = 3.0;

constexpr double kFarFromGuess = 4.0;  // sigmas; from: derivation, 6 of 100000 normal errors lie beyond

// How far the result is from the guess, for people.
std::string DescribeDistance(const ExtrinsicGuess& guess, const RigidTransform& T_imu_sensor);

}  // namespace mlic
