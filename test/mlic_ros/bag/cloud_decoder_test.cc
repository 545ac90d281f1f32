#include "mlic_ros/bag/cloud_decoder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "support/files.h"
#include "support/test_bags.h"

namespace mlic::cloud_decoder_test {
namespace {

using sensor_msgs::PointCloud2;

template <typename Message>
SerializedMessage Serialize(const Message& message, const std::string& type) {
  SerializedMessage serialized;
  serialized.type = type;
  serialized.bytes.resize(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(serialized.bytes.data(),
                                     static_cast<std::uint32_t>(serialized.bytes.size()));
  ros::serialization::serialize(stream, message);
  return serialized;
}

SerializedMessage Serialize(const PointCloud2& cloud) { return Serialize(cloud, "sensor_msgs/PointCloud2"); }

std::string ErrorOf(const SerializedMessage& message) {
  const std::string fault = FaultOfCloud(message, "/points");
  EXPECT_EQ(fault.empty() ? "no InputError" : fault,
            InputErrorOf([&] { DecodeCloud(message, "/points", PointTimeFieldNames()); }));
  return fault;
}

std::string ErrorOf(const PointCloud2& cloud) { return ErrorOf(Serialize(cloud)); }

PointCloud2 GoodCloud() { return MakeTestCloud(TestBag(), kBagStart); }

TEST(CloudDecoder, ReadsPointsAndTimes) {
  const DecodedCloud cloud = DecodeCloud(Serialize(GoodCloud()), "/points", PointTimeFieldNames());
  ASSERT_EQ(cloud.positions.size(), static_cast<std::size_t>(kColumns * kRings));
  EXPECT_EQ(cloud.positions[5], TestPoint(1, 1, 2.0 * M_PI));
  EXPECT_EQ(cloud.rings[5], 1);
  ASSERT_EQ(cloud.times.size(), 1u);
  EXPECT_EQ(cloud.times[0].name, "time");
  EXPECT_NEAR(cloud.times[0].values[5], TestTime(1), 1e-8);
  EXPECT_EQ(cloud.fields, "x y z intensity f32, ring u16, time f32");
}

// Sizes that claim more than there is are found before any memory is taken: each of these would be gigabytes.
TEST(CloudDecoder, SizesThatDoNotFitAreErrors) {
  PointCloud2 hollow;
  hollow.width = hollow.height = std::numeric_limits<std::uint32_t>::max();
  EXPECT_TRUE(Contains(ErrorOf(hollow), "/points: the sizes of a point cloud do not fit together"));
  hollow.fields = GoodCloud().fields;
  EXPECT_TRUE(Contains(ErrorOf(hollow), "do not fit together"));
  PointCloud2 cloud = GoodCloud();
  cloud.point_step = 0;
  EXPECT_TRUE(Contains(ErrorOf(cloud), "do not fit together"));
  cloud = GoodCloud();
  cloud.width = std::numeric_limits<std::uint32_t>::max();
  EXPECT_TRUE(Contains(ErrorOf(cloud), "do not fit together"));
  cloud = GoodCloud();
  cloud.height = 2;
  EXPECT_TRUE(Contains(ErrorOf(cloud), "do not fit together"));
  cloud = GoodCloud();
  cloud.fields[1].offset = std::numeric_limits<std::uint32_t>::max() - 3;
  EXPECT_TRUE(Contains(ErrorOf(cloud), "field 'y' at byte 4294967292"));
  cloud = GoodCloud();
  cloud.fields[2].name = "height";
  EXPECT_TRUE(Contains(ErrorOf(cloud), "without field 'z'"));
}

TEST(CloudDecoder, EmptyCloudIsNoError) { EXPECT_EQ(ErrorOf(PointCloud2()), ""); }

TEST(CloudDecoder, RowStepOfZeroIsRepaired) {
  PointCloud2 cloud = GoodCloud();
  cloud.height = kRings;
  cloud.width = kColumns;
  cloud.row_step = cloud.width * cloud.point_step;
  const DecodedCloud expected = DecodeCloud(Serialize(cloud), "/points", {});
  cloud.row_step = 0;
  EXPECT_EQ(DecodeCloud(Serialize(cloud), "/points", {}).positions, expected.positions);
}

// The largest memory of this process so far, bytes.
long PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024 * usage.ru_maxrss;
}

TEST(CloudDecoder, CountsAreCheckedAgainstTheBytes) {
  constexpr long kFarLessThanClaimed = 500'000'000;
  SerializedMessage cloud = Serialize(GoodCloud());
  // The length of the data stands before it, and is_dense behind it.
  const std::size_t length = cloud.bytes.size() - 1 - GoodCloud().data.size() - 4;
  Put<std::uint32_t>(cloud.bytes, length, 0xfffffff0u);
  const long before = PeakMemory();
  EXPECT_TRUE(Contains(ErrorOf(cloud), "/points: a message of type sensor_msgs/PointCloud2 is cut off"));
  const std::string livox_type = "livox_ros_driver2/CustomMsg";
  const Livox2Message livox_message = MakeTestLivox(kBagStart);
  SerializedMessage livox = Serialize(livox_message, livox_type);
  EXPECT_EQ(DecodeCloud(livox, "/points", {"offset_time"}).positions.size(), livox_message.points.size());
  const std::size_t count = livox.bytes.size() - 19 * livox_message.points.size() - 4;
  Put<std::uint32_t>(livox.bytes, count, 0x0fffffffu);
  EXPECT_TRUE(Contains(ErrorOf(livox), "/points: a message of type livox_ros_driver2/CustomMsg is cut off"));
  EXPECT_LT(PeakMemory() - before, kFarLessThanClaimed);
}

}  // namespace
}  // namespace mlic::cloud_decoder_test
