#include "mlic_core/io/report/report_tables.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/rig/rig_parsing.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

std::string Cell(const std::string& content, const std::string& style = "") {
  return (style.empty() ? "<td>" : "<td class=\"" + style + "\">") + content + "</td>";
}

// A value with its sigma and, where there is one, a mark below it. label: of the column, where the page is
// too narrow for columns.
std::string ValueCell(const std::string& value, const std::string& sigma, const std::string& mark = "",
                      const std::string& label = "") {
  return "<td class=\"" + std::string(mark.empty() ? "n" : "n marked") + "\"" +
         (label.empty() ? "" : " data-label=\"" + label + "\"") + ">" + value + "<small>&plusmn; " + sigma +
         (mark.empty() ? "" : " <b>" + mark + "</b>") + "</small></td>";
}

std::string MarkOf(bool observable) { return observable ? "" : "unobservable"; }

std::string PoseCells(const RigidTransform& pose, const PoseSigma& sigma,
                      const std::array<bool, 3>& translation, const std::array<bool, 3>& rotation) {
  static const char* const kAxes[] = {"x, m", "y, m", "z, m"};
  static const char* const kAngles[] = {"roll, &deg;", "pitch, &deg;", "yaw, &deg;"};
  std::string cells;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    cells += ValueCell(FixedNumber(pose.translation[i], 4),
                       FixedNumber(1e3 * sigma.translation[i], 2) + " mm", MarkOf(translation[k]), kAxes[k]);
  }
  const Eigen::Vector3d rpy = kDegreesPerRadian * ToRollPitchYaw(pose.rotation);
  for (std::size_t k = 0; k < 3; ++k) {
    cells += "<td class=\"n\" data-label=\"" + std::string(kAngles[k]) + "\">" +
             FixedNumber(rpy[static_cast<Eigen::Index>(k)], 3) + "</td>";
  }
  std::string sigmas, marks;
  for (std::size_t k = 0; k < 3; ++k) {
    sigmas += (k > 0 ? ", " : "") +
              FixedNumber(kDegreesPerRadian * sigma.rotation[static_cast<Eigen::Index>(k)], 4);
    if (!rotation[k]) marks += std::string(marks.empty() ? "" : ", ") + "xyz"[k];
  }
  return cells + "<td class=\"" + (marks.empty() ? "n" : "n marked") +
         "\" data-label=\"&sigma; about x, y, z\">" + "<small>" + sigmas +
         (marks.empty() ? "" : " <b>" + marks + " unobservable</b>") + "</small></td>";
}

std::string Vector(const Eigen::Vector3d& v, int decimals) {
  return FixedNumber(v.x(), decimals) + ", " + FixedNumber(v.y(), decimals) + ", " +
         FixedNumber(v.z(), decimals);
}

// of: the sensor or pair.
std::string DirectionLine(const std::string& of, const UnobservableDirection& direction) {
  const std::string name = "<li><b>" + EscapeXml(of) + "</b>: ";
  switch (direction.quantity) {
    case UnobservableDirection::Quantity::kTranslation:
      return name + "translation along (" + Vector(direction.direction, 2) + "), known to &plusmn; " +
             FixedNumber(1e3 * direction.sigma, 1) + " mm</li>\n";
    case UnobservableDirection::Quantity::kRotation:
      return name + "rotation about (" + Vector(direction.direction, 2) + "), known to &plusmn; " +
             FixedNumber(kDegreesPerRadian * direction.sigma, 2) + "&deg;</li>\n";
    case UnobservableDirection::Quantity::kTimeOffset:
      return name + "time offset, known to &plusmn; " + FixedNumber(1e3 * direction.sigma, 2) + " ms</li>\n";
  }
  return "";
}

std::string MatrixText(const Eigen::Matrix3d& m) {
  std::string text;
  for (int row = 0; row < 3; ++row) text += (row > 0 ? "<br>" : "") + Vector(m.row(row).transpose(), 6);
  return text;
}

