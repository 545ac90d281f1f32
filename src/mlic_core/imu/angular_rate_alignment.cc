#include "mlic_core/imu/angular_rate_alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/angular_rate_correlation.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/imu/gyro_integration.h"
#include "mlic_core/imu/pose_segments.h"
#include "mlic_core/imu/robust.h"
#include "mlic_core/imu/rotation_fit.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

constexpr double kLargestOffset = 1.05;  // s; from: definition, offsets up to 1 s and a little
constexpr double kSmallestAngleSigma =
    2e-6;  // rad: below it robust weights would follow rounding; from: guard
// from: guard, of the Jacobian alone.
constexpr double kRateHalfWidth = 0.05;  // s: the offset's Jacobian takes mean rates, which are less noisy
constexpr double kBiasPriorSigma = 0.2;  // rad/s; from: guard, beyond any IMU's (bias_prior.h)

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Matrix37d = Eigen::Matrix<double, 3, 7>;

struct RateState {
  double time_offset = 0.0;
  Eigen::Quaterniond R_imu_lidar = Eigen::Quaterniond::Identity();
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
};

// Residual of one pose and its Jacobian to (rotation, offset, bias) and to its segment's orientation; the
// residual falls by Jacobian * step.
struct PoseResidual {
  Eigen::Vector3d value;
  Matrix37d jacobian;
  Eigen::Matrix3d segment_jacobian;
};

// What one segment alone says of the offset: it is off by gradient / information, whose sigma is the root of
// 1 / information.
struct SegmentOffset {
  double time;         // s, LiDAR clock
  double gradient;     // 1/s
  double information;  // 1/s^2
};

// The system of one Gauss-Newton step, whitened: minimise |step|' H |step| / 2 - b . step, order rotation,
// offset, bias.
struct RateSystem {
  Matrix7d H = Matrix7d::Zero();
  Vector7d b = Vector7d::Zero();
  double sigma = 0.0;  // of a component of an orientation
  double rms = 0.0;
  double inlier_share = 0.0;
  int poses = 0;
  // What the gyroscope's noise looks like as information on the rotation, about any axis, 1/rad^2.
  double noise_information = 0.0;
  double noise_information_offset = 0.0;  // likewise on the offset, 1/s^2
  std::vector<SegmentOffset> segments;    // information in units of a pose's
};

// Noise of the gyroscope turns the IMU about all axes, so that in the Jacobian even motion about one axis
// seems to show the rotation about it, and rest the offset. Directions that show hardly more than that are
// taken out of the data: only a prior may decide there.
void DropWhatNoiseShows(RateSystem* system) {
  const Matrix7d H = system->H + Matrix7d::Identity() * 1e-9;
  const Eigen::Matrix3d marginal =
      H.topLeftCorner<3, 3>() -
      H.topRightCorner<3, 4>() * SolveSymmetric(H.bottomRightCorner<4, 4>(), H.bottomLeftCorner<4, 3>());
  const SymmetricEigen<3> eigen(marginal);
  Matrix7d kept = Matrix7d::Identity();
  for (int i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] > 4.0 * system->noise_information) continue;
    const Eigen::Vector3d direction = eigen.eigenvectors().col(i);
    kept.topLeftCorner<3, 3>() -= direction * direction.transpose();
  }
  if (H(3, 3) < 4.0 * system->noise_information_offset) kept(3, 3) = 0.0;
  system->H = (kept * system->H * kept).eval();
  system->b = (kept * system->b).eval();
}

Eigen::Vector3d MeanRate(const GyroIntegration& gyro, double time) {
  return Log(gyro.RotationBetween(time - kRateHalfWidth, time + kRateHalfWidth)) / (2.0 * kRateHalfWidth);
}

class Problem {
 public:
  Problem(const std::vector<ImuSample>& imu, const std::vector<TimedPose>& poses)
      : imu_(imu), poses_(poses), gyroscope_noise_(EstimateImuNoise(imu).gyroscope) {}

