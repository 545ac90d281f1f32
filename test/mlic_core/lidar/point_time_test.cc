#include "mlic_core/lidar/point_time.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mlic_core/common/error.h"
#include "mlic_core/common/random.h"
#include "mlic_core/lidar/azimuth_time.h"

namespace mlic::point_time_test {
namespace {

using Reference = PointTimeFormat::Reference;
constexpr TimeNs kStamp = 1'700'000'000'123'456'789;
constexpr TimeNs kPeriod = 100'000'000;

// Ten scans; value(k) is the raw time of the first point of scan k, which spans `span` counts.
template <typename Value>
std::vector<PointTimeRange> Ranges(double span, const Value& value) {
  std::vector<PointTimeRange> ranges;
  for (int k = 0; k < 10; ++k) {
    ranges.push_back({kStamp + k * kPeriod, value(k), value(k) + span});
  }
  return ranges;
}

TEST(PointTime, FindsEveryUnitRelativeToTheStamp) {
  for (const double unit : {1.0, 1e-3, 1e-6, 1e-9}) {
    const auto ranges = Ranges(0.0998 / unit, [&](int) { return 1e-4 / unit; });
    const PointTimeFormat format = FindPointTimeFormat(ranges, 0.1, "topic /a");
    EXPECT_EQ(format.seconds_per_count, unit);
    EXPECT_EQ(format.reference, Reference::kStamp);
    EXPECT_NEAR(static_cast<double>(TimeBaseOf(format, ranges[3]).start - ranges[3].stamp), 1e5, 1.0);
  }
}

TEST(PointTime, NegativeTimesPutTheStampAtTheEndOfTheScan) {
  const auto ranges = Ranges(0.0999, [](int) { return -0.0999; });
  const PointTimeFormat format = FindPointTimeFormat(ranges, 0.1, "topic /a");
  EXPECT_EQ(format.reference, Reference::kStamp);
  EXPECT_NEAR(SecondsSince(ranges[0].stamp, TimeBaseOf(format, ranges[0]).start), -0.0999, 1e-9);
}

TEST(PointTime, FindsAbsoluteSecondsAndNanoseconds) {
  for (const double unit : {1.0, 1e-9}) {
    const auto absolute = [&](int k) { return static_cast<double>(kStamp + k * kPeriod) / (unit * 1e9); };
    const auto ranges = Ranges(0.0998 / unit, absolute);
    const PointTimeFormat format = FindPointTimeFormat(ranges, 0.1, "topic /a");
    EXPECT_EQ(format.seconds_per_count, unit);
    EXPECT_EQ(format.reference, Reference::kAbsolute);
    // A double of epoch seconds resolves 0.24 microseconds.
    EXPECT_NEAR(static_cast<double>(TimeBaseOf(format, ranges[7]).start - ranges[7].stamp), 0.0, 300.0);
  }
}

TEST(PointTime, TakesTheStampWhenValuesRunInAnotherClock) {
  const auto ranges = Ranges(0.0998, [](int k) { return 500.0 + 0.1 * k; });
  const PointTimeFormat format = FindPointTimeFormat(ranges, 0.1, "topic /a");
  EXPECT_EQ(format.reference, Reference::kOtherClock);
  EXPECT_EQ(TimeBaseOf(format, ranges[4]).start, ranges[4].stamp);
  EXPECT_NEAR(format.clock_difference, 500.0 - 1.7e9, 1.0);
}

TEST(PointTime, RefusesAUnitThatFitsNothing) {
  const auto ranges = Ranges(0.0998 * 1e8, [](int) { return 0.0; });  // tens of nanoseconds
  try {
    FindPointTimeFormat(ranges, 0.1, "topic /points, field 't'");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("topic /points, field 't'"), std::string::npos) << text;
    EXPECT_NE(text.find("9.98e+06"), std::string::npos) << text;
    EXPECT_NE(text.find("1e+08 (nanoseconds)"), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
  }
}

TEST(PointTime, RefusesAReferenceThatFitsNothing) {
  Random random(3);
  const auto ranges = Ranges(0.0998, [&](int) { return random.Uniform(10.0, 1000.0); });
  EXPECT_THROW(FindPointTimeFormat(ranges, 0.1, "topic /a"), InputError);
}

TEST(PointTime, ScansThatDoNotFitAreSeen) {
  const auto ranges = Ranges(0.0998, [](int) { return 0.0; });
  const PointTimeFormat format = FindPointTimeFormat(ranges, 0.1, "topic /a");
  EXPECT_TRUE(FitsFormat(format, ranges[0], 0.1));
  EXPECT_FALSE(FitsFormat(format, {kStamp, 0.0, 0.4}, 0.1));
  EXPECT_FALSE(FitsFormat(format, {kStamp, 7.0, 7.1}, 0.1));
}

TEST(PointTime, MedianPeriodIgnoresDuplicatesAndGaps) {
  std::vector<TimeNs> stamps;
  for (int k = 0; k < 30; ++k) {
    if (k != 11) stamps.push_back(kStamp + k * kPeriod);
    if (k == 5) stamps.push_back(kStamp + k * kPeriod);
  }
  EXPECT_DOUBLE_EQ(MedianPeriod(stamps), 0.1);
}

struct Revolution {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint16_t> rings;
  std::vector<double> times;
};

// A 16-ring revolution that starts at `start`, in order of rings or of firing, with a tenth of the points
// missing.
Revolution Spin(int direction, double start, bool ring_by_ring, double sweep = 2.0 * M_PI) {
  Revolution revolution;
  Random random(11);
  const int columns = 900, lasers = 16;
  for (int i = 0; i < columns * lasers; ++i) {
    const int ring = ring_by_ring ? i / columns : i % lasers;
    const int column = ring_by_ring ? i % columns : i / lasers;
    const double share = static_cast<double>(column) / columns;
    const double azimuth = start + direction * sweep * share;
    const double range = random.Uniform() < 0.1 ? 0.0 : random.Uniform(4.0, 30.0);
    revolution.points.emplace_back(range * std::cos(azimuth), range * std::sin(azimuth), 0.1 * ring * range);
    revolution.rings.push_back(static_cast<std::uint16_t>(ring));
    revolution.times.push_back(range > 0.0 ? 0.1 * share : 0.0);
  }
  return revolution;
}

void ExpectTimes(const Revolution& revolution, const std::vector<std::uint16_t>& rings, double tolerance) {
  const auto times = TimesFromAzimuth(revolution.points, rings, 0.1);
  ASSERT_TRUE(times.has_value());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < times->size(); ++i) {
    if (std::abs((*times)[i] - revolution.times[i]) > tolerance) ++wrong;
  }
  EXPECT_LE(wrong, times->size() / 200);
}

TEST(AzimuthTime, FollowsEitherDirectionFromAnyStart) {
  for (const int direction : {1, -1}) {
    for (const double start : {0.0, 3.1, -2.0}) {
      for (const bool ring_by_ring : {true, false}) {
        const Revolution revolution = Spin(direction, start, ring_by_ring);
        ExpectTimes(revolution, revolution.rings, 3e-4);
        ExpectTimes(revolution, {}, 3e-4);
      }
    }
  }
}

TEST(AzimuthTime, RingsWithoutTheirFirstReturnsKeepTheirTime) {
  Revolution revolution = Spin(-1, M_PI, true);
  for (int i = 0; i < 500; ++i) {
    revolution.points[i].setConstant(std::numeric_limits<float>::quiet_NaN());
    revolution.times[i] = 0.0;
  }
  ExpectTimes(revolution, revolution.rings, 3e-4);
}

TEST(AzimuthTime, RefusesWhatDoesNotSpin) {
  const Revolution raster = Spin(1, -1.0, true, 2.1);
  EXPECT_FALSE(TimesFromAzimuth(raster.points, raster.rings, 0.1).has_value());
  Random random(5);
  std::vector<Eigen::Vector3f> rosette(20000);
  for (auto& point : rosette) {
    const double azimuth = random.Uniform(-M_PI, M_PI);
    point = Eigen::Vector3d(5.0 * std::cos(azimuth), 5.0 * std::sin(azimuth), random.Normal()).cast<float>();
  }
  EXPECT_FALSE(TimesFromAzimuth(rosette, {}, 0.1).has_value());
  EXPECT_FALSE(TimesFromAzimuth({}, {}, 0.1).has_value());
}

}  // namespace
}  // namespace mlic::point_time_test
