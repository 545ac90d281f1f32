// export --calibration C.yaml --format FORMAT [--parent FRAME] [--urdf ROBOT.urdf] [--velodyne FILE.yaml
// [--lidar NAME]] [--output FILE]: a calibration as another program reads it. Exit statuses see program.h.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/common/join.h"
#include "mlic_core/io/result/export_formats.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/result/result_file.h"
#include "mlic_core/io/result/robot_model.h"
#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/io/result/urdf_merge.h"
#include "mlic_core/io/result/velodyne_calibration.h"
#include "mlic_core/io/text_file.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  std::string format, parent, lidar;
  fs::path calibration, urdf, velodyne, output;
};

CalibrationResult ReadCalibration(const fs::path& path) {
  CalibrationResult calibration = ReadCalibrationFile(path);
  if (!calibration.Usable()) {
    throw InputError(path.string() + ": its verdict is refused, so there is nothing to export" +
                     (calibration.reasons.empty() ? "" : ": " + calibration.reasons.front()));
  }
  return calibration;
}

// The calibration about the parent that was asked for.
SensorTree TreeFor(const ExportOptions& options, const CalibrationResult& calibration,
                   const std::optional<RobotModel>& model) {
  if (options.parent.empty()) return TreeOf(calibration);
  if (const auto T_parent_root = RootInFrame(calibration, options.parent)) {
    return TreeAbout(calibration, FrameNamed(calibration, options.parent), *T_parent_root);
  }
  if (!model) {
    const SensorTree tree = TreeOf(calibration);
    std::vector<std::string> frames{tree.parent};
    for (const TreeFrame& frame : tree.frames) frames.push_back(frame.frame);
    throw InputError("--parent " + options.parent + ": the calibration has the frames " + Joined(frames) +
                     " only; give the robot's model by --urdf, which says where one of them is in " +
                     options.parent);
  }
  return TreeAbout(calibration, options.parent,
                   ModelPlacement(*model, calibration).InRoot(options.parent).Inverse());
}

// Leaves out what the model has: a frame that two publish has two parents.
void LeaveOutLinksOf(const RobotModel& model, SensorTree* tree) {
  const auto has = [&](const TreeFrame& frame) {
    if (!model.Has(frame.frame)) return false;
    std::fprintf(
        stderr,
        "export: %s is left out: the robot's model has the link %s; --format urdf with --urdf puts the "
        "calibration there\n",
        frame.name.c_str(), frame.frame.c_str());
    return true;
  };
  tree->frames.erase(std::remove_if(tree->frames.begin(), tree->frames.end(), has), tree->frames.end());
}

// The robot's own model with the calibration in it.
ExportedFile Merged(const ExportOptions& options, const CalibrationResult& calibration, RobotModel model) {
  const std::string parent = options.parent.empty() ? "" : FrameNamed(calibration, options.parent);
  const MergedFrames merged = MergeInto(calibration, parent, &model);
  std::fprintf(stderr, "export: %s stays where the model has it; updated: %s; appended: %s\n",
               merged.stayed.c_str(), merged.updated.empty() ? "none" : Joined(merged.updated).c_str(),
               merged.appended.empty() ? "none" : Joined(merged.appended).c_str());
  if (model.HasMoreInXacro() && !merged.appended.empty()) {
    std::fprintf(
        stderr,
        "export: %s has macros or includes, in which links are not looked for; where one of these has an "
        "appended link, expand it (xacro FILE > robot.urdf) and give that\n",
        options.urdf.c_str());
  }
  return {"", model.Text()};
}

// The LiDAR whose corrections are meant: the named one, or the only one that has any.
const SensorResult& CorrectedLidar(const ExportOptions& options, const CalibrationResult& calibration) {
  std::vector<std::string> names;
  const SensorResult* chosen = nullptr;
  for (const SensorResult& sensor : calibration.sensors) {
    if (!sensor.corrections.Any()) continue;
    names.push_back(sensor.name);
    if (options.lidar.empty() || options.lidar == sensor.name) chosen = &sensor;
  }
  if (chosen == nullptr) {
    throw InputError(options.calibration.string() + ": no corrections of " +
                     (options.lidar.empty() ? "any LiDAR" : options.lidar) +
                     (names.empty() ? "" : "; there are some of " + Joined(names)));
  }
  if (options.lidar.empty() && names.size() > 1)
    throw InputError("--velodyne: corrected are " + Joined(names) + "; say by --lidar whose file it is");
  return *chosen;
}

