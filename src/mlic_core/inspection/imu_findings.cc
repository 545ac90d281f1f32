#include "mlic_core/inspection/imu_findings.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/ingest/imu_check.h"
#include "mlic_core/ingest/imu_faults.h"
#include "mlic_core/ingest/stamp_check.h"

namespace mlic {
namespace {

// Constants of this file, from: definition, the limits of docs/inspection.md.
constexpr double kGravityTolerance = 0.3;   // m/s^2: bias and scale of a consumer accelerometer
constexpr double kMovingTolerance = 1.0;    // m/s^2: where it never rests the median holds motion as well
constexpr double kMostFaultySamples = 0.2;  // of the samples
constexpr double kNotFiniteShare = 0.001;   // of the samples

std::string Percent(std::size_t count, std::size_t all) {
  return Number(100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, all)),
                "%.2g") +
         " %";
}

Grade GradeOfShare(std::size_t count, std::size_t all, double pass) {
  const double share = static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, all));
  return share > kMostFaultySamples ? Grade::kFail : share > pass ? Grade::kWarn : Grade::kPass;
}

// Where flagged stretches begin, seconds after `begin`.
std::vector<double> PlacesOf(const std::vector<StampedImu>& samples, const std::vector<bool>& flags,
                             TimeNs begin) {
  std::vector<double> places;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] && (i == 0 || !flags[i - 1])) places.push_back(SecondsSince(begin, samples[i].record));
  }
  return places;
}

Finding FlagFinding(const std::string& name, const std::string& check, const std::string& what,
                    const std::vector<bool>& flags, const std::vector<double>& places) {
  const auto count = static_cast<std::size_t>(std::count(flags.begin(), flags.end(), true));
  if (count == 0) return {Grade::kPass, name, check, "none", "none", ""};
  return {
      GradeOfShare(count, flags.size(), 0.0),
      name,
      check,
      what + std::to_string(count) + " samples (" + Percent(count, flags.size()) + "), " + PlacesText(places),
      "none",
      ""};
}

Finding NotFiniteFinding(const std::string& name, std::size_t count, std::size_t all) {
  return {GradeOfShare(count, all, kNotFiniteShare),
          name,
          "NaN or infinite values",
          std::to_string(count) + " samples (" + Percent(count, all) + ")",
          Number(100.0 * kNotFiniteShare) + " %",
          "they are dropped; check the driver"};
}

Finding UnitFinding(const std::string& name, const std::vector<StampedImu>& samples) {
  const std::string limit = "specific force about 9.8 m/s^2, rad/s";
  std::vector<StampedImu> copy = samples;
  try {
    CleanImu(copy, name);
  } catch (const InputError& error) {
    return {Grade::kFail, name,  "units",
            error.what(), limit, "convert the topic and record or rewrite the bag"};
  }
  std::vector<double> forces, rates;
  for (const StampedImu& s : samples) {
    forces.push_back(s.specific_force.norm());
    rates.push_back(s.angular_velocity.norm());
  }
  return {Grade::kPass,
          name,
          "units",
          "median |specific force| " + Number(Median(forces), "%.2f") + " m/s^2, 98 % of the rates below " +
              Number(Quantile(rates, 0.98), "%.2f") + " rad/s",
          limit,
          ""};
}

// At rest the mean force is gravity; in motion the mean over a drive nearly is, if the IMU keeps its tilt.
Finding GravityFinding(const std::string& name, const std::vector<ImuSample>& samples) {
  const std::vector<TimeInterval> rest = StaticIntervals(samples, EstimateImuNoise(samples));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::vector<double> norms;
  double count = 0.0;
  for (const ImuSample& sample : samples) {
    norms.push_back(sample.specific_force.norm());
    const auto within = [&](const TimeInterval& i) { return sample.time >= i.start && sample.time < i.end; };
    if (!rest.empty() && std::none_of(rest.begin(), rest.end(), within)) continue;
    sum += sample.specific_force;
    count += 1.0;
  }
  const Eigen::Vector3d up = sum / count;
  const double magnitude = rest.empty() ? Median(norms) : up.norm();
  int axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  const double tilt = std::acos(std::abs(up[axis]) / up.norm()) * 180.0 / M_PI;
  const std::string direction = std::string(up[axis] < 0.0 ? "-" : "+") + "xyz"[axis];
  const double tolerance = rest.empty() ? kMovingTolerance : kGravityTolerance;
  return {std::abs(magnitude - kStandardGravity) > tolerance ? Grade::kWarn : Grade::kPass,
          name,
          "gravity",
          Number(magnitude, "%.3f") + " m/s^2 " + (rest.empty() ? "in the median" : "at rest") +
              ", up is the IMU's " + direction + " within " + Number(tilt, "%.0f") + " deg",
          "9.81 +- " + Number(tolerance),
          "check the accelerometer's scale; try imu: {intrinsics: scale_misalignment}"};
}

