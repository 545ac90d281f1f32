#pragma once

#include <string>
#include <vector>

#include "mlic_core/ingest/decoded_cloud.h"
#include "mlic_core/ingest/scan_reader.h"
#include "mlic_ros/bag/bag_set.h"
#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

// The first messages of a LiDAR topic that are not malformed, at most ten, with all fields that may hold
// point times. Empty where the topic has no messages; throws InputError, one line that starts with the topic,
// when all of them are malformed.
std::vector<DecodedCloud> ProbeLidar(const BagSet& bags, const std::string& topic,
                                     const BagSet::Interval& interval);

// Decodes one message and thins it out; a malformed one becomes a scan that says so.
ReadScan ReadOneScan(const SerializedMessage& message, const LidarFormat& format);

// The malformed messages of a LiDAR topic, of which all are read.
struct MalformedClouds {
  std::size_t messages = 0;
  std::size_t malformed = 0;
  std::string first_fault;  // one line that starts with the topic
};
MalformedClouds CountMalformed(const BagSet& bags, const std::string& topic,
                               const BagSet::Interval& interval);

}  // namespace mlic
