#pragma once

#include <cmath>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/sensors/measurements.h"

namespace mlic::test {

// A sum of sines with its derivatives.
struct Sines {
  std::vector<Eigen::Vector3d> terms;  // amplitude, angular frequency (rad/s), phase
  double slope = 0.0;

  double Value(double t) const {
    double sum = slope * t;
    for (const auto& s : terms) sum += s[0] * std::sin(s[1] * t + s[2]);
    return sum;
  }
  double Derivative(double t) const {
    double sum = slope;
    for (const auto& s : terms) sum += s[0] * s[1] * std::cos(s[1] * t + s[2]);
    return sum;
  }
  double SecondDerivative(double t) const {
    double sum = 0.0;
    for (const auto& s : terms) sum -= s[0] * s[1] * s[1] * std::sin(s[1] * t + s[2]);
    return sum;
  }
};

// Analytic motion of an IMU in a map with z up: roll, pitch, yaw and position are sums of sines.
struct Motion {
  Sines rpy[3];
  Sines position[3];

  RigidTransform T_map_imu(double t) const {
    RigidTransform T;
    T.rotation = FromRollPitchYaw({rpy[0].Value(t), rpy[1].Value(t), rpy[2].Value(t)});
    T.translation = Eigen::Vector3d(position[0].Value(t), position[1].Value(t), position[2].Value(t));
    return T;
  }

  ImuSample Sample(double t) const {
    const double roll = rpy[0].Value(t), pitch = rpy[1].Value(t);
    const double d_roll = rpy[0].Derivative(t), d_pitch = rpy[1].Derivative(t), d_yaw = rpy[2].Derivative(t);
    ImuSample sample;
    sample.time = t;
    sample.angular_velocity = Eigen::Vector3d(
        d_roll - d_yaw * std::sin(pitch), d_pitch * std::cos(roll) + d_yaw * std::sin(roll) * std::cos(pitch),
        -d_pitch * std::sin(roll) + d_yaw * std::cos(roll) * std::cos(pitch));
    const Eigen::Vector3d acceleration(position[0].SecondDerivative(t), position[1].SecondDerivative(t),
                                       position[2].SecondDerivative(t));
    sample.specific_force =
        T_map_imu(t).rotation.conjugate() * (acceleration + Eigen::Vector3d(0.0, 0.0, 9.81));
    return sample;
  }
};

// A hand-held sweep: all axes, up to about 2 rad/s.
inline Motion HandHeld() {
  Motion m;
  m.rpy[0].terms = {{0.35, 2.1, 0.3}, {0.12, 5.3, 1.0}};
  m.rpy[1].terms = {{0.30, 1.7, 1.1}, {0.10, 6.1, 0.2}};
  m.rpy[2].terms = {{0.80, 1.3, 0.0}, {0.15, 4.3, 2.0}, {0.9, 0.23, 0.0}};
  m.position[0].terms = {{0.6, 1.1, 0.0}, {0.15, 4.7, 0.7}, {3.0, 0.2, 0.0}};
  m.position[1].terms = {{0.5, 1.4, 0.9}, {0.12, 5.1, 0.1}};
  m.position[2].terms = {{0.2, 1.9, 0.4}, {0.06, 5.7, 1.9}};
  return m;
}

// A car on a perfect plane that weaves and speeds up and down.
inline Motion Planar() {
  Motion m;
  m.rpy[2].terms = {{1.2, 0.37, 0.0}, {0.25, 0.9, 0.4}, {0.1, 1.7, 1.3}};
  m.position[0].terms = {{12.0, 0.31, 0.0}, {0.8, 0.83, 0.2}};
  m.position[1].terms = {{8.0, 0.41, 0.7}, {0.5, 1.1, 1.2}};
  return m;
}

struct Rig {
  RigidTransform T_imu_lidar{FromRollPitchYaw({0.4, -0.7, 2.1}), Eigen::Vector3d(0.25, -0.4, 0.6)};
  double time_offset = 0.0;
  Eigen::Vector3d gyroscope_bias = Eigen::Vector3d(0.004, -0.006, 0.003);
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d(0.05, -0.04, 0.03);
};

struct Noise {
  double gyroscope = 0.0;  // densities
  double accelerometer = 0.0;
  double position = 0.0;     // of LiDAR poses, m
  double orientation = 0.0;  // rad
};

struct Recording {
  std::vector<ImuSample> imu;
  std::vector<TimedPose> poses;  // in an odometry frame that is the map turned and moved
  Eigen::Vector3d gravity;       // in the odometry frame
};

inline Eigen::Vector3d NormalVector(Random* random) {
  const double x = random->Normal(), y = random->Normal();
  return {x, y, random->Normal()};
}

inline Recording Record(const Motion& motion, const Rig& rig, const Noise& noise, double rate,
                        double duration, std::uint64_t seed) {
  Recording recording;
  Random random(seed);
  const double root_rate = std::sqrt(rate);
  const int samples = static_cast<int>(duration * rate);
  for (int i = 0; i <= samples; ++i) {
    ImuSample sample = motion.Sample(i / rate);
    sample.angular_velocity += rig.gyroscope_bias + noise.gyroscope * root_rate * NormalVector(&random);
    sample.specific_force += rig.accelerometer_bias + noise.accelerometer * root_rate * NormalVector(&random);
    recording.imu.push_back(sample);
  }
  const RigidTransform T_odom_map{FromRollPitchYaw({0.2, 0.1, -0.9}), Eigen::Vector3d(3.0, -2.0, 1.0)};
  recording.gravity = T_odom_map.rotation * Eigen::Vector3d(0.0, 0.0, -9.81);
  // The LiDAR records for the same duration on its own clock, so that with an offset the overlap is partial.
  for (double time = 0.0137; time < duration; time += 0.1) {
    TimedPose pose;
    pose.time = time;
    pose.pose = T_odom_map * motion.T_map_imu(time + rig.time_offset) * rig.T_imu_lidar;
    pose.pose.translation += noise.position * NormalVector(&random);
    pose.pose.rotation = pose.pose.rotation * ExpQuaternion(noise.orientation * NormalVector(&random));
    recording.poses.push_back(pose);
  }
  return recording;
}

// Gross errors in a share of the poses: up to 30 deg and 1 m.
inline void AddOutliers(double share, std::uint64_t seed, std::vector<TimedPose>* poses) {
  Random random(seed);
  for (TimedPose& pose : *poses) {
    if (random.Uniform() >= share) continue;
    pose.pose.rotation = pose.pose.rotation * ExpQuaternion(0.3 * NormalVector(&random));
    pose.pose.translation += 0.6 * NormalVector(&random);
  }
}

}  // namespace mlic::test
