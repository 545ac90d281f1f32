#include "mlic_core/initialization/pose_fit.h"

#include <algorithm>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/problem/joint_solver.h"

namespace mlic {

RigidTransform PoseAt(const std::vector<TimedPose>& poses, double time) {
  const auto next = std::lower_bound(poses.begin(), poses.end(), time,
                                     [](const TimedPose& p, double t) { return p.time < t; });
  if (next == poses.begin()) return poses.front().pose;
  if (next == poses.end()) return poses.back().pose;
  const TimedPose& a = *(next - 1);
  const double share = (time - a.time) / (next->time - a.time);
  return {a.pose.rotation.slerp(share, next->pose.rotation),
          a.pose.translation + share * (next->pose.translation - a.pose.translation)};
}

SplitSpline SplineThrough(const std::vector<TimedPose>& poses, const UniformKnots& rotation_knots,
                          const UniformKnots& position_knots) {
  std::vector<Eigen::Quaterniond> rotations;
  std::vector<Eigen::Vector3d> positions;
  for (int j = 0; j < rotation_knots.count; ++j) {
    rotations.push_back(PoseAt(poses, rotation_knots.ControlPointTime(j)).rotation);
  }
  for (int j = 0; j < position_knots.count; ++j) {
    positions.push_back(PoseAt(poses, position_knots.ControlPointTime(j)).translation);
  }
  return {So3Spline(rotation_knots, rotations), PositionSpline(position_knots, positions)};
}

SplitSpline SplineThrough(const std::vector<TimedPose>& poses, const KnotSpacing& spacing) {
  const double half = 0.5 * MedianPeriod(poses);
  const double start = poses.front().time - half, end = poses.back().time + half;
  return SplineThrough(poses, UniformKnots::Covering(start, end, spacing.rotation),
                       UniformKnots::Covering(start, end, spacing.position));
}

DriveState FitToPoses(const Drive& drive, const ImuSigma& imu_sigma, const std::vector<TimedPose>& poses,
                      double sigma_rotation, double sigma_translation, DriveState start) {
  CalibrationState fit;
  fit.drives.push_back(std::move(start));
  Dataset one;
  one.drives.emplace_back();
  one.drives[0].epoch = drive.epoch;
  one.drives[0].imu = drive.imu;
  JointProblem problem;
  problem.dataset = &one;
  DriveTerms& terms = problem.drives.emplace_back();
  terms.imu_sigma = {imu_sigma};
  terms.poses = {poses, sigma_rotation, sigma_translation};
  Check(SolveJointProblem(problem, 6, CancellationToken(), &fit).solved,
        "the fit of the trajectory to poses has no solution");
  return fit.drives.front();
}

}  // namespace mlic
