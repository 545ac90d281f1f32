// Messages as a damaged or hostile bag may hold them.
#include "fuzz/corpus.h"
#include "fuzz/ros_targets.h"
#include "support/mutations.h"

namespace mlic::fuzz_test {
namespace {

constexpr int kMutants = 20000;

TEST(Fuzz, PointCloud2) { ReadMutants(Corpus("point_cloud2"), kMutants, FuzzPointCloud2); }
TEST(Fuzz, Livox) { ReadMutants(Corpus("livox"), kMutants, FuzzLivox); }
TEST(Fuzz, Image) { ReadMutants(Corpus("image"), kMutants, FuzzImage); }
TEST(Fuzz, CompressedImage) { ReadMutants(Corpus("compressed_image"), kMutants / 4, FuzzCompressedImage); }
TEST(Fuzz, Imu) { ReadMutants(Corpus("imu"), kMutants, FuzzImu); }

TEST(CompressedImage, ClaimsNoMoreThanItsBytesHold) {
  std::string bytes = CorpusFile("compressed_image", "png");
  const std::size_t width = bytes.find("IHDR") + 4;
  bytes.replace(width, 8, std::string("\0\0\xea\x60\0\0\xea\x60", 8));
  try {
    FuzzCompressedImage(bytes);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("damaged (60000 x 60000"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace mlic::fuzz_test
