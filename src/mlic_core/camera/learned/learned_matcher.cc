#include "mlic_core/camera/learned/learned_matcher.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/camera/learned/learned_network.h"
#include "mlic_core/camera/learned/learned_pairing.h"
#include "mlic_core/common/error.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr char kDetectorStem[] = "superpoint";
const std::vector<std::pair<std::string, PairingKind>> kPairingStems = {
    {"lightglue", PairingKind::kLightGlue}, {"superglue", PairingKind::kSuperGlue}};

// The networks to use, and what runs them.
struct NetworkFiles {
  NetworkRuntime runtime;
  fs::path detector, pairing;
  PairingKind kind;
};

bool FindFiles(const fs::path& directory, NetworkRuntime runtime, NetworkFiles* files) {
  const std::string suffix = FileSuffix(runtime);
  files->runtime = runtime;
  files->detector = directory / (kDetectorStem + suffix);
  if (!fs::is_regular_file(files->detector)) return false;
  for (const auto& [stem, kind] : kPairingStems) {
    files->pairing = directory / (stem + suffix);
    files->kind = kind;
    if (fs::is_regular_file(files->pairing)) return true;
  }
  return false;
}

constexpr char kDocumentation[] = " (see docs/learned_matcher.md)";

NetworkFiles ChooseFiles(const fs::path& directory) {
  const std::vector<NetworkRuntime> runtimes = NetworkRuntimes();
  const std::string where = "weights of the learned matcher: " + directory.string();
  if (runtimes.empty()) {
    throw InputError(
        "learned matcher: this build of MLIC has neither ONNX Runtime nor libtorch: install "
        "libonnxruntime-dev "
        "(Debian 13) or libtorch-dev (Debian 12) and build again, or use the classical matcher");
  }
  if (!fs::is_directory(directory)) {
    throw InputError(where + " is not a directory: give the one with the networks" + kDocumentation);
  }
  NetworkFiles files;
  for (const NetworkRuntime runtime : runtimes) {
    if (FindFiles(directory, runtime, &files)) return files;
  }
  for (const NetworkRuntime other : {NetworkRuntime::kOnnxRuntime, NetworkRuntime::kLibtorch}) {
    if (!FindFiles(directory, other, &files)) continue;
    throw InputError(where + " holds networks for " + RuntimeName(other) + " (" + FileSuffix(other) +
                     "), and this build of MLIC has " + RuntimeName(runtimes.front()) + " (" +
                     FileSuffix(runtimes.front()) + ") only: export them so, or install " +
                     RuntimePackage(other) + " and build again");
  }
  std::string expected;
  for (const NetworkRuntime runtime : runtimes) {
    const std::string suffix = FileSuffix(runtime);
    expected += (expected.empty() ? "" : "; or ") + (kDetectorStem + suffix) + ", and lightglue" + suffix +
                " or superglue" + suffix;
  }
  throw InputError(where + " lacks networks: expected " + expected + kDocumentation);
}

// FNV-1a (64 bits) of a file's bytes: tells networks apart.
std::uint64_t HashOfFile(const fs::path& path, std::uint64_t hash) {
  std::ifstream stream(path, std::ios::binary);
  std::vector<char> block(1 << 16);
  do {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    for (std::streamsize i = 0; i < stream.gcount(); ++i) {
      hash = (hash ^ static_cast<unsigned char>(block[i])) * 0x100000001B3ull;
    }
  } while (stream);
  return hash;
}

class LearnedMatcher : public FeatureMatcher {
 public:
  explicit LearnedMatcher(const LearnedMatcherOptions& options)
      : options_(options), files_(ChooseFiles(options.weights)) {
    detector_ = LoadNetwork(files_.runtime, files_.detector, DetectorSignature());
    pairing_ = LoadNetwork(files_.runtime, files_.pairing, PairingSignature(files_.kind));
    const std::uint64_t hash = HashOfFile(files_.pairing, HashOfFile(files_.detector, 0xCBF29CE484222325ull));
    char text[80];
    std::snprintf(text, sizeof text, " %016llx %d %g", static_cast<unsigned long long>(hash),
                  options_.detection.longest_side, static_cast<double>(options_.least_score));
    name_ = files_.detector.filename().string() + " " + files_.pairing.filename().string() + text;
  }

  std::string Name() const override { return name_; }

  FeatureSet Detect(const cv::Mat& gray, const cv::Mat& mask) const override {
    return DetectLearned(*detector_, files_.detector.string(), gray, mask, options_.detection);
  }

  std::vector<FeatureMatch> Match(const FeatureSet& a, const FeatureSet& b,
                                  const MatchGuide* guide) const override {
    return PairFeatures(*pairing_, files_.kind, files_.pairing.string(), a, b, guide, options_.least_score);
  }

 private:
  LearnedMatcherOptions options_;
  NetworkFiles files_;
  std::string name_;
  std::unique_ptr<Network> detector_, pairing_;
};

}  // namespace

std::unique_ptr<FeatureMatcher> MakeLearnedMatcher(const LearnedMatcherOptions& options) {
  return std::make_unique<LearnedMatcher>(options);
}

}  // namespace mlic
