#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// A point as a plane sees it.
struct PointAtPlane {
  Eigen::Vector2d position;  // in the plane, m
  double distance;           // from the plane along its normal, m
  double sigma;              // of the distance, m
};

// For each point, whether it lies where other surfaces meet the plane: in cells of the plane that hold points
// off it (by more than gate_sigmas of their noise), or beside such cells. Of what stands on a wall a part
// lies within the wall's gate, all of it on one side, and the more of it the noisier a LiDAR's points are:
// the wall would seem nearer to each LiDAR by another length, 1 to 3 mm at 2 cm of noise. Cells are as wide
// as the gate is thick (what crosses the plane at 45 deg or more leaves the gate in the next cell at the
// latest), and wide enough to be no more than the points. gate: its thickness, m.
std::vector<bool> FindMixed(const std::vector<PointAtPlane>& points, double gate_sigmas, double gate);

// For each point within the gate, whether it lies in relief or beside it: in cells whose points lie off the
// plane that most cells share by more than their mean is unsure and cells differ in. A window that lies 5 cm
// deeper than its wall is within the gate of a LiDAR of 2 cm noise, where one of 1 cm sees that it is none of
// the wall. The plane that most cells share has the least median of squares (Rousseeuw, J. Am. Stat. Assoc.
// 1984), so that less than half of them do not tilt it. gate: its thickness, m.
std::vector<bool> FindRelief(const std::vector<PointAtPlane>& points, double gate);

}  // namespace mlic
