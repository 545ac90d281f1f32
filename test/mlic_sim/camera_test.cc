#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "mlic_core/geometry/so3.h"
#include "mlic_sim/camera_renderer.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"

namespace mlic::sim::camera_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Turns at a constant rate and moves at a constant velocity.
class SteadyMotion : public Trajectory {
 public:
  SteadyMotion(const Vector3d& rate, const Vector3d& velocity) : rate_(rate), velocity_(velocity) {}
  RigidTransform PoseAt(double time) const override {
    return {ExpQuaternion(time * rate_), Vector3d(0.1, -0.2, 0.3) + time * velocity_};
  }
  MotionState StateAt(double time) const override {
    return {PoseAt(time), velocity_, Vector3d::Zero(), rate_};
  }

 private:
  Vector3d rate_, velocity_;
};

// A bright square frame, tilted, before a dark wall, four metres away along z; its corners.
const Vector3d kCorners[] = {{-1.1, -0.7, 4.0}, {1.2, -0.8, 4.3}, {1.1, 0.9, 4.4}, {-1.0, 0.8, 4.1}};

Mesh BrightBoard() {
  Mesh mesh;
  mesh.AddQuad({-30, -30, 9}, {30, -30, 9}, {30, 30, 9}, {-30, 30, 9}, Material::kRubber);
  mesh.AddTriangle(kCorners[0], kCorners[1], kCorners[2], Material::kWindowFrame);
  mesh.AddTriangle(kCorners[0], kCorners[2], kCorners[3], Material::kWindowFrame);
  return mesh;
}

// Sky light only: no shadows.
Lighting Overcast() {
  Lighting lighting;
  lighting.sun.setZero();
  return lighting;
}

SimulatedCamera Camera(CameraModel model) {
  SimulatedCamera camera;
  camera.name = "camera";
  camera.calibration.T_imu_sensor = {FromRollPitchYaw({0.03, -0.05, 0.2}), Vector3d(0.05, 0.1, -0.02)};
  camera.intrinsics.model = model;
  camera.intrinsics.width = 640, camera.intrinsics.height = 480;
  camera.intrinsics.parameters = IntrinsicsFromFieldOfView(model, 640, 480, 100.0).parameters;
  camera.intrinsics.parameters[2] += 3.3;
  camera.intrinsics.parameters[3] -= 2.2;
  if (model == CameraModel::kPlumbBob) camera.intrinsics.parameters[4] = -0.05;
  if (model == CameraModel::kEquidistant) camera.intrinsics.parameters[4] = 0.02;
  camera.fov_deg = 100.0;
  return camera;
}

double Bilinear(const cv::Mat& light, const Vector2d& p) {
  const int u = static_cast<int>(p.x()), v = static_cast<int>(p.y());
  const double a = p.x() - u, b = p.y() - v;
  const auto at = [&](int x, int y) { return static_cast<double>(light.at<cv::Vec3f>(y, x)[1]); };
  return (1 - b) * ((1 - a) * at(u, v) + a * at(u + 1, v)) +
         b * ((1 - a) * at(u, v + 1) + a * at(u + 1, v + 1));
}

// Where the light passes half way between its levels on either side, pixels from `p` along `normal`.
double EdgeOffset(const cv::Mat& light, const Vector2d& p, const Vector2d& normal) {
  const double low = Bilinear(light, p - 4.0 * normal), high = Bilinear(light, p + 4.0 * normal);
  double last = -3.0;
  for (double x = -3.0; x <= 3.0; x += 0.05) {
    if ((Bilinear(light, p + x * normal) - 0.5 * (low + high)) * (high - low) > 0.0) return 0.5 * (x + last);
    last = x;
  }
  return 100.0;
}

// The pixel of a point at the time of its own row.
Vector2d Seen(const SimulatedCamera& camera, const Trajectory& trajectory, double time,
              const Vector3d& point) {
  Vector2d pixel(0, 0.5 * camera.intrinsics.height);
  for (int i = 0; i < 20; ++i) {
    const double t = time + pixel.y() / camera.intrinsics.height * camera.readout;
    const RigidTransform T = trajectory.PoseAt(t) * camera.calibration.T_imu_sensor;
    EXPECT_TRUE(Project(camera.intrinsics, T.Inverse() * point, &pixel));
  }
  return pixel;
}

