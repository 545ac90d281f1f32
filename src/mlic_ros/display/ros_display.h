#pragma once

#include <ros/ros.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <chrono>
#include <map>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_ros/display/job_observer.h"
#include "mlic_ros/display/status_board.h"

namespace mlic {

// Publishes the calibration as it converges, latched: /mlic/voxel_map (MarkerArray), /mlic/voxel_map_points
// (PointCloud2), /mlic/trajectory (Path), /mlic/status (Status), /mlic/rig and /mlic/overlay (MarkerArray),
// and the frames map -> IMU (at the end of the path) -> sensors on /tf_static. With cameras also
// /mlic/landmarks (PointCloud2), /mlic/cameras (MarkerArray), /mlic/NAME/tracks (Image) of each camera and
// /mlic/tracks (Image) of all in one; with LiDARs as well, once the map has been matched,
// /mlic/NAME/projection and /mlic/projections (Image).
class RosDisplay : public JobObserver {
 public:
  explicit RosDisplay(ros::NodeHandle& node);

  void OnProgress(const std::string& stage, double fraction) override;
  void OnSnapshot(const CalibrationSnapshot& snapshot) override;
  void OnMessage(const std::string& line) override;
  void OnPlan(const std::vector<PlannedStage>& plan) override;
  void OnRig(const Rig& rig) override;
  void OnResult(const CalibrationResult& result) override;
  void OnFailure(const std::string& line) override;
  void OnInterruption(const std::string& line) override;

 private:
  double Now() const;  // s since the start
  void PublishStatus();
  void PublishRig(const std::vector<StampedPose>& trajectory);
  void End(std::uint8_t state, const std::string& line);
  void PublishTracks(const std::vector<CameraView>& views);
  void PublishRound(const CalibrationSnapshot& snapshot);
  void PublishProjections(const std::vector<CameraProjection>& projections);

  // Topics of one kind of picture: of each camera, by its name, and of all side by side.
  struct PictureTopics {
    std::map<std::string, ros::Publisher> of_cameras;
    ros::Publisher all;
  };
  PictureTopics AdvertisePictures(const Rig& rig, const std::string& one, const std::string& all);
  // One picture of each of these cameras.
  void PublishPictures(const std::vector<std::string>& cameras, const std::vector<cv::Mat>& pictures,
                       PictureTopics* topics);

  struct Photo {
    std::size_t image = 0;
    cv::Mat pixels;
  };
  // The view's photo, kept for as long as the same one is shown.
  const cv::Mat& PhotoOf(const CameraView& view);

  std::mutex mutex_;  // progress and the timer come from any thread
  ros::NodeHandle node_;
  ros::Publisher voxel_map_, voxel_map_points_, trajectory_, status_publisher_, rig_markers_, overlay_;
  ros::Publisher landmarks_, cameras_;   // of a rig with cameras
  PictureTopics tracks_, projections_;   // likewise
  std::map<std::string, Photo> photos_;  // by camera
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  StatusBoard status_;
  std::string imu_frame_ = "imu";
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double last_progress_ = 0.0, last_overlay_ = -1.0;  // s since the start
  ros::WallTimer heartbeat_;                          // the last one made, the first one to end
};

}  // namespace mlic
