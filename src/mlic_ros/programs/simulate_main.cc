// rosrun mlic simulate: a drive with known truth. Writes DRIVE.bag, DRIVE_truth.yaml and DRIVE_rig.yaml.
// With --harp: photos of a calibration harp by each camera. Writes DIR/NAME/01.png and so on, and
// DIR/truth.yaml.

#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/trajectory_file.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/result/result.h"
#include "mlic_ros/bag/drive_bag_writer.h"
#include "mlic_ros/programs/program.h"
#include "mlic_sim/harp.h"
#include "mlic_sim/image_stage.h"
#include "mlic_sim/imu_simulator.h"
#include "mlic_sim/simulation.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string sensors;
  std::string scenario = "figure_eight";
  std::string output;
  double duration = 60.0;
  std::uint64_t seed = 1;
  std::string world = "of_scenario";
  std::uint64_t world_seed = 1;
  int moving = 0;
  std::string path, readings;
  double begin = 0.0;       // s
  double image_rate = 0.0;  // Hz; 0: as the sensors file has it
  bool no_guess = false;
  bool noise_free = false;
  bool harp = false;
  double rotation_error_deg = 4.81;
  double translation_error = 0.1;
};

CancellationToken& Cancellation() {
  static CancellationToken token;
  return token;
}

void AddOptions(CLI::App& app, Arguments& a) {
  app.option_defaults()->always_capture_default();
  const auto file = [&](const std::string& name, std::string& path, const std::string& what) {
    app.add_option(name, path, what)->required()->type_name("FILE");
  };
  const auto name = [&](const std::string& option, std::string& value, const std::string& what) {
    app.add_option(option, value, what)->type_name("NAME");
  };
  file("--sensors", a.sensors, "sensors file, such as config/simulation/paper_rig.yaml");
  name("--scenario", a.scenario,
       "figure_eight, handheld, handheld_tilted, straight, static, planar, circle or weaving");
  app.add_option("--duration", a.duration, "length of the drive")
      ->check(CLI::Range(0.5, 7200.0))
      ->type_name("SECONDS");
  app.add_option("--seed", a.seed, "motion, noise and errors of the guess follow from it")
      ->type_name("NUMBER");
  file("--output", a.output,
       "DRIVE.bag; DRIVE_truth.yaml and DRIVE_rig.yaml are written beside it. With --harp: a folder");
  name("--world", a.world,
       "yard, hall, street, car_park, corridor, slope or grove from --world-seed; of_scenario: the one yard "
       "or hall");
  app.add_option("--world-seed", a.world_seed, "layout, materials and clutter of --world follow from it")
      ->type_name("NUMBER");
  app.add_option("--moving", a.moving, "how many cars, people or doors move in --world")
      ->check(CLI::Range(0, 100))
      ->type_name("NUMBER");
  app.add_option(
         "--path", a.path,
         "recorded poses of the IMU, z up, 'seconds x y z qx qy qz qw' in each line: the motion, in place "
         "of the scenario's; the world is still the scenario's, a hall for handheld")
      ->type_name("FILE");
  app.add_option(
         "--readings", a.readings,
         "what the IMU read along --path, 'nanoseconds, rad/s about x, y, z, m/s^2 along x, y, z': in "
         "place of the simulated one, whose errors then mean nothing in the truth")
      ->type_name("FILE");
  app.add_option("--begin", a.begin, "where in --path the drive begins, since its first pose")
      ->check(CLI::NonNegativeNumber)
      ->type_name("SECONDS");
  app.add_option(
         "--image-rate", a.image_rate,
         "images per second of every camera, which take most of the time; 0: as the sensors file has it")
      ->check(CLI::NonNegativeNumber)
      ->type_name("HZ");
  app.add_flag(
      "--harp", a.harp,
      "no drive, but photos of straight bars by each camera, NAME/01.png and so on, for evaluate --harp");
  app.add_flag("--no-guess", a.no_guess, "the rig file gets no initial extrinsics");
  app.add_flag("--noise-free", a.noise_free, "exact measurements (biases, matrices and clock offsets stay)");
  app.add_option("--rotation-error-deg", a.rotation_error_deg, "error of the guessed rotations, deg")
      ->check(CLI::Range(0.0, 180.0))
      ->type_name("NUMBER");
  app.add_option("--translation-error", a.translation_error, "error of the guessed translations, m")
      ->check(CLI::NonNegativeNumber)
      ->type_name("NUMBER");
  Describe(app, {{kTrusted, "written"}, {kInterrupted, "interrupted"}},
           "rosrun mlic simulate --sensors config/simulation/handheld.yaml --scenario handheld "
           "--duration 30 --output drive.bag");
}

