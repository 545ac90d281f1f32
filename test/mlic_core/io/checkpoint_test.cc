#include "mlic_core/io/checkpoint/checkpoint.h"

#include <cstring>

#include "mlic_core/common/random.h"
#include "mlic_core/io/checkpoint/serialize.h"
#include "mlic_core/io/content_hash.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::checkpoint_test {
namespace {

Dataset SampleDataset(int scans, int points) {
  Random random(2);
  Dataset dataset;
  dataset.drives.resize(2);
  for (Drive& drive : dataset.drives) {
    drive.epoch = static_cast<TimeNs>(random.Next() >> 2);
    drive.imu.resize(300);
    for (ImuSample& sample : drive.imu) sample.angular_velocity.setConstant(random.Normal());
    drive.lidars.resize(2);
    drive.lidars[1].point_times_from_azimuth = true;
    for (LidarRecording& recording : drive.lidars) {
      recording.scans.resize(static_cast<std::size_t>(scans));
      for (LidarScan& scan : recording.scans) {
        scan.time = random.Uniform();
        scan.points.resize(static_cast<std::size_t>(points));
        for (LidarPoint& point : scan.points) {
          point.position.setConstant(static_cast<float>(random.Uniform()));
          point.ring = static_cast<std::uint16_t>(random.Next());
        }
      }
    }
  }
  return dataset;
}

TEST(Serialize, DatasetRoundTrip) {
  const Dataset dataset = SampleDataset(7, 100);
  const std::vector<char> bytes = ToBytes(dataset);
  Dataset copy;
  ASSERT_TRUE(FromBytes(bytes, &copy));
  ASSERT_EQ(copy.drives.size(), 2u);
  EXPECT_EQ(copy.drives[1].epoch, dataset.drives[1].epoch);
  EXPECT_EQ(copy.drives[1].imu[17].angular_velocity, dataset.drives[1].imu[17].angular_velocity);
  EXPECT_TRUE(copy.drives[1].lidars[1].point_times_from_azimuth);
  EXPECT_FALSE(copy.drives[1].lidars[0].point_times_from_azimuth);
  const LidarScan &a = dataset.drives[1].lidars[1].scans[6], &b = copy.drives[1].lidars[1].scans[6];
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.points[99].position, b.points[99].position);
  EXPECT_EQ(a.points[99].ring, b.points[99].ring);
}

TEST(Serialize, ResultAndOdometryRoundTrip) {
  const CalibrationResult result = SampleResult();
  CalibrationResult copy;
  ASSERT_TRUE(FromBytes(ToBytes(result), &copy));
  EXPECT_EQ(copy.warnings, result.warnings);
  EXPECT_EQ(copy.sensors[3].unobservable[2].quantity, result.sensors[3].unobservable[2].quantity);
  EXPECT_EQ(copy.sensors[3].intrinsics->parameters, result.sensors[3].intrinsics->parameters);
  EXPECT_FALSE(copy.sensors[0].intrinsics.has_value());
  EXPECT_EQ(copy.map[19999].position, result.map[19999].position);
  EXPECT_EQ(copy.residuals[4].over_time_rms, result.residuals[4].over_time_rms);
  EXPECT_EQ(copy.stages[3].lines, result.stages[3].lines);
  EXPECT_EQ(copy.peak_memory_megabytes, result.peak_memory_megabytes);
}

TEST(Serialize, CutOrLongerBytesAreNoObject) {
  const std::vector<char> bytes = ToBytes(SampleResult());
  CalibrationResult copy;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{40}, bytes.size() / 2, bytes.size() - 1}) {
    EXPECT_FALSE(FromBytes(std::vector<char>(bytes.begin(), bytes.begin() + size), &copy)) << size;
  }
  std::vector<char> longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(FromBytes(longer, &copy));
  std::vector<char> absurd = bytes;
  std::memset(absurd.data() + 1, 0x7f, 8);  // the number of reasons
  EXPECT_FALSE(FromBytes(absurd, &copy));
}

