#include "mlic_ros/bag/recording_survey.h"

#include <std_msgs/Header.h>

#include <algorithm>
#include <optional>

#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/ingest/image_stream.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/imu_messages.h"
#include "mlic_ros/bag/lidar_messages.h"
#include "mlic_ros/bag/message_reader.h"
#include "mlic_ros/bag/message_stream.h"

namespace mlic {
namespace {

// Samples of each LiDAR and camera: 40 of each, no closer than half a second, keep the doctor of the paper's
// rig (4 LiDARs, 6 cameras) within seconds, and are enough to find the own body. from: definition
constexpr double kSamples = 40.0;
constexpr double kClosestSamples = 0.5;  // s; from: definition

// The header that sensor messages begin with; a stamp of 0 where the message is cut off.
MessageTimes TimesOf(const SerializedMessage& message, std::string* frame) {
  std_msgs::Header header;
  try {
    ros::serialization::IStream stream = StreamOf(message);
    ros::serialization::deserialize(stream, header);
  } catch (const std::exception&) {
    return {0, message.record_time};
  }
  *frame = header.frame_id;
  return {static_cast<TimeNs>(header.stamp.toNSec()), message.record_time};
}

// What one message says, worked out in parallel.
struct MessageReading {
  MessageTimes times;
  std::string frame;
  std::optional<StampedImu> imu;
  std::string fault;
  std::optional<ScanSample> scan;
  std::optional<ImageSample> image;
};

class Surveyor {
 public:
  Surveyor(const BagSet& bags, const Rig& rig, const BagSet::Interval& interval) : rig_(rig) {
    survey_.interval = interval;
    survey_.imu_times = {"imu", SensorKind::kImu, {}};
    for (const LidarConfig& lidar : rig.lidars) {
      LidarSurvey& survey = survey_.lidars.emplace_back();
      survey.name = lidar.name;
      try {
        survey.format = FindLidarFormat(ProbeLidar(bags, lidar.topic, interval), lidar.topic);
      } catch (const InputError& error) {
        survey.format_error = error.what();
      }
      survey_.lidar_times.push_back({lidar.name, SensorKind::kLidar, {}});
    }
    for (const CameraConfig& camera : rig.cameras) {
      survey_.cameras.emplace_back().config = camera;
      survey_.camera_times.push_back({camera.name, SensorKind::kCamera, {}});
    }
    survey_.lidar_frames.resize(rig.lidars.size());
    survey_.camera_frames.resize(rig.cameras.size());
    spacing_ = std::max(kClosestSamples, SecondsSince(interval.begin, interval.end) / kSamples);
    next_sample_.assign(1 + rig.lidars.size() + rig.cameras.size(), interval.begin);
  }

  std::vector<std::string> Topics() const {
    std::vector<std::string> topics{rig_.imu.topic};
    for (const LidarConfig& lidar : rig_.lidars) topics.push_back(lidar.topic);
    for (const CameraConfig& camera : rig_.cameras) topics.push_back(camera.topic);
    return topics;
  }

  void Add(const std::vector<RawMessage>& batch) {
    std::vector<MessageReading> readings(batch.size());
    std::vector<bool> sampled(batch.size());
    for (std::size_t i = 0; i < batch.size(); ++i) sampled[i] = IsSample(batch[i]);
    ParallelFor(batch.size(), [&](std::size_t i) { readings[i] = Read(batch[i], sampled[i]); });
    for (std::size_t i = 0; i < batch.size(); ++i) Keep(batch[i].topic, std::move(readings[i]));
  }

  RecordingSurvey Take() { return std::move(survey_); }

 private:
  bool IsSample(const RawMessage& raw) {
    TimeNs& next = next_sample_[raw.topic];
    if (raw.topic == 0 || raw.content.record_time < next) return false;
    next = TimeFrom(raw.content.record_time, spacing_);
    return true;
  }

  bool IsLidar(std::size_t topic) const { return topic >= 1 && topic <= rig_.lidars.size(); }

  MessageReading Read(const RawMessage& raw, bool sampled) const {
    MessageReading reading;
    reading.times = TimesOf(raw.content, &reading.frame);
    try {
      if (raw.topic == 0) {
        reading.imu = DecodeImu(raw.content, rig_.imu.topic, reading.frame);
      } else if (IsLidar(raw.topic)) {
        ReadScan(raw, sampled, &reading);
      } else if (sampled) {
        ReadImage(raw, &reading);
      }
    } catch (const InputError& error) {
      reading.fault = error.what();
    }
    return reading;
  }

