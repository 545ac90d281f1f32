#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_ros/bag/bag_set.h"
#include "mlic_ros/bag/serialized_message.h"

namespace mlic {

// A message of topic topics[index], still serialised.
struct RawMessage {
  std::size_t topic = 0;
  SerializedMessage content;
  std::shared_ptr<const rosbag::MessageInstance> place;  // to read it again; valid while the bags are open
};

// Hands over the messages of the topics in order of recording, in batches of bounded size. While a batch is
// worked on, the next is read by another thread. The fraction is the share of messages read. Throws
// InputError for a damaged bag.
void ReadInBatches(const BagSet& bags, const std::vector<std::string>& topics,
                   const BagSet::Interval& interval, const CancellationToken& cancellation,
                   const std::function<void(const std::vector<RawMessage>& batch, double fraction)>& work);

// Hands over the messages of one topic in order of recording for as long as `work` returns true. Throws
// InputError for a damaged bag.
void ReadEach(const BagSet& bags, const std::string& topic, const BagSet::Interval& interval,
              const std::function<bool(const SerializedMessage&)>& work);

// The first `count` messages of one topic.
std::vector<SerializedMessage> ReadFirst(const BagSet& bags, const std::string& topic,
                                         const BagSet::Interval& interval, std::size_t count);

// One message once more; for several threads at once. Throws InputError for a damaged bag.
SerializedMessage ReadMessage(const BagSet& bags, const rosbag::MessageInstance& place);

}  // namespace mlic
