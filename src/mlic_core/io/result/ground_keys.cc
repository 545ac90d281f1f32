#include "mlic_core/io/result/ground_keys.h"

#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// Without the brace that closes it.
std::string AnglesText(const PoseOverGround::Angles& angles) {
  return "{height: " + FixedNumber(angles.height, 5) +
         ", roll_deg: " + FixedNumber(kDegreesPerRadian * angles.roll, 4) +
         ", pitch_deg: " + FixedNumber(kDegreesPerRadian * angles.pitch, 4);
}

PoseOverGround::Angles ReadAngles(const YamlReader& node) {
  const auto number = [&](const char* key) { return node.Get(key, "give a number").Number(); };
  return {number("height"), number("roll_deg") / kDegreesPerRadian, number("pitch_deg") / kDegreesPerRadian};
}

}  // namespace

std::string GroundText(const std::optional<PoseOverGround>& ground) {
  if (!ground) return "";
  return "ground: " + AnglesText(ground->mean) + ", up: [" + FixedNumber(ground->up.x(), 6) + ", " +
         FixedNumber(ground->up.y(), 6) + ", " + FixedNumber(ground->up.z(), 6) +
         "],\n         sigma: " + AnglesText(ground->sigma) + "}, scatter: " + AnglesText(ground->scatter) +
         "}, places: " + std::to_string(ground->places) + "}  # of the IMU over the ground\n";
}

std::optional<PoseOverGround> ReadGround(const YamlReader& root) {
  if (!root.Has("ground")) return std::nullopt;
  const YamlReader node = root.Get("ground");
  PoseOverGround ground;
  ground.mean = ReadAngles(node);
  ground.sigma = ReadAngles(node.Get("sigma", "give height, roll_deg and pitch_deg"));
  ground.scatter = ReadAngles(node.Get("scatter", "give height, roll_deg and pitch_deg"));
  ground.up = node.Get("up", "give a unit vector").Vector3("of a unit vector");
  ground.places = static_cast<std::size_t>(node.Get("places", "give a number").Number());
  return ground;
}

}  // namespace mlic