// Mean and largest distance between the rendered edges of the board and their projections, pixels.
void CompareEdges(const SimulatedCamera& camera, const Trajectory& trajectory, double time, double* mean,
                  double* largest) {
  const World world(BrightBoard());
  const SurfaceTextures textures(world, Overcast());
  const CameraRenderer renderer(camera, world, Overcast(), textures, trajectory);
  const cv::Mat light = renderer.RenderLight({time, camera.exposure, 1.0}, 0, camera.intrinsics.height);
  *mean = *largest = 0.0;
  int count = 0;
  for (int side = 0; side < 4; ++side) {
    const Vector3d a = kCorners[side], b = kCorners[(side + 1) % 4];
    for (int k = 2; k < 38; ++k, ++count) {
      const Vector2d p = Seen(camera, trajectory, time, a + k / 40.0 * (b - a));
      const Vector2d next = Seen(camera, trajectory, time, a + (k + 0.1) / 40.0 * (b - a));
      const Vector2d along = (next - p).normalized();
      const double offset = EdgeOffset(light, p, Vector2d(-along.y(), along.x()));
      *mean += offset;
      *largest = std::max(*largest, std::abs(offset));
    }
  }
  *mean /= count;
}

TEST(CameraRenderer, EdgesAreWhereTheModelProjectsThem) {
  const SteadyMotion still(Vector3d::Zero(), Vector3d::Zero());
  for (const CameraModel model : {CameraModel::kPlumbBob, CameraModel::kRationalPolynomial,
                                  CameraModel::kEquidistant, CameraModel::kDoubleSphere}) {
    SCOPED_TRACE(static_cast<int>(model));
    double mean, largest;
    CompareEdges(Camera(model), still, 0.0, &mean, &largest);
    EXPECT_LT(std::abs(mean), 0.04);
    EXPECT_LT(largest, 0.3);  // rays have a spacing of half a pixel
  }
}

TEST(CameraRenderer, RowsOfARollingShutterHaveTheirOwnTimes) {
  const SteadyMotion moving({0.5, -0.7, 0.9}, {1.0, -0.5, 0.4});
  SimulatedCamera camera = Camera(CameraModel::kPlumbBob);
  camera.rolling_shutter = true;
  camera.readout = 0.025;
  double mean, largest;
  CompareEdges(camera, moving, 0.02, &mean, &largest);
  EXPECT_LT(std::abs(mean), 0.04);
  EXPECT_LT(largest, 0.3);
  // The motion within one image matters: without the row times the edges would be pixels away.
  SimulatedCamera global = camera;
  global.readout = 0.0;
  const Vector2d difference =
      Seen(camera, moving, 0.02, kCorners[2]) - Seen(global, moving, 0.02, kCorners[2]);
  EXPECT_GT(difference.norm(), 3.0);
}

TEST(CameraRenderer, ExposureBlursAboutItsMiddle) {
  const SteadyMotion turning({0.0, 1.5, 0.0}, {0.0, 0.0, 0.0});
  SimulatedCamera camera = Camera(CameraModel::kPlumbBob);
  camera.exposure = 0.01;  // some 4 pixels of motion
  double mean, largest;
  CompareEdges(camera, turning, 0.0, &mean, &largest);
  EXPECT_LT(std::abs(mean), 0.06);
  EXPECT_LT(largest, 0.8);
}