Findings AxisFindings(const std::string& name, const std::vector<StampedImu>& samples, TimeNs begin) {
  Findings findings;
  for (int axis = 0; axis < kImuAxes; ++axis) {
    const std::vector<bool> frozen = FindFrozenAxis(samples, axis), limited = FindSaturated(samples, axis);
    Finding hangs =
        FlagFinding(name, "frozen axis", AxisName(axis) + ", ", frozen, PlacesOf(samples, frozen, begin));
    hangs.remedy = "the sensor is broken or the driver fills it in; calibrate a part without";
    Finding range =
        FlagFinding(name, "saturation", AxisName(axis) + ", ", limited, PlacesOf(samples, limited, begin));
    range.remedy = "they are dropped; set a wider range, or move less violently";
    if (hangs.grade != Grade::kPass) findings.push_back(hangs);
    if (range.grade != Grade::kPass) findings.push_back(range);
  }
  if (findings.empty()) {
    findings.push_back({Grade::kPass, name, "saturated or frozen axes", "none of six", "none", ""});
  }
  return findings;
}

// Takes out what is not finite, sorts by stamp; returns how many were taken out.
std::size_t KeepFinite(std::vector<StampedImu>* samples) {
  const std::size_t all = samples->size();
  samples->erase(std::remove_if(samples->begin(), samples->end(),
                                [](const StampedImu& s) {
                                  return !s.angular_velocity.allFinite() || !s.specific_force.allFinite();
                                }),
                 samples->end());
  std::stable_sort(samples->begin(), samples->end(),
                   [](const StampedImu& a, const StampedImu& b) { return a.stamp < b.stamp; });
  return all - samples->size();
}

}  // namespace

Findings ImuFindings(const std::string& name, std::vector<StampedImu> samples, TimeNs begin) {
  const std::size_t all = samples.size(), not_finite = KeepFinite(&samples);
  Findings findings{NotFiniteFinding(name, not_finite, all)};
  if (samples.size() < 2) return findings;
  findings.push_back(UnitFinding(name, samples));
  const std::vector<ImuSample> usable = UsableImu(samples).samples;
  if (usable.size() >= 4 && findings.back().grade == Grade::kPass) {
    findings.push_back(GravityFinding(name, usable));
  }
  const std::vector<bool> frozen = FindFrozen(samples), forces = FindSpikes(samples, false);
  std::vector<bool> spikes = FindSpikes(samples, true);
  for (std::size_t i = 0; i < spikes.size(); ++i) spikes[i] = spikes[i] || forces[i];
  findings.push_back(FlagFinding(name, "repeated readings", "", frozen, PlacesOf(samples, frozen, begin)));
  findings.back().remedy = "they are dropped; the driver hangs, check its connection";
  findings.push_back(FlagFinding(name, "spikes", "", spikes, PlacesOf(samples, spikes, begin)));
  findings.back().remedy = "they are dropped; check the connection to the IMU";
  Append(AxisFindings(name, samples, begin), &findings);
  return findings;
}

UsableImuSamples UsableImu(std::vector<StampedImu> samples) {
  KeepSteadyPart(samples, [](const StampedImu& s) { return MessageTimes{s.stamp, s.record}; });
  try {
    CleanImu(samples, "imu");
  } catch (const InputError&) {
    return {};
  }
  if (samples.empty()) return {};
  UsableImuSamples usable{samples.front().stamp, {}};
  for (const StampedImu& s : samples) {
    usable.samples.push_back({SecondsSince(usable.epoch, s.stamp), s.angular_velocity, s.specific_force});
  }
  return usable;
}

}  // namespace mlic
