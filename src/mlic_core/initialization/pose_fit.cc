#include "mlic_core/initialization/pose_fit.h"

#include "mlic_core/common/error.h"
#include "mlic_core/problem/joint_solver.h"

namespace mlic {

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
  terms.imu_sigma = imu_sigma;
  terms.poses = {poses, sigma_rotation, sigma_translation};
  Check(SolveJointProblem(problem, 6, CancellationToken(), &fit).solved,
        "the fit of the trajectory to poses has no solution");
  return fit.drives.front();
}

}  // namespace mlic
