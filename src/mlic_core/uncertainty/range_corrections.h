#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"

namespace mlic {

// m; larger errors of all ranges are no LiDAR's, but a trajectory's that is wrong, or foliage's. from: guard,
// three times what data sheets of LiDARs claim at worst
constexpr double kLargestRangeOffset = 0.1;

// Whether the state corrects the ranges of any LiDAR.
bool AnyRangeCorrected(const CalibrationState& state);

// How many corrections of rings, offsets and walks it has.
std::ptrdiff_t CountCorrections(const CalibrationState& state);

// Corrects what LiDARs' ranges err by (RangeCorrection), where the data confirm it, now or before. An offset:
// points on planes that are not level show more than three of its sigmas, and those that meet these planes
// steeply and the rest each predict the other better than no offset does; what depends on the incidence (wide
// beams, returns of foliage) is no error of ranges. Walks, with all offsets: those of two LiDARs differ by
// more than three sigmas; what planes themselves have of it is common to all, and as far as that makes walks
// and offsets unsure, LiDARs are taken to err as usual. Where narrow views let walks grow beyond what LiDARs
// err by, all are dropped for good: walks_dropped is kept from call to call.
// correlation: of the residuals (CorrelationFactor). True if it changed any by a tenth of a sigma.
bool CorrectRanges(const JointProblem& problem, double correlation, bool* walks_dropped,
                   CalibrationState* state);

// m, of each LiDAR: what is added to its ranges, and what it seems to need beyond, as far as that is
// confirmed as above. More than LiDARs err by shows that something else is wrong.
std::vector<double> ApparentOffsets(const JointProblem& problem, const CalibrationState& state,
                                    double correlation);

// What adds to the scatter of the gradient (ScatterOfPoints): the corrections' own errors; what uncorrected
// ranges may err by for all that the data say (draws of any size up to what LiDARs err by); walks that were
// dropped (CorrectRanges); and what points on level planes err by where that is shown, of all LiDARs or of
// one against another, which is no error of ranges and stays in: the calibration is as unsure as it would
// move without. correlation: as above.
Eigen::MatrixXd ScatterOfRanges(const JointProblem& problem, const CalibrationState& state,
                                double correlation, bool walks_dropped);

}  // namespace mlic