  RateSystem Linearize(const RateState& state, bool redescending) const {
    const GyroIntegration gyro(imu_, state.bias);
    const std::vector<PoseSegment> segments = CutSegments(poses_, gyro, state.time_offset);
    std::vector<PoseResidual> residuals;
    for (const PoseSegment& segment : segments) AddResiduals(gyro, state, segment, &residuals);
    std::vector<double> norms;
    for (const PoseResidual& residual : residuals) norms.push_back(residual.value.norm());

    RateSystem system;
    system.poses = static_cast<int>(residuals.size());
    if (residuals.empty()) return system;
    // Each segment's orientation takes three of its residuals' degrees of freedom.
    const double freedom = 1.0 - static_cast<double>(segments.size()) / static_cast<double>(residuals.size());
    system.sigma = std::max(kSmallestAngleSigma, SigmaFromNorms(norms) / std::sqrt(freedom));
    double correlated = 0.0, squares = 0.0, inliers = 0.0, weights = 0.0;
    std::size_t next = 0;
    for (const PoseSegment& segment : segments) {
      const std::size_t count = static_cast<std::size_t>(segment.Count());
      Eigen::Matrix3d H_ss = Eigen::Matrix3d::Identity() * 1e-12;
      Matrix37d H_sg = Matrix37d::Zero();
      Eigen::Vector3d b_s = Eigen::Vector3d::Zero();
      SegmentOffset offset{poses_[segment.Center()].time, 0.0, 0.0};
      for (std::size_t i = next; i < next + count; ++i) {
        const PoseResidual& r = residuals[i];
        const double weight =
            redescending ? TukeyWeight(norms[i], system.sigma) : AbsoluteWeight(norms[i], system.sigma);
        weights += weight;
        H_ss += weight * r.segment_jacobian.transpose() * r.segment_jacobian;
        H_sg += weight * r.segment_jacobian.transpose() * r.jacobian;
        b_s += weight * r.segment_jacobian.transpose() * r.value;
        system.H += weight * r.jacobian.transpose() * r.jacobian;
        system.b += weight * r.jacobian.transpose() * r.value;
        offset.gradient += weight * r.jacobian.col(3).dot(r.value);
        offset.information += weight * r.jacobian.col(3).squaredNorm();
        if (TukeyWeight(norms[i], system.sigma) <= 0.0) continue;
        squares += r.value.squaredNorm();
        inliers += 1.0;
        if (i > next && norms[i - 1] < 6.0 * system.sigma) correlated += r.value.dot(residuals[i - 1].value);
      }
      const Matrix37d eliminated = SolveSymmetric(H_ss, H_sg);
      system.H -= H_sg.transpose() * eliminated;
      system.b -= eliminated.transpose() * b_s;
      offset.gradient -= eliminated.col(3).dot(b_s);
      offset.information -= eliminated.col(3).dot(H_sg.col(3));
      if (offset.information > 0.0) system.segments.push_back(offset);
      next += count;
    }
    system.inlier_share = inliers / static_cast<double>(residuals.size());
    system.rms = std::sqrt(squares / std::max(1.0, 3.0 * inliers * freedom));
    // Errors that neighbours share count less: first-order autoregressive residuals.
    const double rho = std::min(0.9, std::max(0.0, correlated / std::max(squares, 1e-300)));
    const double variance = system.sigma * system.sigma * (1.0 + rho) / (1.0 - rho);
    system.H /= variance;
    system.b /= variance;
    // A random walk about its mean over a segment has the variance density^2 * length / 6, on two axes.
    const double walk = gyroscope_noise_ * gyroscope_noise_ * kSegmentLength / 6.0;
    system.noise_information = 2.0 * walk * weights / variance;
    const double rate_variance = gyroscope_noise_ * gyroscope_noise_ / (2.0 * kRateHalfWidth);
    system.noise_information_offset = 3.0 * rate_variance * weights / variance;
    DropWhatNoiseShows(&system);
    return system;
  }

 private:
  void AddResiduals(const GyroIntegration& gyro, const RateState& state, const PoseSegment& segment,
                    std::vector<PoseResidual>* residuals) const {
    const double center = poses_[segment.Center()].time + state.time_offset;
    const Eigen::Matrix3d R_lidar_imu = state.R_imu_lidar.conjugate().toRotationMatrix();
    const Eigen::Vector3d center_rate = MeanRate(gyro, center);
    std::vector<Eigen::Quaterniond> turns;
    std::vector<Eigen::Quaterniond> centers;
    for (int k = segment.begin; k < segment.end; ++k) {
      turns.push_back(gyro.RotationBetween(center, poses_[k].time + state.time_offset));
      const Eigen::Quaterniond lidar_turn = state.R_imu_lidar.conjugate() * turns.back() * state.R_imu_lidar;
      centers.push_back(poses_[k].pose.rotation * lidar_turn.conjugate());
    }
    const Eigen::Quaterniond mean = RobustMean(centers, kSmallestAngleSigma);
    for (int k = segment.begin; k < segment.end; ++k) {
      const double time = poses_[k].time + state.time_offset;
      const Eigen::Quaterniond& turn = turns[k - segment.begin];
      const Eigen::Matrix3d turn_back = turn.conjugate().toRotationMatrix();
      const Eigen::Quaterniond lidar_turn = state.R_imu_lidar.conjugate() * turn * state.R_imu_lidar;
      PoseResidual residual;
      residual.value = Log(Eigen::Quaterniond((mean * lidar_turn).conjugate() * poses_[k].pose.rotation));
      const Eigen::Matrix3d outer = RightJacobianInverse(-residual.value);
      residual.jacobian.leftCols<3>() = R_lidar_imu * (Eigen::Matrix3d::Identity() - turn_back);
      residual.jacobian.col(3) = R_lidar_imu * (MeanRate(gyro, time) - turn_back * center_rate);
      residual.jacobian.rightCols<3>() = R_lidar_imu * gyro.BiasJacobian(center, time);
      residual.jacobian = (outer * residual.jacobian).eval();
      residual.segment_jacobian = outer * lidar_turn.conjugate().toRotationMatrix();
      residuals->push_back(residual);
    }
  }

