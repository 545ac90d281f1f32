#include "mlic_core/evaluation/layering.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <tuple>

#include "mlic_core/evaluation/photo_mosaic.h"
#include "mlic_core/evaluation/sensor_colours.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

// Constants of this file, from: structural, how a picture looks.

using Eigen::Vector3d;

constexpr double kSurfaceCell = 1.0;  // m, in which surfaces are sought
constexpr std::size_t kFewest = 200;  // points of a cell
constexpr double kThickest = 0.06;    // m, standard deviation across a surface, of a cell that is one
constexpr double kAlong = 1.0, kAcross = 0.2, kDepth = 0.25;  // m, half of what a section shows
constexpr double kScale = 280.0, kEnlarged = 3.0;             // px/m along; across times as much
constexpr int kTitleHeight = 26, kGap = 10;                   // px
const cv::Scalar kSectionGround(30, 30, 30), kScaleBar(220, 220, 220);

// A place on a surface: along and depth lie in it, the section is across depth.
struct Place {
  Vector3d centre, normal, along, depth;
};

struct SurfaceCell {
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  std::size_t count = 0;
  std::map<int, std::size_t> of_lidars;
};

// Points of the LiDAR that has fewest, of as many LiDARs as see the cell.
std::pair<std::size_t, std::size_t> Worth(const SurfaceCell& cell) {
  std::size_t fewest = cell.count;
  for (const auto& [lidar, count] : cell.of_lidars) fewest = std::min(fewest, count);
  return {cell.of_lidars.size(), fewest};
}

// The cell of a surface (upright: a wall, else the ground) that most LiDARs see, and see best.
std::optional<Place> BestPlace(const std::vector<MapPoint>& map, bool upright) {
  std::map<std::tuple<int, int, int>, SurfaceCell> cells;
  for (const MapPoint& point : map) {
    const Vector3d p = point.position.cast<double>();
    SurfaceCell& cell = cells[{static_cast<int>(std::floor(p.x() / kSurfaceCell)),
                               static_cast<int>(std::floor(p.y() / kSurfaceCell)),
                               static_cast<int>(std::floor(p.z() / kSurfaceCell))}];
    cell.sum += p;
    cell.squares += p * p.transpose();
    ++cell.count;
    ++cell.of_lidars[point.lidar];
  }
  std::optional<Place> best;
  std::pair<std::size_t, std::size_t> most{0, 0};
  for (const auto& [key, cell] : cells) {
    if (cell.count < kFewest || Worth(cell) <= most) continue;
    const double count = static_cast<double>(cell.count);
    const Vector3d mean = cell.sum / count;
    const SymmetricEigen<3> spread(Eigen::Matrix3d(cell.squares / count - mean * mean.transpose()));
    const Vector3d normal = spread.eigenvectors().col(0);
    const double tilt = std::abs(normal.z());
    if (spread.eigenvalues()[0] > kThickest * kThickest || (upright ? tilt > 0.2 : tilt < 0.97)) continue;
    most = Worth(cell);
    const Vector3d along =
        upright ? Vector3d(normal.cross(Vector3d::UnitZ()).normalized()) : Vector3d(normal.unitOrthogonal());
    best = Place{mean, normal, along, normal.cross(along)};
  }
  return best;
}

// Of each sensor of a state the colour that it has in the last one.
std::vector<cv::Scalar> ColoursIn(const MapState& state, const MapState& last) {
  std::vector<cv::Scalar> colours;
  for (const std::string& name : state.sensors) {
    const auto place = std::find(last.sensors.begin(), last.sensors.end(), name);
    colours.push_back(ColourOfLidar(static_cast<std::size_t>(place - last.sensors.begin())));
  }
  return colours;
}

cv::Mat DrawSection(const std::vector<MapPoint>& map, const std::vector<cv::Scalar>& colours,
                    const Place& place) {
  const int width = static_cast<int>(2.0 * kAlong * kScale);
  const int height = static_cast<int>(2.0 * kAcross * kScale * kEnlarged);
  cv::Mat section(height, width, CV_8UC3, kSectionGround);
  for (const MapPoint& point : map) {
    const Vector3d p = point.position.cast<double>() - place.centre;
    if (std::abs(place.depth.dot(p)) > kDepth) continue;
    const cv::Point at(static_cast<int>(std::lround((kAlong + place.along.dot(p)) * kScale)),
                       static_cast<int>(std::lround((kAcross - place.normal.dot(p)) * kScale * kEnlarged)));
    if (!cv::Rect(0, 0, width, height).contains(at)) continue;
    cv::circle(section, at, 2, colours[static_cast<std::size_t>(point.lidar)], cv::FILLED);
  }
  // 5 cm across.
  const int length = static_cast<int>(0.05 * kScale * kEnlarged);
  cv::line(section, {width - 12, height - 10}, {width - 12, height - 10 - length}, kScaleBar, 2);
  LabelPicture("5 cm", {width - 56, height - 10}, &section);
  return section;
}

}  // namespace

cv::Mat DrawLayering(const std::vector<MapState>& states) {
  if (states.empty()) return {};
  std::vector<std::pair<std::string, Place>> places;
  for (const bool upright : {true, false}) {
    const auto place = BestPlace(states.back().map, upright);
    if (place) places.emplace_back(upright ? "a wall" : "the ground", *place);
  }
  if (places.empty()) return {};
  std::vector<cv::Mat> rows;
  for (const MapState& state : states) {
    const std::vector<cv::Scalar> colours = ColoursIn(state, states.back());
    std::vector<cv::Mat> sections;
    for (const auto& [name, place] : places) {
      if (!sections.empty()) sections.emplace_back(sections[0].rows, kGap, CV_8UC3, cv::Scalar::all(0));
      sections.push_back(DrawSection(state.map, colours, place));
      LabelPicture("through " + name, {8, 18}, &sections.back());
    }
    cv::Mat row, title;
    cv::hconcat(sections, row);
    title = cv::Mat(kTitleHeight, row.cols, CV_8UC3, cv::Scalar::all(0));
    LabelPicture(state.title, {8, 18}, &title);
    int right = 300;
    for (std::size_t s = 0; rows.empty() && s < state.sensors.size(); ++s) {
      const bool drawn = std::any_of(state.map.begin(), state.map.end(), [&](const MapPoint& point) {
        return point.lidar == static_cast<int>(s);
      });
      if (!drawn) continue;
      cv::circle(title, {right, 13}, 6, colours[s], cv::FILLED, cv::LINE_AA);
      LabelPicture(state.sensors[s], {right + 12, 18}, &title);
      right += 40 + cv::getTextSize(state.sensors[s], cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width;
    }
    rows.push_back(title);
    rows.push_back(row);
  }
  cv::Mat picture;
  cv::vconcat(rows, picture);
  return picture;
}

}  // namespace mlic
