// Own two-view geometry and own PnP beside OpenGV's on the same seeded scenes: matches of narrow and of
// very wide views with noise and 0 to 50 percent outliers. Times are CPU time of one thread; both sides may
// draw as many samples and stop by the same probability, and both end with a non-linear fit to their inliers.
#include <cstdio>
#include <ctime>
#include <functional>
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/sac/Ransac.hpp>
#include <opengv/sac_problems/absolute_pose/AbsolutePoseSacProblem.hpp>
#include <opengv/sac_problems/relative_pose/CentralRelativePoseSacProblem.hpp>
#include <optional>

#include "mlic_core/camera/two_view/two_view.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/crossmodal/pnp.h"
#include "mlic_core/geometry/so3.h"

namespace mlic {
namespace {

using Bearings = std::vector<Eigen::Vector3d, Eigen::aligned_allocator<Eigen::Vector3d>>;
using opengv::sac_problems::absolute_pose::AbsolutePoseSacProblem;
using opengv::sac_problems::relative_pose::CentralRelativePoseSacProblem;

constexpr int kScenes = 100;
constexpr int kMatches = 300;
constexpr double kNoisePixels = 0.5;
constexpr double kLimitSigmas = 3.5;
constexpr int kMostIterations = 1000;
constexpr double kConfidence = 0.9999;
// A pose worth going on with.
constexpr double kGoodRotationDeg = 0.5, kGoodDirectionDeg = 5.0, kGoodPosition = 0.1;  // m

struct Scene {
  CameraIntrinsics camera;
  double noise = 0.0;    // rad, of a bearing, near the axis
  RigidTransform T_b_a;  // for PnP: of the camera and the map
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> a, b;
  std::vector<Eigen::Vector2d> pixels;  // of b
};

Scene MakeScene(std::uint64_t seed, double fov_deg, double outliers) {
  Random random(seed);
  const auto normal = [&] { return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()); };
  Scene scene;
  const CameraModel model = fov_deg < 120.0 ? CameraModel::kPlumbBob : CameraModel::kEquidistant;
  scene.camera = IntrinsicsFromFieldOfView(model, 1280, 960, fov_deg);
  scene.noise = kNoisePixels / scene.camera.parameters[0];
  scene.T_b_a = {ExpQuaternion(0.2 * normal().normalized()), normal().normalized()};
  while (scene.a.size() < kMatches) {
    const auto anywhere = [&] { return Eigen::Vector2d(random.Uniform(0, 1279), random.Uniform(0, 959)); };
    const Eigen::Vector2d pixel_a = anywhere();
    Eigen::Vector3d a, b;
    Eigen::Vector2d pixel_b;
    if (!Unproject(scene.camera, pixel_a, &a)) continue;
    const Eigen::Vector3d point = random.Uniform(4.0, 30.0) * a;
    const Eigen::Vector3d in_b = scene.T_b_a * point;
    const bool seen = Project(scene.camera, in_b, &pixel_b) && pixel_b.x() > 0.0 && pixel_b.y() > 0.0 &&
                      pixel_b.x() < 1279.0 && pixel_b.y() < 959.0;
    if (!seen) continue;
    if (random.Uniform() < outliers) pixel_b = anywhere();
    const Eigen::Vector2d noise_a(random.Normal(), random.Normal()),
        noise_b(random.Normal(), random.Normal());
    if (!Unproject(scene.camera, pixel_a + kNoisePixels * noise_a, &a)) continue;
    if (!Unproject(scene.camera, pixel_b + kNoisePixels * noise_b, &b)) continue;
    scene.points.push_back(point);
    scene.a.push_back(a);
    scene.b.push_back(b);
    scene.pixels.push_back(pixel_b + kNoisePixels * noise_b);
  }
  return scene;
}

using Estimate = std::function<std::optional<RigidTransform>(const Scene&)>;

std::optional<RigidTransform> OwnTwoView(const Scene& scene) {
  TwoViewOptions options;
  options.largest_error = kLimitSigmas * scene.noise;
  options.most_iterations = kMostIterations;
  options.confidence = kConfidence;
  const auto found = EstimateTwoView(scene.a, scene.b, options);
  if (!found || !found->has_translation) return std::nullopt;
  return RigidTransform{Eigen::Quaterniond(found->R_b_a), found->t_b_a};
}

template <typename Problem>
std::optional<RigidTransform> Ransac(const std::shared_ptr<Problem>& problem, double angle) {
  opengv::sac::Ransac<Problem> ransac;
  ransac.sac_model_ = problem;
  ransac.threshold_ = 1.0 - std::cos(angle);  // OpenGV's errors are one minus cosines
  ransac.max_iterations_ = kMostIterations;
  ransac.probability_ = kConfidence;
  if (!ransac.computeModel() || ransac.inliers_.size() < 15) return std::nullopt;
  opengv::transformation_t model = ransac.model_coefficients_;
  problem->optimizeModelCoefficients(ransac.inliers_, ransac.model_coefficients_, model);
  return RigidTransform{Eigen::Quaterniond(Eigen::Matrix3d(model.leftCols<3>())), model.col(3)}.Inverse();
}

std::optional<RigidTransform> OpengvTwoView(const Scene& scene,
                                            CentralRelativePoseSacProblem::Algorithm algorithm) {
  const Bearings a(scene.a.begin(), scene.a.end()), b(scene.b.begin(), scene.b.end());
  opengv::relative_pose::CentralRelativeAdapter adapter(a, b);
  return Ransac(std::make_shared<CentralRelativePoseSacProblem>(adapter, algorithm, false),
                kLimitSigmas * scene.noise);
}

std::optional<RigidTransform> OwnPnp(const Scene& scene) {
  std::vector<PointCorrespondence> correspondences;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    correspondences.push_back(
        {scene.points[i], scene.pixels[i], kNoisePixels * kNoisePixels * Eigen::Matrix2d::Identity()});
  }
  PnpOptions options;
  options.model_sigma = 0.0;
  options.largest_error = kLimitSigmas;
  options.most_iterations = kMostIterations;
  options.confidence = kConfidence;
  const auto found = EstimatePose(correspondences, scene.camera, options);
  if (!found) return std::nullopt;
  return found->T_camera_body;
}