  const std::vector<ImuSample>& imu_;
  const std::vector<TimedPose>& poses_;
  double gyroscope_noise_;
};

struct Refined {
  RateState state;
  RateSystem system;
};

// The prior's information and gradient are added to the copy of the system that is solved.
void AddPriors(const RateState& state, const std::optional<RotationGuess>& guess, RateSystem* system) {
  system->H.diagonal() += Vector7d::Constant(1e-2);  // keeps steps finite where nothing is shown
  system->H.bottomRightCorner<3, 3>().diagonal().array() += 1.0 / (kBiasPriorSigma * kBiasPriorSigma);
  system->b.tail<3>() -= state.bias / (kBiasPriorSigma * kBiasPriorSigma);
  if (!guess) return;
  const Eigen::Vector3d from_guess =
      Log(Eigen::Quaterniond(state.R_imu_lidar * guess->R_imu_lidar.conjugate()));
  const Eigen::Vector3d information = guess->sigma.array().square().inverse();
  const Eigen::Matrix3d jacobian = RightJacobianInverse(-from_guess);
  system->H.topLeftCorner<3, 3>() += jacobian.transpose() * information.asDiagonal() * jacobian;
  system->b.head<3>() -= jacobian.transpose() * information.asDiagonal() * from_guess;
}

Refined Refine(const Problem& problem, const RateState& start, const std::optional<RotationGuess>& guess) {
  constexpr int kIterations = 25;       // from: guard, ends by convergence
  constexpr int kConvexIterations = 5;  // from: guard, ends by convergence
  Refined refined;
  refined.state = start;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    RateSystem system = problem.Linearize(refined.state, iteration >= kConvexIterations);
    if (system.poses == 0) break;
    AddPriors(refined.state, guess, &system);
    Vector7d step = SolveSymmetric(system.H, system.b);
    // The linearisation holds for a part of a peak's width and of a radian.
    step *= std::min(1.0, 0.05 / std::max(std::abs(step[3]), step.head<3>().norm() / 6.0 + 1e-300));
    RateState& state = refined.state;
    state.R_imu_lidar = (ExpQuaternion(step.head<3>()) * state.R_imu_lidar).normalized();
    state.time_offset += step[3];
    state.bias += step.tail<3>();
    if (iteration > kConvexIterations && step.norm() < 1e-10) break;
  }
  refined.system = problem.Linearize(refined.state, true);
  return refined;
}

// A line through the segments' offsets, their outliers left out.
void FitDrift(const std::vector<SegmentOffset>& segments, double middle, AngularRateAlignment* result) {
  constexpr std::size_t kFewest = 5;   // from: guard, a line and some scatter
  constexpr double kFewestLeft = 3.5;  // that are no outliers; from: guard
  constexpr int kIterations = 10;      // from: guard
  if (segments.size() < kFewest) return;
  Eigen::Vector2d line = Eigen::Vector2d::Zero();  // offset at the middle, drift
  double sigma = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    double squares = 0.0, count = 0.0;
    std::vector<double> sizes;
    for (const SegmentOffset& segment : segments) {
      const Eigen::Vector2d row(1.0, segment.time - middle);
      const double off = segment.gradient / segment.information;
      const double size = std::sqrt(segment.information) * std::abs(off - row.dot(line));
      const double weight = iteration == 0 ? 1.0 : TukeyWeight(size, sigma);
      H += weight * segment.information * row * row.transpose();
      b += weight * segment.gradient * row;
      squares += weight * size * size;
      count += weight;
      sizes.push_back(size);
    }
    const Eigen::Matrix2d covariance = H.inverse();
    const double variance = covariance(1, 1);
    if (count < kFewestLeft || !(variance > 0.0)) return;
    if (iteration > 0) {
      result->clock_drift = line.y();
      result->clock_drift_sigma = std::sqrt(squares / (count - 2.0) * variance);
    }
    line = covariance * b;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const double off = segments[i].gradient / segments[i].information;
      sizes[i] = std::sqrt(segments[i].information) *
                 std::abs(off - line.x() - line.y() * (segments[i].time - middle));
    }
    constexpr double kOfMedian = 1.4826;  // from: derivation, sigma of a normal distribution
    sigma = std::max(1e-12, kOfMedian * Median(std::move(sizes)));
  }
}

