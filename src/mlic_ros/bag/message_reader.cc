#include "mlic_ros/bag/message_reader.h"

#include <ros/serialization.h>

#include <future>
#include <map>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr std::size_t kBatchBytes = 48u << 20;  // from: guard, memory
constexpr std::size_t kBatchMessages = 4096;    // from: guard, memory

SerializedMessage Serialised(const rosbag::MessageInstance& message) {
  SerializedMessage raw;
  raw.type = message.getDataType();
  raw.record_time = static_cast<TimeNs>(message.getTime().toNSec());
  raw.bytes.resize(message.size());
  ros::serialization::OStream stream(raw.bytes.data(), static_cast<std::uint32_t>(raw.bytes.size()));
  message.write(stream);
  return raw;
}

[[noreturn]] void ThrowDamaged(const BagSet& bags, const std::exception& error) {
  throw InputError("bag " + bags.names() + ": damaged (" + error.what() +
                   "); try `rosbag reindex`, or choose an undamaged part with --start and --duration");
}

// Reads on in the view until the batch is full; an empty batch means the end.
class BatchReader {
 public:
  BatchReader(const BagSet& bags, rosbag::View& view, const std::map<std::string, std::size_t>& indices,
              const CancellationToken& cancellation)
      : bags_(bags), at_(view.begin()), end_(view.end()), indices_(indices), cancellation_(cancellation) {}

  std::vector<RawMessage> Next() {
    std::vector<RawMessage> batch;
    std::size_t bytes = 0;
    try {
      for (; at_ != end_ && bytes < kBatchBytes && batch.size() < kBatchMessages; ++at_) {
        cancellation_.ThrowIfCancelled();
        batch.push_back({indices_.at(at_->getTopic()), Serialised(*at_),
                         std::make_shared<const rosbag::MessageInstance>(*at_)});
        bytes += batch.back().content.bytes.size();
      }
    } catch (const Cancelled&) {
      throw;
    } catch (const std::exception& error) {
      ThrowDamaged(bags_, error);
    }
    return batch;
  }

 private:
  const BagSet& bags_;
  rosbag::View::iterator at_, end_;
  const std::map<std::string, std::size_t>& indices_;
  const CancellationToken& cancellation_;
};

}  // namespace

void ReadInBatches(const BagSet& bags, const std::vector<std::string>& topics,
                   const BagSet::Interval& interval, const CancellationToken& cancellation,
                   const std::function<void(const std::vector<RawMessage>&, double)>& work) {
  std::map<std::string, std::size_t> indices;
  for (std::size_t i = 0; i < topics.size(); ++i) indices[topics[i]] = i;
  const auto view = bags.Messages(topics, interval);
  const std::size_t count = view->size();
  BatchReader reader(bags, *view, indices, cancellation);
  std::size_t done = 0;
  std::vector<RawMessage> batch = reader.Next();
  while (!batch.empty()) {
    auto next = std::async(std::launch::async, [&reader] { return reader.Next(); });
    done += batch.size();
    work(batch, static_cast<double>(done) / static_cast<double>(count));
    batch = next.get();
  }
}

void ReadEach(const BagSet& bags, const std::string& topic, const BagSet::Interval& interval,
              const std::function<bool(const SerializedMessage&)>& work) {
  const auto view = bags.Messages({topic}, interval);
  const auto read = [&](const rosbag::MessageInstance& message) {
    try {
      return Serialised(message);
    } catch (const std::exception& error) {
      ThrowDamaged(bags, error);
    }
  };
  for (auto at = view->begin(); at != view->end(); ++at) {
    if (!work(read(*at))) return;
  }
}

std::vector<SerializedMessage> ReadFirst(const BagSet& bags, const std::string& topic,
                                         const BagSet::Interval& interval, std::size_t count) {
  std::vector<SerializedMessage> messages;
  ReadEach(bags, topic, interval, [&](const SerializedMessage& message) {
    messages.push_back(message);
    return messages.size() < count;
  });
  return messages;
}

SerializedMessage ReadMessage(const BagSet& bags, const rosbag::MessageInstance& place) {
  const std::lock_guard<std::mutex> lock(bags.reading());
  try {
    return Serialised(place);
  } catch (const std::exception& error) {
    ThrowDamaged(bags, error);
  }
}

}  // namespace mlic
