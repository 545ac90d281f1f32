// inspect_bag FILE.bag [--write-rig RIG.yaml [--urdf ROBOT.urdf]] [--rig RIG.yaml]: what a bag holds, a rig
// file drafted from it, and whether it will do for a calibration.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/ingest/imu_check.h"
#include "mlic_core/ingest/stamp_check.h"
#include "mlic_core/io/result/model_calibration.h"
#include "mlic_core/io/result/robot_model.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_ros/bag/bag_set.h"
#include "mlic_ros/bag/cloud_decoder.h"
#include "mlic_ros/bag/image_messages.h"
#include "mlic_ros/bag/image_reader.h"
#include "mlic_ros/bag/imu_messages.h"
#include "mlic_ros/bag/lidar_messages.h"
#include "mlic_ros/bag/message_reader.h"
#include "mlic_ros/bag/rig_draft.h"
#include "mlic_ros/programs/doctor.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

void PrintTopics(const BagSet& bags) {
  const double seconds = SecondsSince(bags.interval().begin, bags.interval().end);
  std::printf("%.3f s from %.3f, %zu drive(s)\n", seconds, 1e-9 * static_cast<double>(bags.interval().begin),
              bags.drives().size());
  std::printf("%-40s %-34s %9s %9s\n", "topic", "type", "messages", "Hz");
  for (const auto& [name, topic] : bags.topics()) {
    const double rate = seconds > 0.0 ? static_cast<double>(topic.messages - 1) / seconds : 0.0;
    std::printf("%-40s %-34s %9zu %9.2f\n", name.c_str(), topic.type.c_str(), topic.messages, rate);
  }
}

void PrintLidar(const BagSet& bags, const std::string& topic) {
  std::printf("\nLiDAR %s\n", topic.c_str());
  try {
    const std::vector<DecodedCloud> probe = ProbeLidar(bags, topic, bags.interval());
    if (!probe.empty()) std::printf("  fields: %s\n", probe.front().fields.c_str());
    const LidarFormat format = FindLidarFormat(probe, topic);
    std::printf("  frame %s, %zu points, a scan every %.4f s\n  %s\n", format.frame_id.c_str(),
                probe.front().positions.size(), format.scan_period, DescribeTimes(format).c_str());
  } catch (const InputError& error) {
    std::printf("  not usable: %s\n", error.what());
  }
  const MalformedClouds bad = CountMalformed(bags, topic, bags.interval());
  if (bad.malformed > 0) {
    std::printf("  %zu of %zu messages are malformed, calibrate leaves them out; the first: %s\n",
                bad.malformed, bad.messages, bad.first_fault.c_str());
  }
}

void PrintCamera(const BagSet& bags, const std::string& topic) {
  std::printf("\ncamera %s\n", topic.c_str());
  try {
    const ImageFormat format = ProbeCamera(bags, topic, bags.interval());
    std::printf("  frame %s, %d x %d, %s, %d bits\n", format.frame_id.c_str(), format.width, format.height,
                format.encoding.c_str(), format.bits);
  } catch (const InputError& error) {
    std::printf("  not usable: %s\n", error.what());
  }
}

void PrintImu(const BagSet& bags, const std::string& topic) {
  std::vector<StampedImu> samples;
  std::vector<MessageTimes> times;
  std::string frame;
  std::printf("\nIMU %s\n", topic.c_str());
  ReadEach(bags, topic, bags.interval(), [&](const SerializedMessage& message) {
    samples.push_back(DecodeImu(message, topic, frame));
    times.push_back({samples.back().stamp, samples.back().record});
    return true;
  });
  try {
    const StampReport report = CheckStamps(times);
    const ImuCounts counts = CleanImu(samples, topic);
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (const StampedImu& sample : samples)
      force += sample.specific_force / static_cast<double>(samples.size());
    std::printf("  frame %s, %.2f Hz by its stamps, mean specific force (%.2f, %.2f, %.2f) m/s^2\n",
                frame.c_str(), report.period > 0.0 ? 1.0 / report.period : 0.0, force.x(), force.y(),
                force.z());
    std::printf("  %zu not finite, %zu repeated, %zu out of order, %zu missing\n", counts.not_finite,
                counts.duplicates, report.out_of_order, report.missing);
    for (const std::string& warning : report.warnings) std::printf("  %s\n", warning.c_str());
  } catch (const InputError& error) {
    std::printf("  not usable: %s\n", error.what());
  }
}

// Status 2 where something failed.
int Doctor(const std::vector<std::filesystem::path>& files, const std::filesystem::path& rig_file) {
  const Rig rig = LoadRigFile(rig_file);
  const BagSet bags(files);
  PrintTopics(bags);
  const Findings findings = Diagnose(bags, rig, CancellationToken());
  const std::size_t failures = CountOf(findings, Grade::kFail), warnings = CountOf(findings, Grade::kWarn);
  std::printf("\n%s: %zu passed, %zu warnings, %zu failures\n",
              failures > 0   ? "FAIL"
              : warnings > 0 ? "WARN"
                             : "PASS",
              findings.size() - warnings - failures, warnings, failures);
  return failures > 0 ? kRefused : kTrusted;
}

// urdf: a robot's model that has the guesses; empty: none.
int Inspect(const std::vector<std::filesystem::path>& files, const std::filesystem::path& rig_file,
            const std::filesystem::path& urdf) {
  const BagSet bags(files);
  PrintTopics(bags);
  for (const auto& [name, topic] : bags.topics()) {
    if (IsLidarType(topic.type)) PrintLidar(bags, name);
    if (IsImageType(topic.type)) PrintCamera(bags, name);
    if (topic.type == "sensor_msgs/Imu") PrintImu(bags, name);
  }
  if (rig_file.empty()) return kTrusted;
  std::vector<std::string> notes;
  Rig rig = DraftRig(bags, notes);
  MakeFramesUnique(&rig, &notes);
  if (!urdf.empty()) TakeGuesses(RobotModel::Open(urdf), &rig, &notes);
  WriteRigFile(rig_file, rig);
  std::printf("\nwrote %s: %zu LiDAR(s), %zu camera(s); check names, topics and guesses\n", rig_file.c_str(),
              rig.lidars.size(), rig.cameras.size());
  for (const std::string& note : notes) std::printf("  %s\n", note.c_str());
  std::printf("next: inspect_bag --rig %s %s\n", rig_file.c_str(), files.front().c_str());
  return kTrusted;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  CLI::App app("What a bag holds, a rig file drafted from it, and whether it will do for a calibration",
               "inspect_bag");
  std::vector<std::filesystem::path> bags;
  std::string draft, rig, urdf;
  app.add_option("bag", bags, "ROS 1 bag; several are one recording")->required()->type_name("FILE");
  CLI::Option* write = app.add_option("--write-rig", draft, "rig file to write")->type_name("FILE");
  app.add_option("--urdf", urdf,
                 "robot's URDF: its fixed joints from the IMU give the guesses of --write-rig")
      ->needs(write)
      ->type_name("FILE");
  app.add_option("--rig", rig,
                 "rig file whose sensors are examined: PASS, WARN or FAIL for each check, and what to do")
      ->excludes(write)
      ->type_name("FILE");
  mlic::Describe(
      app,
      {{mlic::kTrusted, "told; with --rig: no check failed"}, {mlic::kRefused, "with --rig: a check failed"}},
      "rosrun mlic inspect_bag drive.bag --write-rig rig.yaml");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  return mlic::RunProgram("inspect_bag", [&] {
    return rig.empty() ? mlic::Inspect(bags, draft, urdf) : mlic::Doctor(bags, rig);
  });
}
