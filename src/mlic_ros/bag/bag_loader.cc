#include "mlic_ros/bag/bag_loader.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/ingest/drive_builder.h"
#include "mlic_core/sensors/sensor_frames.h"
#include "mlic_core/sensors/sensor_problem.h"
#include "mlic_ros/bag/bag_set.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_messages.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/imu_messages.h"
#include "mlic_ros/bag/lidar_messages.h"
#include "mlic_ros/bag/message_reader.h"
#include "mlic_ros/bag/part_choice.h"

namespace mlic {
namespace {

constexpr double kShareOfChoice = 0.3;  // of the time of loading; from: structural

// A kind of sensor and the messages that it may have.
struct Kind {
  bool (*is_type)(const std::string&);
  const char* types;
};

constexpr Kind kImu{IsImuType, "sensor_msgs/Imu"};
constexpr Kind kLidar{IsLidarType,
                      "sensor_msgs/PointCloud2, livox_ros_driver/CustomMsg or livox_ros_driver2/CustomMsg"};
constexpr Kind kCamera{IsImageType, "sensor_msgs/Image or sensor_msgs/CompressedImage"};

void CheckTopic(const BagSet& bags, const std::string& sensor, const std::string& topic, const Kind& kind) {
  const auto found = bags.topics().find(topic);
  if (found == bags.topics().end()) {
    throw InputError("bag " + bags.names() + ": no topic " + topic + " (" + sensor +
                     "); the topics are: " + bags.ListTopics());
  }
  const std::string& type = found->second.type;
  if (kind.is_type(type)) return;
  if (kind.is_type == IsLidarType && IsRawLidarType(type)) {
    throw InputError("bag " + bags.names() + ": topic " + topic + " (" + sensor + ") is of type " + type +
                     ", a LiDAR's raw packets; " + kRawLidarRemedy);
  }
  throw InputError("bag " + bags.names() + ": topic " + topic + " (" + sensor + ") is of type " + type +
                   ", expected " + kind.types + "; the topics are: " + bags.ListTopics());
}

BagSet::Interval ChosenInterval(const BagSet& bags, const LoadOptions& options) {
  BagSet::Interval interval = bags.interval();
  const double length = SecondsSince(interval.begin, interval.end);
  if (options.start < 0.0 || options.start >= length || (options.duration && *options.duration <= 0.0)) {
    char text[120];
    std::snprintf(text, sizeof(text),
                  "--start %g: expected 0 to less than the recording's %.3f s, and --duration > 0",
                  options.start, length);
    throw InputError(text);
  }
  const TimeNs begin = TimeFrom(interval.begin, options.start);
  if (options.duration) interval.end = std::min(interval.end, TimeFrom(begin, *options.duration));
  interval.begin = begin;
  return interval;
}

// Collects the decoded messages of all drives, in order of recording. Topics: IMU, LiDARs, cameras.
class Collector {
 public:
  Collector(const std::vector<BagSet::Interval>& drives, const std::string& imu_topic,
            const std::vector<LidarFormat>& formats, std::size_t cameras)
      : intervals_(drives), imu_topic_(imu_topic), formats_(formats), drives_(drives.size()) {
    for (Drive& drive : drives_) {
      drive.messages.lidars.resize(formats.size());
      drive.headers.resize(cameras);
      drive.places.resize(cameras);
    }
  }

  void Add(const std::vector<RawMessage>& batch) {
    std::vector<ReadScan> scans(batch.size());
    std::vector<StampedImu> samples(batch.size());
    std::vector<ImageHeader> images(batch.size());
    std::vector<std::string> frames(batch.size());
    ParallelFor(batch.size(), [&](std::size_t i) {
      if (batch[i].topic == 0) {
        samples[i] = DecodeImu(batch[i].content, imu_topic_, frames[i]);
      } else if (batch[i].topic <= formats_.size()) {
        scans[i] = ReadOneScan(batch[i].content, formats_[batch[i].topic - 1]);
        scans[i].scan.points.shrink_to_fit();
      } else {
        images[i] = ReadImageHeader(batch[i].content);
      }
    });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      Drive& drive = drives_[DriveAt(batch[i].content.record_time)];
      if (batch[i].topic == 0) {
        drive.messages.imu.push_back(samples[i]);
        if (imu_frame_.empty()) imu_frame_ = frames[i];
      } else if (batch[i].topic <= formats_.size()) {
        drive.messages.lidars[batch[i].topic - 1].push_back(std::move(scans[i]));
      } else {
        const std::size_t camera = batch[i].topic - 1 - formats_.size();
        drive.headers[camera].push_back(std::move(images[i]));
        drive.places[camera].push_back(batch[i].place);
      }
    }
  }

