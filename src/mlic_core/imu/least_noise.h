#pragma once

namespace mlic {

// Densities that no IMU on a vehicle undercuts (navigation grade: 1e-6 rad/s/sqrt(Hz), 1e-5 m/s^2/sqrt(Hz)).
// Exact or filtered data would give the IMU such weight that the joint solve runs out of digits, and rounding
// would look like vibration. from: standard, data sheets; twice the navigation grade
constexpr double kBestGyroscope = 2e-6;      // from: standard, as above
constexpr double kBestAccelerometer = 2e-5;  // from: standard, as above

// Density that hardly any gyroscope on a vehicle exceeds. rad/s/sqrt(Hz). from: standard, data sheets; 0.01
// deg/s/sqrt(Hz) is usual of consumer grade, 0.05 the worst
constexpr double kWorstGyroscope = 1e-3;

}  // namespace mlic
