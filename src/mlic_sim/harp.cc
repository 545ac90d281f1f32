#include "mlic_sim/harp.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/angles.h"
#include "mlic_core/common/random.h"
#include "mlic_sim/image_stage.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated harp.

using Eigen::Vector3d;

constexpr double kDistance = 0.5;  // m, from the camera to the bars
constexpr double kBarPixels = 20;  // width of a bar in the middle of the image, px
// The bars end where a camera sees them at 60 deg from their normal: further out they are too narrow.
constexpr double kReach = 1.75;  // of the distance
// The camera is turned by this share of its field of view to either side, and up and down.
constexpr double kTurnShare = 0.3;
constexpr double kMostTurnDeg = 55.0;
// Bars along one axis of the image and along the other; off both, so that no edge runs along pixels.
constexpr double kRollsDeg[] = {7.0, 97.0};
constexpr double kBehind = 1.0;     // m, a dark wall behind the bars
constexpr double kWallHalf = 30.0;  // m

Mesh HarpMesh(const std::vector<double>& edges) {
  Mesh mesh;
  mesh.AddQuad({-kWallHalf, kBehind, -kWallHalf}, {kWallHalf, kBehind, -kWallHalf},
               {kWallHalf, kBehind, kWallHalf}, {-kWallHalf, kBehind, kWallHalf}, Material::kRubber);
  const double end = edges.back();
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    mesh.AddQuad({edges[k], 0, -end}, {edges[k + 1], 0, -end}, {edges[k + 1], 0, end}, {edges[k], 0, end},
                 k % 2 == 0 ? Material::kWindowFrame : Material::kRubber);
  }
  return mesh;
}

std::vector<RigidTransform> HarpPoses(const SimulatedCamera& camera) {
  Eigen::Matrix3d R_map_facing;  // a camera that faces the bars: x right, y down, z towards them
  R_map_facing << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const double turn = kRadiansPerDegree * std::min(kTurnShare * camera.fov_deg, kMostTurnDeg);
  const double turns[][2] = {{0, 0}, {turn, 0}, {-turn, 0}, {0, turn}, {0, -turn}};
  std::vector<RigidTransform> poses;
  for (const double roll_deg : kRollsDeg) {
    for (const auto& [yaw, pitch] : turns) {
      const Eigen::AngleAxisd roll(kRadiansPerDegree * roll_deg, Vector3d::UnitZ());
      const Eigen::Quaterniond R = Eigen::Quaterniond(R_map_facing) * roll *
                                   Eigen::AngleAxisd(yaw, Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(pitch, Vector3d::UnitX());
      poses.push_back({R, Vector3d(0.0, -kDistance, 0.0)});
    }
  }
  return poses;
}

// A dark room, so that there is nothing else with edges: no sky, no clouds.
Lighting HarpLighting() {
  Lighting lighting = HallLighting();
  lighting.lamps = {{-1.5f, -2.0f, 1.0f}, {1.5f, -2.0f, 1.0f}};
  return lighting;
}

}  // namespace

// Stands in pose k from k - 0.5 to k + 0.5 s.
class Harp::Standing : public Trajectory {
 public:
  explicit Standing(const std::vector<RigidTransform>& poses) : poses_(poses) {}
  RigidTransform PoseAt(double time) const override {
    return poses_[static_cast<std::size_t>(
        std::clamp<long>(std::lround(time), 0, static_cast<long>(poses_.size()) - 1))];
  }
  MotionState StateAt(double time) const override {
    return {PoseAt(time), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  }

 private:
  std::vector<RigidTransform> poses_;
};

Harp::Harp(const SimulatedCamera& camera)
    : camera_(camera), poses_(HarpPoses(camera)), lighting_(HarpLighting()) {
  camera_.calibration.T_imu_sensor = RigidTransform();
  const double bar = kBarPixels / camera_.intrinsics.parameters[0] * kDistance;
  const int bars_to_either_side = static_cast<int>(std::ceil(kReach * kDistance / bar));
  for (int k = -bars_to_either_side; k <= bars_to_either_side; ++k) edges_.push_back(k * bar);
  world_ = std::make_unique<World>(HarpMesh(edges_));
  textures_ = std::make_unique<SurfaceTextures>(*world_, lighting_);
  standing_ = std::make_unique<Standing>(poses_);
  renderer_ = std::make_unique<CameraRenderer>(camera_, *world_, lighting_, *textures_, *standing_);
}

Harp::~Harp() = default;

cv::Mat Harp::Render(std::size_t photo, bool with_noise, std::uint64_t seed) const {
  const std::uint64_t own_seed = Random(seed).Fork(photo).Next();
  return WithoutMosaic(camera_, renderer_->Render(static_cast<double>(photo), with_noise, own_seed));
}

}  // namespace mlic::sim
