#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "mlic_core/camera/learned/learned_matcher.h"
#include "mlic_core/camera/learned/toy_networks.h"
#include "mlic_core/camera/tracks/tracks_from_images.h"
#include "mlic_core/common/parallel.h"
#include "support/synthetic_images.h"

extern "C" {
void openblas_set_num_threads(int threads);
int openblas_get_num_threads();
}

namespace mlic::matcher_test {
namespace {

namespace fs = std::filesystem;
constexpr int kWidth = 480, kHeight = 360;

// Texture coordinates of the pixels of a second view: shifted and a little turned against the first.
Eigen::Vector2d SecondView(const Eigen::Vector2d& p) {
  const double c = std::cos(0.04), s = std::sin(0.04);
  return {c * p.x() - s * p.y() + 21.4, s * p.x() + c * p.y() - 12.7};
}

cv::Mat First() {
  static const cv::Mat image = RenderTexture(
      SyntheticTexture(7), kWidth, kHeight, [](const Eigen::Vector2d& p) { return p; }, 2.0, 1);
  return image;
}
cv::Mat Second() {
  static const cv::Mat image = RenderTexture(SyntheticTexture(7), kWidth, kHeight, SecondView, 2.0, 2);
  return image;
}

struct Backend {
  NetworkRuntime runtime;
  PairingKind kind;
};

void WriteToyNetworks(const fs::path& directory, const Backend& backend) {
  if (backend.runtime == NetworkRuntime::kOnnxRuntime) WriteOnnxToyNetworks(directory, backend.kind);
#ifdef MLIC_HAS_LIBTORCH
  if (backend.runtime == NetworkRuntime::kLibtorch) WriteTorchToyNetworks(directory, backend.kind);
#endif
}

std::string BackendName(const testing::TestParamInfo<Backend>& info) {
  const bool onnx = info.param.runtime == NetworkRuntime::kOnnxRuntime;
  return std::string(onnx ? "OnnxRuntime" : "Libtorch") +
         (info.param.kind == PairingKind::kLightGlue ? "LightGlue" : "SuperGlue");
}

class LearnedMatcherTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    const auto runtimes = NetworkRuntimes();
    if (std::find(runtimes.begin(), runtimes.end(), GetParam().runtime) == runtimes.end()) {
      GTEST_SKIP() << RuntimeName(GetParam().runtime) << " is not in this build: install "
                   << RuntimePackage(GetParam().runtime);
    }
    directory_ = fs::path(testing::TempDir()) / ("mlic_learned_matcher_" + BackendName({GetParam(), 0}));
    fs::remove_all(directory_);
    fs::create_directories(directory_);
    WriteToyNetworks(directory_, GetParam());
  }
  void TearDown() override { fs::remove_all(directory_); }

  std::unique_ptr<FeatureMatcher> Make(int longest_side = 1024) const {
    LearnedMatcherOptions options;
    options.weights = directory_;
    options.detection.longest_side = longest_side;
    options.detection.most_features = 1500;  // all
    return MakeLearnedMatcher(options);
  }

  fs::path directory_;
};

std::vector<double> Errors(const FeatureSet& a, const FeatureSet& b,
                           const std::vector<FeatureMatch>& matches) {
  std::vector<double> errors;
  for (const FeatureMatch& match : matches) {
    errors.push_back(
        (SecondView(b.pixels[match.b].cast<double>()) - a.pixels[match.a].cast<double>()).norm());
  }
  return errors;
}

TEST_P(LearnedMatcherTest, FindsTheSamePointsUnderAKnownWarp) {
  const auto matcher = Make();
  const FeatureSet a = matcher->Detect(First(), cv::Mat()), b = matcher->Detect(Second(), cv::Mat());
  ASSERT_GT(a.Count(), 200u);
  EXPECT_EQ(a.descriptor_size, 256);
  EXPECT_EQ(a.float_descriptors.size(), 256 * a.Count());
  const auto matches = matcher->Match(a, b, nullptr);
  const auto errors = Errors(a, b, matches);
  const auto right = std::count_if(errors.begin(), errors.end(), [](double e) { return e < 3.0; });
  std::printf("%zu %zu features, %zu matches, %d right\n", a.Count(), b.Count(), matches.size(),
              static_cast<int>(right));
  EXPECT_GT(right, 0.5 * std::min(a.Count(), b.Count()));
  EXPECT_GT(right, 0.9 * matches.size());
  for (std::size_t i = 1; i < matches.size(); ++i) EXPECT_LT(matches[i - 1].a, matches[i].a);
}

