#include "mlic_core/ingest/lidar_format.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mlic_core/ingest/scan_reader.h"
#include "support/files.h"

namespace mlic::lidar_format_test {
namespace {

constexpr int kColumns = 360;
constexpr double kPeriod = 0.1;

// Scans at 10 Hz that cover `view` radians; `field` holds the time of each point in units of `count` s.
std::vector<DecodedCloud> Scans(double view, const std::string& field, double count) {
  std::vector<DecodedCloud> scans(10);
  for (std::size_t k = 0; k < scans.size(); ++k) {
    DecodedCloud& cloud = scans[k];
    cloud.stamp = 1'700'000'000'000'000'000 + static_cast<TimeNs>(k) * 100'000'000;
    cloud.frame_id = "lidar_frame";
    cloud.fields = "x y z f32";
    if (!field.empty()) cloud.times.push_back({field, {}});
    for (int i = 0; i < kColumns; ++i) {
      const double azimuth = view * i / kColumns;
      cloud.positions.push_back(
          Eigen::Vector3d(20.0 * std::cos(azimuth), 20.0 * std::sin(azimuth), 1.0).cast<float>());
      if (!field.empty()) cloud.times[0].values.push_back(kPeriod * i / kColumns / count);
    }
  }
  return scans;
}

std::string ErrorOf(const std::vector<DecodedCloud>& scans) {
  return InputErrorOf([&] { FindLidarFormat(scans, "/points"); });
}

TEST(LidarFormat, FindsFieldAndUnit) {
  std::vector<DecodedCloud> scans = Scans(1.0, "t", 1e-9);
  for (DecodedCloud& cloud : scans) {  // a field that the driver leaves at zero comes first
    cloud.times.insert(cloud.times.begin(), {"time", std::vector<double>(kColumns, 0.0)});
  }
  const LidarFormat format = FindLidarFormat(scans, "/points");
  EXPECT_EQ(format.time_field, "t");
  EXPECT_EQ(format.time.seconds_per_count, 1e-9);
  EXPECT_NEAR(format.scan_period, kPeriod, 1e-9);
  const ReadScan scan = MakeScan(scans[3], format);
  ASSERT_EQ(scan.problem, ReadScan::Problem::kNone);
  EXPECT_EQ(scan.start, scans[3].stamp);
  ASSERT_EQ(scan.scan.points.size(), static_cast<std::size_t>(kColumns));
  EXPECT_NEAR(scan.scan.points.back().time, kPeriod * (kColumns - 1) / kColumns, 1e-6);
}

TEST(LidarFormat, UnknownUnitIsAnError) {
  const std::string error = ErrorOf(Scans(1.0, "time", 1e-8));
  for (const char* part : {"/points", "'time'", "nanoseconds"}) EXPECT_TRUE(Contains(error, part));
}

TEST(LidarFormat, WithoutTimesOnlyASpinningLidarWillDo) {
  EXPECT_EQ(FindLidarFormat(Scans(2.0 * M_PI, "", 1.0), "/points").time_field, "");
  const std::string error = ErrorOf(Scans(2.1, "", 1.0));
  for (const char* part : {"/points", "no times", "set the driver"}) EXPECT_TRUE(Contains(error, part));
}

TEST(LidarFormat, TooFewAndEqualStampsAreErrors) {
  std::vector<DecodedCloud> scans = Scans(1.0, "t", 1e-9);
  EXPECT_TRUE(Contains(ErrorOf({scans[0]}), "1 usable message(s)"));
  for (DecodedCloud& cloud : scans) cloud.stamp = scans[0].stamp;
  EXPECT_TRUE(Contains(ErrorOf(scans), "all header stamps are the same"));
}

TEST(ScanReader, SaysWhatIsWrongWithAScan) {
  const std::vector<DecodedCloud> scans = Scans(1.0, "t", 1e-9);
  const LidarFormat format = FindLidarFormat(scans, "/points");
  DecodedCloud cloud = scans[0];
  for (double& time : cloud.times[0].values) time *= 100.0;
  EXPECT_EQ(MakeScan(cloud, format).problem, ReadScan::Problem::kBadTimes);
  cloud.times.clear();
  EXPECT_EQ(MakeScan(cloud, format).problem, ReadScan::Problem::kMalformed);
  EXPECT_TRUE(Contains(MakeScan(cloud, format).error, "field 't' is missing"));
  for (Eigen::Vector3f& point : cloud.positions) point.setZero();
  EXPECT_EQ(MakeScan(cloud, format).problem, ReadScan::Problem::kNoReturns);
}

}  // namespace
}  // namespace mlic::lidar_format_test
