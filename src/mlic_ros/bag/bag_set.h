#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Some bags opened for reading as one recording.
class BagSet {
 public:
  struct Topic {
    std::string type;
    std::size_t messages = 0;
  };
  // Recording times, both ends included.
  struct Interval {
    TimeNs begin = 0;
    TimeNs end = 0;
  };

  // Throws InputError, one line that names the file, for what is no bag, empty, truncated or without its
  // index.
  explicit BagSet(const std::vector<std::filesystem::path>& paths);

  const std::map<std::string, Topic>& topics() const { return topics_; }
  // Name and type of every topic, for messages.
  std::string ListTopics() const;
  // ROS resolves names to absolute ones, people and some recorders leave the slash out: both are one topic.
  std::string NameInBag(const std::string& topic) const;
  const std::string& names() const { return names_; }

  // From the first message of any bag to the last one.
  const Interval& interval() const { return interval_; }
  // Bags that overlap in time, or follow each other within a second as split recordings do, are one drive.
  const std::vector<Interval>& drives() const { return drives_; }

  // Messages of all bags in order of recording time, within the interval.
  std::unique_ptr<rosbag::View> Messages(const std::vector<std::string>& topics,
                                         const Interval& interval) const;

  // To be held while reading single messages: a rosbag::Bag serves one reader at a time.
  std::mutex& reading() const { return reading_; }

 private:
  mutable std::mutex reading_;
  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  std::string names_;
  std::map<std::string, Topic> topics_;
  Interval interval_;
  std::vector<Interval> drives_;
};

// The rig with its topics named as the bags name them.
Rig WithTopicsOfBag(Rig rig, const BagSet& bags);

}  // namespace mlic
