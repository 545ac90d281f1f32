#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "mlic_core/crossmodal/view_selection.h"
#include "mlic_core/lidar/scan_filter.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/simulation.h"
#include "support/source_directory.h"
#include "support/true_spline.h"

namespace mlic::renderer_test {
namespace {

using Eigen::Vector3d;

// A simulated drive, its true trajectory and the map of its LiDARs.
struct Simulated {
  sim::SensorSet set;
  std::unique_ptr<sim::ImageStage> stage;
  SplitSpline trajectory;
  IntensityMap map;
};

Simulated Simulate(const char* sensors, sim::Scenario scenario, double duration) {
  Simulated s;
  s.set = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/" + sensors);
  sim::SimulationOptions options;
  options.scenario = scenario;
  options.duration = duration;
  const Drive drive = sim::SimulateDrive(s.set, options, [](LidarScan& scan) { FilterScan(scan); });
  s.stage = std::make_unique<sim::ImageStage>(s.set, options);
  s.trajectory = TrueSpline(s.stage->trajectory(), duration);
  s.map = BuildIntensityMap(CollectReturns(drive, s.trajectory, sim::TrueCalibrations(s.set), 10000000));
  return s;
}

ViewPose PoseOf(const Simulated& s, const sim::SimulatedCamera& camera, double time) {
  return PoseOnTrajectory(s.trajectory, camera.calibration, time - camera.calibration.time_offset,
                          camera.readout, camera.intrinsics.height);
}

// What the simulator's rays find: range (0: nothing within 80 m) and the near-infrared look of the surface.
struct Truth {
  cv::Mat depth, infrared;
};

Truth CastTruth(const Simulated& s, const sim::SimulatedCamera& camera, const ViewPose& pose) {
  const cv::Size size(camera.intrinsics.width, camera.intrinsics.height);
  Truth truth{cv::Mat::zeros(size, CV_32F),
              cv::Mat(size, CV_32F, cv::Scalar(std::numeric_limits<float>::quiet_NaN()))};
  for (int row = 0; row < size.height; ++row) {
    const RigidTransform T = pose.T_map_camera(row);
    for (int column = 0; column < size.width; ++column) {
      Vector3d bearing;
      if (!Unproject(camera.intrinsics, Eigen::Vector2d(column, row), &bearing)) continue;
      const auto hit = s.stage->world().Cast(T.translation, T.rotation * bearing, 80.0);
      if (!hit) continue;
      truth.depth.at<float>(row, column) = static_cast<float>(hit->range);
      truth.infrared.at<float>(row, column) =
          std::sqrt(sim::ReflectanceOf(hit->material, hit->position, hit->normal, hit->object).near_infrared);
    }
  }
  return truth;
}

struct DepthFigures {
  double seen = 0.0;          // share of the world's pixels
  double median_error = 0.0;  // m
  double through = 0.0;       // share of seen pixels that show something hidden
};

DepthFigures CompareDepth(const cv::Mat& depth, const cv::Mat& truth) {
  std::vector<float> errors;
  double world = 0.0, through = 0.0;
  for (int row = 0; row < depth.rows; ++row) {
    for (int column = 0; column < depth.cols; ++column) {
      const float d = depth.at<float>(row, column), t = truth.at<float>(row, column);
      if (t == 0.0f) continue;
      world += 1.0;
      if (d == 0.0f) continue;
      errors.push_back(std::abs(d - t));
      if (d > 1.03f * t + 0.1f) through += 1.0;
    }
  }
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  return {errors.size() / world, errors[errors.size() / 2], through / errors.size()};
}

// Correlation of the gradients of two images, smoothed by a pixel, where both are known, the second one
// shifted to the right.
double GradientCorrelation(const cv::Mat& a, const cv::Mat& b, int shift) {
  const auto gradients = [](const cv::Mat& image, cv::Mat* x, cv::Mat* y) {
    cv::Mat smooth;
    cv::GaussianBlur(image, smooth, cv::Size(7, 7), 1.0);  // what is not a number spreads
    cv::Sobel(smooth, *x, CV_32F, 1, 0);
    cv::Sobel(smooth, *y, CV_32F, 0, 1);
  };
  cv::Mat ax, ay, bx, by;
  gradients(a, &ax, &ay);
  gradients(b, &bx, &by);
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (int row = 0; row < a.rows; ++row) {
    for (int column = shift; column < a.cols; ++column) {
      const float p[2] = {ax.at<float>(row, column), ay.at<float>(row, column)};
      const float q[2] = {bx.at<float>(row, column - shift), by.at<float>(row, column - shift)};
      if (!std::isfinite(p[0] + p[1] + q[0] + q[1])) continue;
      for (int k = 0; k < 2; ++k) ab += p[k] * q[k], aa += p[k] * p[k], bb += q[k] * q[k];
    }
  }
  return ab / std::sqrt(aa * bb);
}

TEST(Renderer, ShowsWhatTheCamerasOfTheCarSee) {
  const Simulated s = Simulate("paper_rig.yaml", sim::Scenario::kFigureEight, 5.0);
  for (const std::size_t c : {std::size_t{0}, std::size_t{2}}) {  // a pinhole and a fisheye, to the front
    const sim::SimulatedCamera& camera = s.set.cameras[c];
    const ViewPose pose = PoseOf(s, camera, 1.5);
    const RenderedView view = ViewRenderer(s.map, camera.intrinsics, {}).Render(pose);
    const Truth truth = CastTruth(s, camera, pose);
    const DepthFigures figures = CompareDepth(view.depth, truth.depth);
    EXPECT_GT(figures.seen, 0.8) << camera.name;
    EXPECT_LT(figures.median_error, 0.012) << camera.name;
    EXPECT_LT(figures.through, 0.005) << camera.name;
    const double here = GradientCorrelation(view.intensity, truth.infrared, 0);
    EXPECT_GT(here, 0.6) << camera.name;
    EXPECT_LT(GradientCorrelation(view.intensity, truth.infrared, 4), 0.7 * here) << camera.name;
    // The photo: another spectrum and shadows, but the same structure.
    cv::Mat photo;
    s.stage->Render(c, 15, 1.5).convertTo(photo, CV_32F, 1.0 / 255.0);
    const double with_photo = GradientCorrelation(view.intensity, photo, 0);
    EXPECT_GT(with_photo, 0.5) << camera.name;
    EXPECT_LT(GradientCorrelation(view.intensity, photo, 4), 0.7 * with_photo) << camera.name;
  }
}

TEST(Renderer, FollowsARollingShutter) {
  const Simulated s = Simulate("rolling_shutter.yaml", sim::Scenario::kHandheld, 6.0);
  const sim::SimulatedCamera& camera = s.set.cameras[0];
  ASSERT_GT(camera.readout, 0.01);
  const ViewPose pose = PoseOf(s, camera, 3.0);
  ASSERT_TRUE(pose.rolling);
  const ViewRenderer renderer(s.map, camera.intrinsics, {});
  const Truth truth = CastTruth(s, camera, pose);
  const RenderedView rolling = renderer.Render(pose);
  const RenderedView global = renderer.Render(FixedPose(pose.T_map_camera(0.0)));
  const DepthFigures figures = CompareDepth(rolling.depth, truth.depth);
  EXPECT_GT(figures.seen, 0.95);
  EXPECT_LT(figures.median_error, 0.015);
  EXPECT_LT(figures.through, 0.01);
  const double right = GradientCorrelation(rolling.intensity, truth.infrared, 0);
  EXPECT_GT(right, 0.3);
  EXPECT_LT(GradientCorrelation(global.intensity, truth.infrared, 0), 0.8 * right);
  // A place that a pixel shows is where the simulator's ray of that row ends.
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(400.3, 500.6), Eigen::Vector2d(900.0, 600.25)}) {
    Vector3d bearing, place;
    ASSERT_TRUE(Unproject(camera.intrinsics, pixel, &bearing));
    ASSERT_TRUE(SurfaceAt(rolling, camera.intrinsics, pose, pixel, &place));
    const RigidTransform T = pose.T_map_camera(pixel.y());
    const auto hit = s.stage->world().Cast(T.translation, T.rotation * bearing, 80.0);
    ASSERT_TRUE(hit);
    EXPECT_LT((place - hit->position).norm(), 0.05);
  }
}