// Colour, name, model and image size.
std::string CameraNameCell(std::size_t index, const SensorResult& sensor) {
  const CameraIntrinsics& intrinsics = *sensor.intrinsics;
  return Cell("<i style=\"background:" + SensorColor(index) + "\"></i>" + EscapeXml(sensor.name) + "<small>" +
              CameraModelNames()[static_cast<std::size_t>(intrinsics.model)] + ", " +
              std::to_string(intrinsics.width) + " &times; " + std::to_string(intrinsics.height) +
              "</small>");
}

// One cell for each parameter, its name above the value; the last one is the readout, where there is one.
std::string IntrinsicsCells(const SensorResult& sensor) {
  const std::vector<std::string> names = ParameterNames(sensor.intrinsics->model);
  const std::vector<double>& values = sensor.intrinsics->parameters;
  std::string cells;
  for (std::size_t k = 0; k < values.size() && k < names.size(); ++k) {
    const int decimals = k < 4 ? 2 : 6;  // pixels; shares of the radius
    const bool fixed = k < sensor.intrinsics_fixed.size() && sensor.intrinsics_fixed[k];
    const std::string sigma = k < sensor.intrinsics_sigma.size()
                                  ? FixedNumber(sensor.intrinsics_sigma[k], decimals + 1)
                                  : std::string("?");
    cells += ValueCell("<small>" + names[k] + "</small>" + FixedNumber(values[k], decimals), sigma,
                       fixed ? "fixed" : "");
  }
  if (sensor.rolling_shutter_readout) {
    const std::string sigma = sensor.readout_sigma ? FixedNumber(1e3 * *sensor.readout_sigma, 3) : "?";
    cells += ValueCell("<small>readout, ms</small>" + FixedNumber(1e3 * *sensor.rolling_shutter_readout, 3),
                       sigma);
  }
  return cells;
}

// Of the sensor's clock against the IMU's; empty where it is constant.
std::string DriftCell(const SensorResult& sensor) {
  if (!sensor.calibration.clock_drift) return Cell("");
  return ValueCell(FixedNumber(1e6 * *sensor.calibration.clock_drift, 2),
                   FixedNumber(1e6 * sensor.drift_sigma, 2) + " ppm");
}

// Each parameter's difference with its sigma, in units of `unit`; empty cells where nothing is compared.
std::string DifferenceCells(const SensorHalves& sensor, HalvesDifference::Quantity quantity,
                            std::size_t count, double unit) {
  const auto found =
      std::find_if(sensor.quantities.begin(), sensor.quantities.end(),
                   [&](const HalvesDifference& difference) { return difference.quantity == quantity; });
  std::string cells;
  for (std::size_t i = 0; i < count; ++i) {
    const bool shown = found != sensor.quantities.end() && i < found->sigma.size() && found->sigma[i] > 0.0;
    cells +=
        shown ? ValueCell(FixedNumber(found->difference[i] / unit, 2), FixedNumber(found->sigma[i] / unit, 2))
              : Cell("");
  }
  const bool compared = found != sensor.quantities.end();
  return cells + Cell(compared ? FixedNumber(found->Worst(), 1) : "", "n");
}

const char* const kPoseHeader =
    "<th>x, m</th><th>y, m</th><th>z, m</th><th>roll, &deg;</th><th>pitch, &deg;</th><th>yaw, &deg;</th>"
    "<th>&sigma; about x, y, z, &deg;</th>";

}  // namespace

