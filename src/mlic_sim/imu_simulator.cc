#include "mlic_sim/imu_simulator.h"

#include <cmath>
#include <complex>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/random_direction.h"

namespace mlic::sim {
namespace {

constexpr int kSubsteps = 8;     // from: definition, of the filter in each sample
constexpr double kWarmUp = 0.5;  // s; from: definition, many time constants of any filter of an IMU

// The filter's answer to exp(i w t).
std::complex<double> Response(double cut_off, double angular_frequency) {
  const std::complex<double> s(0.0, angular_frequency / (2.0 * M_PI * cut_off));
  return 1.0 / (s * s + std::sqrt(2.0) * s + 1.0);
}

}  // namespace

double GroupDelay(double low_pass, double rate) {
  return low_pass > 0.0 ? std::sqrt(2.0) / (2.0 * M_PI * low_pass * rate) : 0.0;
}

ButterworthFilter::ButterworthFilter(double cut_off, double step, const Eigen::Vector3d& start)
    : before_(start) {
  // x' = A x + B u with x = (y, y'), u straight in time: exp of the augmented system by scaling and squaring.
  const double w = 2.0 * M_PI * cut_off;
  Eigen::Matrix4d system = Eigen::Matrix4d::Zero();  // y, y', u, its slope times the step
  system(0, 1) = step;
  system(1, 0) = -w * w * step;
  system(1, 1) = -std::sqrt(2.0) * w * step;
  system(1, 2) = w * w * step;
  system(2, 3) = 1.0;
  constexpr int kHalvings = 20, kTerms = 8;  // from: derivation, to rounding
  const Eigen::Matrix4d part = system / std::pow(2.0, kHalvings);
  Eigen::Matrix4d power = Eigen::Matrix4d::Identity(), exponential = power;
  for (int i = 1; i <= kTerms; ++i) {
    power = power * part / i;
    exponential += power;
  }
  for (int i = 0; i < kHalvings; ++i) exponential = exponential * exponential;
  transition_ = exponential.topLeftCorner<2, 2>();
  of_now_ = exponential.block<2, 1>(0, 3);
  of_before_ = exponential.block<2, 1>(0, 2) - of_now_;
  state_ << start.transpose(), Eigen::RowVector3d::Zero();
}

Eigen::Vector3d ButterworthFilter::Next(const Eigen::Vector3d& input) {
  state_ = transition_ * state_ + of_before_ * before_.transpose() + of_now_ * input.transpose();
  before_ = input;
  return state_.row(0).transpose();
}

ImuSimulator::ImuSimulator(const SimulatedImu& imu, bool with_noise, Random random)
    : imu_(imu),
      with_noise_(with_noise),
      random_(random),
      gyroscope_bias_(imu.calibration.gyroscope_bias),
      accelerometer_bias_(imu.calibration.accelerometer_bias) {
  Random of_lines = random.Fork(1);
  for (const VibrationLine& line : imu.vibration) {
    const Eigen::Vector3d along = RandomDirection(&of_lines), about = RandomDirection(&of_lines);
    const double force_phase = of_lines.Uniform(0.0, 2.0 * M_PI),
                 rate_phase = of_lines.Uniform(0.0, 2.0 * M_PI);
    const double w = 2.0 * M_PI * line.frequency;
    const auto response = [&](double low_pass) {
      return low_pass > 0.0 ? Response(low_pass * imu.rate, w) : std::complex<double>(1.0);
    };
    const std::complex<double> gyroscope = response(imu.gyroscope_low_pass);
    const std::complex<double> accelerometer = response(imu.accelerometer_low_pass);
    lines_.push_back({w, std::abs(gyroscope) * line.angular_velocity * about,
                      std::abs(accelerometer) * line.specific_force * along, rate_phase + std::arg(gyroscope),
                      force_phase + std::arg(accelerometer)});
  }
}

Eigen::Vector3d ImuSimulator::WhiteNoise() {
  const double x = random_.Normal(), y = random_.Normal(), z = random_.Normal();
  return {x, y, z};
}

ImuSample ImuSimulator::TrueReading(double time, const Motion& motion) const {
  const MotionState state = motion(time);
  const Eigen::Vector3d up(0.0, 0.0, imu_.gravity);
  const Eigen::Vector3d specific_force = state.T_map_imu.rotation.conjugate() * (state.acceleration + up);
  return {time, imu_.calibration.gyroscope_matrix * state.angular_velocity,
          imu_.calibration.accelerometer_matrix * specific_force};
}

void ImuSimulator::AddVibration(ImuSample* sample) const {
  for (const Line& line : lines_) {
    const double phase = line.frequency * sample->time;
    sample->angular_velocity +=
        std::sin(phase + line.gyroscope_phase) * (imu_.calibration.gyroscope_matrix * line.angular_velocity);
    sample->specific_force += std::sin(phase + line.accelerometer_phase) *
                              (imu_.calibration.accelerometer_matrix * line.specific_force);
  }
}

void ImuSimulator::StartFilters(double time, const Motion& motion) {
  const double step = 1.0 / (kSubsteps * imu_.rate);
  filtered_until_ = time - kWarmUp;
  const ImuSample start = TrueReading(filtered_until_, motion);
  if (imu_.gyroscope_low_pass > 0.0) {
    gyroscope_filter_.emplace(imu_.gyroscope_low_pass * imu_.rate, step, start.angular_velocity);
  }
  if (imu_.accelerometer_low_pass > 0.0) {
    accelerometer_filter_.emplace(imu_.accelerometer_low_pass * imu_.rate, step, start.specific_force);
  }
}

void ImuSimulator::Filter(double time, const Motion& motion, ImuSample* reading) {
  if (!gyroscope_filter_ && !accelerometer_filter_) StartFilters(time, motion);
  const double step = 1.0 / (kSubsteps * imu_.rate), per_step = with_noise_ ? 1.0 / std::sqrt(step) : 0.0;
  const int steps = static_cast<int>(std::lround((time - filtered_until_) / step));
  for (int i = 1; i <= steps; ++i) {
    const ImuSample input = TrueReading(filtered_until_ + i * step, motion);
    if (gyroscope_filter_) {
      reading->angular_velocity =
          gyroscope_filter_->Next(input.angular_velocity + imu_.noise.gyroscope * per_step * WhiteNoise());
    }
    if (accelerometer_filter_) {
      reading->specific_force = accelerometer_filter_->Next(
          input.specific_force + imu_.noise.accelerometer * per_step * WhiteNoise());
    }
  }
  filtered_until_ = time;
}

ImuSample ImuSimulator::Next(double time, const Motion& motion) {
  const bool gyroscope_filtered = imu_.gyroscope_low_pass > 0.0;
  const bool accelerometer_filtered = imu_.accelerometer_low_pass > 0.0;
  ImuSample sample = TrueReading(time, motion);
  if (gyroscope_filtered || accelerometer_filtered) Filter(time, motion, &sample);
  const double warm = -std::expm1(-std::max(0.0, time) / imu_.warm_up.time_constant);
  sample.angular_velocity += gyroscope_bias_ + warm * imu_.warm_up.gyroscope;
  sample.specific_force += accelerometer_bias_ + warm * imu_.warm_up.accelerometer;
  AddVibration(&sample);
  if (with_noise_) {
    const double per_sample = std::sqrt(imu_.rate), per_step = 1.0 / per_sample;
    if (!gyroscope_filtered) sample.angular_velocity += imu_.noise.gyroscope * per_sample * WhiteNoise();
    if (!accelerometer_filtered) {
      sample.specific_force += imu_.noise.accelerometer * per_sample * WhiteNoise();
    }
    gyroscope_bias_ += imu_.gyroscope_walk * per_step * WhiteNoise();
    accelerometer_bias_ += imu_.accelerometer_walk * per_step * WhiteNoise();
  }
  return sample;
}

}  // namespace mlic::sim
