#include "mlic_ros/display/ros_display.h"

#include <nav_msgs/Path.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include "mlic_core/io/pictures/projection_picture.h"
#include "mlic_core/io/pictures/track_picture.h"
#include "mlic_ros/display/display_cameras.h"
#include "mlic_ros/display/display_messages.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr double kSecondsBetweenProgress = 0.1;
constexpr int kTileWidth = 640;  // px, of each camera in pictures of all

}  // namespace

RosDisplay::RosDisplay(ros::NodeHandle& node)
    : node_(node),
      voxel_map_(node.advertise<visualization_msgs::MarkerArray>("/mlic/voxel_map", 1, true)),
      voxel_map_points_(node.advertise<sensor_msgs::PointCloud2>("/mlic/voxel_map_points", 1, true)),
      trajectory_(node.advertise<nav_msgs::Path>("/mlic/trajectory", 1, true)),
      status_publisher_(node.advertise<Status>("/mlic/status", 1, true)) {
  status_.state = Status::RUNNING;
  status_.stage = "starting";
  PublishStatus();
}

void RosDisplay::PublishStatus() {
  status_.header.stamp = ros::Time::now();
  status_publisher_.publish(status_);
}

void RosDisplay::OnProgress(const std::string& stage, double fraction) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  const bool due = std::chrono::duration<double>(now - last_progress_).count() >= kSecondsBetweenProgress;
  if (stage == status_.stage && !due) return;
  last_progress_ = now;
  status_.stage = stage;
  status_.progress = static_cast<float>(fraction);
  PublishStatus();
}

void RosDisplay::OnMessage(const std::string& line) { ROS_DEBUG_STREAM(line); }

void RosDisplay::OnRig(const Rig& rig) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!rig.imu.frame_id.empty()) imu_frame_ = FrameName(rig.imu.frame_id, "imu");
  if (rig.cameras.empty()) return;
  landmarks_ = node_.advertise<sensor_msgs::PointCloud2>("/mlic/landmarks", 1, true);
  cameras_ = node_.advertise<visualization_msgs::MarkerArray>("/mlic/cameras", 1, true);
  tracks_ = AdvertisePictures(rig, "tracks", "tracks");
  if (!rig.lidars.empty()) projections_ = AdvertisePictures(rig, "projection", "projections");
}

RosDisplay::PictureTopics RosDisplay::AdvertisePictures(const Rig& rig, const std::string& one,
                                                        const std::string& all) {
  PictureTopics topics;
  topics.all = node_.advertise<sensor_msgs::Image>("/mlic/" + all, 1, true);
  for (const CameraConfig& camera : rig.cameras) {
    const std::string topic = "/mlic/" + TopicPart(camera.name) + "/" + one;
    topics.of_cameras[camera.name] = node_.advertise<sensor_msgs::Image>(topic, 1, true);
  }
  return topics;
}

void RosDisplay::PublishPictures(const std::vector<std::string>& cameras,
                                 const std::vector<cv::Mat>& pictures, PictureTopics* topics) {
  if (pictures.empty()) return;
  const ros::Time now = ros::Time::now();
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    topics->of_cameras.at(cameras[i]).publish(MakeImage(pictures[i], cameras[i], now));
  }
  topics->all.publish(MakeImage(TilePictures(pictures, kTileWidth), "map", now));
}

void RosDisplay::PublishTracks(const std::vector<CameraView>& views) {
  std::vector<std::string> cameras;
  std::vector<cv::Mat> pictures;
  for (const CameraView& view : views) {
    Photo& photo = photos_[view.camera];
    if (photo.pixels.empty() || photo.image != view.image) {
      photo = {view.image, view.images->Load(view.image)};
    }
    cameras.push_back(view.camera);
    pictures.push_back(DrawTracks(photo.pixels, view));
  }
  PublishPictures(cameras, pictures, &tracks_);
}

void RosDisplay::PublishProjections(const std::vector<CameraProjection>& projections) {
  std::vector<std::string> cameras;
  std::vector<cv::Mat> pictures;
  for (const CameraProjection& projection : projections) {
    cameras.push_back(projection.camera);
    pictures.push_back(DrawProjection(projection.images->Load(projection.image), projection));
  }
  PublishPictures(cameras, pictures, &projections_);
}

void RosDisplay::PublishFrames(const std::vector<SensorStatus>& sensors,
                               const std::vector<StampedPose>& trajectory) {
  const ros::Time now = ros::Time::now();
  std::vector<geometry_msgs::TransformStamped> frames;
  const RigidTransform T_map_imu = trajectory.empty() ? RigidTransform() : trajectory.back().pose;
  frames.push_back(MakeFrame("map", imu_frame_, ToMessage(T_map_imu), now));
  for (const SensorStatus& sensor : sensors) {
    if (sensor.frame_id == imu_frame_) continue;
    frames.push_back(MakeFrame(imu_frame_, sensor.frame_id, sensor.transform, now));
  }
  broadcaster_.sendTransform(frames);
}

void RosDisplay::OnSnapshot(const CalibrationSnapshot& snapshot) {
  const ros::Time now = ros::Time::now();
  if (!snapshot.planes.empty()) voxel_map_.publish(MakePlaneMarkers(snapshot.planes, now));
  if (!snapshot.points.empty()) voxel_map_points_.publish(MakeMapCloud(snapshot.points, now));
  if (!snapshot.trajectory.empty()) trajectory_.publish(MakePath(snapshot.trajectory, now));
  if (!snapshot.landmarks.empty()) landmarks_.publish(MakeLandmarkCloud(snapshot.landmarks, now));
  if (!snapshot.intrinsics.empty()) cameras_.publish(MakeFrustumMarkers(snapshot));
  PublishTracks(snapshot.views);
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.stage = snapshot.stage;
  status_.iteration = snapshot.iteration;
  status_.costs.push_back(snapshot.cost);
  status_.sensors = MakeSensorStatus(snapshot);
  PublishFrames(status_.sensors, snapshot.trajectory);
  PublishStatus();
}

void RosDisplay::OnResult(const CalibrationResult& result) {
  const ros::Time now = ros::Time::now();
  static const std::vector<StampedPose> kNoPath;
  const std::vector<StampedPose>& path = result.trajectories.empty() ? kNoPath : result.trajectories.front();
  if (!result.map.empty()) voxel_map_points_.publish(MakeMapCloud(result.map, now));
  if (!path.empty()) trajectory_.publish(MakePath(path, now));
  PublishTracks(result.views);
  PublishProjections(result.projections);
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.state = result.Trusted() ? Status::TRUSTED : result.Usable() ? Status::PARTIAL : Status::REFUSED;
  status_.stage = "done";
  status_.progress = 1.0f;
  status_.messages = result.reasons;
  status_.messages.insert(status_.messages.end(), result.warnings.begin(), result.warnings.end());
  status_.sensors = MakeSensorStatus(result);
  PublishFrames(status_.sensors, path);
  PublishStatus();
}

void RosDisplay::OnFailure(const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.state = Status::FAILED;
  status_.messages = {line};
  PublishStatus();
}

}  // namespace mlic
