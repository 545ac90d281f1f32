#include "mlic_core/imu/excitation.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/imu_samples.h"
#include "mlic_core/imu/least_noise.h"

namespace mlic {
namespace {

constexpr double kWindow = 0.5;  // s

using Signal = Eigen::Vector3d ImuSample::*;

Eigen::Vector3d RobustSigma(const std::vector<ImuSample>& samples, Signal signal) {
  Eigen::Vector3d sigma;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> differences;
    for (std::size_t i = 3; i < samples.size(); ++i) {
      const auto at = [&](std::size_t k) { return (samples[k].*signal)[axis]; };
      differences.push_back(std::abs(at(i) - 3.0 * at(i - 1) + 3.0 * at(i - 2) - at(i - 3)));
    }
    sigma[axis] = 1.4826 * Median(std::move(differences)) / std::sqrt(20.0);
  }
  return sigma;
}

struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

Moments MomentsOf(const std::vector<ImuSample>& samples, std::size_t begin, std::size_t end, Signal signal) {
  Moments moments;
  const double count = static_cast<double>(end - begin);
  for (std::size_t i = begin; i < end; ++i) moments.mean += samples[i].*signal / count;
  for (std::size_t i = begin; i < end; ++i) {
    const Eigen::Vector3d deviation = samples[i].*signal - moments.mean;
    moments.covariance += deviation * deviation.transpose() / count;
  }
  return moments;
}

bool AtRest(const std::vector<ImuSample>& samples, std::size_t begin, std::size_t end, double gyroscope_limit,
            double accelerometer_limit) {
  const Moments rate = MomentsOf(samples, begin, end, &ImuSample::angular_velocity);
  const Moments force = MomentsOf(samples, begin, end, &ImuSample::specific_force);
  return rate.covariance.diagonal().maxCoeff() < gyroscope_limit * gyroscope_limit &&
         force.covariance.diagonal().maxCoeff() < accelerometer_limit * accelerometer_limit &&
         rate.mean.norm() < 0.05 && std::abs(force.mean.norm() - 9.81) < 0.5;
}

}  // namespace

double ImuRate(const std::vector<ImuSample>& samples) {
  return 1.0 / MedianPeriod(OrderedFiniteSamples(samples));
}

ImuSigma SampleSigma(const std::vector<ImuSample>& samples, const std::optional<ImuNoise>& given) {
  const std::vector<ImuSample> ordered = OrderedFiniteSamples(samples);
  const double root_rate = std::sqrt(1.0 / MedianPeriod(ordered));
  if (given) {
    return {Eigen::Vector3d::Constant(given->gyroscope * root_rate),
            Eigen::Vector3d::Constant(given->accelerometer * root_rate)};
  }
  return {RobustSigma(ordered, &ImuSample::angular_velocity).cwiseMax(kBestGyroscope * root_rate),
          RobustSigma(ordered, &ImuSample::specific_force).cwiseMax(kBestAccelerometer * root_rate)};
}

ImuNoise EstimateImuNoise(const std::vector<ImuSample>& samples) {
  const ImuSigma sigma = SampleSigma(samples, std::nullopt);
  const double root_rate = std::sqrt(ImuRate(samples));
  return {sigma.gyroscope.maxCoeff() / root_rate, sigma.accelerometer.maxCoeff() / root_rate};
}

std::vector<TimeInterval> StaticIntervals(const std::vector<ImuSample>& samples, const ImuNoise& noise,
                                          double shortest) {
  const std::vector<ImuSample> ordered = OrderedFiniteSamples(samples);
  const double root_rate = 1.0 / std::sqrt(MedianPeriod(ordered));
  const double gyroscope_limit = std::max(3.0 * noise.gyroscope * root_rate, 5e-3);
  const double accelerometer_limit = std::max(3.0 * noise.accelerometer * root_rate, 0.05);
  std::vector<TimeInterval> intervals;
  bool open = false;
  for (std::size_t begin = 0; begin < ordered.size();) {
    std::size_t end = begin;
    while (end < ordered.size() && ordered[end].time - ordered[begin].time < kWindow) ++end;
    const bool whole = end < ordered.size() && ordered[end].time - ordered[begin].time < 1.2 * kWindow;
    const bool rest =
        whole && end - begin >= 4 && AtRest(ordered, begin, end, gyroscope_limit, accelerometer_limit);
    if (rest && !open) intervals.push_back({ordered[begin].time, ordered[end].time});
    if (rest && open) intervals.back().end = ordered[end].time;
    open = rest;
    begin = std::max(end, begin + 1);
  }
  intervals.erase(
      std::remove_if(intervals.begin(), intervals.end(),
                     [&](const TimeInterval& interval) { return interval.Duration() < shortest; }),
      intervals.end());
  return intervals;
}

Eigen::Vector3d MeanAngularVelocity(const std::vector<ImuSample>& samples,
                                    const std::vector<TimeInterval>& intervals) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const ImuSample& sample : OrderedFiniteSamples(samples)) {
    for (const TimeInterval& interval : intervals) {
      if (sample.time < interval.start || sample.time >= interval.end) continue;
      sum += sample.angular_velocity;
      count += 1.0;
      break;
    }
  }
  return count > 0.0 ? Eigen::Vector3d(sum / count) : sum;
}

Excitation MeasureExcitation(const std::vector<ImuSample>& samples) {
  const std::vector<ImuSample> ordered = OrderedFiniteSamples(samples);
  const Moments rate = MomentsOf(ordered, 0, ordered.size(), &ImuSample::angular_velocity);
  const Moments force = MomentsOf(ordered, 0, ordered.size(), &ImuSample::specific_force);
  const SymmetricEigen<3> eigen(rate.covariance);
  Excitation excitation;
  excitation.angular_velocity_rms = rate.covariance.diagonal().cwiseSqrt();
  excitation.specific_force_rms = force.covariance.diagonal().cwiseSqrt();
  excitation.principal_rms = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  excitation.principal_axes = eigen.eigenvectors();
  return excitation;
}

}  // namespace mlic
