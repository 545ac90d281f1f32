#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace mlic {

// Errors as draws from a normal distribution about none, of which the data tell the size (a standard
// deviation) in part (empirical Bayes): in the mean over all sizes that are possible, evenly in their
// logarithm and each with its likelihood.

// From the finest to below the coarsest, each `step` times the one before.
inline std::vector<double> SizesBetween(double finest, double coarsest, double step) {
  std::vector<double> sizes;
  for (double size = finest; size < coarsest; size *= step) sizes.push_back(size);
  return sizes;
}

// None, and those.
inline std::vector<double> SizesFromNone(double finest, double coarsest, double step) {
  std::vector<double> sizes = SizesBetween(finest, coarsest, step);
  sizes.insert(sizes.begin(), 0.0);
  return sizes;
}

// The share of each size in the likelihood of all. draws.Gain(size): twice the logarithm of its likelihood's
// ratio to no errors.
template <typename Draws, typename Size>
std::vector<double> LikelihoodShares(const Draws& draws, const std::vector<Size>& sizes) {
  std::vector<double> shares;
  for (const Size& size : sizes) shares.push_back(draws.Gain(size));
  const double largest = *std::max_element(shares.begin(), shares.end());  // or they could overflow
  double sum = 0.0;
  for (double& share : shares) sum += share = std::exp(0.5 * (share - largest));
  for (double& share : shares) share /= sum;
  return shares;
}

// The mean of the errors' products. draws.MeanSquare(size): the same of draws of that size, given the data.
template <typename Draws, typename Size>
Eigen::MatrixXd MeanSquareOfSizes(const Draws& draws, const std::vector<Size>& sizes) {
  const std::vector<double> shares = LikelihoodShares(draws, sizes);
  Eigen::MatrixXd square = shares[0] * draws.MeanSquare(sizes[0]);
  for (std::size_t i = 1; i < sizes.size(); ++i) square += shares[i] * draws.MeanSquare(sizes[i]);
  return square;
}

}  // namespace mlic
