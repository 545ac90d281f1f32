#include "mlic_ros/bag/part_choice.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>

#include <cmath>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "support/files.h"

namespace mlic::part_choice_test {
namespace {

constexpr double kStart = 1000.0;            // s, of the recording
constexpr double kLength = 200.0;            // s
constexpr double kLively = 120.0;            // s after the start; for 40 s it turns about all axes
constexpr double kStampBeforeRecord = 30.0;  // s: the recorder's clock is another

// An IMU at 50 Hz that turns about z, clouds at 20 Hz.
void WriteBag(const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  Random random(5);
  const auto vector = [&](const Eigen::Vector3d& v, double noise) {
    geometry_msgs::Vector3 message;
    message.x = v.x() + noise * random.Normal();
    message.y = v.y() + noise * random.Normal();
    message.z = v.z() + noise * random.Normal();
    return message;
  };
  Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();
  for (int i = 0; i <= static_cast<int>(50.0 * kLength); ++i) {
    const double t = i / 50.0;
    const double share = t >= kLively && t < kLively + 40.0 ? 0.5 : 0.0;
    const Eigen::Vector3d rate(share * std::sin(1.3 * t), share * std::sin(1.7 * t), 0.5 * std::cos(2.0 * t));
    const Eigen::Vector3d force(std::sin(0.9 * t), std::cos(1.1 * t), kStandardGravity);
    sensor_msgs::Imu imu;
    imu.header.stamp = ros::Time(kStart + t - kStampBeforeRecord);
    imu.angular_velocity = vector(rate, 1e-3);
    imu.linear_acceleration = vector(attitude.conjugate() * force, 1e-2);
    attitude = (attitude * ExpQuaternion(rate / 50.0)).normalized();
    bag.write("/imu", ros::Time(kStart + t), imu);
    if (i % 5 < 2) bag.write("/points", ros::Time(kStart + t), sensor_msgs::PointCloud2());
  }
}

class PartChoice : public ::testing::Test {
 protected:
  PartChoice() {
    WriteBag((directory_.Path() / "drive.bag").string());
    rig_.imu.topic = "/imu";
    rig_.lidars.resize(1);
    rig_.lidars[0].topic = "/points";
  }
  std::vector<BagSet::Interval> Choose(const BagSet& bags, double longest) {
    return ChooseParts(
        bags, rig_, bags.drives(), longest, CancellationToken(),
        [&](double done) { progress_.push_back(done); }, &notes_);
  }

  const TemporaryDirectory directory_;
  Rig rig_;
  std::vector<double> progress_;
  std::vector<std::string> notes_;
};

TEST_F(PartChoice, TakesTheTellingPartOfALongDriveAndSaysWhich) {
  const BagSet bags({directory_.Path() / "drive.bag"});
  const std::vector<BagSet::Interval> parts = Choose(bags, 40.0);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_NEAR(SecondsSince(bags.interval().begin, parts[0].begin), kLively, 10.1);
  EXPECT_NEAR(LengthOf(parts), 40.0, 0.1);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_NE(notes_[0].find("of 200.0 s"), std::string::npos) << notes_[0];
  EXPECT_GT(progress_.back(), 0.9);
}

TEST_F(PartChoice, TakesAllOfAShortDriveWithoutReadingIt) {
  const BagSet bags({directory_.Path() / "drive.bag"});
  const std::vector<BagSet::Interval> parts = Choose(bags, 201.0);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].begin, bags.interval().begin);
  EXPECT_EQ(parts[0].end, bags.interval().end);
  EXPECT_TRUE(notes_.empty());
  EXPECT_TRUE(progress_.empty());
}

TEST_F(PartChoice, OfSeveralDrivesCutsTheLongest) {
  const BagSet bags({directory_.Path() / "drive.bag"});
  const TimeNs begin = bags.interval().begin;
  const std::vector<BagSet::Interval> drives{{begin, TimeFrom(begin, 15.0)},
                                             {TimeFrom(begin, 20.0), TimeFrom(begin, 90.0)},
                                             {TimeFrom(begin, 100.0), TimeFrom(begin, 200.0)}};
  const auto parts = ChooseParts(
      bags, rig_, drives, 95.0, CancellationToken(), [](double) {}, &notes_);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].end, drives[0].end);
  EXPECT_NEAR(LengthOf({parts[1]}), 40.0, 0.1);
  EXPECT_NEAR(LengthOf({parts[2]}), 40.0, 0.1);
  EXPECT_NEAR(SecondsSince(begin, parts[2].begin), kLively, 10.1);
  EXPECT_EQ(notes_.size(), 2u);
}

TEST_F(PartChoice, CountsScansAsTheyAreJoined) {
  const BagSet bags({directory_.Path() / "drive.bag"});
  rig_.cameras.resize(2);
  const SensorLoad load = LoadOf(bags, rig_);
  EXPECT_NEAR(load.scans, 10.0, 0.1) << "20 clouds a second, two to a scan";
  EXPECT_EQ(load.cameras, 2u);
}

}  // namespace
}  // namespace mlic::part_choice_test
