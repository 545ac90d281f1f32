#include "mlic_ros/display/display_cameras.h"

#include <cv_bridge/cv_bridge.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "mlic_ros/display/display_clouds.h"
#include "mlic_ros/display/display_messages.h"

namespace mlic {

// A landmark as PCL knows it; the names become the message's fields.
// In no anonymous namespace: there clang warns of the operators that the macro defines and nobody calls.
struct LandmarkPoint {
  float x, y, z, rgb, error;
  std::uint16_t observations;
};

}  // namespace mlic

POINT_CLOUD_REGISTER_POINT_STRUCT(mlic::LandmarkPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(float, rgb, rgb)(
                                      float, error, error)(std::uint16_t, observations, observations))

namespace mlic {
namespace {

// Constants of this file, from: structural, how RViz shows it.

constexpr double kFrustumLength = 0.7;             // of the rig's size
constexpr double kShortest = 0.1, kLongest = 0.5;  // m, of a frustum
constexpr double kFrustumLine = 0.02;              // of the frustum's length
constexpr int kStepsAlongImageEdge = 8;            // of a frustum's outline
constexpr double kNameHeight = 0.055;              // of a camera's name on its tile, of the tile's width

// Where the ray of a pixel ends; pixels that the model does not cover are drawn in towards the centre.
geometry_msgs::Point EndOfRay(const CameraIntrinsics& intrinsics, const Eigen::Vector2d& pixel,
                              double length) {
  const Eigen::Vector2d centre(0.5 * intrinsics.width, 0.5 * intrinsics.height);
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();
  for (int step = 20; step > 0; --step) {
    if (Unproject(intrinsics, centre + 0.05 * step * (pixel - centre), &bearing)) break;
  }
  geometry_msgs::Point point;
  point.x = length * bearing.x();
  point.y = length * bearing.y();
  point.z = length * bearing.z();
  return point;
}

// Along the lower edge, where the pictures' own legends are not.
void WriteName(const std::string& name, cv::Mat* tile) {
  const double scale = tile->cols * kNameHeight / 22.0;  // capitals of that font are 22 px high
  const int thickness = std::max(1, static_cast<int>(std::lround(2.0 * scale)));
  int below = 0;
  const cv::Size size = cv::getTextSize(name, cv::FONT_HERSHEY_SIMPLEX, scale, thickness, &below);
  const cv::Rect back(0, tile->rows - size.height - below - 8, size.width + 16, size.height + below + 8);
  cv::rectangle(*tile, back & cv::Rect(0, 0, tile->cols, tile->rows), cv::Scalar::all(20), cv::FILLED);
  cv::putText(*tile, name, {8, tile->rows - below - 4}, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar::all(240),
              thickness, cv::LINE_AA);
}

std::vector<Eigen::Vector2d> ImageOutline(const CameraIntrinsics& intrinsics) {
  const double right = intrinsics.width - 1.0, bottom = intrinsics.height - 1.0;
  const Eigen::Vector2d corners[] = {{0.0, 0.0}, {right, 0.0}, {right, bottom}, {0.0, bottom}, {0.0, 0.0}};
  std::vector<Eigen::Vector2d> outline;
  for (int edge = 0; edge < 4; ++edge) {
    for (int k = 0; k < kStepsAlongImageEdge; ++k) {
      const double share = static_cast<double>(k) / kStepsAlongImageEdge;
      outline.push_back((1.0 - share) * corners[edge] + share * corners[edge + 1]);
    }
  }
  return outline;
}

}  // namespace

std::uint32_t ColourOfError(float error) {
  const float share = std::clamp(error / kLargeReprojectionError, 0.0f, 1.0f);
  // From white to red: no colour that a LiDAR has.
  const auto rest = static_cast<std::uint32_t>(255.0f * (1.0f - share));
  return 0xff0000u | (rest << 8) | rest;
}

sensor_msgs::PointCloud2 MakeLandmarkCloud(const std::vector<LandmarkMark>& landmarks,
                                           const ros::Time& stamp) {
  pcl::PointCloud<LandmarkPoint> cloud;
  for (const LandmarkMark& landmark : landmarks) {
    LandmarkPoint point{};
    point.x = landmark.position.x(), point.y = landmark.position.y(), point.z = landmark.position.z();
    point.rgb = PackColour(ColourOfError(landmark.error));
    point.error = landmark.error;
    point.observations = static_cast<std::uint16_t>(std::clamp(landmark.observations, 0, 65535));
    cloud.push_back(point);
  }
  return MakeCloudMessage(cloud, stamp);
}

visualization_msgs::MarkerArray MakeFrustumMarkers(const CalibrationSnapshot& snapshot) {
  visualization_msgs::MarkerArray array;
  const std::size_t first = snapshot.sensors.size() - snapshot.intrinsics.size();
  double rig = 0.0;
  for (const SensorCalibration& sensor : snapshot.sensors) {
    rig = std::max(rig, sensor.T_imu_sensor.translation.norm());
  }
  const double length = std::clamp(kFrustumLength * rig, kShortest, kLongest);
  for (std::size_t c = 0; c < snapshot.intrinsics.size(); ++c) {
    visualization_msgs::Marker marker;
    // With stamp zero and locked to its frame it moves along with the camera's latest pose.
    marker.header.frame_id = FrameName(snapshot.sensor_frames[first + c], snapshot.sensor_names[first + c]);
    marker.frame_locked = true;
    marker.ns = "cameras";
    marker.id = static_cast<int>(c);
    marker.type = visualization_msgs::Marker::LINE_LIST;
    marker.action = visualization_msgs::Marker::ADD;
    marker.pose.orientation.w = 1.0;
    marker.scale.x = kFrustumLine * length;
    marker.color.r = 1.0f;
    marker.color.g = 0.85f;
    marker.color.b = 0.3f;
    marker.color.a = 1.0f;
    const CameraIntrinsics& intrinsics = snapshot.intrinsics[c];
    const std::vector<Eigen::Vector2d> outline = ImageOutline(intrinsics);
    for (std::size_t k = 0; k < outline.size(); ++k) {
      const geometry_msgs::Point end = EndOfRay(intrinsics, outline[k], length);
      marker.points.push_back(end);
      marker.points.push_back(EndOfRay(intrinsics, outline[(k + 1) % outline.size()], length));
      if (k % kStepsAlongImageEdge != 0) continue;
      marker.points.emplace_back();  // the camera itself
      marker.points.push_back(end);
    }
    array.markers.push_back(std::move(marker));
  }
  return array;
}

sensor_msgs::Image MakeImage(const cv::Mat& picture, const std::string& frame, const ros::Time& stamp) {
  std_msgs::Header header;
  header.frame_id = frame;
  header.stamp = stamp;
  return *cv_bridge::CvImage(header, "bgr8", picture).toImageMsg();
}

cv::Mat TilePictures(const std::vector<cv::Mat>& pictures, const std::vector<std::string>& names,
                     int tile_width) {
  if (pictures.empty()) return {};
  const int columns = static_cast<int>(std::sqrt(static_cast<double>(pictures.size())));
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  int tile_height = 1;
  for (const cv::Mat& picture : pictures) {
    tile_height = std::max(tile_height, picture.rows * tile_width / picture.cols);
  }
  cv::Mat tiled(rows * tile_height, columns * tile_width, CV_8UC3, cv::Scalar::all(0));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const cv::Mat& picture = pictures[i];
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    const cv::Rect place(column * tile_width, row * tile_height, tile_width,
                         picture.rows * tile_width / picture.cols);
    cv::Mat tile = tiled(place);
    cv::resize(picture, tile, place.size(), 0.0, 0.0, cv::INTER_AREA);
    WriteName(names[i], &tile);
  }
  return tiled;
}

std::string TopicPart(const std::string& name) {
  std::string part = name;
  for (char& c : part) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return part;
}

}  // namespace mlic
