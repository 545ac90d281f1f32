// What no constant calibration can follow is seen by calibrating the halves of a drive apart.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_core/summary/checks.h"
#include "support/simulated_input.h"

namespace mlic::halves_test {
namespace {

constexpr double kDuration = 15.0;  // s
constexpr double kDegree = M_PI / 180.0;

const SimulatedInput& TwoLidars() {
  static const SimulatedInput input = SimulateInput(
      ConfiguredSensors("dual_rosette.yaml"), DriveOptions(sim::Scenario::kHandheld, kDuration, 4), false);
  return input;
}

// The second LiDAR comes loose: from the middle of the drive on it is turned about its x axis.
CalibrationResult CalibrateTurned(double degrees) {
  Dataset dataset = TwoLidars().dataset;
  const Eigen::Matrix3f turn = ExpMatrix(degrees * kDegree * Eigen::Vector3d::UnitX()).cast<float>();
  for (LidarScan& scan : dataset.drives[0].lidars[1].scans) {
    if (scan.time < 0.5 * kDuration) continue;
    for (LidarPoint& point : scan.points) point.position = turn * point.position;
  }
  CalibrationObserver observer;
  return Calibrate(TwoLidars().rig, dataset, CancellationToken(), observer);
}

const QualityCheck& HalvesOf(const CalibrationResult& result, const std::string& sensor) {
  const auto check =
      std::find_if(result.checks.begin(), result.checks.end(), [&](const QualityCheck& candidate) {
        return candidate.name == "halves" && candidate.sensor == sensor;
      });
  if (check == result.checks.end()) throw std::runtime_error("no check of the halves");
  std::printf("%s\n", DescribeCheck(*check).c_str());
  return *check;
}

TEST(Halves, OfASoundDriveAgree) {
  const CalibrationResult result = CalibrateTurned(0.0);
  EXPECT_TRUE(result.Trusted());
  ASSERT_EQ(result.halves.size(), 2u);
  for (const LidarConfig& lidar : TwoLidars().rig.lidars) {
    EXPECT_TRUE(HalvesOf(result, lidar.name).Passed());
  }
  EXPECT_EQ(result.halves[0].quantities.size(), 3u);
}

TEST(Halves, OfADriveWithALooseLidarDoNot) {
  const CalibrationResult result = CalibrateTurned(0.3);
  const std::vector<LidarConfig>& lidars = TwoLidars().rig.lidars;
  EXPECT_TRUE(HalvesOf(result, lidars[0].name).Passed());
  EXPECT_FALSE(HalvesOf(result, lidars[1].name).Passed());
  EXPECT_EQ(result.verdict, Verdict::kPartial);
  ASSERT_EQ(result.rejected.size(), 1u);
  EXPECT_EQ(result.rejected[0].name, lidars[1].name);
  EXPECT_NE(result.rejected[0].reason.find("half of the drive do not agree"), std::string::npos)
      << result.rejected[0].reason;
  EXPECT_TRUE(result.pairs.empty());
}

}  // namespace
}  // namespace mlic::halves_test
