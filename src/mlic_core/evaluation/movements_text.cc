// The part of movements.h for people.
#include <cmath>
#include <cstdio>
#include <utility>

#include "mlic_core/common/angles.h"
#include "mlic_core/common/join.h"
#include "mlic_core/common/padded.h"
#include "mlic_core/evaluation/movements.h"

namespace mlic {
namespace {

// Value, sigmas and what would have been told, or dashes.
std::string Columns(const Movement& movement, double factor, int decimals) {
  char text[80];
  if (std::isnan(movement.sigmas)) {
    std::snprintf(text, sizeof(text), " %9s %6s %8s", "-", "-", "-");
  } else if (std::isnan(movement.shown)) {
    std::snprintf(text, sizeof(text), " %9.*f %6.1f %8s", decimals, factor * movement.value, movement.sigmas,
                  "-");
  } else {
    std::snprintf(text, sizeof(text), " %9.*f %6.1f %8.*f", decimals, factor * movement.value,
                  movement.sigmas, decimals, factor * movement.shown);
  }
  return text;
}

std::string Finding(const BodyMovement& body) {
  std::string finding = body.Moved() ? "MOVED" : body.against.empty() ? "not checked" : "agrees";
  if (body.clock.told) finding += ", CLOCK SHIFTED";
  std::vector<std::string> open;
  if (!body.against.empty()) {
    for (const std::string& axis : body.rotation.not_checked) open.push_back("rotation " + axis);
    for (const std::string& axis : body.translation.not_checked) open.push_back("translation " + axis);
    if (std::isnan(body.clock.shown)) open.emplace_back("offset");
  }
  if (!open.empty()) finding += "; not checked: " + Joined(open);
  return finding;
}

}  // namespace

std::string TableOf(const Movements& movements) {
  std::string table = Padded("", 24) +
                      "   rotation, deg           translation, mm         time offset, ms\n" +
                      Padded("sensor", 24) +
                      "     moved  sigma    shown     moved  sigma    shown     moved  sigma    shown  "
                      "against           finding\n";
  for (const BodyMovement& body : movements.sensors) {
    table += Padded(body.name, 24) + Columns(body.rotation, kDegreesPerRadian, 4) +
             Columns(body.translation, 1e3, 2) + Columns(body.clock, 1e3, 4) + "  " +
             Padded(body.against.empty() ? "-" : body.against, 18) + Finding(body) + "\n";
  }
  return table;
}

std::string CsvOf(const Movements& movements) {
  std::string csv =
      "sensor,against,moved,clock_shifted,rotation_deg,rotation_sigmas,rotation_shown_deg,translation,"
      "translation_sigmas,translation_shown,time_offset,time_offset_sigmas,time_offset_shown\n";
  for (const BodyMovement& body : movements.sensors) {
    csv += body.name + "," + body.against + "," + (body.Moved() ? "1" : "0") + "," +
           (body.clock.told ? "1" : "0");
    const std::pair<const Movement*, double> columns[] = {
        {&body.rotation, kDegreesPerRadian}, {&body.translation, 1.0}, {&body.clock, 1.0}};
    for (const auto& [movement, factor] : columns) {
      for (const double value : {factor * movement->value, movement->sigmas, factor * movement->shown}) {
        char text[32];
        std::snprintf(text, sizeof(text), ",%.9g", value);
        csv += std::isnan(value) ? ",nan" : text;  // whose sign depends on the compiler
      }
    }
    csv += "\n";
  }
  return csv;
}

std::string WhatMoved(const Movements& movements) {
  std::vector<std::string> moved;
  if (movements.imu_moved) moved.emplace_back("imu (all sensors moved alike against it)");
  if (movements.imu_clock_shifted) moved.emplace_back("the imu's clock (all offsets changed alike)");
  for (const BodyMovement& body : movements.sensors) {
    char text[120];
    std::vector<std::string> by;
    if (body.rotation.told) {
      std::snprintf(text, sizeof(text), "%.3f deg (%.0f sigma)", kDegreesPerRadian * body.rotation.value,
                    body.rotation.sigmas);
      by.emplace_back(text);
    }
    if (body.translation.told) {
      std::snprintf(text, sizeof(text), "%.1f mm (%.0f sigma)", 1e3 * body.translation.value,
                    body.translation.sigmas);
      by.emplace_back(text);
    }
    if (body.clock.told) {
      std::snprintf(text, sizeof(text), "%.3f ms (%.0f sigma)", 1e3 * body.clock.value, body.clock.sigmas);
      by.emplace_back(text);
    }
    if (!by.empty()) moved.push_back(body.name + " by " + Joined(by));
  }
  std::string text = Joined(moved, "; ");
  if (!text.empty() && !movements.or_instead.empty()) {
    text += "; or instead: " + Joined(movements.or_instead) + ", which the drive does not tell apart";
  }
  return text;
}

}  // namespace mlic