// Lines without seven numbers, such as titles, are left out.
std::vector<ImuSample> ReadReadings(const fs::path& path, TimeNs epoch) {
  std::istringstream lines(ReadFile(path));
  std::vector<ImuSample> readings;
  for (std::string line; std::getline(lines, line);) {
    long double time = 0.0;  // which holds nanoseconds of today's clock, also as 1.4E+018
    ImuSample s;
    Eigen::Vector3d &w = s.angular_velocity, &f = s.specific_force;
    if (std::sscanf(line.c_str(), "%Lf ,%lf ,%lf ,%lf ,%lf ,%lf ,%lf", &time, &w[0], &w[1], &w[2], &f[0],
                    &f[1], &f[2]) != 7) {
      continue;
    }
    s.time = SecondsSince(epoch, static_cast<TimeNs>(std::llroundl(time)));
    readings.push_back(s);
  }
  if (readings.empty()) {
    throw InputError(
        "--readings " + path.string() +
        ": no line of seven numbers separated by commas; expected nanoseconds, rates and forces");
  }
  return readings;
}

std::shared_ptr<const sim::RecordedMotion> ReadMotion(const Arguments& arguments) {
  if (arguments.path.empty()) {
    if (arguments.readings.empty()) return nullptr;
    throw InputError("--readings without --path; give the poses that the IMU had as well");
  }
  const std::vector<StampedPose> poses = ReadTrajectoryFile(arguments.path);
  const TimeNs epoch = poses.empty() ? 0 : poses.front().time;
  sim::RecordedMotion motion;
  for (const StampedPose& pose : poses) {
    motion.path.push_back({SecondsSince(epoch, pose.time), pose.pose});
  }
  if (!arguments.readings.empty()) motion.readings = ReadReadings(arguments.readings, epoch);
  return std::make_shared<sim::RecordedMotion>(sim::PartOf(motion, arguments.begin, arguments.duration));
}

// The truth as a calibration result: sigmas are zero.
CalibrationResult TrueResult(const sim::SensorSet& sensors, double duration) {
  CalibrationResult truth;
  truth.verdict = Verdict::kTrusted;
  truth.imu_frame_id = sensors.imu.frame_id;
  truth.imu = sensors.imu.calibration;
  truth.gravity = {0.0, 0.0, -sensors.imu.gravity};
  const auto add = [&](SensorResult sensor) {
    sensor.clock_reference = TimeFrom(sim::kSimulationEpoch, 0.5 * duration);
    for (const SensorResult& other : truth.sensors) {
      PairResult pair;
      pair.a = other.name;
      pair.b = sensor.name;
      pair.T_a_b = other.calibration.T_imu_sensor.Inverse() * sensor.calibration.T_imu_sensor;
      truth.pairs.push_back(pair);
    }
    truth.sensors.push_back(sensor);
  };
  for (const sim::SimulatedLidar& lidar : sensors.lidars) {
    SensorResult sensor;
    sensor.name = lidar.name;
    sensor.frame_id = lidar.frame_id;
    sensor.calibration = sim::AsTheImuSeesIt(sensors.imu, lidar.calibration);
    add(sensor);
  }
  for (const sim::SimulatedCamera& camera : sensors.cameras) {
    SensorResult sensor;
    sensor.name = camera.name;
    sensor.type = SensorResult::Type::kCamera;
    sensor.frame_id = camera.frame_id;
    sensor.calibration = sim::AsTheImuSeesIt(sensors.imu, camera.calibration);
    sensor.intrinsics = camera.intrinsics;
    if (camera.rolling_shutter) sensor.rolling_shutter_readout = camera.readout;
    add(sensor);
  }
  return truth;
}

// How far the simulation is, on stderr: one line that is written anew on a terminal, a line for each tenth
// elsewhere.
class ProgressLine {
 public:
  ProgressLine(double duration, std::size_t images)
      : duration_(duration), images_(images), terminal_(isatty(STDERR_FILENO) != 0) {}