std::optional<RigidTransform> OpengvPnp(const Scene& scene) {
  const Bearings b(scene.b.begin(), scene.b.end()), points(scene.points.begin(), scene.points.end());
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(b, points);
  return Ransac(std::make_shared<AbsolutePoseSacProblem>(adapter, AbsolutePoseSacProblem::KNEIP, false),
                kLimitSigmas * scene.noise);
}

void PrintRow(const char* name, double fov_deg, double outliers, bool scale_known, const Estimate& estimate) {
  std::vector<double> rotations, translations;
  int good = 0;
  double seconds = 0.0;
  for (int seed = 1; seed <= kScenes; ++seed) {
    const Scene scene = MakeScene(seed, fov_deg, outliers);
    const std::clock_t before = std::clock();
    const auto found = estimate(scene);
    seconds += static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    if (!found) continue;
    const double rotation = AngleBetween(found->rotation, scene.T_b_a.rotation) * 180.0 / M_PI;
    const Eigen::Vector3d& t = scene.T_b_a.translation;
    const double direction =
        std::atan2(found->translation.cross(t).norm(), found->translation.dot(t)) * 180.0 / M_PI;
    const double translation = scale_known ? (found->translation - t).norm() : direction;
    rotations.push_back(rotation);
    translations.push_back(translation);
    good += rotation < kGoodRotationDeg && translation < (scale_known ? kGoodPosition : kGoodDirectionDeg);
  }
  std::printf("%-26s %4.0f %8.0f %8d %14.4f %14.4f %10.2f\n", name, fov_deg, 100.0 * outliers, good,
              rotations.empty() ? -1.0 : Median(rotations),
              translations.empty() ? -1.0 : Median(translations), 1e3 * seconds / kScenes);
}

}  // namespace
}  // namespace mlic

int main() {
  using mlic::PrintRow;
  using Problem = opengv::sac_problems::relative_pose::CentralRelativePoseSacProblem;
  constexpr double kOutliers[] = {0.0, 0.1, 0.3, 0.5};
  constexpr double kFieldsOfView[] = {70.0, 220.0};  // degrees
  std::printf("%d scenes a row, %d matches, noise %.1f px of 1280\n", mlic::kScenes, mlic::kMatches,
              mlic::kNoisePixels);
  std::printf("%-26s %4s %8s %8s %14s %14s %10s\n", "two views", "fov", "outl. %", "good", "rotation deg",
              "direction deg", "ms");
  for (const double fov : kFieldsOfView) {
    for (const double outliers : kOutliers) {
      PrintRow("own", fov, outliers, false, mlic::OwnTwoView);
      PrintRow("OpenGV Stewenius", fov, outliers, false,
               [](const auto& scene) { return mlic::OpengvTwoView(scene, Problem::STEWENIUS); });
      PrintRow("OpenGV Nister", fov, outliers, false,
               [](const auto& scene) { return mlic::OpengvTwoView(scene, Problem::NISTER); });
    }
  }
  std::printf("%-26s %4s %8s %8s %14s %14s %10s\n", "PnP", "fov", "outl. %", "good", "rotation deg",
              "position m", "ms");
  for (const double fov : kFieldsOfView) {
    for (const double outliers : kOutliers) {
      PrintRow("own", fov, outliers, true, mlic::OwnPnp);
      PrintRow("OpenGV Kneip", fov, outliers, true, mlic::OpengvPnp);
    }
  }
  return 0;
}
