#include "mlic_core/sensors/camera_model.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "mlic_core/common/error.h"
#include "mlic_core/common/random.h"
#include "mlic_core/sensors/double_sphere_twin.h"
#include "mlic_core/sensors/pinhole_model.h"

namespace mlic::camera_model_test {
namespace {

CameraIntrinsics Make(CameraModel model, int width, int height, std::vector<double> parameters) {
  CameraIntrinsics intrinsics;
  intrinsics.model = model;
  intrinsics.width = width;
  intrinsics.height = height;
  intrinsics.parameters = std::move(parameters);
  return intrinsics;
}

// Lenses as they are sold: what their image shows is inside the domain of the model.
std::vector<CameraIntrinsics> Lenses() {
  const CameraModel pinhole = CameraModel::kPlumbBob, rational = CameraModel::kRationalPolynomial;
  const CameraModel fisheye = CameraModel::kEquidistant, sphere = CameraModel::kDoubleSphere;
  return {
      Make(pinhole, 1280, 800, {369.5, 370.5, 639.5, 399.5, 0.0, 0.0, 0.0, 0.0, 0.0}),
      Make(pinhole, 1280, 720, {900.0, 905.0, 650.0, 350.0, -0.32, 0.12, 8e-4, -5e-4, -0.02}),
      Make(pinhole, 640, 480, {300.0, 300.0, 322.0, 238.0, -0.28, 0.07, 1e-3, 2e-3, -0.002}),
      Make(pinhole, 752, 480, {458.0, 457.0, 367.0, 248.0, -0.283, 0.074, 2e-4, 1.8e-5, 0.0}),
      Make(pinhole, 1280, 800, {800.0, 800.0, 630.0, 410.0, 0.25, 0.1, -2e-3, 1e-3, 0.01}),
      Make(rational, 1280, 800,
           {370.0, 371.0, 641.0, 398.0, 0.6, 0.02, 3e-4, -2e-4, 0.001, 0.95, 0.11, 0.004}),
      Make(rational, 1920, 1080, {950.0, 950.0, 960.0, 540.0, 8.2, 3.1, 1e-4, 1e-4, 0.12, 8.5, 5.6, 0.7}),
      Make(fisheye, 1280, 1024, {375.0, 376.0, 639.0, 512.0, 0.02, -0.01, 0.004, -0.0002}),
      Make(fisheye, 1280, 1280, {385.0, 385.0, 639.5, 639.5, 0.0, 0.0, 0.0, 0.0}),
      Make(fisheye, 512, 512, {190.97, 190.97, 254.9, 256.9, 0.0034, 0.0007, -0.0021, 0.0002}),
      Make(sphere, 512, 512, {156.7, 156.7, 254.9, 256.9, -0.174, 0.592}),
      Make(sphere, 640, 480, {390.0, 391.0, 321.0, 239.0, 0.0, 0.45}),
      Make(sphere, 1280, 1280, {450.0, 450.0, 639.5, 639.5, 0.1, 0.62}),
  };
}

// A direction at `theta` from the optical axis and `phi` about it.
Eigen::Vector3d Direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(CameraModel, EveryParameterHasAName) {
  for (const CameraIntrinsics& lens : Lenses()) {
    EXPECT_EQ(static_cast<int>(ParameterNames(lens.model).size()), ParameterCount(lens.model));
    EXPECT_EQ(static_cast<int>(lens.parameters.size()), ParameterCount(lens.model));
  }
  EXPECT_EQ(ParameterNames(CameraModel::kPlumbBob)[8], "k3");
  EXPECT_EQ(ParameterNames(CameraModel::kDoubleSphere)[5], "alpha");
}

TEST(CameraModel, ProjectionAgreesWithOpenCv) {
  int compared = 0;
  for (const CameraIntrinsics& lens : Lenses()) {
    if (lens.model == CameraModel::kDoubleSphere) continue;
    const bool fisheye = lens.model == CameraModel::kEquidistant;
    const double* p = lens.parameters.data();
    const cv::Matx33d K(p[0], 0, p[2], 0, p[1], p[3], 0, 0, 1);
    const std::vector<double> distortion(lens.parameters.begin() + 4, lens.parameters.end());
    Random random(7);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Vector3d point = random.Uniform(0.5, 50.0) *
                                    Direction(random.Uniform(0.0, fisheye ? 1.5 : 0.7), random.Uniform(0, 7));
      Eigen::Vector2d pixel;
      if (!Project(lens, point, &pixel)) continue;
      const std::vector<cv::Point3d> points{{point.x(), point.y(), point.z()}};
      std::vector<cv::Point2d> expected;
      const cv::Vec3d zero(0, 0, 0);
      if (fisheye) {
        cv::fisheye::projectPoints(points, expected, zero, zero, K, distortion);
      } else {
        cv::projectPoints(points, zero, zero, K, distortion, expected);
      }
      ASSERT_NEAR(pixel.x(), expected[0].x, 1e-8);
      ASSERT_NEAR(pixel.y(), expected[0].y, 1e-8);
      ++compared;
    }
  }
  EXPECT_GT(compared, 2700);
}

// Every pixel of the image, its corners and a margin, as far as the lens sees it.
TEST(CameraModel, PixelsComeBackFromTheirBearing) {
  for (std::size_t l = 0; l < Lenses().size(); ++l) {
    const CameraIntrinsics lens = Lenses()[l];
    int seen = 0, all = 0;
    for (int v = 0; v <= 40; ++v) {
      for (int u = 0; u <= 40; ++u) {
        const Eigen::Vector2d pixel(-0.5 + u * lens.width / 40.0, -0.5 + v * lens.height / 40.0);
        ++all;
        Eigen::Vector3d bearing;
        if (!Unproject(lens, pixel, &bearing)) continue;
        ++seen;
        EXPECT_NEAR(bearing.norm(), 1.0, 1e-14);
        Eigen::Vector2d back;
        ASSERT_TRUE(Project(lens, bearing, &back)) << "lens " << l << " pixel " << pixel.transpose();
        ASSERT_LT((back - pixel).norm(), 1e-7) << "lens " << l << " pixel " << pixel.transpose();
      }
    }
    EXPECT_EQ(seen, all) << "lens " << l;
  }
}

// Bearings over the whole domain, the last degree before its edge included.
TEST(CameraModel, BearingsComeBackFromTheirPixel) {
  for (std::size_t l = 0; l < Lenses().size(); ++l) {
    const CameraIntrinsics lens = Lenses()[l];
    const bool pinhole =
        lens.model == CameraModel::kPlumbBob || lens.model == CameraModel::kRationalPolynomial;
    for (int i = 0; i < 36; ++i) {
      const double phi = i * M_PI / 18.0;
      for (double theta = 0.0; theta < (pinhole ? 1.5 : 3.1); theta += 0.01) {
        const Eigen::Vector3d bearing = Direction(theta, phi);
        Eigen::Vector2d pixel;
        if (!Project(lens, bearing, &pixel)) break;
        Eigen::Vector3d back;
        ASSERT_TRUE(Unproject(lens, pixel, &back)) << "lens " << l << " theta " << theta;
        ASSERT_LT((back - bearing).norm(), 1e-6) << "lens " << l << " theta " << theta;
      }
    }
  }
}

TEST(CameraModel, MagnificationIsThatOfItsProjection) {
  int checked = 0;
  for (CameraIntrinsics lens : Lenses()) {
    const bool rational = lens.model == CameraModel::kRationalPolynomial;
    if (!rational && lens.model != CameraModel::kPlumbBob) continue;
    std::vector<double>& p = lens.parameters;
    p[6] = p[7] = 0.0;
    for (const double share : {0.1, 0.4, 0.6}) {
      const double radius = share * lens.width;
      Eigen::Vector3d bearing;
      ASSERT_TRUE(Unproject(lens, {p[2] + radius, p[3]}, &bearing));
      const double theta = std::atan2(bearing.x(), bearing.z());
      const auto projected = [&] {
        constexpr double kStep = 1e-4;
        Eigen::Vector2d inner, outer;
        EXPECT_TRUE(Project(lens, Direction(theta - kStep, 0.0), &inner));
        EXPECT_TRUE(Project(lens, Direction(theta + kStep, 0.0), &outer));
        return std::log((outer.x() - inner.x()) / (2.0 * kStep * p[0]));
      };
      const std::optional<Magnification> at = PinholeMagnification(p.data(), rational, radius);
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->log, projected(), 1e-6);
      for (int i = 0; i < ParameterCount(lens.model); ++i) {
        if (i == 6 || i == 7) continue;
        const double given = p[i], step = 2e-6 * std::max(1.0, std::abs(given));
        p[i] = given + step;
        const double more = projected();
        p[i] = given - step;
        const double less = projected();
        p[i] = given;
        EXPECT_NEAR(at->gradient[i], (more - less) / (2.0 * step), 1e-4 * (1.0 + std::abs(at->gradient[i])))
            << i << " at " << share;
        ++checked;
      }
    }
  }
  EXPECT_EQ(checked, 3 * (5 * 7 + 2 * 10));
}

