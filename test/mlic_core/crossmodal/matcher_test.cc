#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "mlic_core/crossmodal/cross_modal_matches.h"
#include "mlic_core/crossmodal/structure_matcher.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_sim/image_stage.h"
#include "support/pseudo_rendering.h"
#include "support/source_directory.h"

namespace mlic::matcher_test {
namespace {

// Photos of the simulator's yard by cameras of half the usual size, and stand-ins for renderings from poses
// that are wrong.
class Yard {
 public:
  Yard() {
    sensors_ = sim::LoadSensorSet(SourceDirectory() + "/config/simulation/paper_rig.yaml");
    for (sim::SimulatedCamera& camera : sensors_.cameras) {
      camera.intrinsics.width /= 2, camera.intrinsics.height /= 2;
      std::vector<double>& p = camera.intrinsics.parameters;
      p[0] *= 0.5, p[1] *= 0.5, p[2] = 0.5 * p[2] - 0.25, p[3] = 0.5 * p[3] - 0.25;
    }
    sim::SimulationOptions options;
    options.duration = 60.0;
    stage_ = std::make_unique<sim::ImageStage>(sensors_, options);
  }

  struct View {
    cv::Mat photo;
    CameraIntrinsics intrinsics;
    RigidTransform truth, rendered_from;  // T_map_camera
    RenderedStructure rendering;
  };

  View Make(std::size_t camera, double time, double error_deg, const PseudoRenderingOptions& options) const {
    View view;
    view.photo = stage_->Render(camera, options.seed, time);
    view.intrinsics = sensors_.cameras[camera].intrinsics;
    view.truth = stage_->trajectory().PoseAt(time) * sensors_.cameras[camera].calibration.T_imu_sensor;
    view.rendered_from = view.truth;
    Random random(options.seed);
    const Eigen::Vector3d axis(random.Normal(), random.Normal(), random.Normal());
    view.rendered_from.rotation =
        view.truth.rotation * ExpQuaternion(error_deg * M_PI / 180.0 * axis.normalized());
    view.rendering = PseudoRendering(stage_->world(), view.intrinsics, view.rendered_from, options);
    return view;
  }

