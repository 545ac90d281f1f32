#pragma once

#include <string>

#include "mlic_core/io/report/rig_drawing.h"

namespace mlic {

// What the page's scripts work on, as JSON that is safe inside a script element: the root's frame, the
// sensors in it with guess, sigmas and outline, and the sigmas of pairs; numbers as in calibration.yaml.
std::string ReportData(const CalibrationResult& result, const RigDrawing& drawing);

}  // namespace mlic
