#include "mlic_ros/bag/bag_loader.h"

#include <gtest/gtest.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <unistd.h>

#include <fstream>

#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/rig_draft.h"
#include "support/test_bags.h"

namespace mlic {
// A message of a driver's own type, with nothing in it.
struct PacketMessage {};
}  // namespace mlic

namespace ros::message_traits {
template <>
struct MD5Sum<mlic::PacketMessage> {
  static const char* value() { return "00000000000000000000000000000000"; }
  static const char* value(const mlic::PacketMessage&) { return value(); }
};
template <>
struct DataType<mlic::PacketMessage> {
  static const char* value() { return "velodyne_msgs/VelodyneScan"; }
  static const char* value(const mlic::PacketMessage&) { return value(); }
};
template <>
struct Definition<mlic::PacketMessage> {
  static const char* value() { return "# not needed to read it\n"; }
  static const char* value(const mlic::PacketMessage&) { return value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<mlic::PacketMessage> {
  template <typename Stream>
  static void write(Stream&, const mlic::PacketMessage&) {}
  static std::uint32_t serializedLength(const mlic::PacketMessage&) { return 0; }
};
}  // namespace ros::serialization

namespace mlic::bag_loader_test {
namespace {

namespace fs = std::filesystem;

struct NoProgress : ProgressSink {
  void OnProgress(const std::string&, double) override {}
};

class BagLoader : public ::testing::Test {
 protected:
  BagLoader() : directory_(fs::temp_directory_path() / ("mlic_loader_" + std::to_string(getpid()))) {
    fs::create_directories(directory_);
    recipe_.path = Path("a.bag");
    rig_.imu.topic = "/imu";
    rig_.lidars.resize(1);
    rig_.lidars[0].name = "lidar";
    rig_.lidars[0].topic = "/points";
  }
  ~BagLoader() override { fs::remove_all(directory_); }

  std::string Path(const std::string& name) const { return (directory_ / name).string(); }

  Dataset Load(const std::vector<fs::path>& bags, const LoadOptions& options = {}) {
    NoProgress progress;
    report_ = {};
    return LoadDataset(rig_, bags, options, report_, CancellationToken(), progress);
  }
  Dataset WriteAndLoad() {
    WriteTestBag(recipe_);
    return Load({recipe_.path});
  }

  // Loads and expects an InputError of one line with all the parts.
  void ExpectError(const std::vector<fs::path>& bags, const std::vector<std::string>& parts,
                   const LoadOptions& options = {}) {
    ExpectInputError([&] { Load(bags, options); }, parts);
  }
  void ExpectErrorOf(const TestBag& recipe, const std::vector<std::string>& parts) {
    WriteTestBag(recipe);
    ExpectError({recipe.path}, parts);
  }

