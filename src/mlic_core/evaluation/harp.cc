#include "mlic_core/evaluation/harp.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/evaluation/pixel_distance.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

// Constants of this file, from: definition of the figure of merit.

using Eigen::Vector3d;

constexpr double kShortestShare = 0.1;  // length of an edge, of the photo's width
constexpr std::size_t kAtEnds = 5;      // places left out at either end, where something crosses the edge
constexpr std::size_t kMean = 8;        // places of one mean
// An edge whose root mean square distance from its line is a larger share of its length is none of a harp: a
// circle's arc of 28 deg has as much.
constexpr double kMostBend = 0.02;
constexpr double kMostJump = 5.0;    // robust deviations of a place from the middle of its neighbours
constexpr double kLeastJump = 0.05;  // px, the least that counts as such a deviation
constexpr int kBins = 41;
// A place is lit where its brightest photo has this share of what the brightest tenth of the image has.
constexpr double kBright = 0.9, kLit = 0.6;
constexpr int kFromRim = 4;      // px, which are left out beside what is not lit
constexpr int kGapOfWidth = 12;  // dark gaps up to the image's width over this are bars that no photo lights

// A unit vector across the line in the photo, to the right of its course (x right, y down).
Eigen::Vector2d Across(const HarpLine& line) {
  const Eigen::Vector2d along = (line.places.back() - line.places.front()).normalized();
  return {-along.y(), along.x()};
}

// The line of these places; false where the model does not reach one of them.
bool FitLine(const CameraIntrinsics& intrinsics, HarpLine* line) {
  std::vector<Vector3d> bearings;
  for (const Eigen::Vector2d& place : line->places) {
    bearings.emplace_back();
    if (!Unproject(intrinsics, place, &bearings.back())) return false;
  }
  const std::size_t middle = bearings.size() / 2;
  Vector3d to_the_right;
  if (!Unproject(intrinsics, line->places[middle] + Across(*line), &to_the_right)) return false;
  // Least squares of distances in pixels: the bearings' weights depend on the normal, a little.
  std::vector<double> weights(bearings.size(), 1.0);
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < bearings.size(); ++i) {
      scatter += weights[i] * bearings[i] * bearings[i].transpose();
    }
    Vector3d normal = SymmetricEigen<3>(scatter).eigenvectors().col(0);
    if (normal.dot(to_the_right - bearings[middle]) < 0.0) normal = -normal;
    line->distances.assign(bearings.size(), 0.0);
    for (std::size_t i = 0; i < bearings.size(); ++i) {
      if (!PixelDistance(intrinsics, bearings[i], normal, &line->distances[i])) return false;
      const double off = normal.dot(bearings[i]);
      const double scale = off == 0.0 ? 0.0 : line->distances[i] / off;  // px per unit of the bearing
      if (scale > 0.0) weights[i] = scale * scale;
    }
  }
  return true;
}

double LengthOf(const HarpLine& line) { return (line.places.back() - line.places.front()).norm(); }

// How far place i is from the middle of its neighbours, across the line.
double JumpAt(const HarpLine& line, std::size_t i) {
  const std::vector<double>& d = line.distances;
  return std::abs(d[i] - 0.5 * (d[i - 1] + d[i + 1]));
}

// Leaves out places that jump out of their edge's course and fits the lines anew.
void RemoveJumps(const CameraIntrinsics& intrinsics, std::vector<HarpLine>* lines) {
  std::vector<double> jumps;
  for (const HarpLine& line : *lines) {
    for (std::size_t i = 1; i + 1 < line.places.size(); ++i) jumps.push_back(JumpAt(line, i));
  }
  const double limit = kMostJump * std::max(kLeastJump, 1.4826 * Median(jumps));
  for (HarpLine& line : *lines) {
    HarpLine kept;
    for (std::size_t i = 0; i < line.places.size(); ++i) {
      if (i > 0 && i + 1 < line.places.size() && JumpAt(line, i) > limit) continue;
      kept.places.push_back(line.places[i]);
    }
    if (kept.places.size() < line.places.size() && kept.places.size() > 3 && FitLine(intrinsics, &kept)) {
      line = kept;
    }
  }
}

HarpErrors ErrorsOf(const std::vector<HarpLine>& lines) {
  HarpErrors errors;
  errors.lines = lines.size();
  double squares = 0.0;
  for (const HarpLine& line : lines) {
    errors.places += line.places.size();
    for (const double distance : line.distances) {
      squares += distance * distance;
      errors.largest = std::max(errors.largest, std::abs(distance));
    }
  }
  if (errors.places > 0) errors.rms = std::sqrt(squares / static_cast<double>(errors.places));
  return errors;
}

