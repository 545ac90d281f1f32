#include "mlic_ros/programs/job_end.h"

#include <gtest/gtest.h>

#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::job_end_test {
namespace {

TEST(EndWithResult, SaysSigmasOfObservableAxesAndWhereThereAreNone) {
  CalibrationResult result = SampleResult();
  result.verdict = Verdict::kTrusted;
  const std::string shown = EndWithResult(result, "result").lines.front();
  EXPECT_EQ(shown.find("observable"), shown.find("unobservable") + 2) << shown;
  for (SensorResult& sensor : result.sensors) sensor.rotation_observable = {false, false, false};
  EXPECT_TRUE(Contains(EndWithResult(result, "result").lines.front(),
                       "worst sigma no IMU axis of rotation observable, "));
}

}  // namespace
}  // namespace mlic::job_end_test