  void ReadScan(const RawMessage& raw, bool sampled, MessageReading* reading) const {
    const std::string& topic = rig_.lidars[raw.topic - 1].topic;
    reading->fault = FaultOfCloud(raw.content, topic);
    const auto& format = survey_.lidars[raw.topic - 1].format;
    if (!sampled || !reading->fault.empty() || !format) return;
    std::vector<std::string> fields;
    if (!format->time_field.empty()) fields.push_back(format->time_field);
    reading->scan = MeasureScan(DecodeCloud(raw.content, topic, fields), *format);
  }

  void ReadImage(const RawMessage& raw, MessageReading* reading) const {
    const std::string& topic = rig_.cameras[raw.topic - 1 - rig_.lidars.size()].topic;
    const ImageHeader header = ReadImageHeader(raw.content);
    const cv::Mat image = DecodeImage(raw.content, "topic " + topic);
    const ImageFormat format = FormatOf(topic, header, image);
    reading->image = MeasureImage(ToEightBits(image, format.bits));
    reading->image->record = raw.content.record_time;
    reading->image->encoding = header.encoding;
  }

  void Keep(std::size_t topic, MessageReading reading) {
    if (topic == 0) {
      survey_.imu_times.messages.push_back(reading.times);
      if (reading.imu) survey_.imu.push_back(*reading.imu);
      if (survey_.imu_frame.empty()) survey_.imu_frame = reading.frame;
    } else if (IsLidar(topic)) {
      LidarSurvey& lidar = survey_.lidars[topic - 1];
      ++lidar.messages;
      if (!reading.fault.empty() && lidar.malformed++ == 0) lidar.first_fault = reading.fault;
      if (reading.scan) lidar.samples.push_back(std::move(*reading.scan));
      if (reading.fault.empty()) survey_.lidar_times[topic - 1].messages.push_back(reading.times);
      if (survey_.lidar_frames[topic - 1].empty()) survey_.lidar_frames[topic - 1] = reading.frame;
    } else {
      const std::size_t index = topic - 1 - rig_.lidars.size();
      CameraSurvey& camera = survey_.cameras[index];
      if (!reading.fault.empty() && camera.undecodable++ == 0) camera.first_fault = reading.fault;
      if (reading.image) camera.samples.push_back(*reading.image);
      survey_.camera_times[index].messages.push_back(reading.times);
      if (survey_.camera_frames[index].empty()) survey_.camera_frames[index] = reading.frame;
    }
  }

  const Rig& rig_;
  RecordingSurvey survey_;
  double spacing_ = 0.0;             // s, between samples
  std::vector<TimeNs> next_sample_;  // of each topic, on the recorder's clock
};

}  // namespace

RecordingSurvey SurveyRecording(const BagSet& bags, const Rig& rig, const BagSet::Interval& interval,
                                const CancellationToken& cancellation) {
  Surveyor surveyor(bags, rig, interval);
  ReadInBatches(bags, surveyor.Topics(), interval, cancellation,
                [&](const std::vector<RawMessage>& batch, double) { surveyor.Add(batch); });
  return surveyor.Take();
}

std::vector<LidarRecording> ReadStretch(const BagSet& bags, const Rig& rig, const RecordingSurvey& survey,
                                        const BagSet::Interval& interval, TimeNs epoch,
                                        const CancellationToken& cancellation) {
  std::vector<LidarRecording> recordings(rig.lidars.size());
  std::vector<std::string> topics;
  for (const LidarConfig& lidar : rig.lidars) topics.push_back(lidar.topic);
  ReadInBatches(bags, topics, interval, cancellation, [&](const std::vector<RawMessage>& batch, double) {
    std::vector<ReadScan> scans(batch.size());
    ParallelFor(batch.size(), [&](std::size_t i) {
      const auto& format = survey.lidars[batch[i].topic].format;
      if (format) scans[i] = ReadOneScan(batch[i].content, *format);
    });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (scans[i].scan.points.empty()) continue;
      scans[i].scan.time = SecondsSince(epoch, scans[i].start);
      recordings[batch[i].topic].scans.push_back(std::move(scans[i].scan));
    }
  });
  for (std::size_t l = 0; l < recordings.size(); ++l) {
    std::vector<LidarScan>& scans = recordings[l].scans;
    std::stable_sort(scans.begin(), scans.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    if (survey.lidars[l].format) recordings[l].scan_period = survey.lidars[l].format->scan_period;
  }
  return recordings;
}

}  // namespace mlic
