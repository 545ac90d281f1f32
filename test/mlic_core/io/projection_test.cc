#include <gtest/gtest.h>

#include "mlic_core/io/pictures/projection_picture.h"
#include "mlic_core/io/result/point_cloud_reader.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"

namespace mlic::projection_test {
namespace {

std::string HeaderOf(int points, const std::string& encoding) {
  const std::string count = std::to_string(points);
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity ring\nSIZE 4 4 4 4 2\nTYPE F F F F U\n"
         "COUNT 1 1 1 1 1\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA " + encoding + "\n";
}

template <typename T>
void Put(T value, std::string* out) {
  out->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

TEST(PointCloudReader, ReadsTextAndLeavesOutWhatIsNotFinite) {
  const TemporaryDirectory directory;
  const auto path = directory.Path() / "a.pcd";
  WriteFileAtomically(path, HeaderOf(3, "ascii") + "1 2 3 40 5\nnan nan nan 0 6\n-1 -2 -3 50 7\n");
  const auto points = ReadPointCloudFile(path);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].position, Eigen::Vector3f(-1, -2, -3));
  EXPECT_EQ(points[1].intensity, 50.0f);
  EXPECT_EQ(points[1].ring, 7);
}

TEST(PointCloudReader, ReadsBytesWholeAndCompressed) {
  const TemporaryDirectory directory;
  std::string bytes, columns;
  for (const float k : {1.0f, 2.0f}) {
    for (const float value : {k, 10 * k, 100 * k, 1000 * k}) Put(value, &bytes);
    Put(static_cast<std::uint16_t>(k), &bytes);
  }
  for (const float scale : {1.0f, 10.0f, 100.0f, 1000.0f}) {
    for (const float k : {1.0f, 2.0f}) Put(scale * k, &columns);
  }
  for (const std::uint16_t ring : {1, 2}) Put(ring, &columns);
  // The first 32 bytes as one run of literals, the rest as another.
  std::string packed;
  Put(std::uint32_t{38}, &packed);
  Put(std::uint32_t{36}, &packed);
  packed += std::string(1, 31) + columns.substr(0, 32) + std::string(1, 3) + columns.substr(32);
  WriteFileAtomically(directory.Path() / "whole.pcd", HeaderOf(2, "binary") + bytes);
  WriteFileAtomically(directory.Path() / "packed.pcd", HeaderOf(2, "binary_compressed") + packed);
  for (const char* name : {"whole.pcd", "packed.pcd"}) {
    const auto points = ReadPointCloudFile(directory.Path() / name);
    ASSERT_EQ(points.size(), 2u) << name;
    EXPECT_EQ(points[1].position, Eigen::Vector3f(2, 20, 200)) << name;
    EXPECT_EQ(points[1].intensity, 2000.0f) << name;
    EXPECT_EQ(points[1].ring, 2) << name;
  }
}

TEST(PointCloudReader, RepeatsWhatCompressionRefersBackTo) {
  const TemporaryDirectory directory;
  // Seven points of zeros: one literal byte, then 125 bytes that repeat it (length 7 + 116 + 2, 1 back).
  std::string packed;
  Put(std::uint32_t{5}, &packed);
  Put(std::uint32_t{126}, &packed);
  packed += std::string("\x00\x00", 2) + "\xe0" + "\x74" + std::string(1, '\x00');
  WriteFileAtomically(directory.Path() / "zeros.pcd", HeaderOf(7, "binary_compressed") + packed);
  const auto points = ReadPointCloudFile(directory.Path() / "zeros.pcd");
  ASSERT_EQ(points.size(), 7u);
  EXPECT_EQ(points[6].position, Eigen::Vector3f(0, 0, 0));
}

TEST(PointCloudReader, SaysWhatIsWrong) {
  const TemporaryDirectory directory;
  const auto path = directory.Path() / "bad.pcd";
  const auto error = [&](const std::string& content) {
    WriteFileAtomically(path, content);
    return InputErrorOf([&] { ReadPointCloudFile(path); });
  };
  const std::string whole = "cannot be read as a PCD file; expected a whole one";
  EXPECT_TRUE(Contains(error("ply\n"), whole));
  EXPECT_TRUE(Contains(error(HeaderOf(5, "binary") + "abc"), whole));
  EXPECT_TRUE(Contains(error(HeaderOf(5, "ascii") + "1 2 3 4 5\n"), whole));
  std::string packed;
  Put(std::uint32_t{2}, &packed);
  Put(std::uint32_t{18}, &packed);
  EXPECT_TRUE(Contains(error(HeaderOf(1, "binary_compressed") + packed + "\x20\x40"), whole));
  EXPECT_TRUE(
      Contains(InputErrorOf([&] { ReadPointCloudFile(directory.Path() / "none.pcd"); }), "no such file"));
  EXPECT_TRUE(
      Contains(error("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
                     "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n"),
               "no field intensity"));
}

TEST(ProjectionPicture, ShowsPointsWhereTheyAre) {
  CameraProjection projection;
  projection.camera = "cam";
  projection.rendering = cv::Mat(120, 200, CV_32FC1, std::nanf(""));
  projection.after.push_back({{100.0f, 60.0f}, 5.0f, 1.0f});
  projection.after.push_back({{150.0f, 60.0f}, 50.0f, 9.0f});
  const cv::Mat picture = DrawProjection(cv::Mat(120, 200, CV_8UC1, cv::Scalar(100)), projection);
  ASSERT_EQ(picture.size(), cv::Size(400, 360));
  const auto before = picture.at<cv::Vec3b>(120 + 60, 100), near = picture.at<cv::Vec3b>(120 + 60, 300),
             far = picture.at<cv::Vec3b>(120 + 60, 350);
  EXPECT_EQ(before[0], before[2]);  // no point: gray
  EXPECT_GT(near[2], near[0]);      // red
  EXPECT_GT(far[0], far[2]);        // blue
}

TEST(ProjectionPicture, OfACameraThatWasNotFoundShowsTheGuessAlone) {
  CameraProjection projection;
  projection.found = false;
  projection.guess.push_back({{100.0f, 60.0f}, 5.0f, 1.0f});
  projection.guess.push_back({{150.0f, 60.0f}, 50.0f, 9.0f});
  const cv::Mat photo(120, 200, CV_8UC1, cv::Scalar(100));
  const cv::Mat picture = DrawProjection(photo, projection);
  ASSERT_EQ(picture.size(), cv::Size(400, 120));
  const auto near = picture.at<cv::Vec3b>(60, 100), far = picture.at<cv::Vec3b>(60, 150);
  EXPECT_GT(near[2], near[0]);  // red
  EXPECT_GT(far[0], far[2]);    // blue
  EXPECT_EQ(DrawOverlays(photo, projection).before.at<cv::Vec3b>(60, 100), near);
}

// The points of the guess and those of the result, each on its own picture, near ones in the same red.
TEST(Overlays, OfGuessAndResultShareTheirColours) {
  const cv::Mat photo(100, 200, CV_8UC1, cv::Scalar(100));
  CameraProjection projection;
  for (int i = 0; i < 50; ++i) {
    projection.after.push_back({{100.0f, 30.0f + static_cast<float>(i)}, i < 25 ? 2.0f : 20.0f, 0.0f});
    projection.guess.push_back({{140.0f, 30.0f + static_cast<float>(i)}, i < 25 ? 2.0f : 40.0f, 0.0f});
    projection.before.push_back({{180.0f, 30.0f + static_cast<float>(i)}, 2.0f, 0.0f});
  }
  const OverlayPair pictures = DrawOverlays(photo, projection);
  const auto at = [](const cv::Mat& picture, int u, int v) { return picture.at<cv::Vec3b>(v, u); };
  const cv::Vec3b bare = at(pictures.after, 140, 40), red = at(pictures.after, 100, 40);
  EXPECT_GT(red[2], red[0] + 100);
  EXPECT_EQ(at(pictures.before, 140, 40), red);
  EXPECT_EQ(at(pictures.before, 100, 40), bare);
  EXPECT_EQ(at(pictures.before, 180, 40), bare) << "the guess, not the state before the last stage";
  EXPECT_EQ(at(pictures.before, 4, 4), bare) << "no title, which the line between the two would cut";
  EXPECT_NEAR(pictures.range.near, 2.0f, 0.1f);
  EXPECT_NEAR(pictures.range.far, 20.0f, 0.5f);
  projection.guess.clear();
  EXPECT_EQ(at(DrawOverlays(photo, projection).before, 180, 40), red);
}

}  // namespace
}  // namespace mlic::projection_test
