#include "mlic_core/inspection/forecast.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/imu/excitation.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/inspection/excitation_findings.h"
#include "mlic_core/inspection/low_pass.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

constexpr double kShortest = 2.0;  // s; from: guard
constexpr double kUnknown =
    10.0;  // rad, m, s: sigma of what nothing shows; from: guard, far above the limits

constexpr double kHeld =
    1e-6;  // rad, m/s^2: sigma of what is not estimated; from: guard, far below all others

constexpr double kUsualRate = 10.0;  // Hz, of poses in texts; from: structural

// Columns: phi, p, tau, b_w, b_a, gamma (about gravity it does nothing), g, alpha.
constexpr int kPhi = 0, kLever = 3, kOffset = 6, kGyroBias = 7, kForceBias = 10, kTilt = 13, kGravity = 16,
              kAlignment = 17;  // from: structural
constexpr int kColumns = 20;    // from: structural

using Rows = Eigen::Matrix<double, 3, kColumns>;
using Information = Eigen::Matrix<double, kColumns, kColumns>;

// The motion itself: knots of the trajectory are 50 to 150 ms apart and follow no more.
constexpr double kMotionBandwidth = 5.0;  // Hz; from: derivation, half a knot's rate of 100 ms

// Samples of the motion without what is above its bandwidth, which would drown in the derivatives.
std::vector<ImuSample> Smoothed(std::vector<ImuSample> samples, double rate) {
  SecondOrderLowPass<3, 2> filter(std::min(kMotionBandwidth, 0.4 * rate), rate);
  for (ImuSample& sample : samples) {
    Eigen::Matrix<double, 3, 2> reading;
    reading << sample.angular_velocity, sample.specific_force;
    reading = filter.Next(reading);
    sample.angular_velocity = reading.col(0);
    sample.specific_force = reading.col(1);
  }
  return samples;
}

// Every second sample, so that the two halves share the motion and not the noise: the products of one half's
// Jacobian with the other's hold no information that is only noise.
std::vector<ImuSample> Half(const std::vector<ImuSample>& samples, std::size_t first) {
  std::vector<ImuSample> half;
  for (std::size_t i = first; i < samples.size(); i += 2) half.push_back(samples[i]);
  return half;
}

// Densities of the IMU's noise and of the poses' along axes on which the poses' noise is independent.
struct AxisNoise {
  Eigen::Matrix3d axes;  // columns, in the IMU's frame
  Eigen::Vector3d imu, pose;

  AxisNoise(const Eigen::Vector3d& imu_sigma, const Eigen::Matrix3d& pose_covariance) {
    const SymmetricEigen<3> eigen(pose_covariance);
    axes = eigen.eigenvectors();
    pose = eigen.eigenvalues().cwiseMax(1e-30).cwiseSqrt();
    imu = (axes.cwiseAbs2().transpose() * imu_sigma.cwiseAbs2()).cwiseSqrt();
  }
};

// Whitens the rows of one sensor of the IMU; the cutoffs are where the poses' noise, differentiated, is the
// IMU's.
template <typename LowPass>
class Whitening {
 public:
  // cutoffs: rad/s, along the axes of the noise.
  Whitening(const AxisNoise& noise, const Eigen::Vector3d& cutoffs, double rate) : noise_(noise) {
    for (const double cutoff : cutoffs) {
      filters_.emplace_back(std::min(0.4 * rate, cutoff / (2.0 * M_PI)), rate);
    }
  }

  Rows Next(const Rows& rows) {
    Rows whitened = noise_.axes.transpose() * rows;
    for (int i = 0; i < 3; ++i) whitened.row(i) = filters_[i].Next(whitened.row(i)) / noise_.imu[i];
    return whitened;
  }

 private:
  AxisNoise noise_;
  std::vector<LowPass> filters_;
};

// What the samples are whitened with.
struct NoiseDensities {
  AxisNoise rotation, position;
};