std::string SensorTable(const CalibrationResult& result) {
  if (result.sensors.empty()) {
    const std::string elsewhere = result.root.empty() ? ""
                                                      : " Where the sensors are to each other stands <a "
                                                        "href=\"#frames\">about " +
                                                            EscapeXml(result.root) +
                                                            "</a> and for <a href=\"#pairs\">each pair</a>.";
    return "<p class=\"none\">No sensor's pose in the IMU's frame is observable." + elsewhere + "</p>\n";
  }
  const bool drifts =
      std::any_of(result.sensors.begin(), result.sensors.end(),
                  [](const SensorResult& sensor) { return sensor.calibration.clock_drift.has_value(); });
  std::string html = std::string("<div class=\"wide\"><table class=\"stack\"><thead><tr><th>sensor</th>") +
                     kPoseHeader + "<th>time offset, ms</th>" + (drifts ? "<th>drift, ppm</th>" : "") +
                     "</tr></thead>\n";
  std::string directions;
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    const SensorResult& sensor = result.sensors[i];
    html += "<tr>" + Cell("<i style=\"background:" + SensorColor(i) + "\"></i>" + EscapeXml(sensor.name) +
                          (sensor.frame_id == sensor.name
                               ? ""
                               : "<small>frame " + EscapeXml(sensor.frame_id) + "</small>"));
    html += PoseCells(sensor.calibration.T_imu_sensor, sensor.sigma, sensor.translation_observable,
                      sensor.rotation_observable);
    html += ValueCell(FixedNumber(1e3 * sensor.calibration.time_offset, 3),
                      FixedNumber(1e3 * sensor.sigma.time_offset, 3) + " ms",
                      MarkOf(sensor.time_offset_observable), "time offset, ms");
    if (drifts) html += DriftCell(sensor);
    html += "</tr>\n";
    for (const UnobservableDirection& direction : sensor.unobservable) {
      directions += DirectionLine(sensor.name, direction);
    }
  }
  html +=
      "</table></div>\n<p class=\"note\">T_imu_sensor, the <dfn>extrinsic</dfn>: it maps points of the "
      "sensor's "
      "frame into the IMU's; roll, pitch, yaw about fixed axes, as in URDF. Sigmas along and about the IMU's "
      "axes. <dfn>Time offset</dfn>: t_imu = t_sensor + time offset.";
  if (drifts) html += " Where a clock drifts the offset is that in the middle of the drive.";
  html += "</p>\n";
  if (directions.empty())
    return html + "<p class=\"note\">Every direction of these sensors is observable.</p>\n";
  return html +
         "<p>These directions are unobservable in this drive; the given guess decides them:</p><ul>\n" +
         directions + "</ul>\n";
}

std::string CameraTable(const CalibrationResult& result) {
  std::string html;
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    const SensorResult& sensor = result.sensors[i];
    if (sensor.intrinsics) html += "<tr>" + CameraNameCell(i, sensor) + IntrinsicsCells(sensor) + "</tr>\n";
  }
  if (html.empty()) return "";
  return "<div class=\"wide\"><table>\n" + html +
         "</table></div>\n<p class=\"note\">Pixels for focal lengths and centre (a pixel's centre is at "
         "whole "
         "coordinates). Fixed: not determined by the drive, or fixed in the rig file; the value is the "
         "initial one.</p>\n";
}

std::string PairTable(const CalibrationResult& result) {
  std::string html =
      std::string("<div class=\"wide\"><table class=\"stack\"><thead><tr><th>pair a / b</th>") + kPoseHeader +
      "<th>&sigma; time offset</th></tr></thead>\n";
  const std::array<bool, 3> all{true, true, true};
  std::string directions;
  for (const PairResult& pair : result.pairs) {
    html += "<tr>" + Cell(EscapeXml(pair.a) + " / " + EscapeXml(pair.b)) +
            PoseCells(pair.T_a_b, pair.sigma, all, all) +
            "<td class=\"n\" data-label=\"&sigma; time offset\"><small>&plusmn; " +
            FixedNumber(1e3 * pair.sigma.time_offset, 3) + " ms</small></td></tr>\n";
    for (const UnobservableDirection& direction : pair.unobservable) {
      directions += DirectionLine(pair.a + " / " + pair.b, direction);
    }
  }
  html +=
      "</table></div>\n<p class=\"note\">Pose of b in the frame of a; sigmas along and about the axes of "
      "a.</p>\n";
  if (directions.empty()) return html;
  return html +
         "<p>These directions are unobservable in this drive; the given guess, or how well clocks are known, "
         "decides them:</p><ul>\n" +
         directions + "</ul>\n";
}