// rho = f (r - 0.3 r^3) has its largest value, 0.7027 f, at r = 1.054.
TEST(CameraModel, MagnificationEndsWhereTheLensFoldsOver) {
  const double p[] = {500.0, 500.0, 320.0, 240.0, -0.3, 0.0, 0.0, 0.0, 0.0};
  ASSERT_TRUE(PinholeMagnification(p, false, 351.0));
  EXPECT_LT(PinholeMagnification(p, false, 351.0)->log, -1.5);
  EXPECT_FALSE(PinholeMagnification(p, false, 352.0));
}

TEST(CameraModel, JacobiansAgreeWithNumericOnes) {
  for (std::size_t l = 0; l < Lenses().size(); ++l) {
    const CameraIntrinsics lens = Lenses()[l];
    const bool pinhole =
        lens.model == CameraModel::kPlumbBob || lens.model == CameraModel::kRationalPolynomial;
    Random random(11);
    int checked = 0;
    for (int i = 0; i < 400; ++i) {
      // The first on the axis, the next close to it.
      const double theta = i == 0 ? 0.0 : i < 5 ? 1e-7 * i : random.Uniform(0.0, pinhole ? 1.3 : 1.9);
      const Eigen::Vector3d point = random.Uniform(0.5, 20.0) * Direction(theta, random.Uniform(0, 7));
      Eigen::Vector2d pixel, plus, minus;
      CameraPointJacobian J_point;
      CameraParameterJacobian J_parameters;
      if (!Project(lens, point, &pixel, &J_point, &J_parameters)) continue;
      ASSERT_EQ(J_parameters.cols(), ParameterCount(lens.model));
      bool inside = true;
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d h = 1e-6 * point.norm() * Eigen::Vector3d::Unit(c);
        inside = inside && Project(lens, point + h, &plus) && Project(lens, point - h, &minus);
        if (!inside) break;
        const Eigen::Vector2d numeric = (plus - minus) / (2.0 * h[c]);
        ASSERT_LT((numeric - J_point.col(c)).norm(),
                  2e-6 * (J_point.norm() + lens.parameters[0] / point.norm()))
            << "lens " << l << " theta " << theta << " column " << c;
      }
      if (!inside) continue;
      for (int c = 0; c < J_parameters.cols(); ++c) {
        CameraIntrinsics moved = lens;
        const double h = 1e-6 * std::max(1.0, std::abs(lens.parameters[c]));
        moved.parameters[c] += h;
        inside = inside && Project(moved, point, &plus);
        moved.parameters[c] -= 2.0 * h;
        inside = inside && Project(moved, point, &minus);
        if (!inside) break;
        const Eigen::Vector2d numeric = (plus - minus) / (2.0 * h);
        ASSERT_LT((numeric - J_parameters.col(c)).norm(), 1e-5 * (1.0 + J_parameters.col(c).norm()))
            << "lens " << l << " theta " << theta << " parameter " << c;
      }
      checked += inside;
    }
    EXPECT_GT(checked, 100) << "lens " << l;
  }
}

