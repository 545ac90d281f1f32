#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mlic_core/io/result/exported_file.h"
#include "mlic_core/io/result/sensor_tree.h"
#include "mlic_core/result/result.h"

namespace mlic {

// A format that the program export writes.
struct ExportFormat {
  // What the poses are about. kNone: frames that the format itself says. kTree: any parent. kBesideModel:
  // likewise, without frames that the robot's model publishes. kRobot: likewise, or the model itself.
  enum class Place { kNone, kTree, kBesideModel, kRobot };

  std::string name;
  Place place = Place::kNone;
  bool several = false;  // files, in a directory
  std::string needs;     // of the calibration, where it may lack it
  // Empty where the calibration has nothing for it. The tree is that of TreeOf or TreeAbout.
  std::function<std::vector<ExportedFile>(const CalibrationResult&, const SensorTree&)> write;
};

const std::vector<ExportFormat>& ExportFormats();
// One of them.
const ExportFormat& ExportFormatNamed(const std::string& name);

}  // namespace mlic
