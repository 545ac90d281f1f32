#include "mlic_core/evaluation/harp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "mlic_core/common/error.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic::harp_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const CameraIntrinsics kPinhole{
    CameraModel::kPlumbBob, 640, 480, {400, 400, 319.5, 239.5, -0.2, 0.03, 0.001, -0.001, 0}};
const CameraIntrinsics kFisheye{
    CameraModel::kEquidistant, 640, 480, {190, 191, 318, 243, 0.02, -0.004, 0.001, 0}};

// Places of a straight edge from a to b (points in front of the camera, or at its side), each moved across
// the edge in the image by what `off` says of its number.
template <typename Off>
HarpEdge EdgeOf(const CameraIntrinsics& intrinsics, const Vector3d& a, const Vector3d& b, const Off& off) {
  HarpEdge edge;
  constexpr int kPlaces = 200;
  for (int k = 0; k < kPlaces; ++k) {
    const Vector3d point = a + (k + 0.5) / kPlaces * (b - a);
    Vector2d pixel, next;
    EXPECT_TRUE(Project(intrinsics, point, &pixel));
    EXPECT_TRUE(Project(intrinsics, point + 1e-4 * (b - a), &next));
    const Vector2d along = (next - pixel).normalized();
    edge.push_back(pixel + off(k) * Vector2d(-along.y(), along.x()));
  }
  return edge;
}

TEST(Harp, StraightEdgesAreStraightForAnyLens) {
  const auto exact = [](int) { return 0.0; };
  const HarpMeasurement pinhole =
      MeasureHarp({"a"}, {{EdgeOf(kPinhole, {-1.0, -0.5, 2.0}, {1.2, 0.6, 2.5}, exact)}}, kPinhole);
  EXPECT_EQ(pinhole.all.lines, 1u);
  EXPECT_LT(pinhole.all.largest, 1e-5);
  // An edge beside the camera, from before to behind it.
  const HarpMeasurement fisheye =
      MeasureHarp({"a"}, {{EdgeOf(kFisheye, {1.0, -0.3, 1.5}, {1.0, 0.4, -0.1}, exact)}}, kFisheye);
  EXPECT_EQ(fisheye.all.lines, 1u);
  EXPECT_LT(fisheye.all.largest, 1e-5);
}

TEST(Harp, MeasuresDistancesInPixelsOfThePhoto) {
  const auto waves = [](int k) { return 0.7 * std::cos(2.0 * M_PI * (k - 99.5) / 40.0); };
  for (const CameraIntrinsics& intrinsics : {kPinhole, kFisheye}) {
    const HarpEdge edge = EdgeOf(intrinsics, {-1.0, -0.5, 2.0}, {1.2, 0.6, 2.5}, waves);
    const HarpMeasurement found = MeasureHarp({"a"}, {{edge}}, intrinsics);
    EXPECT_EQ(found.all.places, 200u);
    EXPECT_NEAR(found.all.rms, 0.7 / std::sqrt(2.0), 0.01);
    EXPECT_NEAR(found.all.largest, 0.7, 0.02);
    // Positive to the right of the course.
    EXPECT_GT(found.photos[0].lines[0].distances[20], 0.5);
    const HarpHistogram histogram = HistogramOf(found);
    std::size_t sum = 0;
    for (const std::size_t count : histogram.counts) sum += count;
    EXPECT_EQ(sum, 200u);
    // A wave is most often at its ends.
    EXPECT_GT(histogram.counts.front(), histogram.counts[histogram.counts.size() / 2]);
  }
}

TEST(Harp, LeavesOutWhatIsNoEdgeOfTheHarp) {
  const auto speck = [](int k) { return k == 77 ? 3.0 : 0.05 * std::sin(7.0 * k); };
  const HarpEdge straight = EdgeOf(kPinhole, {-1.0, -0.5, 2.0}, {1.2, 0.6, 2.5}, speck);
  HarpEdge arc;
  for (int k = 0; k < 60; ++k)
    arc.emplace_back(320 + 150 * std::cos(0.02 * k), 240 + 150 * std::sin(0.02 * k));
  const HarpMeasurement found = MeasureHarp({"a", "b"}, {{straight, arc}, {arc}}, kPinhole);
  EXPECT_EQ(found.all.lines, 1u);
  EXPECT_LT(found.all.largest, 0.1);
  EXPECT_GT(found.all.places, 190u);
  EXPECT_EQ(found.photos[1].errors.lines, 0u);
  EXPECT_THROW(MeasureHarp({"b"}, {{arc}}, kPinhole), InputError);
}

TEST(Harp, EdgesAreFoundToAFractionOfAPixel) {
  // A bright bar between two lines, each pixel by the share of it that the bar covers, along its row or
  // column.
  for (const double slope : {0.1, 0.9, 4.0}) {
    cv::Mat photo(400, 400, CV_8UC1);
    const Vector2d across = Vector2d(slope, -1.0).normalized();
    for (int v = 0; v < photo.rows; ++v) {
      for (int u = 0; u < photo.cols; ++u) {
        double sum = 0.0;
        for (int sample = 0; sample < 64; ++sample) {
          const Vector2d p(u + (sample % 8 - 3.5) / 8.0, v + (sample / 8 - 3.5) / 8.0);
          sum += std::abs(across.dot(p - Vector2d(200.3, 199.6))) < 15.0 ? 180.0 : 30.0;
        }
        photo.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(std::lround(sum / 64.0));
      }
    }
    const std::vector<HarpEdge> edges = FindHarpEdges(photo, cv::Mat(photo.size(), CV_8UC1, cv::Scalar(255)));
    ASSERT_EQ(edges.size(), 2u);
    for (const HarpEdge& edge : edges) {
      EXPECT_GT((edge.back() - edge.front()).norm(), 350.0);
      double mean = 0.0;
      for (const Vector2d& place : edge) {
        const double off = std::abs(across.dot(place - Vector2d(200.3, 199.6))) - 15.0;
        EXPECT_LT(std::abs(off), 0.06);
        mean += off / static_cast<double>(edge.size());
      }
      EXPECT_LT(std::abs(mean), 0.02);
    }
  }
}

}  // namespace
}  // namespace mlic::harp_test
