// The search for matches among SIFT descriptors, own and by OpenCV's brute-force matcher with the same tests
// (nearest of each other, ratio), on one thread.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <opencv2/features2d.hpp>

#include "mlic_core/camera/features/feature_matcher.h"
#include "mlic_core/common/random.h"
#include "mlic_core/solver/blas.h"

namespace mlic {
namespace {

constexpr int kSize = 128;  // of a descriptor

// Descriptors as SIFT has them, many small and few large numbers.
FeatureSet RandomFeatures(int count, Random* random) {
  FeatureSet features;
  features.descriptor_size = kSize;
  features.pixels.resize(count);
  for (int k = 0; k < count * kSize; ++k) {
    const double number = std::abs(random->Normal());
    features.descriptors.push_back(static_cast<std::uint8_t>(std::min(255.0, 40.0 * number * number)));
  }
  return features;
}

// Half of the features of another image of the same place are seen again.
FeatureSet SeenAgain(const FeatureSet& first, Random* random) {
  FeatureSet features = RandomFeatures(static_cast<int>(first.Count()), random);
  for (std::size_t k = 0; k < features.descriptors.size() / 2; ++k) {
    const double number = first.descriptors[k] + 6.0 * random->Normal();
    features.descriptors[k] = static_cast<std::uint8_t>(std::clamp(number, 0.0, 255.0));
  }
  return features;
}

struct Images {
  explicit Images(int count) : random(1), a(RandomFeatures(count, &random)), b(SeenAgain(a, &random)) {}
  Random random;
  FeatureSet a, b;
};

void MatchOwn(benchmark::State& state) {
  const Images images(static_cast<int>(state.range(0)));
  const auto matcher = MakeClassicalMatcher(ClassicalMatcherOptions());
  const BlasOnOneThread one_thread;
  std::size_t matches = 0;
  for (auto _ : state) matches = matcher->Match(images.a, images.b, nullptr).size();
  state.counters["matches"] = static_cast<double>(matches);
}

// RootSIFT, as the own matcher compares.
cv::Mat RootDescriptors(const FeatureSet& features) {
  const cv::Mat bytes(static_cast<int>(features.Count()), kSize, CV_8U,
                      const_cast<std::uint8_t*>(features.descriptors.data()));
  cv::Mat numbers;
  bytes.convertTo(numbers, CV_32F);
  for (int row = 0; row < numbers.rows; ++row) numbers.row(row) /= cv::sum(numbers.row(row))[0];
  cv::sqrt(numbers, numbers);
  return numbers;
}

void MatchOpenCv(benchmark::State& state) {
  const Images images(static_cast<int>(state.range(0)));
  const double ratio = ClassicalMatcherOptions().largest_ratio;
  cv::setNumThreads(1);
  std::size_t matches = 0;
  for (auto _ : state) {
    const cv::Mat a = RootDescriptors(images.a), b = RootDescriptors(images.b);
    const cv::BFMatcher matcher(cv::NORM_L2);
    std::vector<std::vector<cv::DMatch>> of_a, of_b;
    matcher.knnMatch(a, b, of_a, 2);
    matcher.knnMatch(b, a, of_b, 2);
    matches = 0;
    for (const auto& nearest : of_a) {
      const auto& back = of_b[nearest[0].trainIdx];
      if (back[0].trainIdx != nearest[0].queryIdx) continue;
      matches += nearest[0].distance <= ratio * std::min(nearest[1].distance, back[1].distance);
    }
  }
  state.counters["matches"] = static_cast<double>(matches);
}

BENCHMARK(MatchOwn)->Arg(500)->Arg(1500)->Unit(benchmark::kMillisecond);
BENCHMARK(MatchOpenCv)->Arg(500)->Arg(1500)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mlic

BENCHMARK_MAIN();
