#include "mlic_core/uncertainty/range_draws.h"

#include <Eigen/Cholesky>
#include <vector>

#include "mlic_core/common/sizes_of_draws.h"

namespace mlic {
namespace {

constexpr double kAnySize = 1.0;  // m, m/rad; from: structural, no prior

// Sigmas, one for each kind: m, and m for each power of ten.
struct ErrorSizes {
  double offset = 0.0, walk = 0.0, level = 0.0;
};

class Draws {
 public:
  Draws(const RangeErrors& found, const std::vector<FreeRanges>& drawn, const Eigen::MatrixXd& covariance)
      : errors_(covariance.rows()), noise_(covariance), drawn_(drawn) {
    for (std::size_t l = 0; l < drawn.size(); ++l) {
      errors_.segment<kRangeParameters>(RangeErrors::Of(l, kRangeOffset)) = found.steps[l];
    }
    noise_.diagonal().array() += 1e-18;  // of those that are held
  }

  // Twice the logarithm of the likelihood, but for a constant.
  double Gain(const ErrorSizes& sizes) const {
    const Eigen::LLT<Eigen::MatrixXd> whole(noise_ + Prior(sizes));
    const Eigen::VectorXd diagonal = Eigen::MatrixXd(whole.matrixL()).diagonal();
    return -errors_.dot(whole.solve(errors_)) - 2.0 * diagonal.array().log().sum();
  }

  // Given what is found.
  Eigen::MatrixXd MeanSquare(const ErrorSizes& sizes) const {
    const Eigen::MatrixXd prior = Prior(sizes);
    const Eigen::MatrixXd gain = (noise_ + prior).llt().solve(prior).transpose();
    const Eigen::VectorXd mean = gain * errors_;
    return mean * mean.transpose() + gain * noise_;
  }

 private:
  Eigen::MatrixXd Prior(const ErrorSizes& sizes) const {
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(errors_.size(), kAnySize);
    for (std::size_t l = 0; l < drawn_.size(); ++l) {
      const auto set = [&](RangeParameter parameter, double size) {
        if (drawn_[l][parameter]) sigmas[RangeErrors::Of(l, parameter)] = size;
      };
      set(kRangeOffset, sizes.offset);
      set(kRangeWalk, sizes.walk);
      set(kRangeLevel, sizes.level);
    }
    return sigmas.cwiseAbs2().asDiagonal();
  }

  Eigen::VectorXd errors_;
  Eigen::MatrixXd noise_;
  std::vector<FreeRanges> drawn_;
};

}  // namespace

Eigen::MatrixXd MeanSquareOfRangeErrors(const RangeErrors& found, const std::vector<FreeRanges>& drawn,
                                        const Eigen::MatrixXd& covariance, double largest) {
  constexpr double kFinest = 1e-4, kStep = 1.5;  // m; from: guard, the likelihood is flat there
  const std::vector<double> each = SizesBetween(kFinest, largest, kStep);
  std::vector<ErrorSizes> sizes;
  for (const double offset : each) {
    for (const double walk : each) {
      for (const double level : each) sizes.push_back({offset, walk, level});
    }
  }
  return MeanSquareOfSizes(Draws(found, drawn, covariance), sizes);
}

}  // namespace mlic