// Whitened Jacobians of one half, sample by sample.
class JacobianStream {
 public:
  JacobianStream(std::vector<ImuSample> samples, const Eigen::Vector3d& bias, const NoiseDensities& noise,
                 double rate)
      : samples_(Smoothed(std::move(samples), rate)),
        bias_(bias),
        gyro_(noise.rotation, noise.rotation.imu.cwiseQuotient(noise.rotation.pose), rate),
        force_(noise.position, noise.position.imu.cwiseQuotient(noise.position.pose).cwiseSqrt(), rate) {
    // Accelerations are zero in the mean, in the map's axes.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 1; i < samples_.size(); ++i) {
      Turn(i);
      sum += attitude_ * samples_[i].specific_force;
    }
    up_ = sum.normalized();
    attitude_.setIdentity();
  }

  std::size_t Count() const { return samples_.size() - 1; }

  // The rows of gyroscope and accelerometer at sample i, in order from 1.
  void Next(std::size_t i, Rows* gyro, Rows* force) {
    const ImuSample &before = samples_[i - 1], &now = samples_[i];
    const double step = now.time - before.time;
    const Eigen::Vector3d w = now.angular_velocity - bias_, a = now.specific_force;
    const Eigen::Vector3d w_dot = (now.angular_velocity - before.angular_velocity) / step;
    const Eigen::Vector3d a_dot = (now.specific_force - before.specific_force) / step;
    Turn(i);
    Rows rates = Rows::Zero(), forces = Rows::Zero();
    rates.middleCols<3>(kPhi) = -Hat(w);
    rates.col(kOffset) = w_dot;
    rates.middleCols<3>(kGyroBias).setIdentity();
    forces.middleCols<3>(kPhi) = -Hat(a);
    forces.middleCols<3>(kLever) = -(Hat(w_dot) + Hat(w) * Hat(w));
    forces.col(kOffset) = a_dot;
    forces.middleCols<3>(kForceBias).setIdentity();
    forces.middleCols<3>(kTilt) = kStandardGravity * attitude_.conjugate().toRotationMatrix() * Hat(up_);
    forces.col(kGravity) = attitude_.conjugate() * up_;
    forces.middleCols<3>(kAlignment) = -Hat(a);
    *gyro = gyro_.Next(rates);
    *force = force_.Next(forces);
  }

 private:
  // The attitude to that of sample i, from that of the one before.
  void Turn(std::size_t i) {
    const double step = samples_[i].time - samples_[i - 1].time;
    attitude_ = (attitude_ * ExpQuaternion((samples_[i].angular_velocity - bias_) * step)).normalized();
  }

  std::vector<ImuSample> samples_;
  Eigen::Vector3d bias_, up_ = Eigen::Vector3d::UnitZ();
  Eigen::Quaterniond attitude_ = Eigen::Quaterniond::Identity();
  Whitening<FirstOrderLowPass<1, kColumns>> gyro_;
  Whitening<SecondOrderLowPass<1, kColumns>> force_;
};

