#include "mlic_ros/bag/part_choice.h"

#include <algorithm>
#include <numeric>

#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/inspection/imu_findings.h"
#include "mlic_core/inspection/telling_stretch.h"
#include "mlic_core/lidar/scan_joining.h"
#include "mlic_ros/bag/imu_messages.h"
#include "mlic_ros/bag/message_reader.h"

namespace mlic {
namespace {

double LengthOf(const BagSet::Interval& interval) { return SecondsSince(interval.begin, interval.end); }

std::vector<StampedImu> ReadImu(const BagSet& bags, const std::string& topic,
                                const BagSet::Interval& interval, const CancellationToken& cancellation,
                                const std::function<void(double)>& progress) {
  std::vector<StampedImu> samples;
  ReadInBatches(bags, {topic}, interval, cancellation,
                [&](const std::vector<RawMessage>& batch, double fraction) {
                  std::string frame;
                  for (const RawMessage& message : batch) {
                    samples.push_back(DecodeImu(message.content, topic, frame));
                  }
                  progress(fraction);
                });
  return samples;
}

// How much is taken of each drive, s: as much of all, or the whole of those that are shorter, `longest`
// together.
std::vector<double> SharesOf(const std::vector<BagSet::Interval>& drives, double longest) {
  std::vector<std::size_t> order(drives.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return LengthOf(drives[a]) < LengthOf(drives[b]); });
  std::vector<double> shares(drives.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    shares[order[i]] = std::min(LengthOf(drives[order[i]]), longest / static_cast<double>(order.size() - i));
    longest -= shares[order[i]];
  }
  return shares;
}

// Seconds after the drive's begin on the recorder's clock. Its first part where the IMU tells nothing.
TimeInterval PartOf(std::vector<StampedImu> recorded, const ImuConfig& imu, TimeNs begin, double duration) {
  if (recorded.empty()) return {0.0, duration};
  const double before = SecondsSince(begin, recorded.front().record);
  const std::vector<ImuSample> samples = UsableImu(std::move(recorded)).samples;
  if (samples.size() < 2) return {0.0, duration};
  const TimeInterval part = MostTellingStretch(samples, imu, TypicalPoseNoise(), duration);
  return {before + part.start, before + part.end};
}

}  // namespace

double LengthOf(const std::vector<BagSet::Interval>& drives) {
  double sum = 0.0;
  for (const BagSet::Interval& drive : drives) sum += LengthOf(drive);
  return sum;
}

SensorLoad LoadOf(const BagSet& bags, const Rig& rig) {
  SensorLoad load;
  load.cameras = rig.cameras.size();
  const double length = std::max(1e-9, LengthOf(bags.drives()));
  for (const LidarConfig& lidar : rig.lidars) {
    const double rate = static_cast<double>(bags.topics().at(lidar.topic).messages) / length;
    if (rate > 0.0) load.scans += rate / static_cast<double>(PiecesOfScan(1.0 / rate));
  }
  return load;
}

std::vector<BagSet::Interval> ChooseParts(const BagSet& bags, const Rig& rig,
                                          std::vector<BagSet::Interval> drives, double longest,
                                          const CancellationToken& cancellation,
                                          const std::function<void(double)>& progress,
                                          std::vector<std::string>* notes) {
  const double all = LengthOf(drives);
  if (all <= longest) return drives;
  const std::vector<double> shares = SharesOf(drives, longest);
  double before = 0.0;
  for (std::size_t d = 0; d < drives.size(); ++d) {
    BagSet::Interval& drive = drives[d];
    const double length = LengthOf(drive);
    if (shares[d] >= length) continue;
    const auto of_drive = [&](double fraction) { progress((before + fraction * length) / all); };
    const TimeInterval part =
        PartOf(ReadImu(bags, rig.imu.topic, drive, cancellation, of_drive), rig.imu, drive.begin, shares[d]);
    before += length;
    notes->push_back(
        "of " + Number(length, "%.1f") + " s from " +
        Number(1e-9 * static_cast<double>(drive.begin), "%.3f") + " on, those from " +
        Number(part.start, "%.1f") + " to " + Number(part.end, "%.1f") +
        " s are used, where the motion shows the calibration best: all of them would take too much "
        "memory or time; --start and --duration choose others");
    drive.end = std::min(drive.end, TimeFrom(drive.begin, part.end));
    drive.begin = TimeFrom(drive.begin, part.start);
  }
  return drives;
}

}  // namespace mlic
