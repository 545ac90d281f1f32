#include "mlic_core/evaluation/layering.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/evaluation/sensor_colours.h"

namespace mlic::layering_test {
namespace {

// A wall 5 m ahead and the ground, seen by two LiDARs, of which the second has the wall `apart` m too far.
MapState Room(const std::string& title, float apart) {
  Random random(2);
  MapState state{title, {}, {"front", "left"}};
  for (int i = 0; i < 40000; ++i) {
    const int lidar = i % 2;
    const auto noise = static_cast<float>(0.003 * random.Normal());
    const auto a = static_cast<float>(random.Uniform(-3.0, 3.0)),
               b = static_cast<float>(random.Uniform(0.1, 3.0));
    MapPoint point;
    point.lidar = lidar;
    point.position = i % 4 < 2 ? Eigen::Vector3f(5.5f + noise + (lidar == 1 ? apart : 0.0f), a, b)
                               : Eigen::Vector3f(a, 2.0f * b - 3.0f, -0.5f + noise);
    state.map.push_back(point);
  }
  return state;
}

// Mean row of a colour in a part of the picture.
double RowOf(const cv::Mat& picture, const cv::Rect& part, const cv::Scalar& colour) {
  const cv::Vec3b wanted(cv::saturate_cast<unsigned char>(colour[0]),
                         cv::saturate_cast<unsigned char>(colour[1]),
                         cv::saturate_cast<unsigned char>(colour[2]));
  double sum = 0.0, count = 0.0;
  for (int v = part.y; v < part.y + part.height; ++v) {
    for (int u = part.x; u < part.x + part.width; ++u) {
      if (picture.at<cv::Vec3b>(v, u) != wanted) continue;
      sum += v;
      count += 1.0;
    }
  }
  EXPECT_GT(count, 100.0);
  return sum / count;
}

TEST(Layering, ShowsLayersComeTogether) {
  const cv::Mat picture = DrawLayering({Room("guess", 0.08f), Room("calibration", 0.0f)});
  ASSERT_FALSE(picture.empty());
  // A title and a section for each state, the wall to the left.
  const int half = picture.rows / 2, width = (picture.cols - 10) / 2;
  const auto apart = [&](int row) {
    const cv::Rect wall(0, row + 50, width, half - 60);
    return std::abs(RowOf(picture, wall, ColourOfLidar(0)) - RowOf(picture, wall, ColourOfLidar(1)));
  };
  const double before = apart(0), after = apart(half);
  EXPECT_NEAR(before, 0.08 * 280.0 * 3.0, 6.0);
  EXPECT_LT(after, 3.0);
  const cv::Rect ground(width + 10, 50, width, half - 60);
  EXPECT_NEAR(RowOf(picture, ground, ColourOfLidar(0)), RowOf(picture, ground, ColourOfLidar(1)), 3.0);
}

TEST(Layering, NeedsASurface) {
  EXPECT_TRUE(DrawLayering({}).empty());
  Random random(3);
  MapState leaves{"calibration", {}, {"front"}};
  for (int i = 0; i < 20000; ++i) {
    MapPoint point;
    point.position = Eigen::Vector3d(random.Uniform(), random.Uniform(), random.Uniform()).cast<float>();
    leaves.map.push_back(point);
  }
  EXPECT_TRUE(DrawLayering({leaves}).empty());
}

}  // namespace
}  // namespace mlic::layering_test
