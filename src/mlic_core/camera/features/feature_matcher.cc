#include "mlic_core/camera/features/feature_matcher.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"

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

// The two most similar of the other set.
struct Nearest {
  int index = -1;
  float best = -1.0f;
  float second = -1.0f;

  void See(int candidate, float similarity) {
    if (similarity > best) {
      second = best;
      best = similarity;
      index = candidate;
    } else if (similarity > second) {
      second = similarity;
    }
  }
};

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

    std::vector<Nearest> of_a(count_a), of_b(count_b);
    Eigen::MatrixXf similarity;
    for (int first = 0; first < count_b; first += kBlock) {
      const int columns = std::min(kBlock, count_b - first);
      similarity.noalias() = descriptors_a.transpose() * descriptors_b.middleCols(first, columns);
      if (filter) filter->Apply(first, &similarity);
      for (int j = 0; j < columns; ++j) {
        const float* column = similarity.col(j).data();
        Nearest& nearest = of_b[first + j];
        for (int i = 0; i < count_a; ++i) {
          nearest.See(i, column[i]);
          of_a[i].See(first + j, column[i]);
        }
      }
    }
    const double ratio = guide != nullptr ? options_.largest_guided_ratio : options_.largest_ratio;
    for (int i = 0; i < count_a; ++i) {
      const Nearest& nearest = of_a[i];
      if (nearest.index < 0 || of_b[nearest.index].index != i) continue;
      const float square = SquaredDistance(nearest.best);
      const float second = std::max(nearest.second, of_b[nearest.index].second);
      if (square > options_.largest_distance * options_.largest_distance) continue;
      if (second > -1.0f && square > ratio * ratio * SquaredDistance(second)) continue;
      matches.push_back({i, nearest.index, nearest.best});
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
