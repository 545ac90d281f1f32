#include "mlic_ros/display/pause_gate.h"

#include <gtest/gtest.h>

#include <future>

namespace mlic::pause_gate_test {
namespace {

using std::chrono::milliseconds;

TEST(PauseGate, LetsThroughWhatIsNotPaused) {
  const CancellationToken token;
  PauseGate gate(token);
  gate.Wait();
  gate.Set(true);
  EXPECT_TRUE(gate.IsPaused());
  gate.Set(false);
  gate.Wait();
  EXPECT_FALSE(gate.IsPaused());
}

TEST(PauseGate, HoldsUntilItGoesOn) {
  const CancellationToken token;
  PauseGate gate(token);
  gate.Set(true);
  std::future<void> work = std::async(std::launch::async, [&] { gate.Wait(); });
  EXPECT_EQ(work.wait_for(milliseconds(150)), std::future_status::timeout);
  EXPECT_GT(gate.PausedSeconds(), 0.1);
  gate.Set(false);
  EXPECT_EQ(work.wait_for(milliseconds(10000)), std::future_status::ready);
  const double paused = gate.PausedSeconds();
  gate.Set(false);
  EXPECT_EQ(gate.PausedSeconds(), paused);
}

TEST(PauseGate, ACancelledPauseEnds) {
  CancellationToken token;
  PauseGate gate(token);
  gate.Set(true);
  std::future<void> work = std::async(std::launch::async, [&] { gate.Wait(); });
  token.Cancel();
  EXPECT_EQ(work.wait_for(milliseconds(10000)), std::future_status::ready);
}

}  // namespace
}  // namespace mlic::pause_gate_test
