#include "mlic_core/io/report/report_data.h"

#include <cmath>
#include <vector>

#include "mlic_core/common/angles.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

// A string of JSON; < as an escape, lest it end the script element.
std::string Quoted(const std::string& text) {
  static const char kDigits[] = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += std::string("\\") + c;
    } else if (byte < 0x20 || c == '<') {
      out += std::string("\\u00") + kDigits[byte >> 4] + kDigits[byte & 15];
    } else {
      out += c;
    }
  }
  return out + "\"";
}

// JSON has no word for what is not a number.
std::string Number(double value) { return std::isfinite(value) ? ShortNumber(value, 12) : "null"; }

std::string FixedList(const Eigen::Vector3d& v, int decimals) {
  return "[" + FixedNumber(v.x(), decimals) + ", " + FixedNumber(v.y(), decimals) + ", " +
         FixedNumber(v.z(), decimals) + "]";
}

std::string JsonList(const Eigen::Vector3d& v) {
  return "[" + Number(v.x()) + ", " + Number(v.y()) + ", " + Number(v.z()) + "]";
}

std::string Pose(const RigidTransform& pose) {
  const double sign = pose.rotation.w() < 0.0 ? -1.0 : 1.0;  // one of the two equal quaternions
  const Eigen::Vector4d q = sign * pose.rotation.normalized().coeffs();
  return "{\"translation\": " + FixedList(pose.translation, 9) + ", \"rotation\": [" + FixedNumber(q[0], 12) +
         ", " + FixedNumber(q[1], 12) + ", " + FixedNumber(q[2], 12) + ", " + FixedNumber(q[3], 12) + "]}";
}

std::string Sigma(const PoseSigma& sigma) {
  return "{\"translation\": " + JsonList(sigma.translation) +
         ", \"rotation_deg\": " + JsonList(kDegreesPerRadian * sigma.rotation) +
         ", \"time_offset\": " + Number(sigma.time_offset) + "}";
}

std::string Listed(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ",\n") + item;
  return "[" + text + "]";
}

std::string Sensor(const DrawnSensor& sensor) {
  std::string outline;
  for (const Eigen::Vector3d& bearing : sensor.outline) {
    outline += (outline.empty() ? "" : ", ") + FixedList(bearing, 4);
  }
  std::string observable;
  for (const bool flag : sensor.translation_observable) {
    observable += std::string(observable.empty() ? "" : ", ") + (flag ? "true" : "false");
  }
  return "{\"name\": " + Quoted(sensor.name) + ", \"frame\": " + Quoted(sensor.frame) +
         ", \"type\": " + Quoted(TypeNames()[static_cast<std::size_t>(sensor.type)]) +
         ", \"color\": " + Quoted(sensor.color) + ", \"T_root_sensor\": " + Pose(sensor.T_root_sensor) +
         ", \"guess\": " + (sensor.guess ? Pose(*sensor.guess) : "null") +
         ", \"sigma\": " + Sigma(sensor.sigma) + ", \"translation_observable\": [" + observable +
         "], \"time_offset\": " + (sensor.time_offset ? FixedNumber(*sensor.time_offset, 9) : "null") +
         ", \"outline\": [" + outline + "]}";
}

}  // namespace

std::string ReportData(const CalibrationResult& result, const RigDrawing& drawing) {
  std::vector<std::string> sensors, pairs;
  for (const DrawnSensor& sensor : drawing.sensors) sensors.push_back(Sensor(sensor));
  for (const PairResult& pair : result.pairs) {
    pairs.push_back("{\"a\": " + Quoted(pair.a) + ", \"b\": " + Quoted(pair.b) +
                    ", \"sigma\": " + Sigma(pair.sigma) + "}");
  }
  return "{\"verdict\": " + Quoted(VerdictName(result.verdict)) + ", \"root\": " + Quoted(drawing.root) +
         ", \"root_name\": " + Quoted(result.root.empty() ? "imu" : result.root) + ", \"view\": " +
         Listed({FixedList(drawing.R_view_root.row(0), 6), FixedList(drawing.R_view_root.row(1), 6),
                 FixedList(drawing.R_view_root.row(2), 6)}) +
         ", \"extent\": " + Number(drawing.extent) +
         ", \"ellipsoid_scale\": " + Number(drawing.ellipsoid_scale) + ",\n\"sensors\": " + Listed(sensors) +
         ",\n\"pairs\": " + Listed(pairs) + "}";
}

}  // namespace mlic