TEST_P(LearnedMatcherTest, MatchesAtASmallerWorkingSizeWithoutAShift) {
  // Mirrored, the network sees its own image mirrored: its keypoints lie mirrored in the original to the last
  // digit, if they are brought back by pixel centres; without the halves they would be 0.5 px off.
  const cv::Mat image = First();
  cv::Mat mirrored;
  cv::flip(image, mirrored, 1);
  const auto matcher = Make(kWidth / 2);
  const FeatureSet a = matcher->Detect(image, cv::Mat()), b = matcher->Detect(mirrored, cv::Mat());
  ASSERT_GT(a.Count(), 100u);
  std::size_t found = 0;
  for (const auto& pixel : a.pixels) {
    const Eigen::Vector2f expected(kWidth - 1 - pixel.x(), pixel.y());
    for (const auto& other : b.pixels) found += (other - expected).norm() < 1e-3f;
  }
  EXPECT_GT(found, 0.95 * a.Count());
  EXPECT_NEAR(a.scales.front(), 2.0f * Make()->Detect(image, cv::Mat()).scales.front(), 1e-4f);

  const FeatureSet second = matcher->Detect(Second(), cv::Mat());
  const auto matches = matcher->Match(a, second, nullptr);
  const auto errors = Errors(a, second, matches);
  const auto right = std::count_if(errors.begin(), errors.end(), [](double e) { return e < 5.0; });
  EXPECT_GT(right, 0.9 * matches.size());
  EXPECT_GT(right, 50);
}

TEST_P(LearnedMatcherTest, KeepsClearOfTheMaskAndOfTheBorder) {
  cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 200, kWidth, kHeight - 200)).setTo(0);
  const FeatureSet features = Make()->Detect(First(), mask);
  ASSERT_GT(features.Count(), 100u);
  for (const auto& pixel : features.pixels) {
    EXPECT_GT(pixel.minCoeff(), 7.0f);
    EXPECT_LT(pixel.x(), kWidth - 8.0f);
    EXPECT_LT(pixel.y(), 193.0f);
  }
}

TEST_P(LearnedMatcherTest, TakesImagesOfAnySize) {
  const cv::Mat image = First();
  const FeatureSet whole = Make()->Detect(image, cv::Mat());
  const FeatureSet part = Make()->Detect(image(cv::Rect(0, 0, 331, 203)), cv::Mat());
  EXPECT_EQ(part.width, 331);
  EXPECT_EQ(part.height, 203);
  std::size_t found = 0;
  for (const auto& pixel : part.pixels) {
    EXPECT_LT(pixel.x(), 331 - 8);
    EXPECT_LT(pixel.y(), 203 - 8);
    for (const auto& other : whole.pixels) found += other == pixel;
  }
  EXPECT_GT(found, 0.9 * part.Count());
  EXPECT_GT(part.Count(), 50u);
  // Nothing to see.
  const FeatureSet empty = Make()->Detect(cv::Mat(100, 100, CV_8UC1, cv::Scalar(90)), cv::Mat());
  EXPECT_EQ(empty.Count(), 0u);
  EXPECT_TRUE(Make()->Match(empty, whole, nullptr).empty());
  EXPECT_TRUE(Make()->Match(whole, empty, nullptr).empty());
}

