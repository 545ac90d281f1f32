#pragma once

#include <Eigen/Core>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/uncertainty/observability.h"

namespace mlic {

// The combinations of sensors' translations that the data do not show and the guesses give, as
// JointProblem::held_translations wants them. Where LiDARs share their map, what the motion does not show is
// one shift of all of them: it is held as a whole, and what the map shows between them stays as the data have
// it. So the eigenvectors of the sensors' joint covariance (from the data alone) are held, the largest first,
// until what remains shows every direction of each sensor to its limit. Of several guesses each counts by its
// weight along its own part. analysis: of the problem. docs/method.md, section 10.
std::vector<Eigen::VectorXd> UnobservableTranslations(const JointProblem& problem, const SensorOrder& order,
                                                      const ObservabilityAnalysis& analysis);

}  // namespace mlic
