// verify --calibration C.yaml|--urdf ROBOT.urdf --bag SHORT.bag [--bag MORE.bag]: whether a calibration is
// still right, and if not, which sensor moved and by how much. Exit statuses: 0 still right, 2 something
// moved, 4 nothing moved of what could be checked, others see program.h.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/evaluation/movements.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/inspection/imu_findings.h"
#include "mlic_core/inspection/rotation_findings.h"
#include "mlic_core/io/result/model_calibration.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/pipeline/calibrator.h"
#include "mlic_ros/bag/bag_loader.h"
#include "mlic_ros/bag/imu_messages.h"
#include "mlic_ros/bag/message_reader.h"
#include "mlic_ros/bag/rig_draft.h"
#include "mlic_ros/programs/evaluation_inputs.h"
#include "mlic_ros/programs/interrupt.h"
#include "mlic_ros/programs/program.h"
#include "mlic_ros/programs/thread_limit.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

// sigmas; from: derivation, of a rig of ten sensors (400 numbers of sensors and pairs) one check in 4000 is
// beyond by chance, and sigmas are good to some tenths
constexpr double kMoved = 5.0;

struct VerifyOptions {
  fs::path calibration, urdf, rig, output;
  std::vector<fs::path> bags;
  double start = -1.0;     // s; negative: the liveliest part; from: structural
  double duration = 20.0;  // s; 0: all. from: measured, half a minute of work for two cameras and a LiDAR
  int threads = 0;         // 0: one for each core; from: structural
  bool verbose = false;
};

// What the estimation says, on stderr where asked for.
class Lines : public CalibrationObserver {
 public:
  explicit Lines(bool shown) : shown_(shown) {}
  void OnMessage(const std::string& line) override {
    if (shown_) std::fprintf(stderr, "verify: %s\n", line.c_str());
  }

 private:
  bool shown_;
};

template <typename Config>
void StartAt(const SensorResult& sensor, Config* config) {
  config->guess = ExtrinsicGuess();
  config->guess->T_imu_sensor = sensor.calibration.T_imu_sensor;
  if (!std::isnan(sensor.sigma.time_offset)) config->time_offset = sensor.calibration.time_offset;
  config->fixed = false;
}

void StartCameraAt(const SensorResult& sensor, CameraConfig* config) {
  StartAt(sensor, config);
  config->model = sensor.intrinsics->model;
  config->intrinsics = sensor.intrinsics->parameters;
  config->shutter = sensor.rolling_shutter_readout ? Shutter::kRolling : Shutter::kGlobal;
}

// The sensors of both, where the calibration has them: what it says of them is a guess with the usual sigmas,
// so that it holds what the bag does not show and hardly anything else.
Rig AtCalibration(const Rig& rig, const CalibrationResult& calibration) {
  Rig start;
  start.imu = rig.imu;
  start.imu.intrinsics = ImuIntrinsicsModel::kBias;  // its matrices are the calibration's
  for (const SensorResult& sensor : calibration.sensors) {
    const auto take = [&](const auto& from, auto* to, const auto& start_at) {
      for (const auto& config : from) {
        if (config.name != sensor.name) continue;
        to->push_back(config);
        start_at(sensor, &to->back());
      }
    };
    if (sensor.type == SensorResult::Type::kLidar) {
      take(rig.lidars, &start.lidars, StartAt<LidarConfig>);
    } else {
      take(rig.cameras, &start.cameras, StartCameraAt);
    }
  }
  return start;
}

template <typename Config>
void TakeFrames(const std::vector<Config>& from, std::vector<Config>* to) {
  for (Config& config : *to) {
    for (const Config& other : from) {
      if (config.frame_id.empty() && other.topic == config.topic) config.frame_id = other.frame_id;
    }
  }
}

// The rig file, or what the bag shows of the rig; with the frames of the messages.
Rig GivenRig(const VerifyOptions& options, const BagSet& bags) {
  std::vector<std::string> notes;
  const Rig draft = DraftRig(bags, notes);
  if (options.rig.empty()) return draft;
  Rig rig = LoadRigFile(options.rig);
  if (rig.imu.frame_id.empty() && rig.imu.topic == draft.imu.topic) rig.imu.frame_id = draft.imu.frame_id;
  TakeFrames(draft.lidars, &rig.lidars);
  TakeFrames(draft.cameras, &rig.cameras);
  return rig;
}

