#include "mlic_core/inspection/lidar_findings.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/ingest/scan_reader.h"
#include "mlic_core/inspection/azimuth_rate.h"
#include "mlic_core/lidar/own_body.h"

namespace mlic {
namespace {

// Constants of this file, from: definition, the limits of docs/inspection.md.
constexpr double kFewestReturns = 0.1;       // of a scan's points
constexpr std::size_t kFewestPoints = 500;   // returns of a scan, for odometry
constexpr double kShortSight = 2.0;          // m: 95 % of the returns are nearer
constexpr double kFarthest = 1000.0;         // m: no LiDAR's; millimetres look like it
constexpr double kMostBody = 0.3;            // of the returns
constexpr double kFaultyShare = 0.01;        // of the messages
constexpr double kMostFaultyMessages = 0.5;  // of the messages
constexpr std::size_t kFewestSamples = 10;   // scans, to tell de-skewed ones
constexpr double kLeastTurning = 0.05;       // rad/s, standard deviation over the samples
constexpr double kExplained = 0.5;           // share of the variance

std::string Percent(double share) { return Number(100.0 * share, "%.1f") + " %"; }

Finding FormatFinding(const LidarSurvey& lidar) {
  const std::string limit = "a time for each point, within its scan";
  if (!lidar.format) {
    return {Grade::kFail,       lidar.name, "point times",
            lidar.format_error, limit,      "correct the driver's setting and record again"};
  }
  const bool from_azimuth = lidar.format->time_field.empty();
  const bool other_clock = lidar.format->livox_other_clock ||
                           lidar.format->time.reference == PointTimeFormat::Reference::kOtherClock;
  const std::string remedy = from_azimuth ? "set the driver to write a time for each point"
                                          : "synchronise the LiDAR's clock with the computer's (PTP)";
  return {from_azimuth || other_clock ? Grade::kWarn : Grade::kPass,
          lidar.name,
          "point times",
          DescribeTimes(*lidar.format),
          limit,
          remedy};
}

Finding FaultFinding(const LidarSurvey& lidar) {
  const auto bad_times = static_cast<std::size_t>(std::count_if(
      lidar.samples.begin(), lidar.samples.end(), [](const ScanSample& s) { return s.bad_times; }));
  const double malformed =
      static_cast<double>(lidar.malformed) / static_cast<double>(std::max<std::size_t>(1, lidar.messages));
  const double unfit =
      static_cast<double>(bad_times) / static_cast<double>(std::max<std::size_t>(1, lidar.samples.size()));
  const double share = std::max(malformed, unfit);
  std::string measured = std::to_string(lidar.malformed) + " of " + std::to_string(lidar.messages) +
                         " messages malformed, " + std::to_string(bad_times) + " of " +
                         std::to_string(lidar.samples.size()) + " sampled with other point times";
  if (!lidar.first_fault.empty()) measured += "; the first: " + lidar.first_fault;
  return {share > kMostFaultyMessages ? Grade::kFail
          : share > kFaultyShare      ? Grade::kWarn
                                      : Grade::kPass,
          lidar.name,
          "messages",
          measured,
          Percent(kFaultyShare),
          "they are left out; check network and driver"};
}

Finding ReturnFinding(const LidarSurvey& lidar) {
  std::vector<double> shares, returns;
  for (const ScanSample& s : lidar.samples) {
    returns.push_back(static_cast<double>(s.returns));
    shares.push_back(returns.back() / static_cast<double>(std::max<std::size_t>(1, s.points)));
  }
  const double share = Median(shares), count = Median(returns);
  const bool few = share < kFewestReturns || count < static_cast<double>(kFewestPoints);
  return {count == 0.0 ? Grade::kFail
          : few        ? Grade::kWarn
                       : Grade::kPass,
          lidar.name,
          "returns",
          Number(count, "%.0f") + " a scan, " + Percent(share) + " of its points, the others NaN or zero",
          Percent(kFewestReturns) + " and " + std::to_string(kFewestPoints) + " a scan",
          "free the view, check the range settings, record among walls and objects"};
}

Finding RangeFinding(const LidarSurvey& lidar) {
  std::vector<double> medians, far;
  for (const ScanSample& s : lidar.samples) {
    if (s.returns == 0) continue;
    medians.push_back(s.median_range);
    far.push_back(s.far_range);
  }
  const double reach = Median(far);
  const std::string measured =
      "median " + Number(Median(medians), "%.1f") + " m, 95 % within " + Number(reach, "%.1f") + " m";
  const std::string limit = "95 % within " + Number(kShortSight) + " to " + Number(kFarthest) + " m";
  if (reach > kFarthest) {
    return {Grade::kFail, lidar.name, "ranges",
            measured,     limit,      "it looks like millimetres: the driver has to write metres"};
  }
  return {reach < kShortSight ? Grade::kFail : Grade::kPass,    lidar.name, "ranges", measured, limit,
          "the view is blocked: take off covers, mount it free"};
}

Finding IntensityFinding(const LidarSurvey& lidar) {
  const bool varies = std::any_of(lidar.samples.begin(), lidar.samples.end(),
                                  [](const ScanSample& s) { return s.intensity_varies; });
  return {varies ? Grade::kPass : Grade::kWarn,
          lidar.name,
          "intensity",
          varies ? "varies" : "absent or always the same",
          "varies",
          "let the driver write intensity: photos are matched to it"};
}

Finding BodyFinding(const LidarSurvey& lidar) {
  LidarRecording recording;
  std::size_t all = 0;
  for (const ScanSample& s : lidar.samples) {
    recording.scans.push_back(s.thinned);
    all += s.thinned.points.size();
  }
  const double share =
      static_cast<double>(RemoveOwnBody(&recording)) / static_cast<double>(std::max<std::size_t>(1, all));
  return {share > kMostBody ? Grade::kWarn : Grade::kPass,
          lidar.name,
          "own vehicle in view",
          Percent(share) + " of the returns stay in place within 4 m, and are left out",
          Percent(kMostBody),
          "mount the LiDAR where it sees less of its vehicle"};
}

// The gyroscope's mean over [begin, end]; nothing without samples.
std::optional<Eigen::Vector3d> MeanRate(const std::vector<ImuSample>& imu, double begin, double end) {
  const auto before = [](const ImuSample& s, double time) { return s.time < time; };
  auto at = std::lower_bound(imu.begin(), imu.end(), begin, before);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (; at != imu.end() && at->time <= end; ++at) {
    sum += at->angular_velocity;
    count += 1.0;
  }
  if (count == 0.0) return std::nullopt;
  return sum / count;
}

}  // namespace

ScanSample MeasureScan(const DecodedCloud& cloud, const LidarFormat& format) {
  ScanSample sample;
  sample.stamp = cloud.stamp;
  sample.points = cloud.positions.size();
  std::vector<double> ranges;
  for (const Eigen::Vector3f& p : cloud.positions) {
    if (HasReturn(p)) ranges.push_back(static_cast<double>(p.norm()));
  }
  sample.returns = ranges.size();
  sample.median_range = Median(ranges);
  sample.far_range = Quantile(std::move(ranges), 0.95);
  const auto [low, high] = std::minmax_element(cloud.intensities.begin(), cloud.intensities.end());
  sample.intensity_varies = low != cloud.intensities.end() && *low < *high;
  ReadScan scan = MakeScan(cloud, format);
  sample.bad_times = scan.problem == ReadScan::Problem::kBadTimes;
  sample.thinned = std::move(scan.scan);
  if (const auto rate = MeasureAzimuthRate(sample.thinned.points)) {
    sample.azimuth_rate = rate->radians_per_second;
    sample.sweep = rate->sweep;
    sample.stamp = scan.start;
  }
  return sample;
}

Findings LidarFindings(const LidarSurvey& lidar, bool with_cameras) {
  Findings findings{FormatFinding(lidar)};
  if (lidar.malformed > 0 || lidar.format) findings.push_back(FaultFinding(lidar));
  if (lidar.samples.empty()) return findings;
  findings.push_back(ReturnFinding(lidar));
  findings.push_back(RangeFinding(lidar));
  if (with_cameras) findings.push_back(IntensityFinding(lidar));
  findings.push_back(BodyFinding(lidar));
  return findings;
}

Findings DeskewFindings(const LidarSurvey& lidar, const std::vector<ImuSample>& imu, TimeNs epoch) {
  std::vector<Eigen::Vector3d> rates;
  std::vector<double> advances;
  for (const ScanSample& s : lidar.samples) {
    if (!s.azimuth_rate) continue;
    const double begin = SecondsSince(epoch, s.stamp);
    const auto rate = MeanRate(imu, begin, begin + s.sweep);
    if (!rate) continue;
    rates.push_back(*rate);
    advances.push_back(*s.azimuth_rate);
  }
  if (rates.size() < kFewestSamples) return {};
  const auto count = static_cast<Eigen::Index>(rates.size());
  Eigen::MatrixXd turning(count, 3);
  Eigen::VectorXd advance(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    turning.row(i) = rates[static_cast<std::size_t>(i)].transpose();
    advance[i] = advances[static_cast<std::size_t>(i)];
  }
  turning.rowwise() -= turning.colwise().mean().eval();
  advance.array() -= advance.mean();
  if (std::sqrt(turning.squaredNorm() / static_cast<double>(count)) < kLeastTurning) return {};
  // About axes that do not turn nothing can be told: they must not blow up the fit.
  Eigen::Matrix3d normal = turning.transpose() * turning;
  normal.diagonal().array() += 1e-4 * kLeastTurning * kLeastTurning * static_cast<double>(count);
  const Eigen::Vector3d share = SolveSymmetric(normal, turning.transpose() * advance);
  const double explained = 1.0 - (advance - turning * share).squaredNorm() / advance.squaredNorm();
  const bool deskewed = share.norm() > 0.5 && explained > kExplained;
  return {
      {deskewed ? Grade::kFail : Grade::kPass, lidar.name, "raw scans",
       Number(100.0 * std::max(0.0, explained), "%.0f") +
           " % of the variation of the azimuth's rate is the vehicle's turning",
       Number(100.0 * kExplained) + " %",
       "record the driver's raw points: motion that is taken out by another estimate cannot be calibrated"}};
}

}  // namespace mlic
