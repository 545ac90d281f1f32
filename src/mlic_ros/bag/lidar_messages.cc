#include "mlic_ros/bag/lidar_messages.h"

#include "mlic_core/common/error.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/message_reader.h"

namespace mlic {
namespace {

constexpr std::size_t kProbeMessages = 10;  // from: guard, a topic's first messages

}  // namespace

std::vector<DecodedCloud> ProbeLidar(const BagSet& bags, const std::string& topic,
                                     const BagSet::Interval& interval) {
  std::vector<DecodedCloud> probe;
  std::size_t malformed = 0;
  std::string first_fault;
  ReadEach(bags, topic, interval, [&](const SerializedMessage& message) {
    try {
      probe.push_back(DecodeCloud(message, topic, PointTimeFieldNames()));
    } catch (const InputError& error) {
      if (malformed++ == 0) first_fault = error.what();
    }
    return probe.size() < kProbeMessages;
  });
  if (probe.empty() && malformed > 0) {
    throw InputError(first_fault + " (so are all " + std::to_string(malformed) + " messages of the topic)");
  }
  return probe;
}

ReadScan ReadOneScan(const SerializedMessage& message, const LidarFormat& format) {
  try {
    std::vector<std::string> time_fields;
    if (!format.time_field.empty()) time_fields.push_back(format.time_field);
    return MakeScan(DecodeCloud(message, format.topic, time_fields), format);
  } catch (const InputError& error) {
    return MalformedScan(message.record_time, error.what());
  }
}

MalformedClouds CountMalformed(const BagSet& bags, const std::string& topic,
                               const BagSet::Interval& interval) {
  MalformedClouds count;
  ReadEach(bags, topic, interval, [&](const SerializedMessage& message) {
    ++count.messages;
    const std::string fault = FaultOfCloud(message, topic);
    if (!fault.empty() && count.malformed++ == 0) count.first_fault = fault;
    return true;
  });
  return count;
}

}  // namespace mlic