  void Show(double time, int images) {
    const int tenth = static_cast<int>(10.0 * time / duration_);
    if (!terminal_ && tenth <= shown_) return;
    shown_ = tenth;
    std::fprintf(stderr, "%ssimulated %5.1f of %.1f s", terminal_ ? "\r" : "", time, duration_);
    if (images_ > 0) std::fprintf(stderr, ", %d of %zu images", images, images_);
    if (!terminal_) std::fputc('\n', stderr);
  }
  void End() const {
    if (terminal_) std::fputc('\n', stderr);
  }

 private:
  double duration_;  // s
  std::size_t images_;
  bool terminal_;
  int shown_ = 0;  // tenths
};

void WritePhotos(const sim::SimulatedCamera& camera, const Arguments& arguments, const fs::path& directory) {
  const sim::Harp harp(camera);
  for (std::size_t k = 0; k < harp.PhotoCount(); ++k) {
    Cancellation().ThrowIfCancelled();
    const std::string name = (k < 9 ? "0" : "") + std::to_string(k + 1) + ".png";
    std::vector<unsigned char> png;
    cv::imencode(".png", harp.Render(k, !arguments.noise_free, arguments.seed), png);
    WriteFileAtomically(directory / camera.name / name, std::string(png.begin(), png.end()));
  }
}

void RunHarp(const Arguments& arguments) {
  const sim::SensorSet sensors = sim::LoadSensorSet(arguments.sensors);
  if (sensors.cameras.empty()) throw InputError("--sensors " + arguments.sensors + ": has no camera");
  OutputDirectory output(arguments.output, "simulate");
  output.Replace([&](const fs::path& directory) {
    for (const sim::SimulatedCamera& camera : sensors.cameras) {
      WritePhotos(camera, arguments, directory);
      std::fprintf(stderr, "photos of %s\n", camera.name.c_str());
    }
    WriteCalibrationFile(directory / "truth.yaml", TrueResult(sensors, 0.0));
  });
  std::printf("wrote %s: a folder of photos for each camera, and truth.yaml\n", arguments.output.c_str());
}

void Run(const Arguments& arguments) {
  const fs::path bag = arguments.output;
  if (bag.extension() != ".bag") {
    throw InputError("--output " + bag.string() +
                     ": must end in .bag; the other files' names follow from it");
  }
  if (bag.has_parent_path() && !fs::is_directory(bag.parent_path())) {
    throw InputError("--output " + bag.string() + ": the directory " + bag.parent_path().string() +
                     " does not exist; make it first");
  }
  sim::SensorSet sensors = sim::LoadSensorSet(arguments.sensors);
  for (sim::SimulatedCamera& camera : sensors.cameras) {
    if (arguments.image_rate > 0.0) camera.rate = arguments.image_rate;
  }
  sim::SimulationOptions options;
  options.scenario = sim::ScenarioFromName(arguments.scenario);
  options.duration = arguments.duration;
  options.seed = arguments.seed;
  options.world = sim::WorldFamilyFromName(arguments.world);
  options.world_seed = arguments.world_seed;
  options.moving_objects = arguments.moving;
  options.with_noise = !arguments.noise_free;
  options.recorded = ReadMotion(arguments);
  sim::GuessOptions guess;
  guess.with_guess = !arguments.no_guess;
  guess.rotation_error_deg = arguments.rotation_error_deg;
  guess.translation_error = arguments.translation_error;
  guess.seed = arguments.seed;

  std::size_t images = 0;
  for (const sim::SimulatedCamera& camera : sensors.cameras) {
    images += sim::ImageTimes(camera, options.duration).size();
  }
  ProgressLine progress(options.duration, images);
  DriveBagWriter writer(bag, sensors, [&](double time, int written) { progress.Show(time, written); });
  sim::Simulate(sensors, options, writer, Cancellation());
  progress.End();
  writer.Finish();
  const fs::path stem = bag.parent_path() / bag.stem();
  WriteCalibrationFile(stem.string() + "_truth.yaml", TrueResult(sensors, arguments.duration));
  WriteRigFile(stem.string() + "_rig.yaml", sim::RigFromSensorSet(sensors, guess));
  std::printf("wrote %s, %s_truth.yaml and %s_rig.yaml\n", bag.c_str(), stem.c_str(), stem.c_str());
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  CLI::App app("Simulates a drive with known truth", "simulate");
  mlic::Arguments arguments;
  mlic::AddOptions(app, arguments);
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  for (int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int) { mlic::Cancellation().Cancel(); });
  }
  return mlic::RunProgram("simulate", [&] {
    arguments.harp ? mlic::RunHarp(arguments) : mlic::Run(arguments);
    return 0;
  });
}