// What of a half's own information is motion and not noise. Where own is K and the noise in it, own less
// shared, is N, the generalised eigenvectors K v = lambda N v say by how much each direction exceeds its
// noise: of those that do not, beyond the scatter of `independent` values, nothing stays. Columns are scaled
// to the same information.
Information WithoutNoise(const Information& shared, const Information& own, double independent) {
  constexpr double kScatters = 4.0;  // sigmas; from: derivation, none of 20 directions exceeds it by chance
  constexpr double kFloor = 1e-8;    // of the information; from: guard, rounding
  const Eigen::Matrix<double, kColumns, 1> scale = own.diagonal().cwiseMax(1e-30).cwiseSqrt();
  const auto inverse = scale.cwiseInverse().asDiagonal();
  const SymmetricEigen<Eigen::Dynamic> spectrum(Information(inverse * (own - shared) * inverse));
  const Information noise = spectrum.eigenvectors() *
                            (spectrum.eigenvalues().cwiseMax(0.0).array() + kFloor).matrix().asDiagonal() *
                            spectrum.eigenvectors().transpose();
  const Information root = noise.llt().matrixL();
  const Information half = root.triangularView<Eigen::Lower>().solve(Information(inverse * own * inverse));
  const Information whitened = root.triangularView<Eigen::Lower>().solve(Information(half.transpose()));
  const SymmetricEigen<Eigen::Dynamic> eigen(whitened);
  const double least = 1.0 + kScatters / std::sqrt(independent);
  Eigen::Matrix<double, kColumns, 1> values = eigen.eigenvalues();
  for (int i = 0; i < kColumns; ++i) values[i] = values[i] < least ? 0.0 : values[i] - 1.0;
  const Information back = scale.asDiagonal() * root * eigen.eigenvectors();
  return back * values.asDiagonal() * back.transpose();
}

// Of both halves together.
Information InformationOf(JacobianStream first, JacobianStream second, double rate) {
  Information shared = Information::Zero(), own = Information::Zero();
  const std::size_t count = std::min(first.Count(), second.Count());
  Rows gyro[2], force[2];
  for (std::size_t i = 1; i <= count; ++i) {
    first.Next(i, &gyro[0], &force[0]);
    second.Next(i, &gyro[1], &force[1]);
    shared += gyro[0].transpose() * gyro[1] + force[0].transpose() * force[1];
    own += 0.5 * (gyro[0].transpose() * gyro[0] + gyro[1].transpose() * gyro[1]);
    own += 0.5 * (force[0].transpose() * force[0] + force[1].transpose() * force[1]);
  }
  const double seconds = static_cast<double>(count) / rate;
  const double independent = std::max(1.0, 2.0 * std::min(kMotionBandwidth, 0.5 * rate) * seconds);
  return WithoutNoise(0.5 * (shared + shared.transpose()), own, independent) / rate;
}

Information InverseOf(const Information& information) {
  const SymmetricEigen<Eigen::Dynamic> eigen(information);
  Information known = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                      eigen.eigenvectors().transpose();
  known.diagonal().array() += 1.0 / (kUnknown * kUnknown);
  return SolveSymmetric(known, Information::Identity());
}

// With gravity's magnitude and the accelerometer's rotation as free as in the calibration: the latter has its
// prior along directions that the data do not show better (ReviewAlignment in uncertainty/imu_alignment.h).
Information WithPriors(Information information, const ImuConfig& imu) {
  constexpr double kWellBelow = 1.0 / 3.0;  // of the prior; from: definition, as there
  const double gravity_sigma = imu.gravity ? kHeld : kGravitySigma;
  information(kGravity, kGravity) += 1.0 / (gravity_sigma * gravity_sigma);
  const SymmetricEigen<3> eigen(Eigen::Matrix3d(InverseOf(information).block<3, 3>(kAlignment, kAlignment)));
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    if (eigen.eigenvalues()[i] < std::pow(kWellBelow * imu.alignment_sigma, 2)) continue;
    information.block<3, 3>(kAlignment, kAlignment) +=
        axis * axis.transpose() / (imu.alignment_sigma * imu.alignment_sigma);
  }
  return information;
}

// With phi the rotation to the axes that the calibration gives it to, also as there: about directions about
// which the rotation to the accelerometer, phi + alpha, has the smaller sigma, that one.
Information ToTheImusAxes(const Information& information) {
  const Information covariance = InverseOf(information);
  const Eigen::Matrix3d common = covariance.block<3, 3>(kPhi, kAlignment);
  const SymmetricEigen<3> gain(
      Eigen::Matrix3d(-common - common.transpose() - covariance.block<3, 3>(kAlignment, kAlignment)));
  Information to_axes = Information::Identity();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = gain.eigenvectors().col(i);
    if (gain.eigenvalues()[i] > 0.0) to_axes.block<3, 3>(kPhi, kAlignment) -= axis * axis.transpose();
  }
  return to_axes.transpose() * information * to_axes;
}