  // Their images are read from the bags, which stay open for as long as they are in use.
  std::vector<DriveMessages> TakeDrives(const std::shared_ptr<const BagSet>& bags) {
    std::vector<DriveMessages> taken;
    for (Drive& drive : drives_) {
      for (std::size_t c = 0; c < drive.headers.size(); ++c) {
        drive.messages.cameras.push_back(
            MakeImageStream(bags, std::move(drive.headers[c]), std::move(drive.places[c])));
      }
      taken.push_back(std::move(drive.messages));
    }
    return taken;
  }
  const std::string& imu_frame() const { return imu_frame_; }

 private:
  struct Drive {
    DriveMessages messages;  // its cameras are made at the end, of the two below
    std::vector<std::vector<ImageHeader>> headers;
    std::vector<std::vector<BagPlace>> places;
  };

  std::size_t DriveAt(TimeNs record_time) const {
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      if (record_time <= intervals_[i].end) return i;
    }
    return intervals_.size() - 1;
  }

  const std::vector<BagSet::Interval>& intervals_;
  const std::string& imu_topic_;
  const std::vector<LidarFormat>& formats_;
  std::vector<Drive> drives_;
  std::string imu_frame_;
};

// What the chosen interval contains of each drive.
std::vector<BagSet::Interval> DrivesWithin(const BagSet& bags, const BagSet::Interval& interval) {
  std::vector<BagSet::Interval> drives;
  for (const BagSet::Interval& drive : bags.drives()) {
    const BagSet::Interval within{std::max(drive.begin, interval.begin), std::min(drive.end, interval.end)};
    if (within.begin <= within.end) drives.push_back(within);
  }
  if (drives.empty()) throw InputError("bag " + bags.names() + ": nothing was recorded in the chosen time");
  return drives;
}

void NoteFormats(const std::vector<LidarFormat>& formats, LoadReport& report) {
  for (const LidarFormat& format : formats) {
    report.lidar_frame_ids.push_back(format.frame_id);
    if (format.time_field.empty()) {
      report.warnings.push_back("topic " + format.topic +
                                ": the points have no times; taken from azimuth and order, good to some "
                                "milliseconds, with the header stamp at the start of the scan");
    } else if (format.time.reference == PointTimeFormat::Reference::kOtherClock || format.livox_other_clock) {
      report.warnings.push_back(
          "topic " + format.topic +
          ": point times run in another clock than the header stamp; the first point of each "
          "scan is taken to be at the stamp");
    }
  }
}

std::vector<ImageFormat> FindImageFormats(const Rig& rig, const BagSet& bags,
                                          const BagSet::Interval& interval,
                                          const CancellationToken& cancellation, LoadReport& report) {
  std::vector<ImageFormat> formats;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    cancellation.ThrowIfCancelled();
    formats.push_back(
        OfSensor(CameraId(c), [&] { return ProbeCamera(bags, rig.cameras[c].topic, interval); }));
    report.camera_frame_ids.push_back(formats.back().frame_id);
  }
  return formats;
}

// Throws InputError where two sensors' messages carry each other's frames.
void CheckFrames(const Rig& rig, const LoadReport& report) {
  const std::vector<SensorFrame> frames = FramesOf(rig, report.lidar_frame_ids, report.camera_frame_ids);
  for (const auto& [first, second] : ExchangedFrames(frames)) {
    const SensorFrame &a = frames[first], &b = frames[second];
    throw InputError(a.name + ": its messages are in the frame " + a.found +
                     ", which the rig file gives to " + b.name + ", and the other way round; " +
                     LookExchanged(a.name, b.name));
  }
}