TEST(ViewSelection, SpreadsViewsAndLeavesOutEmptyOnes) {
  const Simulated s = Simulate("handheld_stereo.yaml", sim::Scenario::kHandheld, 6.0);
  const sim::SimulatedCamera& camera = s.set.cameras[0];
  std::vector<ViewCandidate> candidates;
  for (int k = 0; k < 40; ++k) candidates.push_back({PoseOf(s, camera, 0.5 + 0.125 * k), 1.0});
  // One that looks at nothing, and one that is blurred.
  candidates[7].pose = FixedPose({Eigen::Quaterniond::Identity(), Vector3d(0.0, 0.0, 500.0)});
  ViewSelectionOptions options;
  options.count = 8;
  const std::vector<std::size_t> chosen = SelectViews(s.map, camera.intrinsics, candidates, options);
  ASSERT_EQ(chosen.size(), 8u);
  EXPECT_EQ(std::count(chosen.begin(), chosen.end(), 7u), 0);
  std::vector<std::size_t> sorted = chosen;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(std::unique(sorted.begin(), sorted.end()), sorted.end()) << "each view once";
  EXPECT_GT(sorted.back() - sorted.front(), 20u) << "not all from one place";
  // The first choice loses to others once its picture is bad.
  candidates[chosen[0]].quality = 0.01;
  EXPECT_NE(SelectViews(s.map, camera.intrinsics, candidates, options)[0], chosen[0]);
  const std::vector<ViewCandidate> nothing(3, candidates[7]);
  EXPECT_TRUE(SelectViews(s.map, camera.intrinsics, nothing, options).empty());
  EXPECT_TRUE(SelectViews(s.map, camera.intrinsics, {}, options).empty());
}

TEST(ViewSelection, ScaledIntrinsicsSeeTheSameBearings) {
  const CameraIntrinsics camera = IntrinsicsFromFieldOfView(CameraModel::kEquidistant, 640, 480, 180.0);
  const CameraIntrinsics half = ScaledIntrinsics(camera, 0.5);
  Vector3d a, b;
  // The middle of a small pixel is the corner between four large ones.
  ASSERT_TRUE(Unproject(camera, {100.5, 200.5}, &a));
  ASSERT_TRUE(Unproject(half, {50.0, 100.0}, &b));
  EXPECT_LT((a - b).norm(), 1e-12);
}

}  // namespace
}  // namespace mlic::renderer_test
