#pragma once

#include <ros/ros.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mlic_ros/display/display_services.h"
#include "mlic_ros/display/job_observer.h"
#include "mlic_ros/display/pause_gate.h"
#include "mlic_ros/display/scene_display.h"
#include "mlic_ros/display/status_board.h"

namespace mlic {

// Publishes the calibration as it converges, latched: /mlic/voxel_map (MarkerArray), /mlic/voxel_map_points
// (PointCloud2), /mlic/trajectory (Path), /mlic/excitation (MarkerArray), /mlic/status (Status), /mlic/rig
// and /mlic/overlay (MarkerArray), and the frames map -> IMU (at the end of the path) -> sensors on
// /tf_static. With cameras also /mlic/landmarks (PointCloud2), /mlic/cameras (MarkerArray), /mlic/NAME/tracks
// (Image) of each camera and /mlic/tracks (Image) of all in one; with LiDARs as well, once the map has been
// matched, /mlic/NAME/projection and /mlic/projections (Image). All frames are below the prefix.
//
// Services: /mlic/pause, /mlic/blink (SetBool), /mlic/show, /mlic/hide, /mlic/colour_by, /mlic/round
// (Choose), /mlic/export (Trigger).
class RosDisplay : public JobObserver {
 public:
  // cancellation: that of the job, which a pause does not outlast.
  RosDisplay(ros::NodeHandle& node, const std::string& frame_prefix, const CancellationToken& cancellation);

  // Where /mlic/export writes: into the folder `unfinished` of the job's output directory.
  void SetOutput(const std::filesystem::path& directory);

  void OnProgress(const std::string& stage, double fraction) override;
  void OnSnapshot(const CalibrationSnapshot& snapshot) override;
  void OnMessage(const std::string& line) override;
  void OnPlan(const std::vector<PlannedStage>& plan) override;
  void OnRig(const Rig& rig) override;
  void OnResult(const CalibrationResult& result) override;
  void OnFailure(const std::string& line) override;
  void OnInterruption(const std::string& line) override;

 private:
  double Now() const;  // s since the start, without pauses
  void OfferServices();
  Answer Pause(bool paused);
  Answer Export();
  void PublishStatus();
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
  // Those of all cameras in one.
  void PublishTiles(const std::vector<std::string>& cameras, const std::vector<cv::Mat>& pictures,
                    PictureTopics* topics);

  struct Photo {
    std::size_t image = 0;
    cv::Mat pixels;
  };
  // The view's photo, kept for as long as the same one is shown.
  const cv::Mat& PhotoOf(const CameraView& view);

  std::mutex mutex_;  // progress and the timer come from any thread
  ros::NodeHandle node_;
  PauseGate pause_;
  SceneDisplay scene_;
  ros::Publisher status_publisher_, overlay_;
  PictureTopics tracks_, projections_;   // of a rig with cameras
  std::map<std::string, Photo> photos_;  // by camera
  StatusBoard status_;
  std::filesystem::path output_;
  std::string imu_frame_;
  std::optional<CalibrationSnapshot> last_;  // without its views
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double last_progress_ = 0.0, last_overlay_ = -1.0;  // s since the start
  float overlay_radius_ = 0.0f;                       // m, of the map that the overlay stands over
  DisplayServices services_;
  ros::WallTimer heartbeat_, blinker_;  // the last ones made, the first ones to end
};

}  // namespace mlic