cv::Mat InGray(const cv::Mat& photo) {
  if (photo.channels() == 1) return photo;
  cv::Mat gray;
  cv::cvtColor(photo, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

HarpEdge MeansOf(const EdgeCurve& curve) {
  HarpEdge edge;
  for (std::size_t begin = kAtEnds; begin + kMean + kAtEnds <= curve.size(); begin += kMean) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t i = begin; i < begin + kMean; ++i) sum += curve[i];
    edge.push_back(sum / static_cast<double>(kMean));
  }
  return edge;
}

}  // namespace

void LitPart::Add(const cv::Mat& photo) {
  const cv::Mat gray = InGray(photo);
  if (brightest_.empty()) {
    brightest_ = gray.clone();
  } else {
    cv::max(brightest_, gray, brightest_);
  }
}

cv::Mat LitPart::Mask() const {
  const auto bright = Quantile(
      std::vector<std::uint8_t>(brightest_.begin<std::uint8_t>(), brightest_.end<std::uint8_t>()), kBright);
  cv::Mat mask = brightest_ >= kLit * bright;
  const int gap = std::max(1, brightest_.cols / kGapOfWidth);
  cv::copyMakeBorder(mask, mask, gap, gap, gap, gap, cv::BORDER_REPLICATE);
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {gap, gap}));
  mask = mask(cv::Rect(gap, gap, brightest_.cols, brightest_.rows)).clone();
  cv::erode(mask, mask, cv::getStructuringElement(cv::MORPH_RECT, {2 * kFromRim + 1, 2 * kFromRim + 1}));
  return mask;
}

std::vector<HarpEdge> FindHarpEdges(const cv::Mat& photo, const cv::Mat& mask) {
  const std::size_t shortest =
      std::max(static_cast<std::size_t>(kShortestShare * photo.cols), 2 * kAtEnds + 4 * kMean);
  std::vector<HarpEdge> edges;
  EdgeCurve part;
  const auto end_part = [&] {
    if (part.size() >= shortest) edges.push_back(MeansOf(part));
    part.clear();
  };
  for (const EdgeCurve& curve : TraceEdges(InGray(photo), shortest)) {
    for (const Eigen::Vector2d& place : curve) {
      const cv::Point pixel(static_cast<int>(std::lround(place.x())),
                            static_cast<int>(std::lround(place.y())));
      if (mask.at<std::uint8_t>(pixel) == 0) {
        end_part();
      } else {
        part.push_back(place);
      }
    }
    end_part();
  }
  return edges;
}

HarpMeasurement MeasureHarp(const std::vector<std::string>& names,
                            const std::vector<std::vector<HarpEdge>>& edges,
                            const CameraIntrinsics& intrinsics) {
  HarpMeasurement measurement;
  std::vector<HarpLine> all;
  for (std::size_t k = 0; k < names.size(); ++k) {
    HarpPhoto photo;
    photo.name = names[k];
    for (const HarpEdge& edge : edges[k]) {
      HarpLine line{edge, {}};
      if (!FitLine(intrinsics, &line)) continue;
      if (ErrorsOf({line}).rms > kMostBend * LengthOf(line)) continue;
      photo.lines.push_back(line);
    }
    RemoveJumps(intrinsics, &photo.lines);
    photo.errors = ErrorsOf(photo.lines);
    all.insert(all.end(), photo.lines.begin(), photo.lines.end());
    measurement.photos.push_back(std::move(photo));
  }
  measurement.all = ErrorsOf(all);
  if (all.empty()) {
    throw InputError(
        "no photo shows a straight edge; photograph parallel bars or taut strings before a plain background");
  }
  return measurement;
}

HarpHistogram HistogramOf(const HarpMeasurement& measurement) {
  HarpHistogram histogram;
  histogram.limit = measurement.all.largest;
  histogram.counts.assign(kBins, 0);
  for (const HarpPhoto& photo : measurement.photos) {
    for (const HarpLine& line : photo.lines) {
      for (const double distance : line.distances) {
        const double share = histogram.limit > 0.0 ? 0.5 + 0.5 * distance / histogram.limit : 0.5;
        const int bin = std::clamp(static_cast<int>(share * kBins), 0, kBins - 1);
        ++histogram.counts[static_cast<std::size_t>(bin)];
      }
    }
  }
  return histogram;
}

}  // namespace mlic