std::vector<cv::Mat> LoadMasks(const Rig& rig, const std::vector<ImageFormat>& formats,
                               const std::filesystem::path& directory) {
  std::vector<cv::Mat> masks(rig.cameras.size());
  for (std::size_t i = 0; i < masks.size(); ++i) {
    const CameraConfig& camera = rig.cameras[i];
    if (camera.mask.empty()) continue;
    masks[i] = LoadMask(directory / camera.mask, camera.name, formats[i].width, formats[i].height);
  }
  return masks;
}

}  // namespace

Dataset LoadDataset(const Rig& rig_file, const std::vector<std::filesystem::path>& paths,
                    const LoadOptions& options, LoadReport& report, const CancellationToken& cancellation,
                    ProgressSink& progress) {
  progress.OnProgress("loading", 0.0);
  const auto shared_bags = std::make_shared<const BagSet>(paths);
  const BagSet& bags = *shared_bags;
  const Rig rig = WithTopicsOfBag(rig_file, bags);
  std::vector<std::string> topics{rig.imu.topic};
  CheckTopic(bags, "imu", rig.imu.topic, kImu);
  for (const LidarConfig& lidar : rig.lidars) {
    CheckTopic(bags, lidar.name, lidar.topic, kLidar);
    topics.push_back(lidar.topic);
  }
  for (const CameraConfig& camera : rig.cameras) {
    CheckTopic(bags, camera.name, camera.topic, kCamera);
    topics.push_back(camera.topic);
  }
  const BagSet::Interval interval = ChosenInterval(bags, options);
  // Of the loading, where the IMU is read by itself first.
  double loaded = 0.0;
  const auto report_progress = [&](double fraction) { progress.OnProgress("loading", fraction); };
  std::vector<BagSet::Interval> drives = DrivesWithin(bags, interval);
  if (options.most_telling) {
    const std::size_t others = report.warnings.size();
    drives = ChooseParts(
        bags, rig, std::move(drives), LongestDrive(LoadOf(bags, rig)), cancellation,
        [&](double fraction) { report_progress(kShareOfChoice * fraction); }, &report.warnings);
    if (report.warnings.size() > others) loaded = kShareOfChoice;
  }

  std::vector<LidarFormat> formats;
  for (std::size_t l = 0; l < rig.lidars.size(); ++l) {
    cancellation.ThrowIfCancelled();
    const std::string& topic = rig.lidars[l].topic;
    formats.push_back(
        OfSensor(LidarId(l), [&] { return FindLidarFormat(ProbeLidar(bags, topic, interval), topic); }));
  }
  NoteFormats(formats, report);
  const std::vector<ImageFormat> image_formats = FindImageFormats(rig, bags, interval, cancellation, report);
  CheckFrames(rig, report);
  const std::vector<cv::Mat> masks = LoadMasks(rig, image_formats, options.rig_directory);

  Collector collector(drives, rig.imu.topic, formats, rig.cameras.size());
  const double share = (1.0 - loaded) / static_cast<double>(drives.size());
  for (const BagSet::Interval& drive : drives) {
    ReadInBatches(bags, topics, drive, cancellation,
                  [&](const std::vector<RawMessage>& batch, double fraction) {
                    collector.Add(batch);
                    report_progress(loaded + share * fraction);
                  });
    loaded += share;
  }
  report.imu_frame_id = collector.imu_frame();

  Dataset dataset;
  for (DriveMessages& messages : collector.TakeDrives(shared_bags)) {
    DriveNotes notes;
    dataset.drives.push_back(BuildDrive(std::move(messages), rig.imu.topic, formats, image_formats, notes));
    for (std::size_t i = 0; i < masks.size(); ++i) dataset.drives.back().cameras[i].mask = masks[i];
    report.lines.insert(report.lines.end(), notes.lines.begin(), notes.lines.end());
    report.warnings.insert(report.warnings.end(), notes.warnings.begin(), notes.warnings.end());
  }
  return dataset;
}

Rig WithMessageFrames(Rig rig, const LoadReport& report) {
  if (rig.imu.frame_id.empty()) rig.imu.frame_id = report.imu_frame_id;
  for (std::size_t i = 0; i < rig.lidars.size(); ++i) {
    if (rig.lidars[i].frame_id.empty()) rig.lidars[i].frame_id = report.lidar_frame_ids[i];
  }
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    if (rig.cameras[i].frame_id.empty()) rig.cameras[i].frame_id = report.camera_frame_ids[i];
  }
  return rig;
}

}  // namespace mlic
