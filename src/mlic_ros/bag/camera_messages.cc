#include "mlic_ros/bag/camera_messages.h"

#include <cv_bridge/cv_bridge.h>

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"

namespace mlic {
namespace {

std_msgs::Header MakeHeader(const sim::SimulatedCamera& camera, const sim::SimulatedImage& image) {
  std_msgs::Header header;
  header.stamp.fromNSec(static_cast<std::uint64_t>(image.stamp));
  header.frame_id = camera.frame_id;
  return header;
}

const char* DistortionName(CameraModel model) {
  switch (model) {
    case CameraModel::kPlumbBob:
      return "plumb_bob";
    case CameraModel::kRationalPolynomial:
      return "rational_polynomial";
    case CameraModel::kEquidistant:
      return "equidistant";
    case CameraModel::kDoubleSphere:
      return "double_sphere";
  }
  throw InternalError("unknown camera model");
}

const char* EncodingName(sim::ImageEncoding encoding) {
  switch (encoding) {
    case sim::ImageEncoding::kMono8:
      return "mono8";
    case sim::ImageEncoding::kBgr8:
      return "bgr8";
    case sim::ImageEncoding::kBayerRggb8:
      return "bayer_rggb8";
    case sim::ImageEncoding::kJpeg:  // as image_transport writes it
      return "bgr8; jpeg compressed bgr8";
    case sim::ImageEncoding::kMonoJpeg:
      return "mono8; jpeg compressed ";
  }
  throw InternalError("unknown image encoding");
}

}  // namespace

bool IsCompressed(sim::ImageEncoding encoding) {
  return encoding == sim::ImageEncoding::kJpeg || encoding == sim::ImageEncoding::kMonoJpeg;
}

sensor_msgs::Image MakeImageMessage(const sim::SimulatedCamera& camera, const sim::SimulatedImage& image) {
  return *cv_bridge::CvImage(MakeHeader(camera, image), EncodingName(camera.encoding), image.pixels)
              .toImageMsg();
}

sensor_msgs::CompressedImage MakeCompressedMessage(const sim::SimulatedCamera& camera,
                                                   const sim::SimulatedImage& image) {
  sensor_msgs::CompressedImage message;
  message.header = MakeHeader(camera, image);
  message.format = EncodingName(camera.encoding);
  if (!cv::imencode(".jpg", image.pixels, message.data, {cv::IMWRITE_JPEG_QUALITY, camera.jpeg_quality})) {
    throw InternalError("OpenCV cannot write JPEG");
  }
  return message;
}

sensor_msgs::CameraInfo MakeCameraInfo(const sim::SimulatedCamera& camera, const sim::SimulatedImage& image) {
  sensor_msgs::CameraInfo info;
  info.header = MakeHeader(camera, image);
  info.width = static_cast<std::uint32_t>(camera.intrinsics.width);
  info.height = static_cast<std::uint32_t>(camera.intrinsics.height);
  if (camera.camera_info != sim::CameraInfoContent::kTrue) return info;
  const std::vector<double>& p = camera.intrinsics.parameters;
  info.distortion_model = DistortionName(camera.intrinsics.model);
  info.D.assign(p.begin() + 4, p.end());
  info.K = {p[0], 0.0, p[2], 0.0, p[1], p[3], 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {p[0], 0.0, p[2], 0.0, 0.0, p[1], p[3], 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

std::string CameraInfoTopic(const sim::SimulatedCamera& camera) {
  std::string topic = camera.topic;
  const std::string suffix = "/compressed";
  if (topic.size() > suffix.size() &&
      topic.compare(topic.size() - suffix.size(), suffix.size(), suffix) == 0) {
    topic.resize(topic.size() - suffix.size());
  }
  const std::size_t slash = topic.rfind('/');
  return (slash == std::string::npos ? "" : topic.substr(0, slash)) + "/camera_info";
}

}  // namespace mlic
