#pragma once

#include <string>

#include "mlic_core/io/report/rig_drawing.h"
#include "mlic_core/result/result.h"

namespace mlic {

// How the calibration came about, HTML that needs nothing from outside. Empty where there is nothing to tell.

// By how much each sensor was moved from where the rig file has it.
std::string ChangeFromGuess(const RigDrawing& drawing);

// By how many sigmas each round of the joint adjustments moved the calibration.
std::string Convergence(const CalibrationResult& result);

// How the IMU turned and was accelerated in the first drive.
std::string Motion(const CalibrationResult& result);

// What the parts of the drive would have the IMU's biases by.
std::string BiasOverTime(const CalibrationResult& result);

// Command, version, inputs and options.
std::string HowItWasMade(const CalibrationResult& result);

}  // namespace mlic
