#include "mlic_sim/trajectory.h"

#include <cmath>
#include <utility>

#include "mlic_core/common/error.h"
#include "mlic_core/common/random.h"
#include "mlic_sim/motions.h"

namespace mlic::sim {
namespace {

// Rotation matrix Rz(yaw) Ry(pitch) Rx(roll), row by row.
template <typename Scalar>
void RotationOf(const BodyPose<Scalar>& body, Scalar R[3][3]) {
  using std::cos;
  using std::sin;
  const Scalar sr = sin(body.roll), cr = cos(body.roll);
  const Scalar sp = sin(body.pitch), cp = cos(body.pitch);
  const Scalar sy = sin(body.yaw), cy = cos(body.yaw);
  R[0][0] = cy * cp, R[0][1] = cy * sp * sr - sy * cr, R[0][2] = cy * sp * cr + sy * sr;
  R[1][0] = sy * cp, R[1][1] = sy * sp * sr + cy * cr, R[1][2] = sy * sp * cr - cy * sr;
  R[2][0] = -sp, R[2][1] = cp * sr, R[2][2] = cp * cr;
}

template <typename Motion>
class AnalyticTrajectory : public Trajectory {
 public:
  AnalyticTrajectory(Motion motion, const RigidTransform& T_body_imu)
      : motion_(std::move(motion)),
        lever_(T_body_imu.translation),
        R_body_imu_(T_body_imu.rotation.toRotationMatrix()) {}

  RigidTransform PoseAt(double time) const override {
    const BodyPose<double> body = motion_.At(time);
    double R[3][3];
    RotationOf(body, R);
    Eigen::Matrix3d R_map_body;
    R_map_body << R[0][0], R[0][1], R[0][2], R[1][0], R[1][1], R[1][2], R[2][0], R[2][1], R[2][2];
    return {Eigen::Quaterniond(Eigen::Matrix3d(R_map_body * R_body_imu_)).normalized(),
            Eigen::Vector3d(body.x, body.y, body.z) + R_map_body * lever_};
  }

  MotionState StateAt(double time) const override {
    const BodyPose<Taylor> body = motion_.At(Taylor::Time(time));
    Taylor R[3][3];
    RotationOf(body, R);
    Eigen::Matrix3d value, first, second;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        value(i, j) = R[i][j].value, first(i, j) = R[i][j].first, second(i, j) = R[i][j].second;
      }
    }
    MotionState state;
    state.T_map_imu = PoseAt(time);
    state.velocity = Eigen::Vector3d(body.x.first, body.y.first, body.z.first) + first * lever_;
    state.acceleration = Eigen::Vector3d(body.x.second, body.y.second, body.z.second) + second * lever_;
    const Eigen::Matrix3d rate =
        value.transpose() * first;  // cross-product matrix of the body's angular velocity
    state.angular_velocity = R_body_imu_.transpose() * Eigen::Vector3d(rate(2, 1), rate(0, 2), rate(1, 0));
    return state;
  }

 private:
  Motion motion_;
  Eigen::Vector3d lever_;
  Eigen::Matrix3d R_body_imu_;
};

template <typename Motion>
std::unique_ptr<Trajectory> Make(Motion motion, const RigidTransform& T_body_imu) {
  return std::make_unique<AnalyticTrajectory<Motion>>(std::move(motion), T_body_imu);
}

constexpr std::pair<Scenario, const char*> kScenarios[] = {{Scenario::kFigureEight, "figure_eight"},
                                                           {Scenario::kHandheld, "handheld"},
                                                           {Scenario::kTiltedHandheld, "handheld_tilted"},
                                                           {Scenario::kStraight, "straight"},
                                                           {Scenario::kStatic, "static"},
                                                           {Scenario::kPlanar, "planar"},
                                                           {Scenario::kCircle, "circle"},
                                                           {Scenario::kWeaving, "weaving"}};

}  // namespace

Scenario ScenarioFromName(const std::string& name) {
  std::string known;
  for (const auto& [scenario, scenario_name] : kScenarios) {
    if (name == scenario_name) return scenario;
    known += (known.empty() ? "" : ", ") + std::string(scenario_name);
  }
  throw InputError("unknown scenario '" + name + "': expected one of " + known);
}

bool IsCarriedByHand(Scenario scenario) {
  return scenario == Scenario::kHandheld || scenario == Scenario::kTiltedHandheld;
}

bool IsOnFlatGround(Scenario scenario) {
  return scenario == Scenario::kPlanar || scenario == Scenario::kCircle || scenario == Scenario::kWeaving;
}

std::string ScenarioName(Scenario scenario) {
  for (const auto& [known, name] : kScenarios) {
    if (known == scenario) return name;
  }
  throw InternalError("scenario without a name");
}

std::unique_ptr<Trajectory> MakeTrajectory(Scenario scenario, std::uint64_t seed, double duration,
                                           const RigidTransform& T_body_imu, const MotionGround& ground) {
  const std::uint64_t own_seed = Random(seed).Fork(1).Next();
  switch (scenario) {
    case Scenario::kFigureEight:
      return Make(FigureEight(own_seed, true, ground.terrain), T_body_imu);
    case Scenario::kPlanar:
      return Make(FigureEight(own_seed, false, Terrain()), T_body_imu);
    case Scenario::kHandheld:
    case Scenario::kTiltedHandheld:
      return Make(Handheld(own_seed, scenario == Scenario::kTiltedHandheld, ground),
                  {T_body_imu.rotation, Eigen::Vector3d::Zero()});
    case Scenario::kStraight:
      return Make(Straight(duration), T_body_imu);
    case Scenario::kStatic:
      return Make(Parked(own_seed), T_body_imu);
    case Scenario::kCircle:
      return Make(Circle(own_seed), T_body_imu);
    case Scenario::kWeaving:
      return Make(Weaving(own_seed, duration), T_body_imu);
  }
  throw InternalError("scenario without a trajectory");
}

}  // namespace mlic::sim
