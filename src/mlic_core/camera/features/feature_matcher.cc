#include "mlic_core/camera/features/feature_matcher.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"
#include "mlic_core/solver/blas.h"

namespace mlic {
namespace {

using DescriptorMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic>;  // one column for each feature

// Columns for one block of the product of descriptors: stays in the cache while its rows and columns are
// searched.
constexpr int kBlock = 256;  // from: structural

// RootSIFT (Arandjelovic and Zisserman, CVPR 2012): the root of the descriptor with sum 1; its unit length
// makes distances a matter of dot products.
DescriptorMatrix RootDescriptors(const FeatureSet& features) {
  const int size = features.descriptor_size, count = static_cast<int>(features.Count());
  DescriptorMatrix result(size, count);
  for (int i = 0; i < count; ++i) {
    const std::uint8_t* descriptor = &features.descriptors[static_cast<std::size_t>(i) * size];
    int sum = 0;
    for (int k = 0; k < size; ++k) sum += descriptor[k];
    const float scale = 1.0f / std::max(1, sum);
    for (int k = 0; k < size; ++k) result(k, i) = std::sqrt(scale * descriptor[k]);
  }
  return result;
}

// Columns: bearings, zero where there are none.
Eigen::Matrix3Xf BearingMatrix(const std::vector<Eigen::Vector3d>& bearings) {
  Eigen::Matrix3Xf result(3, bearings.size());
  for (std::size_t i = 0; i < bearings.size(); ++i) result.col(i) = bearings[i].cast<float>();
  return result;
}

// Sets the similarity of pairs that the guide excludes to -1.
class GuideFilter {
 public:
  GuideFilter(const MatchGuide& guide, int count_a, int count_b) {
    Check(guide.bearings_a != nullptr && guide.bearings_b != nullptr, "MatchGuide: bearings are missing");
    Check(static_cast<int>(guide.bearings_a->size()) == count_a &&
              static_cast<int>(guide.bearings_b->size()) == count_b,
          "MatchGuide: one bearing for each feature");
    a_ = guide.R_b_a.cast<float>() * BearingMatrix(*guide.bearings_a);
    b_ = BearingMatrix(*guide.bearings_b);
    epipolar_ = !guide.t_b_a.isZero();
    if (!epipolar_) {
      least_cosine_ = static_cast<float>(std::cos(guide.largest_error));
      return;
    }
    // b . (t x a) = 0, with first-order error |b . n| / sqrt(|n x b|^2 + |m x a|^2) where n = t x a, m = t x
    // b and a is already turned into the frame of b.
    const Eigen::Vector3f t = guide.t_b_a.normalized().cast<float>();
    n_.resize(3, count_a);
    for (int i = 0; i < count_a; ++i) n_.col(i) = t.cross(Eigen::Vector3f(a_.col(i)));
    n_square_ = n_.colwise().squaredNorm();
    m_square_.resize(count_b);
    for (int j = 0; j < count_b; ++j) m_square_[j] = t.cross(Eigen::Vector3f(b_.col(j))).squaredNorm();
    largest_square_ = static_cast<float>(guide.largest_error * guide.largest_error);
  }

  void Apply(int first_b, Eigen::MatrixXf* similarity) const {
    const int columns = static_cast<int>(similarity->cols());
    const Eigen::MatrixXf product = (epipolar_ ? n_ : a_).transpose() * b_.middleCols(first_b, columns);
    for (int j = 0; j < columns; ++j) {
      const float m_square = epipolar_ ? m_square_[first_b + j] : 0.0f;
      const bool has_bearing = b_.col(first_b + j).squaredNorm() > 0.5f;
      for (int i = 0; i < product.rows(); ++i) {
        bool allowed = has_bearing;
        if (epipolar_) {
          const float square = product(i, j) * product(i, j);
          // |n x b|^2 = |n|^2 - (n . b)^2; likewise for m.
          allowed = allowed && n_square_[i] > 0.0f &&
                    square <= largest_square_ * (n_square_[i] + m_square - 2.0f * square);
        } else {
          allowed = allowed && product(i, j) >= least_cosine_;
        }
        if (!allowed) (*similarity)(i, j) = -1.0f;
      }
    }
  }