// The driver's own file with the corrections in it.
ExportedFile DriverFile(const ExportOptions& options) {
  const CalibrationResult calibration = ReadCalibration(options.calibration);
  const SensorResult& lidar = CorrectedLidar(options, calibration);
  return {"", WithCorrections(options.velodyne, lidar.name, lidar.corrections)};
}

std::vector<ExportedFile> FilesFor(const ExportOptions& options, const ExportFormat& format) {
  const CalibrationResult calibration = ReadCalibration(options.calibration);
  for (const std::string& note : FramesOf(calibration).notes)
    std::fprintf(stderr, "export: %s\n", note.c_str());
  std::optional<RobotModel> model;
  if (!options.urdf.empty()) model.emplace(RobotModel::Open(options.urdf));
  if (model && format.place == ExportFormat::Place::kRobot)
    return {Merged(options, calibration, std::move(*model))};
  SensorTree tree = TreeFor(options, calibration, model);
  if (model && format.place == ExportFormat::Place::kBesideModel) LeaveOutLinksOf(*model, &tree);
  return format.write(calibration, tree);
}

int Export(const ExportOptions& options) {
  const ExportFormat& format = ExportFormatNamed(options.format);
  if (!options.velodyne.empty() && options.format != "rings")
    throw InputError("--velodyne belongs to --format rings");
  if (!options.lidar.empty() && options.velodyne.empty()) throw InputError("--lidar belongs to --velodyne");
  if (format.place == ExportFormat::Place::kNone && !(options.parent.empty() && options.urdf.empty())) {
    throw InputError("--format " + options.format +
                     " has poses in frames of its own: leave out --parent and --urdf");
  }
  const bool several = format.several && options.velodyne.empty();
  if (several && options.output.empty()) {
    throw InputError("--format " + options.format + " has several files: give a directory by --output");
  }
  const std::vector<ExportedFile> files =
      options.velodyne.empty() ? FilesFor(options, format) : std::vector{DriverFile(options)};
  if (files.empty()) {
    throw InputError(options.calibration.string() + ": has no sensor that --format " + options.format +
                     " could hold: it needs " + format.needs);
  }
  for (const ExportedFile& file : files) {
    if (options.output.empty()) {
      std::fputs(file.text.c_str(), stdout);
    } else {
      WriteFileAtomically(several ? options.output / file.name : options.output, file.text);
    }
  }
  return kTrusted;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  CLI::App app("Writes a calibration as another program reads it; docs/exports.md says which file goes where",
               "export");
  mlic::ExportOptions options;
  std::string calibration, urdf, velodyne, output;
  std::vector<std::string> names;
  for (const mlic::ExportFormat& format : mlic::ExportFormats()) names.push_back(format.name);
  app.add_option("--calibration", calibration, "a calibration.yaml")->required()->type_name("FILE");
  app.add_option("--format", options.format, "what to write")->required()->check(CLI::IsMember(names));
  app.add_option("--parent", options.parent,
                 "the frame that the poses are in: a sensor's, or a link of --urdf; by default the IMU's")
      ->type_name("FRAME");
  app.add_option(
         "--urdf", urdf,
         "the robot's model: says where the IMU is in --parent, and with --format urdf is written with the "
         "calibration in it")
      ->type_name("FILE");
  app.add_option(
         "--velodyne", velodyne,
         "velodyne_pointcloud's calibration file of the LiDAR, which --format rings then writes with the "
         "corrections in it")
      ->type_name("FILE");
  app.add_option("--lidar", options.lidar, "of several corrected LiDARs the one of --velodyne")
      ->type_name("NAME");
  app.add_option("--output", output,
                 "file, or directory where the format has several; by default the terminal")
      ->type_name("PATH");
  mlic::Describe(app, {{mlic::kTrusted, "written"}},
                 "rosrun mlic export --calibration result/calibration.yaml --format tf2 --output tf.launch");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  options.calibration = calibration;
  options.urdf = urdf;
  options.velodyne = velodyne;
  options.output = output;
  return mlic::RunProgram("export", [&] { return mlic::Export(options); });
}