// What a robot's model says of the bag's sensors; left_out: a line for each that it does not place.
CalibrationResult ReadModel(const VerifyOptions& options, std::vector<std::string>* left_out) {
  const BagSet bags(options.bags);
  CalibrationResult calibration =
      CalibrationOfModel(RobotModel::Open(options.urdf), GivenRig(options, bags), left_out);
  if (calibration.sensors.empty()) {
    throw InputError(options.urdf.string() +
                     ": nothing to verify: it places no sensor of the bag: " + Joined(*left_out));
  }
  std::fprintf(stderr, "verify: the poses of %s are taken as exact, time offsets are not compared\n",
               options.urdf.c_str());
  return calibration;
}

CalibrationResult ReadCalibration(const fs::path& path) {
  const CalibrationResult calibration = ReadCalibrationFile(path);
  if (calibration.sensors.empty()) {
    throw InputError(path.string() + ": gives no sensor to the IMU, so there is nothing to verify");
  }
  for (const SensorResult& sensor : calibration.sensors) {
    const bool camera = sensor.type == SensorResult::Type::kCamera;
    if (camera && !sensor.intrinsics) {
      throw InputError(path.string() + ": camera " + sensor.name + " has no intrinsics, which verify holds");
    }
  }
  return calibration;
}

// Where in the longest drive to look, s after the first message: recordings begin and end parked.
double LiveliestStart(const BagSet& bags, const std::string& imu_topic, double duration) {
  const auto longest =
      std::max_element(bags.drives().begin(), bags.drives().end(),
                       [](const auto& a, const auto& b) { return a.end - a.begin < b.end - b.begin; });
  const double before = SecondsSince(bags.interval().begin, longest->begin);
  if (duration <= 0.0 || SecondsSince(longest->begin, longest->end) <= duration) return before;
  std::vector<StampedImu> samples;
  const std::string topic = bags.NameInBag(imu_topic);
  std::string frame;
  ReadEach(bags, topic, *longest, [&](const SerializedMessage& message) {
    samples.push_back(DecodeImu(message, topic, frame));
    return true;
  });
  if (samples.size() < 4) return before;
  const std::vector<ImuSample> usable = UsableImu(std::move(samples)).samples;
  return usable.size() < 4 ? before : before + std::max(0.0, LiveliestStretch(usable, duration).start);
}

Rig RigOf(const VerifyOptions& options, const BagSet& bags, const CalibrationResult& calibration) {
  if (!options.urdf.empty()) return AtCalibration(GivenRig(options, bags), calibration);
  const Rig rig = options.rig.empty() ? RigOfCalibration(bags, calibration) : LoadRigFile(options.rig);
  return AtCalibration(rig, calibration);
}

CalibrationResult CalibrateAgain(const VerifyOptions& options, const CalibrationResult& calibration,
                                 const CancellationToken& cancellation) {
  LoadOptions load;
  load.rig_directory = options.rig.parent_path();
  Rig rig;
  {
    const BagSet bags(options.bags);
    rig = RigOf(options, bags, calibration);
    load.start = options.start >= 0.0 ? options.start : LiveliestStart(bags, rig.imu.topic, options.duration);
  }
  if (options.duration > 0.0) load.duration = options.duration;
  Lines lines(options.verbose);
  LoadReport report;
  const Dataset dataset = LoadDataset(rig, options.bags, load, report, cancellation, lines);
  for (const std::string& line : report.warnings) std::fprintf(stderr, "verify: %s\n", line.c_str());
  CalibrationOptions calibrate;
  calibrate.check_of = calibration;
  CalibrationResult check =
      Calibrate(WithMessageFrames(rig, report), dataset, cancellation, lines, nullptr, calibrate);
  for (const StageSummary& stage : check.stages) {
    char text[160];
    std::snprintf(text, sizeof(text), "time: %.1f s, processor %.1f s: %s", stage.seconds,
                  stage.processor_seconds, stage.name.c_str());
    lines.OnMessage(text);
  }
  return check;
}