 private:
  Eigen::Matrix3Xf a_, b_, n_;
  Eigen::VectorXf n_square_, m_square_;
  bool epipolar_ = false;
  float least_cosine_ = 0.0f, largest_square_ = 0.0f;
};

// For each feature of one set the two most similar of the other.
struct Nearest {
  explicit Nearest(int count) : index(count, -1), best(count, -1.0f), second(count, -1.0f) {}

  void See(int feature, int candidate, float similarity) {
    if (similarity > best[feature]) {
      second[feature] = best[feature];
      best[feature] = similarity;
      index[feature] = candidate;
    } else if (similarity > second[feature]) {
      second[feature] = similarity;
    }
  }

  std::vector<int> index;  // of the most similar; -1: none
  std::vector<float> best, second;
};

// Shows the similarities of all features of one set to feature `b` of the other to both. Nearly all are below
// what was seen before: they are looked at by kGroup, which compiles to few instructions.
void SeeColumn(const float* similarity, int b, Nearest* of_a, Nearest* of_b) {
  constexpr int kGroup = 16;  // from: structural
  const int count = static_cast<int>(of_a->index.size());
  const float* second_a = of_a->second.data();
  for (int first = 0; first < count; first += kGroup) {
    const int end = std::min(first + kGroup, count);
    const float second_b = of_b->second[b];
    int larger = 0;
    for (int i = first; i < end; ++i) larger |= (similarity[i] > second_b) | (similarity[i] > second_a[i]);
    if (larger == 0) continue;
    for (int i = first; i < end; ++i) {
      of_a->See(i, b, similarity[i]);
      of_b->See(b, i, similarity[i]);
    }
  }
}

float SquaredDistance(float similarity) { return std::max(0.0f, 2.0f - 2.0f * similarity); }

class ClassicalMatcher : public FeatureMatcher {
 public:
  explicit ClassicalMatcher(const ClassicalMatcherOptions& options) : options_(options) {}

  std::string Name() const override { return "sift"; }

  FeatureSet Detect(const cv::Mat& gray, const cv::Mat& mask) const override {
    return DetectSift(gray, mask, options_.features);
  }

  std::vector<FeatureMatch> Match(const FeatureSet& a, const FeatureSet& b,
                                  const MatchGuide* guide) const override {
    const int count_a = static_cast<int>(a.Count()), count_b = static_cast<int>(b.Count());
    std::vector<FeatureMatch> matches;
    if (count_a == 0 || count_b == 0) return matches;
    Check(a.descriptor_size == b.descriptor_size, "features of one kind only can be matched");
    const DescriptorMatrix descriptors_a = RootDescriptors(a), descriptors_b = RootDescriptors(b);
    std::unique_ptr<GuideFilter> filter;
    if (guide != nullptr) filter = std::make_unique<GuideFilter>(*guide, count_a, count_b);

    Nearest of_a(count_a), of_b(count_b);
    Eigen::MatrixXf similarity;
    const int size = a.descriptor_size;
    for (int first = 0; first < count_b; first += kBlock) {
      const int columns = std::min(kBlock, count_b - first);
      similarity.resize(count_a, columns);
      TransposedProduct({descriptors_a.data(), size, count_a, size},
                        {descriptors_b.col(first).data(), size, columns, size},
                        {similarity.data(), count_a, columns, count_a});
      if (filter) filter->Apply(first, &similarity);
      for (int j = 0; j < columns; ++j) SeeColumn(similarity.col(j).data(), first + j, &of_a, &of_b);
    }
    const double ratio = guide != nullptr ? options_.largest_guided_ratio : options_.largest_ratio;
    for (int i = 0; i < count_a; ++i) {
      const int j = of_a.index[i];
      if (j < 0 || of_b.index[j] != i) continue;
      const float square = SquaredDistance(of_a.best[i]);
      const float second = std::max(of_a.second[i], of_b.second[j]);
      if (square > options_.largest_distance * options_.largest_distance) continue;
      if (second > -1.0f && square > ratio * ratio * SquaredDistance(second)) continue;
      matches.push_back({i, j, of_a.best[i]});
    }
    return matches;
  }

 private:
  ClassicalMatcherOptions options_;
};

}  // namespace

std::unique_ptr<FeatureMatcher> MakeClassicalMatcher(const ClassicalMatcherOptions& options) {
  return std::make_unique<ClassicalMatcher>(options);
}

}  // namespace mlic
