#include "mlic_ros/bag/rig_draft.h"

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Imu.h>

#include <cctype>
#include <cmath>
#include <set>

#include "mlic_core/common/error.h"
#include "mlic_core/ingest/lidar_format.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/lidar_messages.h"
#include "mlic_ros/bag/message_reader.h"
#include "mlic_ros/bag/static_transforms.h"

namespace mlic {
namespace {

using TopicEntry = std::pair<const std::string, BagSet::Topic>;

template <typename Message>
boost::shared_ptr<Message> FirstMessage(const BagSet& bags, const std::string& topic) {
  const auto view = bags.Messages({topic}, bags.interval());
  return view->size() == 0 ? nullptr : view->begin()->instantiate<Message>();
}

ImageHeader FirstImageHeader(const BagSet& bags, const std::string& topic) {
  const auto first = ReadFirst(bags, topic, bags.interval(), 1);
  return first.empty() ? ImageHeader() : ReadImageHeader(first.front());
}

// "/camera_02" of "/camera_02/image_raw/compressed".
std::string CameraNamespace(const std::string& topic) {
  std::string name = topic;
  const std::string compressed = "/compressed";
  if (name.size() > compressed.size() &&
      name.compare(name.size() - compressed.size(), std::string::npos, compressed) == 0) {
    name.resize(name.size() - compressed.size());
  }
  return name.substr(0, name.find_last_of('/'));
}

// A name for files from a topic: its last part that says which sensor it is, as front_lidar of
// "/front_lidar/points", forward of "/livox/forward", velodyne of "/velodyne_points".
std::string NameFromTopic(const std::string& topic, std::set<std::string>& taken) {
  static const std::set<std::string> kCommonParts{"points", "points_raw", "point_cloud", "pointcloud",
                                                  "cloud",  "lidar",      "image",       "raw"};
  std::string name = topic.substr(topic.front() == '/' ? 1 : 0);
  for (std::size_t slash = name.find_last_of('/'); slash != std::string::npos;
       slash = name.find_last_of('/')) {
    const std::string last = name.substr(slash + 1);
    if (kCommonParts.count(last) == 0) {
      name = last;
      break;
    }
    name.resize(slash);
  }
  const std::string suffix = "_points";
  if (name.size() > suffix.size() &&
      name.compare(name.size() - suffix.size(), std::string::npos, suffix) == 0) {
    name.resize(name.size() - suffix.size());
  }
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name = "sensor_" + name;
  std::string unique = name;
  for (int number = 2; !taken.insert(unique).second; ++number) unique = name + "_" + std::to_string(number);
  return unique;
}

ImuConfig DraftImu(const BagSet& bags, std::vector<std::string>& notes) {
  const TopicEntry* best = nullptr;
  for (const TopicEntry& entry : bags.topics()) {
    if (entry.second.type != "sensor_msgs/Imu") continue;
    if (best != nullptr) notes.push_back("several IMU topics: the one with most messages is taken");
    if (best == nullptr || entry.second.messages > best->second.messages) best = &entry;
  }
  if (best == nullptr) {
    throw InputError("bag " + bags.names() +
                     ": no topic of type sensor_msgs/Imu, without which there is no rig; the topics are: " +
                     bags.ListTopics());
  }
  ImuConfig imu;
  imu.topic = best->first;
  const auto message = FirstMessage<sensor_msgs::Imu>(bags, imu.topic);
  if (message != nullptr) imu.frame_id = message->header.frame_id;
  return imu;
}

// From /tf_static and the fixed joints of /tf, with the default sigmas.
std::optional<ExtrinsicGuess> DraftGuess(const StaticTransforms& transforms, const std::string& imu,
                                         const std::string& sensor, std::vector<std::string>& notes) {
  // Drivers that all write one frame say nothing of where their sensors are.
  if (imu.empty() || sensor.empty() || sensor == imu) return std::nullopt;
  const auto pose = transforms.Find(imu, sensor);
  if (!pose) {
    if (!transforms.empty())
      notes.push_back("/tf_static and the fixed joints of /tf do not link " + sensor + " to " + imu +
                      ": no guess");
    return std::nullopt;
  }
  ExtrinsicGuess guess;
  guess.T_imu_sensor = *pose;
  return guess;
}

LidarConfig DraftLidar(const BagSet& bags, const std::string& topic, std::set<std::string>& names) {
  LidarConfig lidar;
  lidar.topic = topic;
  lidar.name = NameFromTopic(topic, names);
  for (const DecodedCloud& cloud : ProbeLidar(bags, topic, bags.interval())) {
    if (lidar.frame_id.empty()) lidar.frame_id = cloud.frame_id;
  }
  return lidar;
}

// Model and intrinsics; focal length 0 means that the driver knows none.
void ApplyCameraInfo(const sensor_msgs::CameraInfo& info, CameraConfig& camera) {
  std::size_t terms = 5;
  if (info.distortion_model == "rational_polynomial") {
    camera.model = CameraModel::kRationalPolynomial;
    terms = 8;
  } else if (info.distortion_model == "equidistant" || info.distortion_model == "fisheye") {
    camera.model = CameraModel::kEquidistant;
    terms = 4;
  }
  if (!(info.K[0] > 0.0)) return;
  std::vector<double> intrinsics{info.K[0], info.K[4], info.K[2], info.K[5]};
  for (std::size_t i = 0; i < terms; ++i) intrinsics.push_back(i < info.D.size() ? info.D[i] : 0.0);
  camera.intrinsics = intrinsics;
  if (info.width > 0) {
    const double angle = camera.model == CameraModel::kEquidistant
                             ? info.width / info.K[0]
                             : 2.0 * std::atan(0.5 * info.width / info.K[0]);
    camera.fov_deg = std::round(angle * 180.0 / M_PI);
  }
}

CameraConfig DraftCamera(const BagSet& bags, const std::string& topic, std::set<std::string>& names,
                         std::vector<std::string>& notes) {
  CameraConfig camera;
  camera.topic = topic;
  const std::string place = CameraNamespace(topic);
  camera.name = NameFromTopic(place + "/image", names);
  camera.frame_id = FirstImageHeader(bags, topic).frame_id;
  const auto info = bags.topics().find(place + "/camera_info");
  if (info != bags.topics().end() && info->second.type == "sensor_msgs/CameraInfo") {
    const auto message = FirstMessage<sensor_msgs::CameraInfo>(bags, info->first);
    if (message != nullptr) ApplyCameraInfo(*message, camera);
  }
  if (!camera.intrinsics) {
    notes.push_back("topic " + topic + ": no CameraInfo with a focal length; fill in fov_deg of " +
                    camera.name + " and correct its model");
  }
  return camera;
}

// Why a topic of a sensor's type is none: maps that are published as clouds, images of depth. Empty: it is
// one.
std::string WhyNoSensor(const BagSet& bags, const TopicEntry& entry) {
  constexpr double kSlowest = 1.0;  // Hz; from: guard
  const double seconds = SecondsSince(bags.interval().begin, bags.interval().end);
  if (static_cast<double>(entry.second.messages) < kSlowest * seconds)
    return "less than one message a second";
  const std::string& topic = entry.first;
  if (IsLidarType(entry.second.type)) {
    try {
      FindLidarFormat(ProbeLidar(bags, topic, bags.interval()), topic);
    } catch (const InputError& error) {
      return std::string("not usable: ") + error.what();
    }
    return "";
  }
  const std::string depth = "/compressedDepth";
  bool is_depth = topic.size() > depth.size() &&
                  topic.compare(topic.size() - depth.size(), std::string::npos, depth) == 0;
  if (entry.second.type == "sensor_msgs/Image") {
    const std::string encoding = FirstImageHeader(bags, topic).encoding;
    is_depth = encoding == "16UC1" || encoding == "32FC1";
  }
  return is_depth ? "images of depth" : "";
}

}  // namespace

Rig DraftRig(const BagSet& bags, std::vector<std::string>& notes) {
  Rig rig;
  rig.imu = DraftImu(bags, notes);
  const StaticTransforms transforms(bags);
  std::set<std::string> names, camera_places;
  std::string packets;  // of the last such topic, what to do
  for (const TopicEntry& entry : bags.topics()) {
    const auto& [topic, content] = entry;
    if (IsRawLidarType(content.type)) {
      packets = "topic " + topic + ": left out, it holds a LiDAR's raw packets (" + content.type + "); " +
                kRawLidarRemedy;
      notes.push_back(packets);
    }
    const bool image = content.type == "sensor_msgs/Image" || content.type == "sensor_msgs/CompressedImage";
    if (!image && !IsLidarType(content.type)) continue;
    const std::string why_not = WhyNoSensor(bags, entry);
    if (!why_not.empty()) {
      notes.push_back("topic " + topic + ": left out, " + why_not);
      continue;
    }
    if (!image) {
      LidarConfig lidar = DraftLidar(bags, topic, names);
      lidar.guess = DraftGuess(transforms, rig.imu.frame_id, lidar.frame_id, notes);
      rig.lidars.push_back(lidar);
    }
    if (image && !camera_places.insert(CameraNamespace(topic)).second) {
      notes.push_back("topic " + topic + ": left out, its camera has another image topic");
    } else if (image) {
      CameraConfig camera = DraftCamera(bags, topic, names, notes);
      camera.guess = DraftGuess(transforms, rig.imu.frame_id, camera.frame_id, notes);
      rig.cameras.push_back(camera);
    }
  }
  if (rig.lidars.empty() && rig.cameras.empty()) {
    throw InputError("bag " + bags.names() + ": neither LiDAR nor camera topics; the topics are: " +
                     bags.ListTopics() + (packets.empty() ? "" : "; ") + packets);
  }
  return rig;
}

void MakeFramesUnique(Rig* rig, std::vector<std::string>* notes) {
  std::set<std::string> taken{rig->imu.frame_id};
  const auto check = [&](auto& sensor) {
    if (sensor.frame_id.empty() || taken.insert(sensor.frame_id).second) return;
    notes->push_back("topic " + sensor.topic + ": its frame " + sensor.frame_id +
                     " is another sensor's as well; it gets the frame " + sensor.name);
    sensor.frame_id = sensor.name;
  };
  for (LidarConfig& lidar : rig->lidars) check(lidar);
  for (CameraConfig& camera : rig->cameras) check(camera);
}

}  // namespace mlic