TEST_P(LearnedMatcherTest, AGuideForbidsWhatTheGeometryForbids) {
  const auto matcher = Make();
  const FeatureSet features = matcher->Detect(First(), cv::Mat());
  std::vector<Eigen::Vector3d> bearings;
  for (const auto& pixel : features.pixels) {
    bearings.push_back(Eigen::Vector3d((pixel.x() - 240) / 400, (pixel.y() - 180) / 400, 1).normalized());
  }
  MatchGuide guide;
  guide.bearings_a = guide.bearings_b = &bearings;
  guide.largest_error = 1e-3;
  const std::size_t all = matcher->Match(features, features, nullptr).size();
  ASSERT_GT(all, features.Count() / 2);
  EXPECT_EQ(matcher->Match(features, features, &guide).size(), all);
  guide.t_b_a = Eigen::Vector3d::UnitX();
  EXPECT_EQ(matcher->Match(features, features, &guide).size(), all);
  // The network only finds each feature in itself, which neither turn allows (but on the axis).
  guide.R_b_a = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_LT(matcher->Match(features, features, &guide).size(), all / 10);
  guide.t_b_a.setZero();
  guide.R_b_a = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_LT(matcher->Match(features, features, &guide).size(), all / 10);
  bearings.assign(bearings.size(), Eigen::Vector3d::Zero());
  guide.R_b_a.setIdentity();
  EXPECT_TRUE(matcher->Match(features, features, &guide).empty());
}

TEST_P(LearnedMatcherTest, LeavesOutFeaturesWithoutDescriptor) {
  const auto matcher = Make();
  const FeatureSet a = matcher->Detect(First(), cv::Mat());
  FeatureSet more;  // one that was only followed, before all others
  more.descriptor_size = a.descriptor_size;
  more.width = a.width;
  more.height = a.height;
  more.pixels = {{3.0f, 4.0f}};
  more.scales = more.angles = more.scores = {0.0f};
  more.float_descriptors.assign(256, 0.0f);
  more.pixels.insert(more.pixels.end(), a.pixels.begin(), a.pixels.end());
  more.scales.insert(more.scales.end(), a.scales.begin(), a.scales.end());
  more.angles.insert(more.angles.end(), a.angles.begin(), a.angles.end());
  more.scores.insert(more.scores.end(), a.scores.begin(), a.scores.end());
  more.float_descriptors.insert(more.float_descriptors.end(), a.float_descriptors.begin(),
                                a.float_descriptors.end());
  const auto matches = matcher->Match(a, more, nullptr);
  EXPECT_EQ(matches.size(), matcher->Match(a, a, nullptr).size());
  for (const FeatureMatch& match : matches) EXPECT_EQ(match.b, match.a + 1);
}

TEST_P(LearnedMatcherTest, AThresholdOfTheScoreHolds) {
  const auto loose = Make();
  const FeatureSet a = loose->Detect(First(), cv::Mat()), b = loose->Detect(Second(), cv::Mat());
  LearnedMatcherOptions options;
  options.weights = directory_;
  options.least_score = 0.9f;
  const auto strict = MakeLearnedMatcher(options)->Match(a, b, nullptr);
  EXPECT_LT(strict.size(), loose->Match(a, b, nullptr).size());
  EXPECT_GT(strict.size(), 20u);
  for (const FeatureMatch& match : strict) EXPECT_GE(match.score, 0.9f);
}

TEST_P(LearnedMatcherTest, IsTheSameEveryTimeAndInParallel) {
  const auto matcher = Make();
  const cv::Mat first = First(), second = Second();
  const FeatureSet a = matcher->Detect(first, cv::Mat()), b = matcher->Detect(second, cv::Mat());
  const auto matches = matcher->Match(a, b, nullptr);
  std::vector<int> differences(6, 0);
  ParallelFor(differences.size(), [&](std::size_t i) {
    const FeatureSet again = matcher->Detect(first, cv::Mat());
    differences[i] += again.float_descriptors != a.float_descriptors || again.pixels != a.pixels;
    const auto matches_again = matcher->Match(again, b, nullptr);
    differences[i] += matches_again.size() != matches.size();
    for (std::size_t k = 0; k < std::min(matches.size(), matches_again.size()); ++k) {
      differences[i] += matches[k].b != matches_again[k].b || matches[k].score != matches_again[k].score;
    }
  });
  EXPECT_EQ(differences, std::vector<int>(6, 0));
}

