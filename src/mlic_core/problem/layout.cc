#include "mlic_core/problem/layout.h"

#include <algorithm>

#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

// Merges both knot sequences by time.
void OrderByTime(const SplitSpline& trajectory, int* next, Layout::DriveKnots* knots) {
  const UniformKnots& rotation = trajectory.rotation.knots();
  const UniformKnots& position = trajectory.position.knots();
  int r = 0, p = 0;
  while (r < rotation.count || p < position.count) {
    const bool take_rotation =
        p == position.count ||
        (r < rotation.count && rotation.ControlPointTime(r) <= position.ControlPointTime(p));
    (take_rotation ? knots->rotation : knots->position).push_back(*next);
    *next += 3;
    ++(take_rotation ? r : p);
  }
}

// The widest set of control points that one measurement touches.
int Bandwidth(const SplitSpline& trajectory, const Layout::DriveKnots& knots) {
  const UniformKnots& rotation = trajectory.rotation.knots();
  const UniformKnots& position = trajectory.position.knots();
  const double step = 0.25 * std::min(rotation.spacing, position.spacing);
  int widest = 0;
  for (double t = trajectory.Start(); t <= trajectory.End() + step; t += step) {
    const int r = SplineBasis(rotation, t).first;
    const int p = SplineBasis(position, t).first;
    const int low = std::min(knots.rotation[r], knots.position[p]);
    const int high = std::max(knots.rotation[r + 3], knots.position[p + 3]) + 2;
    widest = std::max(widest, high - low);
  }
  // Between two samples of this scan a segment of either may begin: one more control point of each.
  return widest + 6;
}

// drift: the step of the clock's drift.
void Move(const Eigen::Matrix<double, 7, 1>& step, double drift, SensorCalibration* sensor) {
  RigidTransform& T = sensor->T_imu_sensor;
  T.rotation = (ExpQuaternion(step.head<3>()) * T.rotation).normalized();
  T.translation += step.segment<3>(3);
  sensor->time_offset += step[6];
  if (sensor->clock_drift) *sensor->clock_drift += drift;
}

}  // namespace

Layout::Layout(const CalibrationState& state, bool with_imu_matrices) {
  for (const DriveState& drive : state.drives) {
    DriveKnots indices;
    OrderByTime(drive.trajectory, &knots, &indices);
    bandwidth = std::max(bandwidth, Bandwidth(drive.trajectory, indices));
    drives.push_back(std::move(indices));
  }
  order = state.Sensors();
  calibration = poses = Sensor(order.size());
  for (const CameraCalibration& camera : state.cameras) {
    readout.push_back(camera.rolling_shutter ? calibration++ : -1);
    intrinsics.push_back(calibration);
    calibration += ParameterCount(camera.intrinsics.model);
  }
  for (std::size_t s = 0; s < order.size(); ++s) {
    drift.push_back(state.Sensor(order.At(s)).clock_drift ? calibration++ : -1);
  }
  gravity = calibration++;
  lag = calibration++;
  alignment = calibration;
  calibration += 3;
  if (with_imu_matrices) {
    matrices = calibration;
    calibration += kOfMatrices;
  }
  for (const DriveState& drive : state.drives) {
    bias.push_back(calibration);
    calibration += kOfBias * static_cast<int>(drive.bias.knots.size());
  }
}

void Layout::Update(const Eigen::VectorXd& delta, CalibrationState* state) const {
  for (std::size_t d = 0; d < drives.size(); ++d) {
    state->drives[d].trajectory.rotation.Update(delta, drives[d].rotation);
    state->drives[d].trajectory.position.Update(delta, drives[d].position);
    std::vector<BiasCourse::Bias>& biases = state->drives[d].bias.knots;
    for (std::size_t k = 0; k < biases.size(); ++k) {
      biases[k] += delta.segment<kOfBias>(knots + Bias(d, static_cast<int>(k)));
    }
  }
  const auto drift_step = [&](SensorId sensor) {
    return Drift(sensor) >= 0 ? delta[knots + Drift(sensor)] : 0.0;
  };
  for (std::size_t i = 0; i < state->lidars.size(); ++i) {
    Move(delta.segment<7>(knots + Lidar(i)), drift_step(LidarId(i)), &state->lidars[i]);
  }
  for (std::size_t c = 0; c < state->cameras.size(); ++c) {
    CameraCalibration& camera = state->cameras[c];
    Move(delta.segment<7>(knots + Camera(c)), drift_step(CameraId(c)), &camera.sensor);
    if (Readout(c) >= 0) camera.readout += delta[knots + Readout(c)];
    for (std::size_t i = 0; i < camera.intrinsics.parameters.size(); ++i) {
      camera.intrinsics.parameters[i] += delta[knots + Intrinsics(c) + static_cast<int>(i)];
    }
  }
  state->gravity += delta[knots + gravity];
  state->accelerometer_lag += delta[knots + lag];
  const Eigen::Vector3d turn = delta.segment<3>(knots + alignment);
  const Eigen::Vector3d of_gyroscope = state->accelerometer_axes * turn;
  state->accelerometer_matrix = ExpMatrix(turn - of_gyroscope) * state->accelerometer_matrix;
  state->gyroscope_matrix *= ExpMatrix(-of_gyroscope);
  if (matrices < 0) return;
  const auto deformed = [&](int first) {
    Eigen::Matrix3d triangle = Eigen::Matrix3d::Identity();
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) triangle(r, c) += delta[first++];
    }
    return triangle;
  };
  state->accelerometer_matrix *= deformed(knots + matrices);
  state->gyroscope_matrix = Eigen::Matrix3d(deformed(knots + matrices + 6) * state->gyroscope_matrix);
}

}  // namespace mlic
