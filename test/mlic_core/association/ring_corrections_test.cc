#include "mlic_core/association/ring_corrections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/common/random.h"

namespace mlic::ring_corrections_test {
namespace {

constexpr int kRings = 32;
constexpr double kNoise = 0.003;  // m

// A LiDAR at rest, tilted, in a hall of 20 x 20 m, 2 m above its floor and 4 m below its ceiling.
CalibrationState AtRest() {
  CalibrationState state;
  state.lidars.resize(1);
  state.lidars[0].T_imu_sensor.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d(1.0, 2.0, 0.0).normalized()));
  const UniformKnots knots = UniformKnots::Covering(0.0, 1.0, 0.1);
  state.drives.resize(1);
  state.drives[0].trajectory = {
      So3Spline(knots, std::vector<Eigen::Quaterniond>(knots.count, Eigen::Quaterniond::Identity())),
      PositionSpline(knots, std::vector<Eigen::Vector3d>(knots.count, Eigen::Vector3d::Zero()))};
  return state;
}

double TrueElevation(int ring) { return -0.5 + 0.8 * ring / (kRings - 1.0); }

// What every ring does wrong, without what the corrections leave alone: a mean, and a slope of elevations.
RingCorrection ErrorOf(int ring) { return {ring % 3 == 0 ? 0.02f : -0.01f, ring % 2 == 0 ? 1e-3f : -1e-3f}; }

// Every sector of the hall's surfaces is a plane of its own.
// `ErrorsAt` says whether the rings err at an azimuth in degrees, in each of the two turns.
template <typename ErrorsAt>
DriveTerms Scan(const CalibrationState& state, const ErrorsAt& errors_at) {
  const Eigen::Matrix3d R = state.lidars[0].T_imu_sensor.rotation.toRotationMatrix();
  const std::vector<Plane> surfaces{{{0, 0, 1}, -2.0},   {{0, 0, -1}, -4.0}, {{1, 0, 0}, -10.0},
                                    {{-1, 0, 0}, -10.0}, {{0, 1, 0}, -10.0}, {{0, -1, 0}, -10.0}};
  constexpr int kSectors = 24;
  std::vector<std::vector<PlaneObservation>> tied(surfaces.size() * kSectors);
  Random random(4);
  for (int ring = 0; ring < kRings; ++ring) {
    for (int step = 0; step < 2 * 1440; ++step) {
      const double azimuth = 2.0 * M_PI * step / 1440.0, elevation = TrueElevation(ring);
      const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range = 1e9;
      std::size_t hit = 0;
      for (std::size_t s = 0; s < surfaces.size(); ++s) {
        const double facing = surfaces[s].normal.dot(R * beam);
        if (facing < -0.05 && surfaces[s].offset / facing < range) {
          range = surfaces[s].offset / facing;
          hit = s;
        }
      }
      PlaneObservation o{};
      const Eigen::Vector3f x = ((range + kNoise * random.Normal()) * beam).cast<float>();
      const RingCorrection error = ErrorOf(ring);
      o.position =
          errors_at(step / 1440, step % 1440 / 4) ? CorrectedPoint(x, {-error.range, -error.elevation}) : x;
      o.cos_incidence = static_cast<float>(-surfaces[hit].normal.dot(R * beam));
      o.sigma = 0.02f;
      o.ring = static_cast<std::uint16_t>(ring);
      o.time = step < 1440 ? 0.25 : 0.75;
      tied[hit * kSectors + kSectors * (step % 1440) / 1440].push_back(o);
    }
  }
  DriveTerms drive;
  PlaneAssociation& association = drive.planes;
  association.begin.push_back(0);
  for (std::size_t p = 0; p < tied.size(); ++p) {
    MapPlane plane;
    plane.plane = surfaces[p / kSectors];
    plane.center = plane.plane.normal * plane.plane.offset;
    association.planes.push_back(plane);
    association.observations.insert(association.observations.end(), tied[p].begin(), tied[p].end());
    association.begin.push_back(association.observations.size());
  }
  return drive;
}

bool Correct(const std::vector<DriveTerms>& drives, CalibrationState* state) {
  return CorrectRings(drives, 1.0, state);
}

const auto kAlways = [](int, int) { return true; };
const auto kNever = [](int, int) { return false; };

TEST(RingCorrections, AreWhatTheRingsDoWrong) {
  CalibrationState state = AtRest();
  ASSERT_TRUE(Correct({Scan(state, kAlways)}, &state));
  ASSERT_EQ(state.rings[0].size(), static_cast<std::size_t>(kRings));
  double mean = 0.0;
  for (int ring = 0; ring < kRings; ++ring) mean += ErrorOf(ring).range / kRings;
  for (int ring = 0; ring < kRings; ++ring) {
    EXPECT_NEAR(state.rings[0][ring].range, ErrorOf(ring).range - mean, 0.003) << ring;
    EXPECT_NEAR(state.rings[0][ring].elevation, ErrorOf(ring).elevation, 3e-4) << ring;
  }
  EXPECT_NEAR(TypicalCorrection(state.rings[0]).range, 0.0141, 0.001);
}