// From images to refined tracks, as the calibration does it.
TEST_P(LearnedMatcherTest, MakesTracks) {
  const SyntheticTexture texture(5);
  const auto place = [](std::size_t image, const Eigen::Vector2d& p) {
    const double turn = 0.01 * image;
    return Eigen::Vector2d(std::cos(turn) * p.x() - std::sin(turn) * p.y() + 7.3 * image,
                           std::sin(turn) * p.x() + std::cos(turn) * p.y() + 1.7 * image);
  };
  std::vector<cv::Mat> images;
  for (std::size_t i = 0; i < 12; ++i) {
    images.push_back(RenderTexture(
        texture, 320, 240, [&](const Eigen::Vector2d& p) { return place(i, p); }, 1.5, 100 + i));
  }
  CameraRecording recording;
  recording.width = 320;
  recording.height = 240;
  recording.images = std::make_shared<MemoryImages>(images);
  const CameraIntrinsics intrinsics = IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 320, 240, 60.0);
  TrackingOptions options;
  options.follow.enabled = false;  // the matches alone
  const TrackSet set = FindTracks({{&recording, intrinsics}}, VehiclePose(), CameraPose(), *Make(), options);
  ASSERT_GT(set.tracks.size(), 100u);
  double square = 0.0;
  int count = 0, wrong = 0;
  for (const Track& track : set.tracks) {
    for (std::size_t i = 1; i < track.observations.size(); ++i) {
      const TrackObservation &a = track.observations[i - 1], &b = track.observations[i];
      const double error = (place(set.keyframes[a.keyframe].image, a.pixel.cast<double>()) -
                            place(set.keyframes[b.keyframe].image, b.pixel.cast<double>()))
                               .squaredNorm() /
                           2.0;
      wrong += error > 0.5;
      square += error > 0.5 ? 0.0 : error;
      count += error <= 0.5;
    }
  }
  std::printf("%zu tracks, %d wrong of %d, rms %.3f px\n", set.tracks.size(), wrong, wrong + count,
              std::sqrt(square / count));
  EXPECT_LT(wrong, 0.01 * count);
  EXPECT_LT(std::sqrt(square / count), 0.1);
}

#ifdef MLIC_HAS_LIBTORCH
// libtorch's convolutions and products go through OpenBLAS, which adds up otherwise with several threads.
TEST(LearnedNetwork, DoesNotDependOnTheNumberOfBlasThreads) {
  const fs::path file = fs::path(testing::TempDir()) / "mlic_learned_blas.pt";
  WriteTorchModule(file, R"(
def forward(self, image):
    kernel = torch.sin(torch.arange(65 * 256) * 1.0).view(65, 256, 1, 1)
    layers = torch.cos(image * torch.arange(1, 257).view(1, 256, 1, 1))
    return torch.conv2d(layers, kernel), image
)");
  const auto network =
      LoadNetwork(NetworkRuntime::kLibtorch, file, {{{{"image"}, {}}}, {{{"a"}, {}}, {{"b"}, {}}}});
  Tensor image{{1, 1, 25, 31}, {}};
  for (int i = 0; i < 25 * 31; ++i) image.values.push_back(0.01f * static_cast<float>(i % 97));
  const int before = openblas_get_num_threads();
  openblas_set_num_threads(1);
  const std::vector<float> one = network->Run({image})[0].values;
  openblas_set_num_threads(4);
  const std::vector<float> four = network->Run({image})[0].values;
  EXPECT_EQ(openblas_get_num_threads(), 4);
  openblas_set_num_threads(before);
  EXPECT_TRUE(one == four);
  fs::remove(file);
}
#endif

INSTANTIATE_TEST_SUITE_P(Backends, LearnedMatcherTest,
                         testing::Values(Backend{NetworkRuntime::kOnnxRuntime, PairingKind::kLightGlue},
                                         Backend{NetworkRuntime::kOnnxRuntime, PairingKind::kSuperGlue},
                                         Backend{NetworkRuntime::kLibtorch, PairingKind::kLightGlue},
                                         Backend{NetworkRuntime::kLibtorch, PairingKind::kSuperGlue}),
                         BackendName);

}  // namespace
}  // namespace mlic::matcher_test
