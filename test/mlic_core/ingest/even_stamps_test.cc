#include "mlic_core/ingest/even_stamps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"

namespace mlic::even_stamps_test {
namespace {

constexpr double kPeriod = 5.007e-3;  // s
constexpr double kDelay = 2e-3;       // s, that all stamps share
constexpr TimeNs kEpoch = 1'600'000'000'000'000'000;

// A hand that waves, measured at these times, with white noise, and stamped at others.
std::vector<StampedImu> Measured(const std::vector<double>& times, const std::vector<double>& stamps) {
  Random random(3);
  std::vector<StampedImu> samples;
  for (std::size_t k = 0; k < times.size(); ++k) {
    StampedImu sample;
    sample.stamp = sample.record = kEpoch + static_cast<TimeNs>(std::llround(1e9 * stamps[k]));
    for (int axis = 0; axis < 3; ++axis) {
      const double phase = 2.0 * M_PI * (2.0 + axis) * times[k] + axis;
      sample.angular_velocity[axis] = 0.7 * std::sin(phase) + 2e-3 * random.Normal();
      sample.specific_force[axis] = 3.0 * std::cos(phase) + 0.02 * random.Normal();
    }
    samples.push_back(sample);
  }
  return samples;
}

struct Arrival {
  std::vector<double> times, stamps;
};

// 20 s; a millisecond late at random, 30 ms of messages at once every 3 s; every 7 s a message is lost.
Arrival Arriving() {
  Random random(5);
  Arrival arrival;
  for (int k = 0; k < 4000; ++k) {
    const double time = k * kPeriod, in_turn = std::fmod(time, 3.0);
    if (k % 1400 == 700) continue;
    const double late = in_turn < 0.03 ? 0.03 - in_turn : 0.0;
    arrival.times.push_back(time);
    arrival.stamps.push_back(time + kDelay + late - 1e-3 * std::log(1.0 - random.Uniform()));
  }
  for (std::size_t k = 1; k < arrival.stamps.size(); ++k) {
    arrival.stamps[k] = std::max(arrival.stamps[k], arrival.stamps[k - 1] + 1e-5);
  }
  return arrival;
}

TEST(EvenStamps, StampsOfArrivalBecomeThoseOfTheDevice) {
  const Arrival arrival = Arriving();
  const auto even = FindEvenStamps(Measured(arrival.times, arrival.stamps));
  ASSERT_TRUE(even);
  std::vector<double> late;
  for (std::size_t k = 0; k < arrival.times.size(); ++k) {
    late.push_back(1e-9 * static_cast<double>(even->stamps[k] - kEpoch) - arrival.times[k]);
  }
  const double shared = Median(late);
  EXPECT_NEAR(shared, kDelay + 0.7e-3, 0.3e-3);
  for (const double of_sample : late) EXPECT_NEAR(of_sample, shared, 0.5e-3);
  EXPECT_GT(even->late, 1e-3);
  EXPECT_GT(even->latest, 25e-3);
}

TEST(EvenStamps, AClockThatDriftsIsFollowed) {
  Arrival arrival = Arriving();
  for (double& stamp : arrival.stamps) stamp += 1e-4 * stamp + 5e-6 * stamp * stamp;
  const auto even = FindEvenStamps(Measured(arrival.times, arrival.stamps));
  ASSERT_TRUE(even);
  const auto late = [&](std::size_t k) {
    const double time =
        arrival.times[k] + 1e-4 * arrival.times[k] + 5e-6 * arrival.times[k] * arrival.times[k];
    return 1e-9 * static_cast<double>(even->stamps[k] - kEpoch) - time;
  };
  EXPECT_NEAR(late(200), late(3800), 0.5e-3);
  EXPECT_NEAR(late(200), late(2000), 0.5e-3);
}

// A host that polls at uneven times, and says when it did.
TEST(EvenStamps, TrueStampsStayWhateverTheirSpacing) {
  const Arrival arrival = Arriving();
  EXPECT_FALSE(FindEvenStamps(Measured(arrival.stamps, arrival.stamps)));
}

TEST(EvenStamps, EvenStampsStay) {
  const Arrival arrival = Arriving();
  EXPECT_FALSE(FindEvenStamps(Measured(arrival.times, arrival.times)));
}

TEST(EvenStamps, WhereEveryTenthMessageIsLostStampsStay) {
  const Arrival all = Arriving();
  Random random(7);
  Arrival left;
  for (std::size_t k = 0; k < all.times.size(); ++k) {
    if (random.Uniform() < 0.1) continue;
    left.times.push_back(all.times[k]);
    left.stamps.push_back(all.stamps[k]);
  }
  EXPECT_FALSE(FindEvenStamps(Measured(left.times, left.stamps)));
}

}  // namespace
}  // namespace mlic::even_stamps_test
