#pragma once

#include <string>

#include "mlic_core/io/report/rig_drawing.h"

namespace mlic {

// The rig from above and from its left side; turnable: with the place where rig_view.js draws it in three
// dimensions instead. Empty without sensors.
std::string RigFigure(const RigDrawing& drawing, bool turnable);

// The place where report.js writes the transforms about a frame and clock of choice. Empty without sensors.
std::string FrameChoice(const RigDrawing& drawing);

}  // namespace mlic
