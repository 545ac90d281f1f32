#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/evaluation/map_colours.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

using Eigen::Vector3f;

constexpr int kViewWidth = 1200, kViewHeight = 800;
constexpr float kFocalLength = 1000.0f;  // px
constexpr float kFromAbove = 0.75f;      // rad, of the line of sight
constexpr float kAbove = 1.5f;           // m above the trajectory, up to where points are drawn
constexpr float kWithin = 0.8f;          // share of the points that the view is to hold
constexpr float kPointShare = 0.004f;    // of the extent of the view, the size of a point, and
constexpr float kLeastPoint = 0.06f;     // m, its least
const cv::Scalar kMapBackground(30, 30, 30);

struct View {
  Eigen::Matrix3f R_view_map;  // x right, y down, z ahead
  Vector3f centre;             // of the view, m
  float point_size;            // m
};

// From behind and above the way that was driven.
View ViewOf(const std::vector<Vector3f>& points, const std::vector<StampedPose>& trajectory) {
  Vector3f middle = Vector3f::Zero();
  for (const StampedPose& pose : trajectory) {
    middle += pose.pose.translation.cast<float>() / static_cast<float>(trajectory.size());
  }
  std::vector<float> distances;
  for (const Vector3f& point : points) distances.push_back((point - middle).head<2>().norm());
  const float extent = std::max(2.0f, Quantile(distances, kWithin));
  const Vector3f ahead(0.0f, std::cos(kFromAbove), -std::sin(kFromAbove));
  View view;
  view.R_view_map.row(0) = Vector3f::UnitX().transpose();
  view.R_view_map.row(1) = ahead.cross(Vector3f::UnitX()).transpose();
  view.R_view_map.row(2) = ahead.transpose();
  // So far that the extent fills the picture's width.
  view.centre = middle - 2.0f * kFocalLength / kViewWidth * extent * ahead;
  view.point_size = std::max(kLeastPoint, kPointShare * extent);
  return view;
}

}  // namespace

cv::Mat DrawColouredMap(const std::vector<ColouredPoint>& points,
                        const std::vector<StampedPose>& trajectory) {
  float highest = -std::numeric_limits<float>::infinity();
  for (const StampedPose& pose : trajectory) {
    highest = std::max(highest, static_cast<float>(pose.pose.translation.z()) + kAbove);
  }
  std::vector<Vector3f> places;
  std::vector<const ColouredPoint*> drawn;
  for (const ColouredPoint& point : points) {
    if (point.position.z() > highest) continue;
    places.push_back(point.position);
    drawn.push_back(&point);
  }
  if (drawn.empty()) return {};
  const View view = ViewOf(places, trajectory);
  cv::Mat picture(kViewHeight, kViewWidth, CV_8UC3, kMapBackground);
  cv::Mat depth(kViewHeight, kViewWidth, CV_32F, cv::Scalar(std::numeric_limits<float>::infinity()));
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const Vector3f p = view.R_view_map * (places[i] - view.centre);
    if (p.z() < 0.5f) continue;
    const int u = static_cast<int>(std::lround(kFocalLength * p.x() / p.z() + 0.5f * kViewWidth));
    const int v = static_cast<int>(std::lround(kFocalLength * p.y() / p.z() + 0.5f * kViewHeight));
    const int reach = static_cast<int>(std::lround(0.5f * view.point_size * kFocalLength / p.z()));
    for (int y = std::max(0, v - reach); y <= std::min(kViewHeight - 1, v + reach); ++y) {
      for (int x = std::max(0, u - reach); x <= std::min(kViewWidth - 1, u + reach); ++x) {
        if (p.z() >= depth.at<float>(y, x)) continue;
        depth.at<float>(y, x) = p.z();
        const auto& bgr = drawn[i]->bgr;
        picture.at<cv::Vec3b>(y, x) = cv::Vec3b(bgr[0], bgr[1], bgr[2]);
      }
    }
  }
  return picture;
}

}  // namespace mlic
