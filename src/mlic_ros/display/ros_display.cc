#include "mlic_ros/display/ros_display.h"

#include <visualization_msgs/MarkerArray.h>

#include <algorithm>

#include "mlic_core/io/pictures/projection_picture.h"
#include "mlic_core/io/pictures/track_picture.h"
#include "mlic_ros/display/display_cameras.h"
#include "mlic_ros/display/display_messages.h"
#include "mlic_ros/display/rig_markers.h"
#include "mlic_ros/display/round_projection.h"
#include "mlic_ros/display/unfinished_result.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr double kSecondsBetweenProgress = 0.1;
constexpr double kSecondsBetweenStatus = 1.0;
constexpr double kSecondsBetweenBlinks = 0.8;
constexpr int kTileWidth = 640;  // px, of each camera in pictures of all

}  // namespace

RosDisplay::RosDisplay(ros::NodeHandle& node, const std::string& frame_prefix,
                       const CancellationToken& cancellation)
    : node_(node),
      pause_(cancellation),
      scene_(node, frame_prefix),
      status_publisher_(node.advertise<Status>("/mlic/status", 50, true)),
      overlay_(node.advertise<visualization_msgs::MarkerArray>("/mlic/overlay", 1, true)),
      services_(node) {
  PublishStatus();
  // Stages that say nothing of themselves for a minute are alive, too.
  heartbeat_ = node_.createWallTimer(ros::WallDuration(kSecondsBetweenStatus), [this](const auto&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (status_.Get().state == Status::RUNNING) PublishStatus();
  });
  blinker_ = node_.createWallTimer(ros::WallDuration(kSecondsBetweenBlinks), [this](const auto&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    scene_.Blink();
  });
  OfferServices();
}

void RosDisplay::SetOutput(const std::filesystem::path& directory) {
  const std::lock_guard<std::mutex> lock(mutex_);
  output_ = directory;
}

void RosDisplay::OfferServices() {
  // What the scene is asked for, and its answer, which /mlic/status shows as well.
  const auto offer_word = [this](const std::string& name, Answer (SceneDisplay::*ask)(const std::string&)) {
    services_.OfferWord(name, [this, ask](const std::string& word) {
      const std::lock_guard<std::mutex> lock(mutex_);
      const Answer answer = (scene_.*ask)(word);
      PublishStatus();
      return answer;
    });
  };
  offer_word("/mlic/show", &SceneDisplay::ShowSensor);
  offer_word("/mlic/hide", &SceneDisplay::HideSensor);
  offer_word("/mlic/colour_by", &SceneDisplay::ColourBy);
  offer_word("/mlic/round", &SceneDisplay::GoToRound);
  services_.OfferSwitch("/mlic/blink", [this](bool blinks) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const Answer answer = scene_.SetBlinking(blinks);
    PublishStatus();
    return answer;
  });
  services_.OfferSwitch("/mlic/pause", [this](bool paused) { return Pause(paused); });
  services_.OfferTrigger("/mlic/export", [this] { return Export(); });
}

Answer RosDisplay::Pause(bool paused) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (status_.Get().state != Status::RUNNING) return {false, "the calibration has ended already"};
  pause_.Set(paused);
  PublishStatus();
  return {true, paused ? "the calibration stands still from its next step on" : "the calibration goes on"};
}

Answer RosDisplay::Export() {
  std::optional<CalibrationSnapshot> snapshot;
  std::filesystem::path directory;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (status_.Get().state != Status::RUNNING) {
      return {false, "the calibration has ended already; what it has found stands in its output directory"};
    }
    if (!last_ || output_.empty()) return {false, "there is no round yet"};
    snapshot = last_;
    directory = output_ / "unfinished";
  }
  try {
    WriteUnfinished(directory, UnfinishedResult(*snapshot, imu_frame_));
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
  return {true, "written, marked as unfinished: " + directory.string()};
}

double RosDisplay::Now() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count() -
         pause_.PausedSeconds();
}