struct Quantity {
  const char* name;
  int column;
  double limit;
  double guess_sigma;
};

// Directions that the data do not show, worst first. Along them a guess of guess_sigma is added.
void FindUnseen(const Information& covariance, const Quantity& quantity, Information* information,
                std::vector<UnseenDirection>* unseen) {
  const SymmetricEigen<3> eigen(Eigen::Matrix3d(covariance.block<3, 3>(quantity.column, quantity.column)));
  for (int i = 2; i >= 0; --i) {
    const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[i]));
    if (sigma <= quantity.limit) continue;
    Eigen::Vector3d direction = eigen.eigenvectors().col(i);
    int largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    if (direction[largest] < 0.0) direction = -direction;
    unseen->push_back({quantity.name, direction, sigma});
    information->block<3, 3>(quantity.column, quantity.column) +=
        direction * direction.transpose() / (quantity.guess_sigma * quantity.guess_sigma);
  }
}

std::string TripleText(const Eigen::Vector3d& v, const char* format) {
  return Number(v.x(), format) + ", " + Number(v.y(), format) + ", " + Number(v.z(), format);
}

std::string UnseenText(const UnseenDirection& direction) {
  if (direction.quantity == "time_offset") return "time offset";
  return direction.quantity + " along (" + TripleText(direction.direction, "%.2f") + ") of the IMU";
}

// What the forecast rests on, and where it is from.
Finding NoiseFinding(const ObservabilityForecast& forecast) {
  const PoseNoise& poses = forecast.pose_noise;
  const Eigen::Vector3d angles = (kUsualRate * poses.rotation.diagonal()).cwiseSqrt() * kDegreesPerRadian;
  const Eigen::Vector3d shifts = (kUsualRate * poses.position.diagonal()).cwiseSqrt() * 1e3;
  return {Grade::kPass,
          "forecast",
          "noise",
          "gyroscope " + Number(forecast.imu_noise.gyroscope, "%.2g") + " rad/s/sqrt(Hz), accelerometer " +
              Number(forecast.imu_noise.accelerometer, "%.2g") +
              " m/s^2/sqrt(Hz), the larger of rig file and samples; poses at 10 Hz " +
              TripleText(angles, "%.2g") + " deg and " + TripleText(shifts, "%.2g") + " mm, " +
              (poses.measured ? "by the points of the LiDARs on planes" : "those of a typical rig"),
          "",
          ""};
}

Finding ShownFinding(const ObservabilityForecast& forecast, const std::string& quantity,
                     const std::string& measured, const std::string& limit) {
  Finding finding{Grade::kPass, "forecast", quantity, measured, limit, ""};
  std::vector<std::string> unseen;
  for (const UnseenDirection& direction : forecast.unseen) {
    if (direction.quantity == quantity) unseen.push_back(UnseenText(direction));
  }
  if (!unseen.empty()) finding.grade = Grade::kWarn;
  if (unseen.size() == 3) unseen = {quantity + ", in any direction"};
  for (const std::string& text : unseen) finding.measured += "; not shown: " + text;
  finding.remedy = quantity == "translation"
                       ? "turn about more axes; measure that direction and give T_imu_sensor"
                       : "turn more, about more axes, with changes of rate";
  return finding;
}

