// Files as a damaged disk or a hostile hand may leave them.
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "mlic_core/camera/colmap/colmap_model.h"
#include "mlic_core/io/checkpoint/serialize.h"
#include "mlic_core/io/checkpoint/serialize_stages.h"
#include "mlic_core/io/result/point_cloud_reader.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/rig/rig_file.h"
#include "support/files.h"
#include "support/mutations.h"
#include "support/sample_result.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr int kMutants = 500;

std::string ContentOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

// read takes a file that holds the mutant.
void ReadMutantFiles(const std::vector<std::string>& seeds, int count,
                     const std::function<void(const fs::path&)>& read) {
  const TemporaryDirectory directory;
  const fs::path path = directory.Path() / "mutant";
  ReadMutants(seeds, count, [&](const std::string& bytes) {
    Write(path, bytes);
    read(path);
  });
}

template <typename... T>
std::string Packed(const T&... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  return bytes;
}

const std::string kRig = R"(imu: {topic: /imu/data, noise: {gyroscope: 2.0e-4, accelerometer: 2.0e-3}}
lidars:
  front:
    topic: /front/points
    T_imu_sensor: {xyz: [0.1, 0.2, 0.3], rpy_deg: [1, 2, 90]}
    sigma: {xyz: [0.1, 0.1, 0.1], rpy_deg: [5, 5, 5]}
    time_offset: 0.01
cameras:
  left: {topic: /left/image_raw, model: equidistant, fov_deg: 190, shutter: rolling}
)";

std::string PointFile(const std::string& kind, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity ring\nSIZE 4 4 4 4 "
         "2\nTYPE F F F F U\nCOUNT 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA " +
         kind + "\n" + data;
}

std::string BinaryPoint(float x, std::uint16_t ring) { return Packed(x, 2.0f, 3.0f, 4.0f, ring); }

// LZF of the fields one after the other, as literals: a run of up to 32 begins with its length less one.
std::string CompressedPoints() {
  const std::string fields = Packed(1.0f, 5.0f, 2.0f, 2.0f, 3.0f, 3.0f, 4.0f, 4.0f, std::uint32_t{0x10002});
  std::string compressed;
  for (std::size_t at = 0; at < fields.size(); at += 32) {
    const std::string run = fields.substr(at, 32);
    compressed += static_cast<char>(run.size() - 1) + run;
  }
  return Packed(static_cast<std::uint32_t>(compressed.size()), static_cast<std::uint32_t>(fields.size())) +
         compressed;
}

TEST(Fuzz, RigFile) {
  ReadMutantFiles({kRig}, kMutants, [](const fs::path& path) { LoadRigFile(path); });
}

TEST(Fuzz, ResultFile) {
  const TemporaryDirectory directory;
  WriteCalibrationFile(directory.Path() / "calibration.yaml", SampleResult());
  ReadMutantFiles({ContentOf(directory.Path() / "calibration.yaml")}, kMutants,
                  [](const fs::path& path) { ReadCalibrationFile(path); });
}

TEST(Fuzz, PointCloudFile) {
  ReadMutantFiles({PointFile("ascii", "1 2 3 4 1\n5 2 3 4 2\n"),
                   PointFile("binary", BinaryPoint(1.0f, 1) + BinaryPoint(5.0f, 2)),
                   PointFile("binary_compressed", CompressedPoints())},
                  kMutants, [](const fs::path& path) { ReadPointCloudFile(path); });
}

TEST(PointCloudFile, ClaimsNoMoreThanItHolds) {
  const TemporaryDirectory directory;
  std::string content = PointFile("binary", BinaryPoint(1.0f, 1) + BinaryPoint(5.0f, 2));
  for (const std::string claim : {"POINTS 2", "WIDTH 2"})
    content.insert(content.find(claim) + claim.size(), "00000000");
  Write(directory.Path() / "huge.pcd", content);
  EXPECT_TRUE(Contains(InputErrorOf([&] { ReadPointCloudFile(directory.Path() / "huge.pcd"); }),
                       "claims more points than a file of its size can hold"));
}

TEST(RigFile, KeepsBreaksOfTheFileOutOfItsLine) {
  const TemporaryDirectory directory;
  Write(directory.Path() / "rig.yaml", "imu: {topic: \"/imu\\\n\"}\n\"la\\nbel\": 1\n");
  const std::string error = InputErrorOf([&] { LoadRigFile(directory.Path() / "rig.yaml"); });
  EXPECT_TRUE(Contains(error, "la?bel"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST(Fuzz, ColmapModel) {
  const std::uint64_t one = 1;
  std::string camera = Packed(one, std::uint32_t{1}, std::int32_t{4}, std::uint64_t{640}, std::uint64_t{480});
  for (const double parameter : {500.0, 500.0, 320.0, 240.0, 0.1, 0.0, 0.0, 0.0}) camera += Packed(parameter);
  std::string points =
      Packed(one, std::uint64_t{7}, 1.0, 2.0, 3.0, std::uint16_t{0}, std::uint8_t{0}, 0.5, one, one);
  std::string images = Packed(one, std::uint32_t{1}, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, std::uint32_t{1});
  images += std::string("image") + '\0' + Packed(one, 10.0, 20.0, std::uint64_t{7});
  const std::vector<std::pair<std::string, std::string>> files{
      {"cameras.bin", camera}, {"points3D.bin", points}, {"images.bin", images}};
  const TemporaryDirectory directory;
  for (const auto& [name, sound] : files) {
    for (const auto& [other, content] : files) Write(directory.Path() / other, content);
    ReadMutants({sound}, kMutants, [&, path = directory.Path() / name](const std::string& bytes) {
      Write(path, bytes);
      ReadColmapModel(directory.Path());
    });
  }
}

template <typename T>
void ReadStages(const T& sound) {
  const std::vector<char> bytes = ToBytes(sound);
  ReadMutants({std::string(bytes.begin(), bytes.end())}, kMutants, [](const std::string& mutant) {
    T object;
    FromBytes(std::vector<char>(mutant.begin(), mutant.end()), &object);
  });
}

TEST(Fuzz, Checkpoint) {
  Dataset dataset;
  Drive& drive = dataset.drives.emplace_back();
  drive.imu.resize(3);
  drive.lidars.emplace_back().scans.emplace_back().points.resize(4);
  ReadStages(dataset);
  ReadStages(SampleResult());
  ReadStages(Adjustment());
  ReadStages(Initialization());
  TrackSet tracks;
  tracks.keyframes.push_back({0, 0, 0.1});
  ReadStages(tracks);
}

}  // namespace
}  // namespace mlic
