// compare A.yaml B.yaml: by how many sigmas two calibrations differ. Exit statuses: 0 they agree, 2 they do
// not, others see program.h.
#include <cstdio>
#include <string>

#include "mlic_core/common/error.h"
#include "mlic_core/evaluation/calibration_difference.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

// sigmas; from: derivation, one in 150 pairs of good calibrations of a rig of ten sensors (100 numbers) has a
// difference beyond
constexpr double kDiffers = 4.0;

int Compare(const std::string& a, const std::string& b) {
  const CalibrationResult first = ReadCalibrationFile(a), second = ReadCalibrationFile(b);
  const CalibrationDifference difference = Subtract(first, second);
  if (difference.poses.sensors.empty() && difference.poses.pairs.empty()) {
    throw InputError(a + " and " + b + " have no sensor in common; sensors are matched by name");
  }
  const LargestDifference largest = LargestOf(difference);
  std::fputs(TableOf(difference).c_str(), stdout);
  if (largest.of.empty()) {
    throw InputError(a + " and " + b + " claim no sigmas: whether they agree cannot be said");
  }
  const bool agree = largest.sigmas <= kDiffers;
  std::printf("%s: worst %.1f sigma (%s), the limit is %.0f\n", agree ? "AGREE" : "DIFFER", largest.sigmas,
              largest.of.c_str(), kDiffers);
  return agree ? kTrusted : kRefused;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  CLI::App app("By how many sigmas two calibrations of a rig differ", "compare");
  std::string a, b;
  app.add_option("A", a, "a calibration.yaml")->required()->type_name("FILE");
  app.add_option("B", b, "another of the same sensors, of another drive")->required()->type_name("FILE");
  mlic::Describe(app, {{mlic::kTrusted, "they agree"}, {mlic::kRefused, "they do not"}},
                 "rosrun mlic compare monday/calibration.yaml friday/calibration.yaml");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  return mlic::RunProgram("compare", [&] { return mlic::Compare(a, b); });
}
