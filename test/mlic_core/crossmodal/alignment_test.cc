#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "mlic_core/camera/features/image_quality.h"
#include "mlic_core/common/random.h"
#include "mlic_core/crossmodal/camera_to_map.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"
#include "support/source_directory.h"
#include "support/true_spline.h"

namespace mlic::alignment_test {
namespace {

constexpr double kDegree = M_PI / 180.0;

// A hand-held LiDAR of 32 rings and one of its cameras in a hall, everything known but the camera's pose.
class Hall {
 public:
  Hall() {
    sensors_ = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/handheld_stereo.yaml");
    sim::SimulationOptions simulation;
    simulation.scenario = sim::Scenario::kHandheld;
    simulation.duration = 6.0;
    const Drive drive = sim::SimulateDrive(sensors_, simulation, [](LidarScan& scan) { FilterScan(scan); });
    trajectory_ = sim::MakeTrajectory(sensors_, simulation);
    map_ = BuildIntensityMap(CollectReturns(drive, TrueSpline(*trajectory_, simulation.duration),
                                            sim::TrueCalibrations(sensors_), 10000000));
    const std::vector<double> times = sim::ImageTimes(camera(), simulation.duration);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t index = 10 + k * (times.size() - 20) / 3;
      const double time = times[index];
      photos_.push_back({ToGray(drive.cameras[0].images->Load(index)),
                         {},
                         [this, time](double) { return trajectory_->PoseAt(time); },
                         false});
    }
  }

  const sim::SimulatedCamera& camera() const { return sensors_.cameras[0]; }
  const RigidTransform& truth() const { return camera().calibration.T_imu_sensor; }

  std::optional<CameraToMapResult> AlignFrom(double degrees, double metres, std::uint64_t seed) const {
    Random random(seed);
    const auto direction = [&] {
      return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized().eval();
    };
    RigidTransform guess = truth();
    guess.rotation = guess.rotation * ExpQuaternion(degrees * kDegree * direction());
    guess.translation += metres * direction();
    return AlignCameraToMap(map_, camera().intrinsics, photos_, guess,
                            UncertaintyOf(degrees * kDegree, metres), {});
  }

 private:
  sim::SensorSet sensors_;
  std::unique_ptr<sim::Trajectory> trajectory_;
  IntensityMap map_;
  std::vector<PhotoOnMap> photos_;
};

TEST(CameraToMap, FindsTheCameraFromOneDegreeAndTwoCentimetresOff) {
  const Hall hall;
  const auto result = hall.AlignFrom(1.0, 0.02, 1);
  ASSERT_TRUE(result);
  const double rotation = AngleBetween(result->T_body_camera.rotation, hall.truth().rotation) / kDegree;
  const double translation = (result->T_body_camera.translation - hall.truth().translation).norm();
  RecordProperty("rotation_deg", std::to_string(rotation));
  RecordProperty("translation_mm", std::to_string(1e3 * translation));
  EXPECT_LT(rotation, 0.03);
  EXPECT_LT(translation, 0.003);
  EXPECT_GT(result->inlier_share, 0.9);
  EXPECT_LT(result->nid_after, result->nid_before - 0.005);
  // The sigmas are of the errors' size.
  const double sigma = std::sqrt(result->covariance.topLeftCorner<3, 3>().trace()) / kDegree;
  EXPECT_LT(sigma, 0.03);
  EXPECT_GT(sigma, 0.002);
}

}  // namespace
}  // namespace mlic::alignment_test
