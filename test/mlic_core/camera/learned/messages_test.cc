// What the learned matcher says when something is missing or wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>

#include "mlic_core/camera/learned/learned_matcher.h"
#include "mlic_core/camera/learned/toy_networks.h"
#include "mlic_core/common/error.h"

namespace mlic::messages_test {
namespace {

namespace fs = std::filesystem;

// The message of the InputError that making a matcher (and using it, with `use`) throws.
std::string Message(const fs::path& directory, bool use = false) {
  LearnedMatcherOptions options;
  options.weights = directory;
  try {
    const auto matcher = MakeLearnedMatcher(options);
    if (use) {
      cv::Mat image(120, 160, CV_8UC1);
      cv::theRNG().state = 1;
      cv::randu(image, 0, 256);
      const FeatureSet features = matcher->Detect(image, cv::Mat());
      matcher->Match(features, features, nullptr);
    }
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool Has(NetworkRuntime runtime) {
  const auto runtimes = NetworkRuntimes();
  return std::find(runtimes.begin(), runtimes.end(), runtime) != runtimes.end();
}

class LearnedMessages : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = fs::path(testing::TempDir()) /
                 (std::string("mlic_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(directory_);
    fs::create_directories(directory_);
  }
  void TearDown() override { fs::remove_all(directory_); }

  void ExpectMessage(const std::string& message, const std::vector<std::string>& parts) {
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
  }

  fs::path directory_;
};

TEST_F(LearnedMessages, WithoutARuntime) {
  if (!NetworkRuntimes().empty()) GTEST_SKIP() << "this build has a runtime";
  ExpectMessage(Message(directory_), {"neither ONNX Runtime nor libtorch", "libtorch-dev", "classical"});
}

TEST_F(LearnedMessages, MissingFiles) {
  if (NetworkRuntimes().empty()) GTEST_SKIP() << "no runtime in this build";
  ExpectMessage(Message(directory_ / "nowhere"), {"nowhere", "is not a directory"});
  const std::string suffix = FileSuffix(NetworkRuntimes().front());
  std::ofstream(directory_ / ("superpoint" + suffix)) << "x";
  ExpectMessage(Message(directory_), {directory_.string(), "lightglue" + suffix, "superglue" + suffix});
}

TEST_F(LearnedMessages, NetworksOfTheOtherRuntime) {
  if (NetworkRuntimes().size() != 1) GTEST_SKIP() << "needs a build with one runtime";
  const bool onnx = Has(NetworkRuntime::kOnnxRuntime);
  for (const char* stem : {"superpoint", "superglue"}) {
    std::ofstream(directory_ / (std::string(stem) + (onnx ? ".pt" : ".onnx"))) << "x";
  }
  ExpectMessage(Message(directory_), {onnx ? "libtorch-dev" : "libonnxruntime-dev", onnx ? ".onnx" : ".pt"});
}

TEST_F(LearnedMessages, FilesThatAreNoNetworks) {
  if (NetworkRuntimes().empty()) GTEST_SKIP() << "no runtime in this build";
  for (const NetworkRuntime runtime : NetworkRuntimes()) {
    const std::string suffix = FileSuffix(runtime);
    for (const char* stem : {"superpoint", "lightglue"}) {
      std::ofstream(directory_ / (stem + suffix)) << "this is no network";
    }
    ExpectMessage(Message(directory_), {"superpoint" + suffix, "cannot be read as"});
    fs::remove(directory_ / ("superpoint" + suffix));
  }
}

TEST_F(LearnedMessages, WrongSignatureOfOnnx) {
  if (!Has(NetworkRuntime::kOnnxRuntime)) GTEST_SKIP() << "no ONNX Runtime in this build";
  WriteOnnxToyNetworks(directory_, PairingKind::kLightGlue);
  const fs::path detector = directory_ / "superpoint.onnx", pairing = directory_ / "lightglue.onnx";
  const NetworkSignature good = DetectorSignature();
  auto inputs = good.inputs;
  inputs[0].names = {"picture"};
  WriteOnnxModule(detector, inputs, good.outputs);
  ExpectMessage(Message(directory_), {"superpoint.onnx", "inputs must be image, and are picture"});
  inputs = good.inputs;
  inputs[0].shape = {1, 3, 0, 0};
  WriteOnnxModule(detector, inputs, good.outputs);
  ExpectMessage(Message(directory_), {"superpoint.onnx", "image", "[1, 1, any, any]", "[1, 3, any, any]"});
  WriteOnnxModule(detector, good.inputs, {good.outputs[0], good.outputs[1]});
  ExpectMessage(Message(directory_), {"superpoint.onnx", "outputs must be keypoints, scores, descriptors"});
  // The names are right, what comes out is not: only running shows it.
  WriteOnnxModule(detector, good.inputs, good.outputs);
  ExpectMessage(Message(directory_, true), {"superpoint.onnx", "[1, N, 256]", "[1, 1, 120, 160]"});

  WriteOnnxToyNetworks(directory_, PairingKind::kLightGlue);
  const NetworkSignature matcher = PairingSignature(PairingKind::kLightGlue);
  inputs = matcher.inputs;
  inputs[2].shape = {1, 256, 0};
  WriteOnnxModule(pairing, inputs, matcher.outputs);
  ExpectMessage(Message(directory_), {"lightglue.onnx", "desc0", "[1, any, 256]"});
  inputs = matcher.inputs;
  inputs[0].shape = {1, 512, 2};
  WriteOnnxModule(pairing, inputs, matcher.outputs);
  ExpectMessage(Message(directory_), {"lightglue.onnx", "kpts0", "[1, any, 2]", "[1, 512, 2]"});
  WriteOnnxModule(pairing, matcher.inputs, matcher.outputs);
  ExpectMessage(Message(directory_, true), {"lightglue.onnx"});
}

// A network for one size of images gets them continued to that size.
TEST_F(LearnedMessages, NoneForAnOnnxNetworkOfOneSize) {
  if (!Has(NetworkRuntime::kOnnxRuntime)) GTEST_SKIP() << "no ONNX Runtime in this build";
  WriteOnnxToyNetworks(directory_, PairingKind::kLightGlue, 320, 240);
  EXPECT_EQ(Message(directory_, true), "");
}

TEST_F(LearnedMessages, WrongSignatureOfTorchScript) {
#ifdef MLIC_HAS_LIBTORCH
  WriteTorchToyNetworks(directory_, PairingKind::kLightGlue);
  const fs::path detector = directory_ / "superpoint.pt", pairing = directory_ / "lightglue.pt";
  EXPECT_EQ(Message(directory_, true), "");
  WriteTorchModule(detector, "def forward(self, image, size):\n  return image, image, image\n");
  ExpectMessage(Message(directory_), {"superpoint.pt", "must take (image)", "takes (image, size)"});
  WriteTorchModule(detector, "def forward(self, image):\n  return image\n");
  ExpectMessage(Message(directory_), {"superpoint.pt", "keypoints, scores, descriptors", "returns Tensor"});
  WriteTorchModule(detector, "def forward(self, image):\n  return image, image\n");
  ExpectMessage(Message(directory_), {"superpoint.pt", "Tuple[Tensor, Tensor]"});
  WriteTorchModule(detector, "def forward(self, image):\n  return {'keypoints': image, 'scores': image}\n");
  ExpectMessage(Message(directory_, true), {"superpoint.pt", "returns no descriptors"});
  WriteTorchModule(detector, "def forward(self, image):\n  return image, image, image\n");
  ExpectMessage(Message(directory_, true), {"superpoint.pt", "[1, N, 256]", "[1, 1, 120, 160]"});
  WriteTorchModule(detector, "def forward(self, image):\n  return image, torch.mm(image, image), image\n");
  ExpectMessage(Message(directory_, true), {"superpoint.pt", "the network fails"});

  WriteTorchToyNetworks(directory_, PairingKind::kLightGlue);
  WriteTorchModule(pairing, "def forward(self, a, b, c):\n  return a, b\n");
  ExpectMessage(Message(directory_), {"lightglue.pt", "(kpts0, kpts1, desc0, desc1)", "(a, b, c)"});
  WriteTorchModule(pairing, "def forward(self, a, b, c, d):\n  return a, b\n");
  ExpectMessage(Message(directory_, true), {"lightglue.pt", "matches0 and mscores0"});
  WriteTorchModule(pairing, "def forward(self, a, b, c, d):\n  return a[0] + 1e6, a[0, :, 0]\n");
  ExpectMessage(Message(directory_, true), {"lightglue.pt", "an index that no feature has"});
#else
  GTEST_SKIP() << "no libtorch in this build";
#endif
}

}  // namespace
}  // namespace mlic::messages_test