// A dark and a bright half of the surroundings are looked at in turn, without other light.
TEST(CameraRenderer, AnAutomaticExposureMovesTheMiddleAgainstTheStamp) {
  const SteadyMotion turning({0.0, 1.5, 0.0}, {0.0, 0.0, 0.0});
  SimulatedCamera camera = Camera(CameraModel::kPlumbBob);
  camera.shortest_exposure = 0.0005;
  camera.exposure = 0.02;
  camera.exposure_drift = 0.0;
  const World world(BrightBoard());
  const SurfaceTextures textures(world, Overcast());
  std::vector<double> times;
  for (int k = 0; k < 20; ++k) times.push_back(0.1 * k);
  const CameraRenderer renderer(camera, world, Overcast(), textures, turning, times);
  double sum = 0.0, shortest = 1.0, longest = 0.0;
  for (const double time : times) {
    const CameraRenderer::Exposure exposure = renderer.ExposureOf(time, true);
    sum += exposure.middle - time;
    shortest = std::min(shortest, exposure.length);
    longest = std::max(longest, exposure.length);
    EXPECT_EQ(renderer.ExposureOf(time, false).middle, time);
  }
  EXPECT_NEAR(sum / static_cast<double>(times.size()), 0.0, 1e-9);
  EXPECT_GT(longest, 2.0 * shortest);
}

SensorSet CameraSet() {
  SensorSet set;
  set.imu.T_body_imu.translation << 0, 0, 1.5;
  for (const ImageEncoding encoding :
       {ImageEncoding::kMono8, ImageEncoding::kBgr8, ImageEncoding::kBayerRggb8}) {
    SimulatedCamera camera = Camera(CameraModel::kEquidistant);
    camera.intrinsics.width = 160, camera.intrinsics.height = 120;
    camera.intrinsics.parameters =
        IntrinsicsFromFieldOfView(camera.intrinsics.model, 160, 120, 100.0).parameters;
    camera.name = "camera" + std::to_string(set.cameras.size());
    camera.calibration.T_imu_sensor = {FromRollPitchYaw({-M_PI / 2, 0.0, -M_PI / 2}),
                                       Vector3d(0.2, 0.1, 0.0)};
    camera.calibration.time_offset = 0.03;
    camera.phase = 0.011;
    camera.encoding = encoding;
    set.cameras.push_back(camera);
  }
  return set;
}

TEST(SimulateDrive, RendersTheSameImagesOnRequestWhateverTheThreads) {
  const SensorSet set = CameraSet();
  SimulationOptions options;
  options.duration = 1.0;
  const Drive drive = SimulateDrive(set, options);
  ASSERT_EQ(drive.cameras.size(), 3u);
  EXPECT_TRUE(drive.lidars.empty());
  EXPECT_EQ(drive.imu.size(), 201u);
  for (std::size_t c = 0; c < 3; ++c) {
    const ImageSource& images = *drive.cameras[c].images;
    ASSERT_EQ(images.Count(), 10u);
    EXPECT_NEAR(images.Time(3), 0.311 - 0.03, 1e-12);  // t_imu = t_camera + offset
    const cv::Mat image = images.Load(3);
    EXPECT_EQ(image.type(), c == 0 ? CV_8UC1 : CV_8UC3);
    cv::Scalar mean, deviation;
    cv::meanStdDev(image, mean, deviation);
    EXPECT_GT(mean[0], 40.0);
    EXPECT_GT(deviation[0], 15.0);
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const Drive again = SimulateDrive(set, options);
    EXPECT_EQ(cv::norm(image, again.cameras[c].images->Load(3), cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(image, images.Load(4), cv::NORM_INF), 0.0);
  }
}

TEST(RigWithCameras, GivesCamerasAFieldOfViewAndNoIntrinsics) {
  SensorSet set = CameraSet();
  set.cameras[1].rolling_shutter = true;
  const Rig rig = RigFromSensorSet(set, {});
  ASSERT_EQ(rig.cameras.size(), 3u);
  EXPECT_EQ(rig.cameras[1].shutter, Shutter::kRolling);
  EXPECT_EQ(rig.cameras[0].model, CameraModel::kEquidistant);
  EXPECT_EQ(rig.cameras[0].fov_deg, 100.0);
  EXPECT_FALSE(rig.cameras[0].intrinsics.has_value());
  EXPECT_NEAR(AngleBetween(rig.cameras[2].guess->T_imu_sensor.rotation,
                           set.cameras[2].calibration.T_imu_sensor.rotation) *
                  180 / M_PI,
              4.81, 1e-9);
}

}  // namespace
}  // namespace mlic::sim::camera_test
