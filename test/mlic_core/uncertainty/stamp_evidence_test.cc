#include "mlic_core/uncertainty/stamp_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "mlic_core/common/random.h"

namespace mlic::stamp_evidence_test {
namespace {

constexpr double kNoise = 1e-4;  // s, of the time error of one image
constexpr int kImages = 60;

// Of images at 3 Hz over 20 s.
std::vector<double> Stamps() {
  std::vector<double> stamps;
  for (int k = 0; k < kImages; ++k) stamps.push_back(k / 3.0);
  return stamps;
}

// Of images that are too early by so much (s) beyond what `course` moves them by. Half of what each image
// shows is that of its neighbour, as points are seen by both, and the offset is not known.
std::vector<StampEvidence> Evidence(const std::vector<double>& shifts, const StampCourse& course,
                                    std::uint64_t seed) {
  Random random(seed);
  StampEvidence evidence;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * kImages, kImages);
  for (int k = 0; k < kImages; ++k) {
    rows(2 * k, k) = 1.0 / kNoise;
    rows(2 * k + 1, k) = 1.0 / kNoise;
    rows(2 * k + 1, (k + 1) % kImages) = -1.0 / kNoise;
  }
  Eigen::VectorXd late(kImages), noise(2 * kImages);
  for (int k = 0; k < kImages; ++k) late[k] = shifts[k] - course.At(Stamps()[k]);
  for (double& value : noise) value = random.Normal();
  const Eigen::VectorXd of_offset = rows * Eigen::VectorXd::Ones(kImages);
  const Eigen::MatrixXd held = rows - of_offset * (of_offset.transpose() * rows) / of_offset.squaredNorm();
  evidence.information = held.transpose() * held;
  evidence.gradient = held.transpose() * (rows * late + noise);
  evidence.coupling = of_offset.transpose() * rows;
  return {evidence};
}

std::vector<double> Shifts(const std::function<double(double)>& of_time) {
  std::vector<double> shifts;
  for (const double stamp : Stamps()) shifts.push_back(of_time(stamp));
  return shifts;
}

// Root mean square of a course about the shifts that it should have, less mean and slope.
double ErrorOf(const StampCourse& course, const std::vector<double>& shifts) {
  double mean = 0.0, slope = 0.0, moment = 0.0, square = 0.0;
  const double middle = 0.5 * (kImages - 1);
  for (int k = 0; k < kImages; ++k) {
    const double error = course.shifts[k] - shifts[k];
    mean += error / kImages;
    slope += (k - middle) * error;
    moment += (k - middle) * (k - middle);
  }
  for (int k = 0; k < kImages; ++k) {
    square += std::pow(course.shifts[k] - shifts[k] - mean - slope / moment * (k - middle), 2);
  }
  return std::sqrt(square / kImages);
}

TEST(StampEvidence, OfGoodStampsShowsNoCourse) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const StampCourse found =
        LikeliestCourse(Stamps(), {}, Evidence(Shifts([](double) { return 3e-5; }), {}, seed));
    EXPECT_TRUE(found.IsEmpty()) << seed;
  }
}

TEST(StampEvidence, ShowsASlowCourseThroughNoise) {
  const std::vector<double> shifts =
      Shifts([](double time) { return -5e-4 * std::cos(2.0 * M_PI * time / 10.0); });
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const StampCourse found = LikeliestCourse(Stamps(), {}, Evidence(shifts, {}, seed));
    ASSERT_FALSE(found.IsEmpty()) << seed;
    EXPECT_LT(ErrorOf(found, shifts), 0.7 * kNoise);
    EXPECT_NEAR(found.At(-1.0), found.shifts.front(), 1e-12);
  }
}

TEST(StampEvidence, ShowsWhatEachImageHasOfItsOwn) {
  Random random(5);
  const std::vector<double> shifts = Shifts([&](double) { return 1e-3 * random.Normal(); });
  const StampCourse found = LikeliestCourse(Stamps(), {}, Evidence(shifts, {}, 1));
  ASSERT_FALSE(found.IsEmpty());
  EXPECT_LT(ErrorOf(found, shifts), 1.1 * kNoise);
  EXPECT_GT(found.jitter, found.walk);
  // Found again where the stamps stand on it already.
  const StampCourse again = LikeliestCourse(Stamps(), found, Evidence(shifts, found, 1));
  EXPECT_LT(ErrorOf(again, found.shifts), 1e-2 * kNoise);
}

TEST(StampEvidence, CoursesErrorsAreNoneOfTheOffset) {
  Random random(5);
  const std::vector<double> shifts = Shifts([&](double) { return 1e-3 * random.Normal(); });
  const std::vector<StampEvidence> evidence = Evidence(shifts, {}, 1);
  const StampCourse found = LikeliestCourse(Stamps(), {}, evidence);
  // All images show the offset alike here: a course without mean leaves it as it is.
  const double offset_information = kImages / (kNoise * kNoise);
  EXPECT_LT(ScatterOfCourse(found, evidence)(0, 0), 1e-3 * offset_information);
}

TEST(StampEvidence, NeedsImages) { EXPECT_TRUE(EvidenceOfStamps({}, {}, {}).empty()); }

}  // namespace
}  // namespace mlic::stamp_evidence_test
