#pragma once

#include "mlic_core/sensors/measurements.h"

namespace mlic {

// Joins scans that come faster than about 15 Hz to scans of 0.1 s: drivers that send the points in pieces
// (Livox up to 100 Hz, sectors of a turn) give scans that are too narrow and too few to be registered. As
// each point has its own time, nothing is lost. Points are thinned out again (scan_filter.h). A piece that
// lacks leaves a hole in its scan. Returns how many pieces make a scan: 1 where nothing was joined.
std::size_t JoinShortScans(LidarRecording* recording);

// How many scans that come `period` seconds after each other are joined to one; 1: none.
std::size_t PiecesOfScan(double period);

}  // namespace mlic
