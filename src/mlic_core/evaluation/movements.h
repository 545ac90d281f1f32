#pragma once

#include <string>
#include <vector>

#include "mlic_core/result/result.h"

namespace mlic {

// Which bodies of a rig have moved between an earlier calibration and a later one, its check. Bodies are the
// IMU and the sensors; a relation is the pose of one of them to another, with the sigmas of both
// calibrations, sqrt(sigma_1^2 + sigma_2^2). All relations of a body that moved differ, also those that tell
// more than the one with the IMU (two LiDARs of a car see the same ground). So the bodies that moved are the
// fewest without which all relations agree: a smallest vertex cover of those that differ; of several, the one
// that leaves the least sum of squared differences. Clocks likewise, by their time offsets.

// How far one quantity of a body is from where it was.
struct Movement {
  double value = 0.0;   // rad, m, s; the length of a vector
  double sigmas = 0.0;  // of the axis that differs most in them; NaN: not checked
  double shown = 0.0;   // a movement by so much along any checked axis would have been told; NaN: none is
  std::vector<std::string> not_checked;  // axes of the relation's first body that are not shown
  bool told = false;                     // it moved
};

struct BodyMovement {
  std::string name;
  std::string
      against;  // a body that has not moved, by the relation with which this one is judged; empty: none
  Movement rotation, translation, clock;

  bool Moved() const { return rotation.told || translation.told; }
};

struct Movements {
  bool imu_moved = false;             // all sensors moved alike against it
  bool imu_clock_shifted = false;     // all offsets changed alike
  std::vector<BodyMovement> sensors;  // of both calibrations
  // Other bodies that may have moved instead of those told; the data tell no difference.
  std::vector<std::string> or_instead;
  double worst = 0.0;  // sigmas, of relations between bodies that have not moved
  std::string worst_of;
};

// The body that is no sensor, in Movements.
constexpr const char* kImuBody = "imu";

// limit: sigmas, by which a relation differs. Offsets whose sigma is NaN are not known and not compared.
Movements FindMovements(const CalibrationResult& check, const CalibrationResult& calibration, double limit);

// For people: degrees, millimetres, milliseconds; one line for each sensor.
std::string TableOf(const Movements& movements);
// One line for each sensor, header first; degrees, metres, seconds.
std::string CsvOf(const Movements& movements);
// What moved, and by how much; empty if nothing did.
std::string WhatMoved(const Movements& movements);

}  // namespace mlic
