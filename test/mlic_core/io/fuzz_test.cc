// Files as a damaged disk or a hostile hand may leave them.
#include <fstream>

#include "fuzz/core_targets.h"
#include "fuzz/corpus.h"
#include "mlic_core/io/checkpoint/serialize.h"
#include "mlic_core/io/checkpoint/serialize_stages.h"
#include "mlic_core/io/result/point_cloud_reader.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/mutations.h"
#include "support/sample_result.h"

namespace mlic::fuzz_test {
namespace {

namespace fs = std::filesystem;

constexpr int kMutants = 500;

void Write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

TEST(Fuzz, RigFile) { ReadMutants(Corpus("rig"), kMutants, FuzzRig); }

// Of today's format, beside that of the corpus.
TEST(Fuzz, ResultFile) {
  const TemporaryDirectory directory;
  WriteCalibrationFile(directory.Path() / "calibration.yaml", SampleResult());
  std::vector<std::string> seeds = Corpus("result");
  seeds.push_back(ReadFile(directory.Path() / "calibration.yaml"));
  ReadMutants(seeds, kMutants, FuzzResult);
}

TEST(Fuzz, PointCloudFile) { ReadMutants(Corpus("point_cloud"), kMutants, FuzzPointCloud); }

TEST(PointCloudFile, ClaimsNoMoreThanItHolds) {
  const TemporaryDirectory directory;
  std::string content = CorpusFile("point_cloud", "binary.pcd");
  for (const std::string claim : {"POINTS 2", "WIDTH 2"})
    content.insert(content.find(claim) + claim.size(), "00000000");
  Write(directory.Path() / "huge.pcd", content);
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadPointCloudFile(directory.Path() / "huge.pcd"); }),
                       "claims more points than a file of its size can hold"));
}

// PCL reads beyond what it has unpacked.
TEST(PointCloudFile, ClaimsNoMoreThanItsCompressedDataHold) {
  const std::string content = CorpusFile("point_cloud", "fewer_unpacked_than_claimed.pcd");
  EXPECT_TRUE(Contains(InputErrorOf([&] { FuzzPointCloud(content); }),
                       "claims more points than its compressed data hold"));
}

TEST(RigFile, KeepsBreaksOfTheFileOutOfItsLine) {
  const TemporaryDirectory directory;
  Write(directory.Path() / "rig.yaml", "imu: {topic: \"/imu\\\n\"}\n\"la\\nbel\": 1\n");
  const std::string error = InputErrorOf([&] { LoadRigFile(directory.Path() / "rig.yaml"); });
  EXPECT_TRUE(Contains(error, "la?bel"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST(Fuzz, ColmapModel) { ReadMutants(Corpus("colmap"), kMutants, FuzzColmap); }

TEST(ColmapModel, ImagesAreNumberedFromOne) {
  EXPECT_TRUE(Contains(InputErrorOf([] { FuzzColmap(CorpusFile("colmap", "image_without_number.bin")); }),
                       "an image has no number of ours; start again"));
}

template <typename T>
std::string Stage(char kind, const T& object) {
  const std::vector<char> bytes = ToBytes(object);
  return kind + std::string(bytes.begin(), bytes.end());
}

// Checkpoints are of one version of the program: those of the corpus may be of an earlier one.
TEST(Fuzz, Checkpoint) {
  Dataset dataset;
  Drive& drive = dataset.drives.emplace_back();
  drive.imu.resize(3);
  drive.lidars.emplace_back().scans.emplace_back().points.resize(4);
  TrackSet tracks;
  tracks.keyframes.push_back({0, 0, 0.1});
  const std::string stages[]{Stage(0, dataset), Stage(1, SampleResult()), Stage(2, Adjustment()),
                             Stage(3, Initialization()), Stage(4, tracks)};
  for (const std::string& stage : stages) ReadMutants({stage}, kMutants, FuzzCheckpoint);
  ReadMutants(Corpus("checkpoint"), kMutants, FuzzCheckpoint);
}

}  // namespace
}  // namespace mlic::fuzz_test
