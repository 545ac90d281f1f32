#include "mlic_core/inspection/excitation_findings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "mlic_core/common/angles.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/ingest/drive_notes.h"

namespace mlic {
namespace {

// Constants of this file, from: definition, the limits of docs/inspection.md.
constexpr double kTurning = 0.05;        // rad/s, root mean square about an axis
constexpr double kHardlyTurning = 0.02;  // rad/s: below it nothing of the rotation will be shown
constexpr double kMostRest = 0.5;        // of the drive
constexpr double kShortDrive = 20.0;     // s
constexpr double kTooShortDrive = 5.0;   // s: the calibration refuses it

double OverlapOf(const TimeInterval& interval, double begin, double end) {
  return std::max(0.0, std::min(interval.end, end) - std::max(interval.start, begin));
}

std::string DirectionText(const Eigen::Vector3d& axis) {
  return "(" + Number(axis.x(), "%.2f") + ", " + Number(axis.y(), "%.2f") + ", " + Number(axis.z(), "%.2f") +
         ")";
}

Finding RotationFinding(const Excitation& excitation) {
  const Eigen::Vector3d rms = excitation.principal_rms;
  const std::string measured =
      Number(rms[2] * kDegreesPerRadian, "%.1f") + ", " + Number(rms[1] * kDegreesPerRadian, "%.1f") + ", " +
      Number(rms[0] * kDegreesPerRadian, "%.1f") + " deg/s rms about its principal axes, the most about " +
      DirectionText(excitation.principal_axes.col(2));
  const std::string limit = "two of at least " + Number(kTurning * kDegreesPerRadian, "%.1f") + " deg/s";
  if (rms[2] < kHardlyTurning) {
    return {Grade::kFail, "drive",
            "rotation",   measured + ": it hardly turns, or evenly",
            limit,        "record a drive with turns: figures of eight, by hand about all axes"};
  }
  if (rms[1] < kTurning) {
    return {Grade::kWarn,
            "drive",
            "rotation",
            measured + ": it turns about one axis only",
            limit,
            "turn about a second axis (kerbs, ramps, by hand), or give T_imu_sensor: see the forecast"};
  }
  return {Grade::kPass, "drive", "rotation", measured, limit, ""};
}

Finding RestFinding(double rest, double length) {
  const double share = rest / length;
  const Grade grade = share > kMostRest ? Grade::kWarn : Grade::kPass;
  return {
      grade,
      "drive",
      "at rest",
      Number(rest, "%.1f") + " of " + Number(length, "%.1f") + " s, " + Number(100.0 * share, "%.0f") + " %",
      "at most " + Number(100.0 * kMostRest) + " %",
      "record a drive that moves; rest shows the biases only"};
}

Finding LengthFinding(double length) {
  const Grade grade = length < kTooShortDrive ? Grade::kFail
                      : length < kShortDrive  ? Grade::kWarn
                                              : Grade::kPass;
  return {grade,
          "drive",
          "length",
          Number(length, "%.1f") + " s",
          "at least " + Number(kShortDrive) + " s",
          "record 30 to 60 s"};
}

}  // namespace

Eigen::Vector3d RoughGyroscopeBias(const std::vector<ImuSample>& samples) {
  const std::vector<TimeInterval> rest = StaticIntervals(samples, EstimateImuNoise(samples));
  if (!rest.empty()) return MeanAngularVelocity(samples, rest);
  return MeanAngularVelocity(samples, {{samples.front().time, samples.back().time}});
}

std::vector<MotionPart> MotionOverTime(const std::vector<ImuSample>& samples, const Eigen::Vector3d& bias,
                                       double length) {
  const std::vector<TimeInterval> rest = StaticIntervals(samples, EstimateImuNoise(samples));
  std::vector<MotionPart> parts;
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    MotionPart part;
    part.begin = length * std::floor(samples[begin].time / length);
    // The last part takes what would be less than half of one.
    const bool last = samples.back().time < part.begin + 1.5 * length;
    const double stop = last ? std::numeric_limits<double>::infinity() : part.begin + length;
    Eigen::Vector3d rates = Eigen::Vector3d::Zero(), mean = rates, squares = rates;
    for (; end < samples.size() && samples[end].time < stop; ++end) {
      rates += (samples[end].angular_velocity - bias).cwiseAbs2();
      mean += samples[end].specific_force;
      squares += samples[end].specific_force.cwiseAbs2();
    }
    const double count = static_cast<double>(end - begin);
    part.end = samples[end - 1].time;
    part.angular_velocity_rms = (rates / count).cwiseSqrt();
    part.specific_force_rms = (squares / count - (mean / count).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
    for (const TimeInterval& interval : rest) part.rest += OverlapOf(interval, part.begin, part.end);
    parts.push_back(part);
  }
  return parts;
}

Findings ExcitationFindings(const std::vector<ImuSample>& samples) {
  if (samples.size() < 4) return {};
  const double length = samples.back().time - samples.front().time;
  double rest = 0.0;
  for (const TimeInterval& interval : StaticIntervals(samples, EstimateImuNoise(samples))) {
    rest += interval.Duration();
  }
  return {LengthFinding(length), RestFinding(rest, length), RotationFinding(MeasureExcitation(samples))};
}

std::vector<std::string> MotionTable(const std::vector<MotionPart>& parts) {
  std::vector<std::string> lines{
      "  from s   to s   turning about x, y, z, deg/s rms   accelerating along x, y, z, m/s^2 rms   at rest, "
      "s"};
  for (const MotionPart& part : parts) {
    const Eigen::Vector3d w = part.angular_velocity_rms * kDegreesPerRadian, a = part.specific_force_rms;
    char text[160];
    std::snprintf(text, sizeof(text), "  %6.1f %6.1f   %8.1f %8.1f %8.1f %20.2f %8.2f %8.2f %18.1f",
                  part.begin, part.end, w.x(), w.y(), w.z(), a.x(), a.y(), a.z(), part.rest);
    lines.emplace_back(text);
  }
  return lines;
}

}  // namespace mlic