 private:
  sim::SensorSet sensors_;
  std::unique_ptr<sim::ImageStage> stage_;
};

const Yard& TheYard() {
  static const Yard yard;
  return yard;
}

std::vector<StructureMatch> MatchesOf(const Yard::View& view, double error_deg) {
  const double sigma = 0.5 + view.intrinsics.parameters[0] * error_deg * M_PI / 180.0;
  const Eigen::Matrix2d predicted = sigma * sigma * Eigen::Matrix2d::Identity();
  return MatchStructure(MapStructure(view.rendering, {}), PhotoStructure(view.photo, {}, {}),
                        [&](const Eigen::Vector2d&) { return predicted; }, {});
}

// Errors of matches against the truth.
struct Errors {
  int count = 0;
  int outliers = 0;         // farther off than 2 px
  double rms = 0.0;         // px along one axis, outliers left out
  double normalized = 0.0;  // mean squared error by covariance along one axis: 1 where sigmas are right
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
};

Errors ErrorsOf(const Yard::View& view, const std::vector<StructureMatch>& matches) {
  Errors errors;
  double squared = 0.0, normalized = 0.0;
  for (const StructureMatch& match : matches) {
    const auto& p = view.rendering.points.at<cv::Vec3f>(static_cast<int>(match.rendered.y()),
                                                        static_cast<int>(match.rendered.x()));
    const Eigen::Vector3d point(p[0], p[1], p[2]);
    Eigen::Vector2d there, here;
    if (point.isZero() || !Project(view.intrinsics, view.truth.Inverse() * point, &there) ||
        !Project(view.intrinsics, view.rendered_from.Inverse() * point, &here)) {
      continue;
    }
    ++errors.count;
    const Eigen::Vector2d error = match.displacement - (there - here);
    if (error.norm() > 2.0) {
      ++errors.outliers;
      continue;
    }
    squared += error.squaredNorm();
    normalized += error.dot(match.covariance.inverse() * error);
    errors.mean += error;
  }
  const double inliers = std::max(1, errors.count - errors.outliers);
  errors.rms = std::sqrt(0.5 * squared / inliers);
  errors.normalized = 0.5 * normalized / inliers;
  errors.mean /= inliers;
  return errors;
}

TEST(StructureMatcher, FindsTheRenderingInThePhoto) {
  for (const std::size_t camera : {0, 2}) {
    const Yard::View view = TheYard().Make(camera, 5.0, 0.5, {});
    const Errors errors = ErrorsOf(view, MatchesOf(view, 0.5));
    EXPECT_GT(errors.count, 40) << camera;
    EXPECT_LT(errors.outliers, 0.08 * errors.count) << camera;
    EXPECT_LT(errors.rms, 0.8) << camera;
    EXPECT_LT(errors.mean.norm(), 0.35) << camera;
    EXPECT_GT(errors.normalized, 0.4) << camera;
    EXPECT_LT(errors.normalized, 2.0) << camera;
  }
}

TEST(StructureMatcher, InvertedContrastIsTheSameEdge) {
  PseudoRenderingOptions options;
  options.invert_half = true;
  const Yard::View view = TheYard().Make(0, 5.0, 0.5, options);
  const Errors errors = ErrorsOf(view, MatchesOf(view, 0.5));
  EXPECT_GT(errors.count, 50);
  EXPECT_LT(errors.outliers, 0.1 * errors.count);
  EXPECT_LT(errors.rms, 0.8);
}

// With another scene's photo, hardly anything passes for a match.
TEST(StructureMatcher, FindsLittleInAnotherPhoto) {
  Yard::View view = TheYard().Make(0, 5.0, 0.0, {});
  const std::size_t right = MatchesOf(view, 0.5).size();
  view.photo = TheYard().Make(0, 35.0, 0.0, {}).photo;
  EXPECT_LT(static_cast<double>(MatchesOf(view, 0.5).size()), 0.15 * static_cast<double>(right));
}

// Points some pixels apart make blobs that the photo does not show.
TEST(StructureMatcher, TrustsMatchesLessWhereTheMapIsCoarse) {
  std::size_t count = 0;
  for (const std::size_t camera : {0, 2}) {
    const Yard::View yard = TheYard().Make(camera, 5.0, 0.0, {});
    RenderedView view{yard.rendering.intensity, yard.rendering.range, yard.rendering.normals,
                      cv::Mat::zeros(yard.photo.size(), CV_32S), cv::Mat::zeros(yard.photo.size(), CV_32F)};
    const auto match = [&](float spacing) {
      view.spacing.setTo(spacing);
      return MatchView(view, yard.intrinsics, FixedPose(yard.truth), yard.photo, cv::Mat(),
                       CameraUncertainty(), {});
    };
    const std::vector<MapMatch> dense = match(0.0f), coarse = match(0.05f), coarser = match(0.1f);
    count += dense.size();
    ASSERT_EQ(coarse.size(), dense.size());
    for (std::size_t i = 0; i < dense.size(); ++i) {
      const double alone = dense[i].covariance.trace();
      const double added = coarse[i].covariance.trace() - alone, more = coarser[i].covariance.trace() - alone;
      EXPECT_NEAR(more, 4.0 * added, 1e-5 * more);
      // Off the axis of a pinhole pixels are narrower.
      const double depth = (yard.truth.Inverse() * dense[i].point).norm();
      const double pixels = 0.05 * yard.intrinsics.parameters[0] / depth;
      EXPECT_GT(added / alone, 0.3 * std::pow(pixels / 6.0, 2));
      EXPECT_LT(added / alone, 60.0 * std::pow(pixels / 6.0, 2));
    }
  }
  ASSERT_GT(count, 40u);
}

TEST(StructureMatcher, DoesNotHangOnTheNumberOfThreads) {
  const Yard::View view = TheYard().Make(0, 5.0, 0.2, {});
  const std::vector<StructureMatch> many = MatchesOf(view, 0.2);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<StructureMatch> single = MatchesOf(view, 0.2);
  ASSERT_EQ(many.size(), single.size());
  for (std::size_t i = 0; i < many.size(); ++i) EXPECT_EQ(many[i].displacement, single[i].displacement);
}

TEST(StructureFeatures, PyramidKeepsPlaces) {
  // A step edge at x = 100.5 of level 0 is at the same place at every level.
  cv::Mat gray(240, 320, CV_8UC1, cv::Scalar(40));
  gray.colRange(101, 320).setTo(200);
  const StructurePyramid pyramid = PhotoStructure(gray, {}, {});
  for (int level = 0; level < 4; ++level) {
    const StructureImage& image = pyramid[static_cast<std::size_t>(level)];
    const int row = image.height / 2;
    double sum = 0.0, moment = 0.0;
    for (int u = 2; u < image.width - 2; ++u) {
      const double strength = image.Channels(row)[StructureImage::kChannels * u + 1];
      sum += strength, moment += strength * u;
    }
    EXPECT_GT(sum, 0.0);
    // A pyramid without care for pixel centres is off by (2^level - 1) / 2.
    EXPECT_NEAR(FromLevel(moment / sum, level), 100.5, 0.05 + 0.06 * (1 << level)) << level;
  }
}

}  // namespace
}  // namespace mlic::matcher_test