TEST(CameraModel, ProjectionKnowsDirectionsOnly) {
  for (const CameraIntrinsics& lens : Lenses()) {
    Eigen::Vector2d near, far;
    const Eigen::Vector3d bearing = Direction(0.6, 1.0);
    ASSERT_TRUE(Project(lens, bearing * 1e-3, &near));
    ASSERT_TRUE(Project(lens, bearing * 1e6, &far));
    EXPECT_LT((near - far).norm(), 1e-9);
  }
}

TEST(CameraModel, PinholeRefusesWhatIsBehind) {
  for (const CameraIntrinsics& lens : Lenses()) {
    Eigen::Vector2d pixel;
    const bool fisheye = lens.model == CameraModel::kEquidistant || lens.model == CameraModel::kDoubleSphere;
    EXPECT_EQ(Project(lens, {0.3, 0.1, 0.0}, &pixel), fisheye);
    if (!fisheye) {
      EXPECT_FALSE(Project(lens, {0.3, 0.1, -1.0}, &pixel));
      EXPECT_FALSE(Project(lens, {0.0, 0.0, 0.0}, &pixel));
    }
    EXPECT_FALSE(Project(lens, {0.0, 0.0, -1.0}, &pixel));
  }
}

// r (1 - 0.3 r^2) turns back at r = sqrt(1 / 0.9).
TEST(CameraModel, PlumbBobEndsWhereItsRadiusTurnsBack) {
  const CameraIntrinsics lens =
      Make(CameraModel::kPlumbBob, 640, 480, {300.0, 300.0, 319.5, 239.5, -0.3, 0.0, 0.0, 0.0, 0.0});
  const double edge = std::sqrt(1.0 / 0.9);
  Eigen::Vector2d pixel;
  Eigen::Vector3d bearing;
  EXPECT_TRUE(Project(lens, {edge - 1e-6, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(Project(lens, {edge + 1e-6, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(Project(lens, {3.0, 0.0, 1.0}, &pixel));
  const double edge_pixel = 300.0 * edge * (1.0 - 0.3 * edge * edge) + 319.5;
  EXPECT_TRUE(Unproject(lens, {edge_pixel - 1e-6, 239.5}, &bearing));
  EXPECT_NEAR(bearing.x() / bearing.z(), edge, 1e-3);
  EXPECT_FALSE(Unproject(lens, {edge_pixel + 1e-3, 239.5}, &bearing));
}

// A distortion that turns back at one radius and rises again beyond: only the inner part is the lens.
TEST(CameraModel, DistortionThatRisesAgainStaysOutside) {
  const CameraIntrinsics lens =
      Make(CameraModel::kPlumbBob, 640, 480, {300.0, 300.0, 319.5, 239.5, -0.4, 0.1, 0.0, 0.0, 0.0});
  // Slope 1 - 1.2 s + 0.5 s^2: no root, so monotonic; with k2 = 0.05 it has two.
  Eigen::Vector2d pixel;
  EXPECT_TRUE(Project(lens, {1.1, 0.0, 1.0}, &pixel));
  EXPECT_TRUE(Project(lens, {3.0, 0.0, 1.0}, &pixel));
  CameraIntrinsics folded = lens;
  folded.parameters[5] = 0.05;
  EXPECT_TRUE(Project(folded, {1.0, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(Project(folded, {1.3, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(Project(folded, {3.0, 0.0, 1.0}, &pixel));
}

TEST(CameraModel, RationalEndsAtThePoleOfItsDenominator) {
  const CameraIntrinsics lens = Make(CameraModel::kRationalPolynomial, 640, 480,
                                     {300.0, 300.0, 319.5, 239.5, 0.0, 0.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0});
  Eigen::Vector2d pixel;
  EXPECT_TRUE(Project(lens, {1.4, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(Project(lens, {1.42, 0.0, 1.0}, &pixel));
  EXPECT_FALSE(Project(lens, {5.0, 0.0, 1.0}, &pixel));
  Eigen::Vector3d bearing;
  ASSERT_TRUE(Unproject(lens, {319.5 + 300.0 * 30.0, 239.5}, &bearing));
  EXPECT_LT(bearing.x() / bearing.z(), std::sqrt(2.0));
}

TEST(CameraModel, EquidistantSeesBehindItself) {
  const CameraIntrinsics lens =
      Make(CameraModel::kEquidistant, 1280, 1280, {385.0, 385.0, 639.5, 639.5, 0.0, 0.0, 0.0, 0.0});
  for (const double degrees : {89.999, 90.0, 90.001, 95.0, 130.0, 179.0}) {
    const double theta = degrees * M_PI / 180.0;
    Eigen::Vector2d pixel;
    ASSERT_TRUE(Project(lens, 4.0 * Direction(theta, 0.5), &pixel));
    EXPECT_NEAR((pixel - Eigen::Vector2d(639.5, 639.5)).norm(), 385.0 * theta, 1e-9);
    Eigen::Vector3d bearing;
    ASSERT_TRUE(Unproject(lens, pixel, &bearing));
    EXPECT_LT((bearing - Direction(theta, 0.5)).norm(), 1e-12);
  }
  Eigen::Vector3d bearing;
  EXPECT_FALSE(Unproject(lens, {639.5 + 385.0 * 3.2, 639.5}, &bearing));
}

TEST(CameraModel, EquidistantEndsWhereItsRadiusTurnsBack) {
  const CameraIntrinsics lens =
      Make(CameraModel::kEquidistant, 1280, 1280, {385.0, 385.0, 639.5, 639.5, -0.1, 0.0, 0.0, 0.0});
  const double edge = std::sqrt(1.0 / 0.3);
  Eigen::Vector2d pixel;
  Eigen::Vector3d bearing;
  EXPECT_TRUE(Project(lens, Direction(edge - 1e-6, 1.0), &pixel));
  EXPECT_FALSE(Project(lens, Direction(edge + 1e-6, 1.0), &pixel));
  const double radius = 385.0 * edge * (1.0 - 0.1 * edge * edge);
  EXPECT_TRUE(Unproject(lens, {639.5 - radius + 1e-6, 639.5}, &bearing));
  EXPECT_NEAR(std::acos(bearing.z()), edge, 1e-3);
  EXPECT_FALSE(Unproject(lens, {639.5 - radius - 1e-3, 639.5}, &bearing));
}

TEST(CameraModel, DoubleSphereEndsAtItsOwnAngle) {
  const CameraIntrinsics lens =
      Make(CameraModel::kDoubleSphere, 512, 512, {156.7, 156.7, 254.9, 256.9, -0.174, 0.592});
  Eigen::Vector2d pixel, before(254.9, 256.9);
  double theta = 0.0, last = 0.0;
  for (; theta < M_PI && Project(lens, Direction(theta, 0.0), &pixel); theta += 0.001) {
    EXPECT_GE(pixel.x(), before.x());
    before = pixel;
    last = theta;
  }
  EXPECT_GT(last, 110.0 * M_PI / 180.0);
  Eigen::Vector3d bearing;
  EXPECT_FALSE(Unproject(lens, {before.x() + 5.0, 256.9}, &bearing));
}

TEST(CameraModel, WrongNumberOfParametersIsOurOwnError) {
  CameraIntrinsics lens = Lenses()[0];
  lens.parameters.pop_back();
  Eigen::Vector2d pixel;
  EXPECT_THROW(Project(lens, {0.0, 0.0, 1.0}, &pixel), InternalError);
}

TEST(IntrinsicsFromFieldOfView, EdgesSeeHalfTheFieldOfView) {
  struct Case {
    CameraModel model;
    double fov_deg;
  };
  for (const Case& c : {Case{CameraModel::kPlumbBob, 60.0}, Case{CameraModel::kRationalPolynomial, 120.0},
                        Case{CameraModel::kEquidistant, 190.0}, Case{CameraModel::kEquidistant, 260.0},
                        Case{CameraModel::kDoubleSphere, 90.0}, Case{CameraModel::kDoubleSphere, 190.0},
                        Case{CameraModel::kDoubleSphere, 260.0}}) {
    const CameraIntrinsics lens = IntrinsicsFromFieldOfView(c.model, 1280, 800, c.fov_deg);
    Eigen::Vector3d left, right;
    ASSERT_TRUE(Unproject(lens, {-0.5, 399.5}, &left)) << c.fov_deg;
    ASSERT_TRUE(Unproject(lens, {1279.5, 399.5}, &right)) << c.fov_deg;
    const double half = 0.5 * c.fov_deg * M_PI / 180.0;
    EXPECT_NEAR(std::atan2(-left.x(), left.z()), half, 1e-9);
    EXPECT_NEAR(std::atan2(right.x(), right.z()), half, 1e-9);
    EXPECT_EQ(lens.parameters[0], lens.parameters[1]);
  }
}

TEST(IntrinsicsFromFieldOfView, RefusesWhatTheModelCannotShow) {
  EXPECT_THROW(IntrinsicsFromFieldOfView(CameraModel::kPlumbBob, 640, 480, 170.0), InputError);
  EXPECT_THROW(IntrinsicsFromFieldOfView(CameraModel::kEquidistant, 640, 480, 261.0), InputError);
  EXPECT_THROW(IntrinsicsFromFieldOfView(CameraModel::kEquidistant, 640, 480, 0.0), InputError);
  EXPECT_THROW(IntrinsicsFromFieldOfView(CameraModel::kEquidistant, 0, 480, 90.0), InputError);
  EXPECT_THROW(IntrinsicsFromFieldOfView(CameraModel::kDoubleSphere, 640, 480, std::nan("")), InputError);
}

// Largest distance between the pixels of two lenses, over the directions up to `theta` from the axis.
double LargestDifference(const CameraIntrinsics& a, const CameraIntrinsics& b, double theta) {
  double largest = 0.0;
  for (int i = 1; i <= 20; ++i) {
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d direction = Direction(theta * i / 20, M_PI / 4 * k);
      Eigen::Vector2d of_a, of_b;
      EXPECT_TRUE(Project(a, direction, &of_a) && Project(b, direction, &of_b));
      largest = std::max(largest, (of_a - of_b).norm());
    }
  }
  return largest;
}

TEST(DoubleSphereTwin, ProjectsAlikeAndIsTheOthersTwin) {
  const CameraIntrinsics lens =
      Make(CameraModel::kDoubleSphere, 720, 720, {193.8, 193.4, 357.9, 364.1, -0.1812, 0.5921});
  const auto twin = DoubleSphereTwin(lens);
  ASSERT_TRUE(twin);
  EXPECT_GT(std::abs(twin->parameters[4] - lens.parameters[4]), 0.3);
  EXPECT_LT(LargestDifference(lens, *twin, 85.0 * M_PI / 180.0), 0.1);
  const auto back = DoubleSphereTwin(*twin);
  ASSERT_TRUE(back);
  for (std::size_t i = 0; i < lens.parameters.size(); ++i) {
    EXPECT_NEAR(back->parameters[i], lens.parameters[i], 0.03 * std::abs(lens.parameters[i]));
  }
}

// Either side of where a change of xi does not show to first order.
TEST(DoubleSphereTwin, TwinsMayLieNearEachOther) {
  const CameraIntrinsics lens =
      Make(CameraModel::kDoubleSphere, 640, 480, {216.4, 216.6, 337.7, 234.8, -0.0477, 0.5824});
  const auto twin = DoubleSphereTwin(lens);
  ASSERT_TRUE(twin);
  EXPECT_GT(twin->parameters[4], 0.0);
  EXPECT_LT(twin->parameters[4], 0.1);
  EXPECT_GT(twin->parameters[0], 225.0);
  EXPECT_LT(LargestDifference(lens, *twin, 75.0 * M_PI / 180.0), 0.02);
}

TEST(DoubleSphereTwin, LensesOfOtherXiProjectAlike) {
  const CameraIntrinsics unified =
      Make(CameraModel::kDoubleSphere, 720, 720, {230.0, 229.6, 357.9, 364.1, 0.0, 0.61});
  const auto lens = DoubleSphereOfXi(unified, -0.2);
  ASSERT_TRUE(lens);
  EXPECT_DOUBLE_EQ(lens->parameters[4], -0.2);
  EXPECT_LT(lens->parameters[0], 0.9 * unified.parameters[0]);
  EXPECT_LT(LargestDifference(unified, *lens, 85.0 * M_PI / 180.0), 0.5);
  EXPECT_FALSE(DoubleSphereOfXi(unified, -2.0));
}

}  // namespace
}  // namespace mlic::camera_model_test