TEST(RingCorrections, AreNoneForNoiseNorWithoutRings) {
  CalibrationState state = AtRest();
  EXPECT_FALSE(Correct({Scan(state, kNever)}, &state));
  EXPECT_TRUE(state.rings[0].empty());
  DriveTerms without = Scan(state, kAlways);
  for (PlaneObservation& o : without.planes.observations) o.ring = 0;
  EXPECT_FALSE(Correct({without}, &state));
  EXPECT_TRUE(state.rings[0].empty());
}

// What the points say of the rings is as sure as it claims: where a plane is near, the noise of the ranges
// must not stand in the derivatives.
TEST(RingCorrections, AreJudgedByEquationsOfTheirNoise) {
  const CalibrationState state = AtRest();
  DriveTerms scan = Scan(state, kNever);
  for (PlaneObservation& o : scan.planes.observations) o.sigma = static_cast<float>(kNoise);
  const QuartersOfRings quarters = SumRings({scan}, state)[0];
  const Eigen::MatrixX2d trend = RingTrend(Eigen::VectorXd::LinSpaced(kRings, -0.5, 0.3));
  std::vector<RingEquations> parts;
  for (const RingSum& quarter : quarters) parts.push_back(WithoutTrend(quarter.equations, trend));
  EXPECT_NEAR(ScatterOfParts(parts, 2, Eigen::MatrixX2d::Zero(kRings, 2)), 1.0, 0.35);
}

TEST(RingCorrections, AreNoneWhereHalvesOfTheDriveOrOfTheViewDiffer) {
  CalibrationState state = AtRest();
  const auto first_turn = [](int turn, int) { return turn == 0; };
  EXPECT_FALSE(Correct({Scan(state, first_turn)}, &state));
  // This quarter lies on one side of where the view is cut in two.
  const auto one_side = [](int, int azimuth) { return azimuth >= 180 && azimuth < 270; };
  EXPECT_FALSE(Correct({Scan(state, one_side)}, &state));
}

// Millimetres count as well as centimetres do: what tells is that the halves agree.
TEST(RingCorrections, AreFoundBelowTheNoise) {
  CalibrationState state = AtRest();
  DriveTerms scan = Scan(state, kNever);
  for (PlaneObservation& o : scan.planes.observations) {
    o.position = CorrectedPoint(o.position, {o.ring % 2 == 0 ? 1e-3f : -1e-3f, 0.0f});
  }
  ASSERT_TRUE(Correct({scan}, &state));
  EXPECT_NEAR(TypicalCorrection(state.rings[0]).range, 1e-3, 1e-4);
  EXPECT_EQ(TypicalCorrection(state.rings[0]).elevation, 0.0f);
}

// As of wide beams on the ground: what rises and falls smoothly over the rings comes from what they see.
TEST(RingCorrections, AreNoneForWhatNeighboursShare) {
  CalibrationState state = AtRest();
  DriveTerms scan = Scan(state, kNever);
  for (PlaneObservation& o : scan.planes.observations) {
    const double x = 2.0 * o.ring / (kRings - 1.0) - 1.0;
    o.position = CorrectedPoint(o.position, {static_cast<float>(3e-3 * (1.5 * x * x - 0.5)), 0.0f});
  }
  EXPECT_FALSE(Correct({scan}, &state));
}

DriveTerms Corrected(DriveTerms scan, const RingCorrections& corrections) {
  for (PlaneObservation& o : scan.planes.observations) {
    o.position = CorrectedPoint(o.position, corrections[o.ring]);
  }
  return scan;
}

// Points that were too far off their planes to count take part once they are corrected.
TEST(RingCorrections, ComeToAnEnd) {
  CalibrationState state = AtRest();
  const DriveTerms scan = Scan(state, kAlways);
  ASSERT_TRUE(Correct({scan}, &state));
  const float range = state.rings[0][0].range;
  int rounds = 0;
  while (Correct({Corrected(scan, state.rings[0])}, &state)) ASSERT_LT(++rounds, 3);
  EXPECT_NEAR(state.rings[0][0].range, range, 5e-4);  // as sure as what points beyond the cut leave
}

// Points that are right without their corrections undo them.
TEST(RingCorrections, AreTakenBack) {
  CalibrationState state = AtRest();
  ASSERT_TRUE(Correct({Scan(state, kAlways)}, &state));
  ASSERT_TRUE(Correct({Corrected(Scan(state, kNever), state.rings[0])}, &state));
  EXPECT_TRUE(state.rings[0].empty());
  EXPECT_FALSE(Correct({Scan(state, kNever)}, &state));
}

TEST(RingCorrections, MoveAPointAlongItsBeamAndUpwards) {
  const Eigen::Vector3f x(3.0f, -4.0f, 2.0f);
  const Eigen::Vector3f moved = CorrectedPoint(x, {0.05f, 0.001f});
  EXPECT_NEAR(moved.norm(), x.norm() + 0.05f, 1e-4);
  EXPECT_NEAR(std::asin(moved.z() / moved.norm()) - std::asin(x.z() / x.norm()), 0.001, 1e-5);
  EXPECT_NEAR(std::atan2(moved.y(), moved.x()), std::atan2(x.y(), x.x()), 1e-6);
}

}  // namespace
}  // namespace mlic::ring_corrections_test
