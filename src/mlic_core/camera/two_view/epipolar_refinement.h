#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// p_b = R * p_a + t, with t a unit vector: two views do not show its length.
struct RelativePose {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
};

// The pose near `pose` with the least sum of squared epipolar errors (EpipolarError in two_view.h) over those
// matches that are used; over all five degrees of freedom.
// Own Gauss-Newton and not Ceres: 15 us for 66 us at 100 matches, 0.14 ms for 0.43 ms at 1000
// (small_fit_benchmark), and RANSAC asks for it at each better sample.
RelativePose RefineRelativePose(RelativePose pose, const std::vector<Eigen::Vector3d>& bearings_a,
                                const std::vector<Eigen::Vector3d>& bearings_b,
                                const std::vector<bool>& used);

}  // namespace mlic