std::string HalvesTable(const CalibrationResult& result) {
  if (result.halves.empty()) return "";
  using Quantity = HalvesDifference::Quantity;
  std::string html =
      "<div class=\"wide\"><table><tr><th>sensor</th><th>parts</th><th>rot x, m&deg;</th><th>rot y, "
      "m&deg;</th>"
      "<th>rot z, m&deg;</th><th>&sigma;s</th><th>x, mm</th><th>y, mm</th><th>z, mm</th><th>&sigma;s</th>"
      "<th>time offset, ms</th><th>&sigma;s</th><th>intrinsics, &sigma;s</th></tr>\n";
  for (const SensorHalves& sensor : result.halves) {
    html += "<tr>" + Cell(EscapeXml(sensor.sensor)) + Cell(NameOf(sensor.parts)) +
            DifferenceCells(sensor, Quantity::kRotation, 3, 1e-3 / kDegreesPerRadian) +
            DifferenceCells(sensor, Quantity::kTranslation, 3, 1e-3) +
            DifferenceCells(sensor, Quantity::kTimeOffset, 1, 1e-3) +
            DifferenceCells(sensor, Quantity::kIntrinsics, 0, 1.0) + "</tr>\n";
  }
  return html +
         "</table></div>\n<p class=\"note\">Halves and quarters of the drive, as the rig turns, were "
         "calibrated from their own data alone; of each sensor those two that differ most: the later minus "
         "the earlier, with the sigma of the difference. &sigma;s: how unlikely the quantity's difference "
         "is, as a deviation of one normal variable. What a part alone does not show is left out.</p>\n";
}

std::string ImuTable(const CalibrationResult& result) {
  const ImuCalibration& imu = result.imu;
  std::string html =
      "<div class=\"wide\"><table>\n<tr><th>gyroscope bias</th>" +
      Cell(Vector(imu.gyroscope_bias, 6) + " rad/s", "n") + "</tr>\n<tr><th>accelerometer bias</th>" +
      Cell(Vector(imu.accelerometer_bias, 5) + " m/s&sup2;", "n") + "</tr>\n<tr><th>gravity in the map</th>" +
      Cell(Vector(result.gravity, 4) + " m/s&sup2;", "n") +
      "</tr>\n<tr><th>accelerometer later than gyroscope</th>" +
      Cell(FixedNumber(1e3 * imu.accelerometer_lag, 2) + " ms", "n") + "</tr>\n";
  if (!imu.gyroscope_matrix.isIdentity(0.0) || !imu.accelerometer_matrix.isIdentity(0.0)) {
    html += "<tr><th>gyroscope matrix</th>" + Cell(MatrixText(imu.gyroscope_matrix), "n") +
            "</tr>\n<tr><th>accelerometer matrix</th>" + Cell(MatrixText(imu.accelerometer_matrix), "n") +
            "</tr>\n";
  }
  return html + "</table></div>\n<p class=\"note\">measured = matrix &times; true + bias</p>\n";
}

std::string StageTable(const CalibrationResult& result) {
  double total = 0.0, processor = 0.0, longest = 1e-9;
  for (const StageSummary& stage : result.stages) {
    total += stage.seconds;
    processor += stage.processor_seconds;
    longest = std::max(longest, stage.seconds);
  }
  std::string html =
      "<div class=\"wide\"><table class=\"stages\"><tr><th>stage</th><th>s</th><th>processor, "
      "s</th><th>share</th>"
      "<th>what was found</th></tr>\n";
  for (const StageSummary& stage : result.stages) {
    std::string lines;
    for (const std::string& line : stage.lines) lines += EscapeXml(line) + "<br>";
    html += "<tr>" + Cell(EscapeXml(stage.name)) + Cell(FixedNumber(stage.seconds, 1), "n") +
            Cell(FixedNumber(stage.processor_seconds, 1), "n") +
            Cell("<div class=\"bar\" style=\"width:" + FixedNumber(90.0 * stage.seconds / longest, 0) +
                 "px\"></div>") +
            Cell(lines) + "</tr>\n";
  }
  html += "<tr><th>all</th>" + Cell("<b>" + FixedNumber(total, 1) + "</b>", "n") +
          Cell("<b>" + FixedNumber(processor, 1) + "</b>", "n") + Cell("") +
          Cell(result.peak_memory_megabytes > 0.0
                   ? "peak memory " + FixedNumber(result.peak_memory_megabytes / 1024.0, 2) + " GB"
                   : "");
  return html + "</tr>\n</table></div>\n";
}

}  // namespace mlic