  const fs::path directory_;
  TestBag recipe_;
  Rig rig_;
  LoadReport report_;
};

// Every point has its own time again: intensity holds its column.
void ExpectPointTimes(const Drive& drive, double scan_start, double tolerance) {
  const LidarRecording& lidar = drive.lidars.at(0);
  ASSERT_EQ(lidar.scans.size(), 30u);
  EXPECT_NEAR(lidar.scan_period, kScanPeriod, 1e-9);
  for (std::size_t k = 0; k < lidar.scans.size(); ++k) {
    const LidarScan& scan = lidar.scans[k];
    ASSERT_GT(scan.points.size(), 300u);
    for (const LidarPoint& point : scan.points) {
      const double expected = scan_start + kScanPeriod * static_cast<double>(k) + TestTime(point.intensity);
      ASSERT_NEAR(scan.time + point.time, expected, tolerance) << "scan " << k;
    }
  }
}

TEST_F(BagLoader, ReadsEveryLayout) {
  for (const Layout layout : {Layout::kSeconds, Layout::kNanoseconds, Layout::kAbsoluteSeconds,
                              Layout::kAbsoluteNanoseconds, Layout::kBeforeStamp, Layout::kOtherClock}) {
    SCOPED_TRACE(static_cast<int>(layout));
    recipe_.layout = layout;
    const Dataset dataset = WriteAndLoad();
    ASSERT_EQ(dataset.drives.size(), 1u);
    EXPECT_EQ(dataset.drives[0].epoch, kBagStart);
    EXPECT_EQ(dataset.drives[0].imu.size(), 300u);
    EXPECT_FALSE(dataset.drives[0].lidars[0].point_times_from_azimuth);
    ExpectPointTimes(dataset.drives[0], 0.0, 1e-6);
    EXPECT_EQ(!report_.warnings.empty(), layout == Layout::kOtherClock);
  }
}

TEST_F(BagLoader, ReadsLivoxMessages) {
  recipe_.livox = true;
  const Dataset dataset = WriteAndLoad();
  const LidarRecording& lidar = dataset.drives.at(0).lidars.at(0);
  ASSERT_EQ(lidar.scans.size(), 30u);
  EXPECT_NEAR(lidar.scans[4].time, 0.4, 1e-9);
  EXPECT_NEAR(lidar.scans[4].points.back().time, TestTime(kColumns - 1), 1e-6);
  EXPECT_EQ(lidar.scans[4].points[0].intensity, 77.0f);
  EXPECT_EQ(WithMessageFrames(rig_, report_).lidars[0].frame_id, "livox_frame");
}

TEST_F(BagLoader, SpinningLidarWithoutTimesGetsThemFromAzimuth) {
  for (const Layout layout : {Layout::kNoTimes, Layout::kZeroTimes}) {
    recipe_.layout = layout;
    const Dataset dataset = WriteAndLoad();
    EXPECT_TRUE(dataset.drives[0].lidars[0].point_times_from_azimuth);
    ExpectPointTimes(dataset.drives[0], 0.0, 1e-3);
    EXPECT_TRUE(Reported(report_.warnings, "azimuth"));
  }
}

TEST_F(BagLoader, MissingTopicListsThoseThereAre) {
  WriteTestBag(recipe_);
  rig_.lidars[0].topic = "/front/points";
  ExpectError({recipe_.path},
              {"/front/points", "/points (sensor_msgs/PointCloud2)", "/imu (sensor_msgs/Imu)"});
  rig_.lidars[0].topic = "/imu";
  ExpectError({recipe_.path}, {"/imu", "is of type sensor_msgs/Imu", "expected sensor_msgs/PointCloud2"});
}

TEST_F(BagLoader, FilesThatAreNoBagsAreErrors) {
  ExpectError({Path("none.bag")}, {"none.bag", "no such file"});
  std::ofstream(Path("empty.bag")).flush();
  ExpectError({Path("empty.bag")}, {"empty.bag", "empty"});
  std::ofstream(Path("text.bag")) << "topic,time,value\n1,2,3\n";
  ExpectError({Path("text.bag")}, {"text.bag", "not a ROS 1 bag"});
  rosbag::Bag(Path("hollow.bag"), rosbag::bagmode::Write).close();
  ExpectError({Path("hollow.bag")}, {"hollow.bag", "no messages"});
}

TEST_F(BagLoader, TruncatedAndUnindexedBagsNameTheRepair) {
  WriteTestBag(recipe_);
  const auto size = fs::file_size(recipe_.path);
  for (const double share : {0.001, 0.3, 0.99}) {
    fs::copy_file(recipe_.path, Path("cut.bag"), fs::copy_options::overwrite_existing);
    fs::resize_file(Path("cut.bag"), static_cast<std::uintmax_t>(share * static_cast<double>(size)) + 20);
    ExpectError({Path("cut.bag")}, {"cut.bag", "rosbag reindex"});
  }
  // A recording that was killed: the header's index position was never filled in.
  std::fstream file(recipe_.path, std::ios::in | std::ios::out | std::ios::binary);
  std::string head(200, '\0');
  file.read(head.data(), 200);
  const std::size_t at = head.find("index_pos=");
  ASSERT_NE(at, std::string::npos);
  file.seekp(static_cast<std::streamoff>(at + 10));
  file.write(std::string(8, '\0').data(), 8);
  file.close();
  ExpectError({recipe_.path}, {"a.bag", "rosbag reindex"});
}

TEST_F(BagLoader, OddMessagesAreHandledAndCounted) {
  recipe_.on_cloud = [](int i, sensor_msgs::PointCloud2& cloud) {
    if (i == 4) cloud.header.stamp -= ros::Duration(0.1);  // repeats the one before
    if (i == 11) cloud.header.stamp += ros::Duration(0.1), cloud.header.seq = 1;
    if (i == 12) cloud.header.stamp -= ros::Duration(0.1);  // swapped with the one before
    for (std::size_t p = 0; p < 40; ++p) {
      Put<float>(cloud.data, p * 32, p < 20 ? std::numeric_limits<float>::quiet_NaN() : 0.0f);
      if (p >= 20) Put<float>(cloud.data, p * 32 + 4, 0.0f), Put<float>(cloud.data, p * 32 + 8, 0.0f);
    }
    if (i == 25) cloud.data.resize(100);
    return i != 20 && i != 21;
  };
  const LidarRecording lidar = WriteAndLoad().drives[0].lidars[0];
  EXPECT_EQ(lidar.scans.size(), 26u);
  for (std::size_t k = 1; k < lidar.scans.size(); ++k)
    EXPECT_GT(lidar.scans[k].time, lidar.scans[k - 1].time);
  EXPECT_TRUE(Reported(report_.lines, "1 with a repeated stamp"));
  EXPECT_TRUE(Reported(report_.lines, "out of order"));
  EXPECT_TRUE(Reported(report_.lines, "4 missing"));  // 20, 21, 25 and the one that repeated another's stamp
  EXPECT_TRUE(Reported(report_.lines, "1 malformed"));
  for (const LidarScan& scan : lidar.scans) {
    for (const LidarPoint& point : scan.points) EXPECT_NEAR(point.position.head<2>().norm(), 20.0, 1e-3);
  }
}

// What a hundred bytes of a driver at fault may claim; also as the first message of its topic.
TEST_F(BagLoader, MalformedCloudsAreLeftOutAndTold) {
  recipe_.on_cloud = [](int i, sensor_msgs::PointCloud2& cloud) {
    if (i == 0 || i == 7) {
      cloud.fields.clear();
      cloud.data.clear();
      cloud.point_step = cloud.row_step = 0;
      cloud.width = std::numeric_limits<std::uint32_t>::max();
    }
    if (i == 9) cloud.width = std::numeric_limits<std::uint32_t>::max();
    if (i == 12) cloud.row_step = 0;  // the data are good
    return true;
  };
  EXPECT_EQ(WriteAndLoad().drives[0].lidars[0].scans.size(), 27u);
  EXPECT_TRUE(Reported(report_.lines, "3 malformed"));
  EXPECT_TRUE(Reported(report_.warnings, "3 scans are malformed"));
  std::vector<std::string> notes;
  EXPECT_EQ(DraftRig(BagSet({recipe_.path}), notes).lidars.at(0).frame_id, "lidar_frame");
}

TEST_F(BagLoader, RawPacketsAreNamedWithWhatToDo) {
  recipe_.write_more = [](rosbag::Bag& bag) {
    for (int i = 0; i < 30; ++i) {
      bag.write("/velodyne_packets", RosTimeAt(kBagStart + TimeNs{100'000'000} * i), PacketMessage());
    }
  };
  rig_.lidars[0].topic = "/velodyne_packets";
  ExpectErrorOf(recipe_, {"/velodyne_packets", "velodyne_msgs/VelodyneScan", "raw packets", "PointCloud2"});
  std::vector<std::string> notes;
  EXPECT_EQ(DraftRig(BagSet({recipe_.path}), notes).lidars.size(), 1u);
  EXPECT_EQ(std::count_if(notes.begin(), notes.end(),
                          [](const std::string& note) {
                            return note.find("/velodyne_packets") != std::string::npos &&
                                   note.find("raw packets") != std::string::npos;
                          }),
            1);
  recipe_.with_lidar = false;
  WriteTestBag(recipe_);
  ExpectInputError([&] { DraftRig(BagSet({recipe_.path}), notes); }, {"neither LiDAR nor", "raw packets"});
  EXPECT_TRUE(IsRawLidarType("ouster_ros/PacketMsg"));
  EXPECT_TRUE(IsRawLidarType("rslidar_msgs/rslidarScan"));
  EXPECT_FALSE(IsRawLidarType("sensor_msgs/LaserScan"));
  EXPECT_FALSE(IsRawLidarType("sensor_msgs/Imu"));
}

TEST_F(BagLoader, TopicOfMalformedCloudsOnlyIsAnError) {
  recipe_.on_cloud = [](int, sensor_msgs::PointCloud2& cloud) {
    cloud.fields.clear();
    return true;
  };
  ExpectErrorOf(recipe_, {"/points", "without field 'x'", "all 30 messages"});
}

TEST_F(BagLoader, ADraftHoldsWhatCanBeCalibratedUnderFramesOfItsOwn) {
  recipe_.write_more = [](rosbag::Bag& bag) {
    for (int i = 0; i < 30; ++i) {
      const TimeNs start = kBagStart + TimeNs{i} * 100'000'000;
      const ros::Time record = RosTimeAt(start + 100'000'000);
      sensor_msgs::PointCloud2 cloud = MakeTestCloud(TestBag(), start);
      bag.write("/2nd/points", record, cloud);  // of the same frame; a name must begin with a letter
      if (i == 5) bag.write("/map", record, cloud);
      cloud.fields.erase(cloud.fields.begin());  // a radar has no x
      bag.write("/radar/points", record, cloud);
      sensor_msgs::Image depth;
      depth.header = cloud.header;
      depth.encoding = "32FC1";
      bag.write("/camera/depth", record, depth);
    }
  };
  WriteTestBag(recipe_);
  std::vector<std::string> notes;
  Rig rig = DraftRig(BagSet({recipe_.path}), notes);
  MakeFramesUnique(&rig, &notes);
  EXPECT_TRUE(Reported(notes, "topic /map: left out"));
  EXPECT_TRUE(Reported(notes, "topic /radar/points: left out, not usable"));
  EXPECT_TRUE(Reported(notes, "topic /camera/depth: left out, images of depth"));
  EXPECT_TRUE(rig.cameras.empty());
  ASSERT_EQ(rig.lidars.size(), 2u);
  EXPECT_EQ(rig.lidars[0].name, "sensor_2nd");
  EXPECT_EQ(rig.lidars[0].frame_id, "lidar_frame");
  EXPECT_EQ(rig.lidars[1].topic, "/points");
  EXPECT_EQ(rig.lidars[1].frame_id, rig.lidars[1].name);
}

TEST_F(BagLoader, ADraftLeavesOpenWhatTheBagDoesNotTell) {
  recipe_.write_more = [](rosbag::Bag& bag) {
    for (int i = 0; i < 30; ++i) {
      const ros::Time time = RosTimeAt(kBagStart + TimeNs{i} * 100'000'000);
      for (const std::string name : {"/known", "/zeros", "/silent"}) {
        sensor_msgs::Image image;
        image.header.stamp = time;
        image.header.frame_id = name.substr(1);
        image.width = image.height = image.step = 4;
        image.encoding = "mono8";
        image.data.resize(16);
        sensor_msgs::CameraInfo info;
        info.header = image.header;
        info.width = 640;
        if (name == "/known") info.K = {320.0, 0.0, 320.0, 0.0, 320.0, 240.0, 0.0, 0.0, 1.0};
        bag.write(name + "/image_raw", time, image);
        if (name != "/silent") bag.write(name + "/camera_info", time, info);
      }
    }
  };
  WriteTestBag(recipe_);
  std::vector<std::string> notes;
  const Rig rig = DraftRig(BagSet({recipe_.path}), notes);
  ASSERT_EQ(rig.cameras.size(), 3u);
  for (const CameraConfig& camera : rig.cameras) {
    const bool known = camera.name == "known";
    EXPECT_EQ(camera.intrinsics.has_value(), known) << camera.name;
    EXPECT_EQ(camera.fov_deg.has_value(), known) << camera.name;
    EXPECT_EQ(Reported(notes, "fill in fov_deg of " + camera.name), !known) << camera.name;
  }
}

TEST_F(BagLoader, TopicsGoWithOrWithoutTheirSlash) {
  rig_.imu.topic = "imu";
  rig_.lidars[0].topic = "points";
  const Drive drive = WriteAndLoad().drives[0];
  EXPECT_EQ(drive.imu.size(), 300u);
  EXPECT_EQ(drive.lidars[0].scans.size(), 30u);
}

TEST_F(BagLoader, ExchangedTopicsShowInTheFrames) {
  std::string frame;
  recipe_.write_more = [&](rosbag::Bag& bag) {
    for (int i = 0; i < 30; ++i) {
      const TimeNs start = kBagStart + TimeNs{i} * 100'000'000;
      sensor_msgs::PointCloud2 cloud = MakeTestCloud(recipe_, start);
      frame = cloud.header.frame_id;
      cloud.header.frame_id = "back";
      bag.write("/back", RosTimeAt(start), cloud);
    }
  };
  WriteTestBag(recipe_);
  rig_.lidars.push_back(rig_.lidars[0]);
  rig_.lidars[1].name = "back_lidar";
  rig_.lidars[1].topic = "/back";
  rig_.lidars[0].frame_id = frame;
  rig_.lidars[1].frame_id = "back";
  EXPECT_EQ(Load({recipe_.path}).drives[0].lidars.size(), 2u);
  std::swap(rig_.lidars[0].topic, rig_.lidars[1].topic);
  ExpectError({recipe_.path}, {"in the frame back", "topics of lidar and back_lidar look exchanged"});
}

TEST_F(BagLoader, LateMessagesAreNoClockJump) {
  recipe_.with_lidar = false;
  recipe_.write_more = [](rosbag::Bag& bag) {
    TestBag recipe;
    for (int i = 0; i < 30; ++i) {
      const TimeNs start = kBagStart + TimeNs{i} * 100'000'000;
      // Twice for half a second nothing is written, then all at once.
      const int written = i >= 10 && i < 15 ? 15 : i >= 20 && i < 25 ? 25 : i;
      bag.write("/points", RosTimeAt(TimeFrom(kBagStart, 0.1 * written + 0.1)), MakeTestCloud(recipe, start));
    }
  };
  const Drive drive = WriteAndLoad().drives[0];
  EXPECT_TRUE(report_.warnings.empty()) << report_.warnings.front();
  EXPECT_EQ(drive.lidars[0].scans.size(), 30u);
}

TEST_F(BagLoader, PiecesOfScansAreJoined) {
  recipe_.with_lidar = false;
  recipe_.write_more = [](rosbag::Bag& bag) {
    for (int i = 0; i < 300; ++i) {
      Livox2Message piece = MakeTestLivox(kBagStart + TimeNs{i} * 10'000'000);
      for (LivoxPoint& point : piece.points) point.offset_time /= 10;
      if (i != 155) bag.write("/points", RosTimeAt(kBagStart + TimeNs{i + 1} * 10'000'000), piece);
    }
  };
  const LidarRecording lidar = WriteAndLoad().drives[0].lidars[0];
  EXPECT_TRUE(Reported(report_.lines, "10 messages each are taken as one scan of 0.1 s"));
  EXPECT_NEAR(lidar.scan_period, 0.1, 1e-9);
  ASSERT_EQ(lidar.scans.size(), 30u);
  for (std::size_t s = 0; s < lidar.scans.size(); ++s) {
    const LidarScan& scan = lidar.scans[s];
    EXPECT_NEAR(scan.time, 0.1 * static_cast<double>(s), 1e-6);
    EXPECT_GT(scan.points.size(), 9000u);
    EXPECT_GT(scan.points.back().time, 0.0995f);
    EXPECT_LT(scan.points.back().time, 0.1f);
    EXPECT_TRUE(std::is_sorted(scan.points.begin(), scan.points.end(),
                               [](const auto& a, const auto& b) { return a.time < b.time; }));
  }
}

TEST_F(BagLoader, SplitBagsAreOneDriveAndDisjointOnesSeveral) {
  TestBag lidar = recipe_;
  recipe_.with_lidar = false;
  lidar.path = Path("b.bag");
  lidar.with_imu = false;
  WriteTestBag(recipe_);
  WriteTestBag(lidar);
  const Dataset split = Load({recipe_.path, lidar.path});
  ASSERT_EQ(split.drives.size(), 1u);
  EXPECT_EQ(split.drives[0].lidars[0].scans.size(), 30u);

  TestBag first = recipe_, second = recipe_;
  first.with_lidar = second.with_lidar = true;
  first.path = Path("c.bag");
  second.path = Path("d.bag");
  second.start = kBagStart + 100'000'000'000;
  WriteTestBag(first);
  WriteTestBag(second);
  const Dataset disjoint = Load({second.path, first.path});
  ASSERT_EQ(disjoint.drives.size(), 2u);
  EXPECT_EQ(disjoint.drives[0].epoch, kBagStart);
  EXPECT_EQ(disjoint.drives[1].epoch, second.start);
  for (const Drive& drive : disjoint.drives) ExpectPointTimes(drive, 0.0, 1e-6);
}

TEST_F(BagLoader, StartAndDurationChooseAPart) {
  WriteTestBag(recipe_);
  LoadOptions options;
  options.start = 1.0;
  options.duration = 0.5;
  const Dataset dataset = Load({recipe_.path}, options);
  EXPECT_EQ(dataset.drives[0].epoch, kBagStart + 1'000'000'000);
  EXPECT_EQ(dataset.drives[0].imu.size(), 51u);
  EXPECT_EQ(dataset.drives[0].lidars[0].scans.size(), 6u);
  options.start = 100.0;
  ExpectError({recipe_.path}, {"--start 100"}, options);
}

TEST_F(BagLoader, CancellationStopsIt) {
  WriteTestBag(recipe_);
  CancellationToken token;
  token.Cancel();
  NoProgress progress;
  EXPECT_THROW(LoadDataset(rig_, {recipe_.path}, {}, report_, token, progress), Cancelled);
}

}  // namespace
}  // namespace mlic::bag_loader_test
