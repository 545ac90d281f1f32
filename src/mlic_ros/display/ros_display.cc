#include "mlic_ros/display/ros_display.h"

#include <nav_msgs/Path.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <algorithm>

#include "mlic_core/io/pictures/projection_picture.h"
#include "mlic_core/io/pictures/track_picture.h"
#include "mlic_ros/display/display_cameras.h"
#include "mlic_ros/display/display_messages.h"
#include "mlic_ros/display/rig_markers.h"
#include "mlic_ros/display/round_projection.h"
#include "mlic_ros/display/status_text.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr double kSecondsBetweenProgress = 0.1;
constexpr double kSecondsBetweenStatus = 1.0;
constexpr int kTileWidth = 640;  // px, of each camera in pictures of all

}  // namespace

RosDisplay::RosDisplay(ros::NodeHandle& node)
    : node_(node),
      voxel_map_(node.advertise<visualization_msgs::MarkerArray>("/mlic/voxel_map", 1, true)),
      voxel_map_points_(node.advertise<sensor_msgs::PointCloud2>("/mlic/voxel_map_points", 1, true)),
      trajectory_(node.advertise<nav_msgs::Path>("/mlic/trajectory", 1, true)),
      status_publisher_(node.advertise<Status>("/mlic/status", 50, true)),
      rig_markers_(node.advertise<visualization_msgs::MarkerArray>("/mlic/rig", 1, true)),
      overlay_(node.advertise<visualization_msgs::MarkerArray>("/mlic/overlay", 1, true)) {
  PublishStatus();
  // Stages that say nothing of themselves for a minute are alive, too.
  heartbeat_ = node_.createWallTimer(ros::WallDuration(kSecondsBetweenStatus), [this](const auto&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (status_.Get().state == Status::RUNNING) PublishStatus();
  });
}

double RosDisplay::Now() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void RosDisplay::PublishStatus() {
  const double now = Now();
  status_.Tick(now);
  Status message = status_.Get();
  message.header.stamp = ros::Time::now();
  status_publisher_.publish(message);
  const bool due = now - last_overlay_ >= kSecondsBetweenStatus || message.state != Status::RUNNING;
  if (!due) return;
  last_overlay_ = now;
  overlay_.publish(MakeOverlay(message));
}

void RosDisplay::OnProgress(const std::string& stage, double fraction) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = Now();
  const bool is_new = status_.SetProgress(stage, fraction, now);
  if (!is_new && now - last_progress_ < kSecondsBetweenProgress) return;
  last_progress_ = now;
  PublishStatus();
}

void RosDisplay::OnPlan(const std::vector<PlannedStage>& plan) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.SetPlan(plan);
}

void RosDisplay::OnMessage(const std::string& line) { ROS_DEBUG_STREAM(line); }

void RosDisplay::OnRig(const Rig& rig) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!rig.imu.frame_id.empty()) imu_frame_ = FrameName(rig.imu.frame_id, "imu");
  status_.SetRig(rig);
  PublishStatus();
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

const cv::Mat& RosDisplay::PhotoOf(const CameraView& view) {
  Photo& photo = photos_[view.camera];
  if (photo.pixels.empty() || photo.image != view.image) photo = {view.image, view.images->Load(view.image)};
  return photo.pixels;
}

void RosDisplay::PublishTracks(const std::vector<CameraView>& views) {
  std::vector<std::string> cameras;
  std::vector<cv::Mat> pictures;
  for (const CameraView& view : views) {
    cameras.push_back(view.camera);
    pictures.push_back(DrawTracks(PhotoOf(view), view));
  }
  PublishPictures(cameras, pictures, &tracks_);
}

// The map's points on the photos as the calibration stands.
void RosDisplay::PublishRound(const CalibrationSnapshot& snapshot) {
  if (snapshot.points.empty()) return;
  const std::string when = "after round " + std::to_string(snapshot.iteration + 1);
  const auto of_cameras =
      snapshot.sensor_names.end() - static_cast<std::ptrdiff_t>(snapshot.intrinsics.size());
  std::vector<std::string> cameras;
  std::vector<cv::Mat> pictures;
  for (std::size_t k = 0; k < snapshot.views.size(); ++k) {
    const CameraView& view = snapshot.views[k];
    const auto camera = std::find(of_cameras, snapshot.sensor_names.end(), view.camera) - of_cameras;
    const CameraIntrinsics& intrinsics = snapshot.intrinsics[static_cast<std::size_t>(camera)];
    cameras.push_back(view.camera);
    pictures.push_back(
        DrawByDepth(PhotoOf(view), ProjectMap(snapshot.points, snapshot.view_poses[k], intrinsics), when));
  }
  PublishPictures(cameras, pictures, &projections_);
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

void RosDisplay::PublishRig(const std::vector<StampedPose>& trajectory) {
  const ros::Time now = ros::Time::now();
  std::vector<geometry_msgs::TransformStamped> frames;
  const RigidTransform T_map_imu = trajectory.empty() ? RigidTransform() : trajectory.back().pose;
  frames.push_back(MakeFrame("map", imu_frame_, ToMessage(T_map_imu), now));
  for (const SensorStatus& sensor : status_.Get().sensors) {
    if (!IsFound(sensor.state) || sensor.frame_id == imu_frame_) continue;
    frames.push_back(MakeFrame(imu_frame_, sensor.frame_id, sensor.transform, now));
  }
  broadcaster_.sendTransform(frames);
  rig_markers_.publish(MakeRigMarkers(status_.Get(), imu_frame_));
}

void RosDisplay::OnSnapshot(const CalibrationSnapshot& snapshot) {
  const ros::Time now = ros::Time::now();
  if (!snapshot.planes.empty()) voxel_map_.publish(MakePlaneMarkers(snapshot.planes, now));
  if (!snapshot.points.empty()) voxel_map_points_.publish(MakeMapCloud(snapshot.points, now));
  if (!snapshot.trajectory.empty()) trajectory_.publish(MakePath(snapshot.trajectory, now));
  if (!snapshot.landmarks.empty()) landmarks_.publish(MakeLandmarkCloud(snapshot.landmarks, now));
  if (!snapshot.intrinsics.empty()) cameras_.publish(MakeFrustumMarkers(snapshot));
  PublishTracks(snapshot.views);
  PublishRound(snapshot);
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.AddSnapshot(snapshot);
  PublishRig(snapshot.trajectory);
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
  status_.SetResult(result);
  PublishRig(path);
  PublishStatus();
}

void RosDisplay::End(std::uint8_t state, const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.SetEnd(state, line);
  PublishStatus();
}

void RosDisplay::OnFailure(const std::string& line) { End(Status::FAILED, line); }

void RosDisplay::OnInterruption(const std::string& line) { End(Status::INTERRUPTED, line); }

}  // namespace mlic
