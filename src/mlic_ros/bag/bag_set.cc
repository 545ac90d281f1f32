#include "mlic_ros/bag/bag_set.h"

#include <algorithm>
#include <fstream>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

constexpr TimeNs kSplitGap = 1'000'000'000;  // from: guard, split recordings follow each other at once

void CheckMagic(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::exists(path, code)) throw InputError("bag " + path.string() + ": no such file");
  if (!std::filesystem::is_regular_file(path, code)) {
    throw InputError("bag " + path.string() + ": not a file; expected a ROS 1 bag");
  }
  if (std::filesystem::file_size(path, code) == 0) {
    throw InputError("bag " + path.string() + ": the file is empty (0 bytes); record it again");
  }
  std::ifstream file(path, std::ios::binary);
  std::string magic(12, '\0');
  if (!file.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != "#ROSBAG V2.0") {
    const bool old = magic.compare(0, 7, "#ROSBAG") == 0;
    throw InputError("bag " + path.string() +
                     (old ? ": not of version 2.0; convert it with `rosbag fix`"
                          : ": not a ROS 1 bag (it does not begin with '#ROSBAG V2.0')" +
                                std::string(file ? "" : " or cannot be read")));
  }
}

std::unique_ptr<rosbag::Bag> Open(const std::filesystem::path& path) {
  CheckMagic(path);
  try {
    return std::make_unique<rosbag::Bag>(path.string(), rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw InputError("bag " + path.string() +
                     ": has no index, the recording was cut off; repair it with `rosbag reindex " +
                     path.string() + "`");
  } catch (const std::exception& error) {
    throw InputError("bag " + path.string() + ": truncated or damaged (" + error.what() +
                     "); try `rosbag reindex " + path.string() + "`");
  }
}

TimeNs Nanoseconds(const ros::Time& time) { return static_cast<TimeNs>(time.toNSec()); }

ros::Time RosTime(TimeNs time) {
  ros::Time result;
  result.fromNSec(static_cast<std::uint64_t>(std::max<TimeNs>(0, time)));
  return result;
}

std::vector<BagSet::Interval> MergeIntervals(std::vector<BagSet::Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  std::vector<BagSet::Interval> merged;
  for (const BagSet::Interval& interval : intervals) {
    if (!merged.empty() && interval.begin <= merged.back().end + kSplitGap) {
      merged.back().end = std::max(merged.back().end, interval.end);
    } else {
      merged.push_back(interval);
    }
  }
  return merged;
}

}  // namespace

BagSet::BagSet(const std::vector<std::filesystem::path>& paths) {
  std::vector<Interval> intervals;
  for (const std::filesystem::path& path : paths) {
    bags_.push_back(Open(path));
    names_ += (names_.empty() ? "" : ", ") + path.string();
    try {
      rosbag::View view(*bags_.back());
      if (view.size() == 0) throw InputError("bag " + path.string() + ": holds no messages");
      intervals.push_back({Nanoseconds(view.getBeginTime()), Nanoseconds(view.getEndTime())});
      for (const rosbag::ConnectionInfo* connection : view.getConnections()) {
        rosbag::View one(*bags_.back(),
                         [&](const rosbag::ConnectionInfo* c) { return c->id == connection->id; });
        Topic& topic = topics_[connection->topic];
        topic.type = connection->datatype;
        topic.messages += one.size();
      }
    } catch (const rosbag::BagException& error) {
      throw InputError("bag " + path.string() + ": truncated or damaged (" + error.what() +
                       "); try `rosbag reindex " + path.string() + "`");
    }
  }
  drives_ = MergeIntervals(intervals);
  interval_ = {drives_.front().begin, drives_.back().end};
}

std::string BagSet::ListTopics() const {
  std::string text;
  for (const auto& [name, topic] : topics_) {
    text += (text.empty() ? "" : ", ") + name + " (" + topic.type + ")";
  }
  return text;
}

std::string BagSet::NameInBag(const std::string& topic) const {
  const std::string other = !topic.empty() && topic.front() == '/' ? topic.substr(1) : "/" + topic;
  return topics_.count(topic) == 0 && topics_.count(other) > 0 ? other : topic;
}

std::unique_ptr<rosbag::View> BagSet::Messages(const std::vector<std::string>& topics,
                                               const Interval& interval) const {
  auto view = std::make_unique<rosbag::View>();
  for (const auto& bag : bags_) {
    view->addQuery(*bag, rosbag::TopicQuery(topics), RosTime(interval.begin), RosTime(interval.end));
  }
  return view;
}

Rig WithTopicsOfBag(Rig rig, const BagSet& bags) {
  rig.imu.topic = bags.NameInBag(rig.imu.topic);
  for (LidarConfig& lidar : rig.lidars) lidar.topic = bags.NameInBag(lidar.topic);
  for (CameraConfig& camera : rig.cameras) camera.topic = bags.NameInBag(camera.topic);
  return rig;
}

}  // namespace mlic