// Sensors of the calibration that the check has no relation of; each with the reason, where there is one.
std::vector<std::string> NotChecked(const CalibrationResult& calibration, const CalibrationResult& check,
                                    const Movements& movements) {
  std::vector<std::string> lines;
  if (!check.root.empty()) lines.emplace_back("all to the IMU");
  for (const SensorResult& sensor : calibration.sensors) {
    const auto of_sensor = [&](const auto& other) { return other.name == sensor.name; };
    const auto found = std::find_if(movements.sensors.begin(), movements.sensors.end(), of_sensor);
    if (found != movements.sensors.end() && !found->against.empty()) continue;
    const auto rejected = std::find_if(check.rejected.begin(), check.rejected.end(), of_sensor);
    lines.push_back(sensor.name + (rejected == check.rejected.end() ? "" : " (" + rejected->reason + ")"));
  }
  return lines;
}

int Verify(const VerifyOptions& options, const CancellationToken& cancellation) {
  const ThreadLimit threads(options.threads);
  std::vector<std::string> left_out;
  const CalibrationResult calibration =
      options.urdf.empty() ? ReadCalibration(options.calibration) : ReadModel(options, &left_out);
  const CalibrationResult check = CalibrateAgain(options, calibration, cancellation);
  if (check.verdict == Verdict::kRefused) {
    std::printf("NOT CHECKED: the drive does not show the sensors' places: %s\n",
                Joined(check.reasons, "; ").c_str());
    return kPartial;
  }
  const Movements movements = FindMovements(check, calibration, kMoved);
  if (!options.output.empty()) WriteFileAtomically(options.output, CsvOf(movements));
  std::fputs(TableOf(movements).c_str(), stdout);
  std::printf("sigma: of calibration and check together; shown: what would have been told, %.0f sigmas\n",
              kMoved);
  for (const std::string& line : NotChecked(calibration, check, movements)) left_out.push_back(line);
  std::string not_checked = Joined(left_out);
  if (!not_checked.empty()) not_checked = "; not checked: " + not_checked;
  const std::string moved = WhatMoved(movements);
  if (!moved.empty()) {
    std::printf("MOVED: %s%s\n", moved.c_str(), not_checked.c_str());
    return kRefused;
  }
  const std::string worst = movements.worst_of.empty() ? "" : " (" + movements.worst_of + ")";
  std::printf("AGREES: worst %.1f sigma%s, the limit is %.0f%s\n", movements.worst, worst.c_str(), kMoved,
              not_checked.c_str());
  return not_checked.empty() ? kTrusted : kPartial;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  mlic::VerifyOptions options;
  CLI::App app("Whether a calibration is still right, from a short drive, and if not, which sensor moved",
               "verify");
  std::string calibration, urdf, rig, output;
  std::vector<std::string> bags;
  CLI::Option_group* of_what = app.add_option_group("of what", "one of them");
  of_what->add_option("--calibration", calibration, "the calibration.yaml in use")->type_name("FILE");
  of_what->add_option("--urdf", urdf, "the robot's model in place of it")->type_name("FILE");
  of_what->require_option(1);
  app.add_option("--bag", bags, "ROS 1 bag of the rig as it is now; give it again for more")
      ->required()
      ->type_name("FILE");
  app.add_option("--rig", rig,
                 "rig file that names the topics and masks; by default topics are found by their frames")
      ->type_name("FILE");
  app.add_option("--start", options.start,
                 "leave out the first seconds; by default the part of the drive that turns most is used")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS");
  app.add_option("--duration", options.duration, "use no more than this many seconds; 0: all")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS")
      ->capture_default_str();
  app.add_option("--output", output, "CSV file for the table")->type_name("FILE");
  app.add_option("--threads", options.threads, "threads to use; 0: one for each core")
      ->check(CLI::Range(0, 1024))
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_flag("--verbose", options.verbose, "show what the estimation finds, and the time that it takes");
  mlic::Describe(app,
                 {{mlic::kTrusted, "still right"},
                  {mlic::kRefused, "something moved; the last line says what and by how much"},
                  {mlic::kPartial, "nothing moved of what could be checked"},
                  {mlic::kInterrupted, "interrupted"}},
                 "rosrun mlic verify --calibration result/calibration.yaml --bag today.bag");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  options.calibration = calibration;
  options.urdf = urdf;
  options.rig = rig;
  options.output = output;
  options.bags.assign(bags.begin(), bags.end());
  const mlic::CancellationToken& cancellation = mlic::CancelOnSignals();
  return mlic::RunProgram("verify", [&] { return mlic::Verify(options, cancellation); });
}
