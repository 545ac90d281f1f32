#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_sim/ground.h"

namespace mlic::sim {

// How the rig is moved. Cars drive in the yard, with x of the body forward, y left, z up and the body's
// origin on the ground; the hand-held rig is carried through the hall.
enum class Scenario {
  kFigureEight,     // a car, with suspension roll and pitch, on slightly uneven ground
  kHandheld,        // all axes excited
  kTiltedHandheld,  // the same, tilted by up to 60 deg besides: what an IMU's matrices need
  kStraight,        // constant velocity
  kStatic,          // parked
  kPlanar,          // figure-eight without any roll, pitch or heave, on perfectly flat ground
  kCircle,          // constant rate, without any roll, pitch or heave
  kWeaving          // along the straight drive's lane, by 0.3 to 1 m to either side, on perfectly flat ground
};

// Whether the scenario takes place in the hall unless another world is asked for; the others do in the yard.
bool IsCarriedByHand(Scenario scenario);
// Whether the scenario's ground is perfectly flat.
bool IsOnFlatGround(Scenario scenario);

// Throws InputError for an unknown name.
Scenario ScenarioFromName(const std::string& name);
std::string ScenarioName(Scenario scenario);

// The IMU's true motion at one instant of the IMU clock. Map frame: the world's own, z up.
struct MotionState {
  RigidTransform T_map_imu;
  Eigen::Vector3d velocity;          // map frame, m/s
  Eigen::Vector3d acceleration;      // map frame, m/s^2
  Eigen::Vector3d angular_velocity;  // IMU frame, rad/s
};

// An analytic trajectory of the IMU, defined at all times. Thread-safe.
class Trajectory {
 public:
  virtual ~Trajectory() = default;
  virtual RigidTransform PoseAt(double time) const = 0;
  virtual MotionState StateAt(double time) const = 0;
};

// Phases, frequencies and amplitudes follow from the seed. duration (s) matters for the straight and the
// weaving drive only, which have to stay inside the yard. T_body_imu mounts the IMU on the vehicle; in the
// hand-held scenarios the trajectory is the IMU's own, and only the rotation of T_body_imu counts. Of the
// cars only that of the figure-eight follows the ground's terrain.
std::unique_ptr<Trajectory> MakeTrajectory(Scenario scenario, std::uint64_t seed, double duration,
                                           const RigidTransform& T_body_imu, const MotionGround& ground = {});

}  // namespace mlic::sim
