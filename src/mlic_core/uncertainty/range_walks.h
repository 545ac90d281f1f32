#pragma once

#include <Eigen/Core>
#include <cmath>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/uncertainty/range_errors.h"

namespace mlic {

// sigmas, which the error itself widens by the correlation that it gives residuals; from: derivation, 3 of
// 1000 normal errors lie beyond
inline constexpr double kFarFromZero = 3.0;
inline constexpr double kFlatness = 1e-3;  // m, of what counts as flat; from: guard, walls and their returns
// Larger errors are not corrected: m, and m for each power of ten; the latter are foliage's, whose depths go
// with its brightness. from: standard, the accuracy that data sheets of LiDARs claim is 1 to 3 cm
inline constexpr double kLargestError = 0.03;
// Sigma of what LiDARs' offsets err by, m, and their walks, m for each power of ten. from: standard, as the
// largest
inline constexpr double kUsualError = 0.01;

// What LiDARs' walks may err by, m for each power of ten: all together, and each beside that, as what kinds
// of points contradict each other in shows.
struct DoubtOfWalks {
  double common = 0.0;
  Eigen::VectorXd own;

  // Sigmas of walks beside what all share, with a share of that: LiDARs see relief from elsewhere, with other
  // beams and noise, which kinds of points need not show. Of a single LiDAR as `own`.
  Eigen::VectorXd Beside() const;

  // Sigma of one LiDAR's walk, and of the difference of two.
  double Of(std::size_t lidar) const { return std::hypot(common, own[static_cast<Eigen::Index>(lidar)]); }
  double OfDifference(std::size_t a, std::size_t b) const {
    return std::hypot(own[static_cast<Eigen::Index>(a)], own[static_cast<Eigen::Index>(b)]);
  }
};

// The largest over kinds of points: strong and weak echoes, near and far ones, on level planes and others.
// Planes' own relief need not go with the logarithm of their brightness, nor be the same for all kinds; nor
// is it the same to all LiDARs, as those of much noise take points for a plane's that lie deeper, in a
// window.
DoubtOfWalks MeasureDoubtOfWalks(const RangeEquations& equations, double correlation);

// What the planes show of LiDARs' walks: nothing, walks, or what is too large to be one.
enum class ShownWalks { kNone, kSome, kTooLarge };

// Of two LiDARs' difference, as both see what planes themselves have of it, and of each walk by itself, as
// far as it is told from that; either beyond its doubt.
ShownWalks FindWalks(const RangeEquations& equations, const DoubtOfWalks& doubt, double correlation);

// How all parameters follow when the walk of one LiDAR moves and the others' stay: a column for each.
Eigen::MatrixXd FollowingWalks(const RangeErrors& found);

// With what walks may err by, all else following.
Eigen::MatrixXd CovarianceWithDoubtOfWalks(const RangeErrors& found, const DoubtOfWalks& doubt,
                                           double correlation);

}  // namespace mlic