TEST(Checkpoint, FoundUnderItsKeyOnly) {
  TemporaryDirectory directory;
  const CheckpointStore store(directory.Path() / "stages");
  const std::vector<char> bytes{'a', 'b', 'c'};
  std::vector<char> loaded;
  EXPECT_FALSE(store.Load("odometry", "key", &loaded));
  store.Save("odometry", "key", bytes);
  EXPECT_TRUE(store.Load("odometry", "key", &loaded));
  EXPECT_EQ(loaded, bytes);
  EXPECT_FALSE(store.Load("odometry", "other", &loaded));
  EXPECT_FALSE(store.Load("dataset", "key", &loaded));
  store.Save("odometry", "other", {});
  EXPECT_FALSE(store.Load("odometry", "key", &loaded));
  EXPECT_TRUE(store.Load("odometry", "other", &loaded));
  EXPECT_TRUE(loaded.empty());
  store.Clear();
  EXPECT_FALSE(store.Load("odometry", "other", &loaded));
}

TEST(Checkpoint, EveryDamagedByteAndLengthIsNoticed) {
  TemporaryDirectory directory;
  const CheckpointStore store(directory.Path());
  store.Save("s", "key", std::vector<char>(50, 'x'));
  const std::filesystem::path file = directory.Path() / "s.stage";
  const std::string good = ReadFile(file);
  std::vector<char> loaded;
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    WriteFileAtomically(file, bad);
    EXPECT_FALSE(store.Load("s", "key", &loaded)) << "byte " << i;
    WriteFileAtomically(file, good.substr(0, i));
    EXPECT_FALSE(store.Load("s", "key", &loaded)) << "length " << i;
  }
  WriteFileAtomically(file, good);
  EXPECT_TRUE(store.Load("s", "key", &loaded));
}

TEST(ContentHash, SeesOrderLengthAndFiles) {
  const auto of = [](const std::string& a, const std::string& b) {
    return ContentHash().Add(a).Add(b).Value();
  };
  EXPECT_EQ(of("ab", "c"), of("ab", "c"));
  EXPECT_NE(of("ab", "c"), of("a", "bc"));
  EXPECT_NE(of("ab", "c"), of("c", "ab"));
  EXPECT_NE(ContentHash().Add("").Value(), ContentHash().Add(std::string(1, '\0')).Value());
  EXPECT_EQ(ContentHash().Text().size(), 16u);
  TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "drive.bag";
  std::string content(3 << 20, 'x');
  WriteFileAtomically(path, content);
  const auto modified = std::filesystem::last_write_time(path);
  const std::uint64_t before = ContentHash().AddFile(path).Value();
  content.back() = 'y';
  WriteFileAtomically(path, content);
  std::filesystem::last_write_time(path, modified);
  EXPECT_NE(ContentHash().AddFile(path).Value(), before);
  WriteFileAtomically(path, "");
  EXPECT_EQ(ContentHash().AddFile(path).Text().size(), 16u);
  EXPECT_TRUE(
      Contains(InputErrorOf([&] { ContentHash().AddFile(directory.Path() / "none.bag"); }), "none.bag"));
}

// 100 MB: larger than any buffer on the way.
TEST(Serialize, LargeDatasetComesBackWhole) {
  const Dataset dataset = SampleDataset(100, 10000);
  TemporaryDirectory directory;
  const CheckpointStore store(directory.Path());
  store.Save("dataset", "key", ToBytes(dataset));
  std::vector<char> bytes;
  ASSERT_TRUE(store.Load("dataset", "key", &bytes));
  EXPECT_GT(bytes.size(), 90000000u);
  Dataset copy;
  ASSERT_TRUE(FromBytes(bytes, &copy));
  EXPECT_TRUE(ToBytes(copy) == bytes);
}

}  // namespace
}  // namespace mlic::checkpoint_test