void RosDisplay::PublishStatus() {
  const double now = Now();
  status_.Tick(now);
  Status message = status_.Get();
  message.header.stamp = ros::Time::now();
  message.paused = message.state == Status::RUNNING && pause_.IsPaused();
  scene_.Describe(&message);
  status_publisher_.publish(message);
  // The panel's view follows the map at once.
  const bool due = now - last_overlay_ >= kSecondsBetweenStatus || message.state != Status::RUNNING ||
                   message.paused || message.map_radius != overlay_radius_;
  if (!due) return;
  last_overlay_ = now;
  overlay_radius_ = message.map_radius;
  scene_.Publish(overlay_, MakeOverlay(message));
}

void RosDisplay::OnProgress(const std::string& stage, double fraction) {
  pause_.Wait();
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
  imu_frame_ = FrameName(rig.imu.frame_id, "imu");
  scene_.SetRig(rig);
  status_.SetRig(rig);
  scene_.ShowGuesses(status_.Get().sensors);
  PublishStatus();
  if (rig.cameras.empty()) return;
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
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    scene_.Publish(topics->of_cameras.at(cameras[i]), MakeImage(pictures[i], cameras[i], ros::Time::now()));
  }
}

void RosDisplay::PublishTiles(const std::vector<std::string>& cameras, const std::vector<cv::Mat>& pictures,
                              PictureTopics* topics) {
  if (pictures.empty()) return;
  const cv::Mat tiles = TilePictures(pictures, cameras, kTileWidth);
  scene_.Publish(topics->all, MakeImage(tiles, "map", ros::Time::now()));
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
  PublishTiles(cameras, pictures, &tracks_);
}

// The map's points on the photos as the calibration stands.
void RosDisplay::PublishRound(const CalibrationSnapshot& snapshot) {
  if (snapshot.points.empty()) return;
  const std::string when =
      snapshot.after_solve ? "after round " + std::to_string(snapshot.iteration + 1) : "of " + snapshot.stage;
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
  PublishTiles(cameras, pictures, &projections_);
}

// Of each camera all that the report has; beside the others one photo, which a small window can show.
void RosDisplay::PublishProjections(const std::vector<CameraProjection>& projections) {
  std::vector<std::string> cameras;
  std::vector<cv::Mat> pictures, tiles;
  for (const CameraProjection& projection : projections) {
    const cv::Mat photo = projection.images->Load(projection.image);
    cameras.push_back(projection.camera);
    pictures.push_back(DrawProjection(photo, projection));
    tiles.push_back(projection.found ? DrawByDepth(photo, projection.after, "of the result")
                                     : DrawByDepth(photo, projection.guess, "of the guess"));
  }
  PublishPictures(cameras, pictures, &projections_);
  PublishTiles(cameras, tiles, &projections_);
}

void RosDisplay::OnSnapshot(const CalibrationSnapshot& snapshot) {
  PublishTracks(snapshot.views);
  PublishRound(snapshot);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    status_.AddSnapshot(snapshot);
    if (snapshot.after_solve) {
      last_ = snapshot;
      last_->views.clear();
    }
    Scene scene;
    const auto lidars = static_cast<std::ptrdiff_t>(snapshot.sensors.size() - snapshot.intrinsics.size());
    scene.lidars.assign(snapshot.sensor_names.begin(), snapshot.sensor_names.begin() + lidars);
    scene.points = snapshot.points;
    scene.planes = snapshot.planes;
    scene.trajectory = snapshot.trajectory;
    scene.turning = TurningAlong(scene.trajectory);
    scene.landmarks = snapshot.landmarks;
    scene.sensors = status_.Get().sensors;
    if (!snapshot.intrinsics.empty()) scene.frustums = MakeFrustumMarkers(snapshot);
    scene_.AddRound(std::move(scene));
    PublishStatus();
  }
  pause_.Wait();
}

void RosDisplay::OnResult(const CalibrationResult& result) {
  PublishTracks(result.views);
  PublishProjections(result.projections);
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.SetResult(result);
  Scene scene;
  scene.points = result.map;
  for (const SensorResult& sensor : result.sensors) {
    if (sensor.type == SensorResult::Type::kLidar) scene.lidars.push_back(sensor.name);
  }
  if (!result.trajectories.empty()) scene.trajectory = result.trajectories.front();
  scene.turning = TurningAlong(scene.trajectory);
  scene.sensors = status_.Get().sensors;
  scene_.SetResult(std::move(scene));
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