// Each sensor that has nothing to stand in for what the motion leaves open.
template <typename Config>
void AddSensor(const ObservabilityForecast& forecast, const Config& sensor, Findings* findings) {
  if (sensor.fixed) return;
  for (const UnseenDirection& direction : forecast.unseen) {
    const bool of_time = direction.quantity == "time_offset";
    if (of_time ? sensor.time_offset.has_value() : sensor.guess.has_value()) continue;
    findings->push_back(
        {Grade::kFail, sensor.name, "link to the IMU",
         UnseenText(direction) + " is not shown, and the rig file gives no " +
             (of_time ? "time_offset" : "T_imu_sensor"),
         "shown or given",
         of_time ? "turn with changes of rate, or give time_offset"
                 : "turn about more axes, or give T_imu_sensor (10 cm and 5 deg are good enough)"});
    return;
  }
}

}  // namespace

std::optional<ObservabilityForecast> ForecastObservability(const std::vector<ImuSample>& samples,
                                                           const ImuConfig& imu, const PoseNoise& poses) {
  if (samples.size() < 20 || samples.back().time - samples.front().time < kShortest) return std::nullopt;
  const double rate = ImuRate(samples);
  // Vibration counts as noise, whatever the data sheet says.
  ImuSigma sigma = SampleSigma(samples, imu.noise);
  const ImuSigma measured = SampleSigma(samples, std::nullopt);
  sigma.gyroscope = sigma.gyroscope.cwiseMax(measured.gyroscope) / std::sqrt(rate);
  sigma.accelerometer = sigma.accelerometer.cwiseMax(measured.accelerometer) / std::sqrt(rate);
  const Eigen::Vector3d bias = RoughGyroscopeBias(samples);
  const NoiseDensities noise{{sigma.gyroscope, poses.rotation}, {sigma.accelerometer, poses.position}};
  const Information information =
      InformationOf(JacobianStream(Half(samples, 0), bias, noise, 0.5 * rate),
                    JacobianStream(Half(samples, 1), bias, noise, 0.5 * rate), 0.5 * rate);
  Information known = ToTheImusAxes(WithPriors(information, imu));
  const Information from_data = InverseOf(known);
  const ExtrinsicGuess guess;
  ObservabilityForecast forecast;
  forecast.imu_noise = {sigma.gyroscope.maxCoeff(), sigma.accelerometer.maxCoeff()};
  forecast.pose_noise = poses;
  FindUnseen(from_data, {"rotation", kPhi, kRotationLimit, guess.sigma_rotation.x()}, &known,
             &forecast.unseen);
  FindUnseen(from_data, {"translation", kLever, kTranslationLimit, guess.sigma_translation.x()}, &known,
             &forecast.unseen);
  const Information covariance = InverseOf(known);
  forecast.rotation_sigma = covariance.diagonal().segment<3>(kPhi).cwiseSqrt();
  forecast.translation_sigma = covariance.diagonal().segment<3>(kLever).cwiseSqrt();
  forecast.time_offset_sigma = std::sqrt(covariance(kOffset, kOffset));
  if (forecast.time_offset_sigma > kTimeLimit) {
    forecast.unseen.push_back({"time_offset", Eigen::Vector3d::Zero(), forecast.time_offset_sigma});
  }
  return forecast;
}

Findings ForecastFindings(const ObservabilityForecast& forecast, const Rig& rig) {
  Findings findings{NoiseFinding(forecast)};
  findings.push_back(ShownFinding(forecast, "rotation",
                                  "sigma " + TripleText(forecast.rotation_sigma * kDegreesPerRadian, "%.2g") +
                                      " deg about the IMU's axes",
                                  "0.5 deg"));
  findings.push_back(ShownFinding(
      forecast, "translation",
      "sigma " + TripleText(forecast.translation_sigma * 1e3, "%.2g") + " mm along the IMU's axes", "50 mm"));
  findings.push_back(ShownFinding(
      forecast, "time_offset", "sigma " + Number(forecast.time_offset_sigma * 1e3, "%.2g") + " ms", "5 ms"));
  for (const LidarConfig& lidar : rig.lidars) AddSensor(forecast, lidar, &findings);
  for (const CameraConfig& camera : rig.cameras) AddSensor(forecast, camera, &findings);
  return findings;
}

}  // namespace mlic