void FillInformation(const Refined& refined, const std::optional<RotationGuess>& guess,
                     AngularRateAlignment* result) {
  RateSystem system = refined.system;
  Matrix7d data = system.H;
  data.diagonal().tail<4>().array() += 1e-6;
  result->rotation_information = data.topLeftCorner<3, 3>() -
                                 data.topRightCorner<3, 4>() * SolveSymmetric(data.bottomRightCorner<4, 4>(),
                                                                              data.bottomLeftCorner<4, 3>());
  const SymmetricEigen<3> eigen(result->rotation_information);
  result->information_values = eigen.eigenvalues().cwiseMax(0.0);
  result->information_directions = eigen.eigenvectors();
  for (int i = 0; i < 3; ++i) {
    if (result->information_values[i] > 1.0 / (kRotationLimit * kRotationLimit))
      ++result->rotation_directions_shown;
  }
  AddPriors(refined.state, guess, &system);
  const Matrix7d covariance = SolveSymmetric(system.H, Matrix7d::Identity());
  result->rotation_covariance = covariance.topLeftCorner<3, 3>();
  result->time_offset_sigma = std::sqrt(std::max(0.0, covariance(3, 3)));
}

}  // namespace

bool IsUsable(const AngularRateAlignment& alignment) {
  constexpr double kOffsetSigma = 0.05;  // s; from: guard, the turning tells when it was
  constexpr double kInliers = 0.3;       // of the poses; from: guard
  return alignment.valid && alignment.time_offset_sigma < kOffsetSigma && alignment.inlier_share > kInliers;
}

AngularRateAlignment AlignAngularRates(const std::vector<ImuSample>& imu, const std::vector<TimedPose>& poses,
                                       const std::optional<RotationGuess>& guess) {
  AngularRateAlignment result;
  const std::vector<TimedPose> ordered = OrderedFinitePoses(poses);
  // A vague guess would only blur the peak.
  std::optional<Eigen::Quaterniond> R_guess;
  if (guess && guess->sigma.maxCoeff() < 0.3) R_guess = guess->R_imu_lidar;
  const std::vector<CorrelationPeak> peaks =
      CorrelateAngularRates(GyroIntegration(imu), ordered, R_guess, kLargestOffset);
  if (peaks.empty()) {
    result.failure =
        "the odometry's and the IMU's angular rates have too little in common in time: fewer than 20 "
        "intervals of the odometry, or no turning at all";
    return result;
  }
  result.peak_correlation = peaks.front().correlation;
  if (peaks.size() > 1) {
    result.second_peak_ratio = peaks[1].correlation / peaks[0].correlation;
    result.second_peak_offset = peaks[1].time_offset;
  }

  const Problem problem(imu, ordered);
  std::optional<Refined> best;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, peaks.size()); ++i) {
    if (peaks[i].correlation < 0.9 * peaks[0].correlation) break;
    RateState start{peaks[i].time_offset, peaks[i].R_imu_lidar, Eigen::Vector3d::Zero()};
    if (guess && !R_guess) start.R_imu_lidar = guess->R_imu_lidar;
    const Refined refined = Refine(problem, start, guess);
    // What runs away from all peaks has found nothing.
    if (refined.system.poses == 0 || std::abs(refined.state.time_offset) > 1.5 * kLargestOffset) continue;
    if (!best || refined.system.sigma < best->system.sigma) best = refined;
  }
  if (!best) {
    result.failure =
        "no time offset up to 1 s fits the odometry to the gyroscope, or no part of it of 2 s is covered by "
        "the IMU without gaps";
    return result;
  }
  result.valid = true;
  result.time_offset = best->state.time_offset;
  result.R_imu_lidar = best->state.R_imu_lidar;
  result.gyroscope_bias = best->state.bias;
  result.residual_rms = best->system.rms;
  result.inlier_share = best->system.inlier_share;
  FillInformation(*best, guess, &result);
  FitDrift(best->system.segments, 0.5 * (ordered.front().time + ordered.back().time), &result);
  return result;
}

}  // namespace mlic
