#pragma once

#include <string>

#include "mlic_core/result/result.h"

namespace mlic {

// What the report shows of the cameras' residuals, HTML that needs nothing from outside.

// Mean reprojection errors by cells of the image as arrows, magnified by a factor that the caption states;
// the darker a cell, the more observations it has. width, height: of the image, px.
std::string ResidualFieldFigure(const ResidualSummary& residual, int width, int height,
                                const std::string& color);

// For each camera its residuals over the image, and the photo with tracks and errors where there is one;
// empty without cameras.
std::string CameraResiduals(const CalibrationResult& result);

}  // namespace mlic
