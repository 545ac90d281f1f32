#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/stamp_course.h"

namespace mlic {

// One camera's images in one drive.
struct ImageStamps {
  std::size_t drive = 0, camera = 0;
  std::vector<double> times;  // s, ascending
};

// What the joint problem says of the stamps of consecutive images, each by itself, when all else is free:
// trajectory, landmarks and calibration.
struct StampEvidence {
  std::size_t first = 0;        // of the images
  Eigen::MatrixXd information;  // 1/s^2
  Eigen::VectorXd gradient;     // 1/s, of the log-likelihood by how much later the images were taken
  Eigen::MatrixXd coupling;  // calibration x images, of the information, the calibration not yet eliminated
};

// The place of the image with that stamp.
std::size_t NearestImage(const std::vector<double>& times, double time);

// Of each of these cameras, with times as the landmarks' observations have them, in stretches of so many
// images as can be looked at together. Empty where the trajectory is held or the equations have no solution.
std::vector<std::vector<StampEvidence>> EvidenceOfStamps(const JointProblem& given,
                                                         const CalibrationState& state,
                                                         const std::vector<ImageStamps>& cameras);

// The likeliest course (StampCourse) of stamps that are off by a random walk and by what each image has of
// its own, docs/method.md, section 8.1: the variances of both by maximum likelihood, the shifts as their mean
// given the evidence; less mean and slope, which are offset and drift. stamps: the images' own; course: by
// what they were shifted where the evidence was taken, may be empty. Empty where the evidence speaks for a
// course by less than three sigmas.
StampCourse LikeliestCourse(const std::vector<double>& stamps, const StampCourse& course,
                            const std::vector<StampEvidence>& evidence);

// What the errors of such a course add to the scatter of the calibration's gradient: G C G^T, with the
// coupling G and the course's covariance C given the evidence. information of the calibration.
Eigen::MatrixXd ScatterOfCourse(const StampCourse& course, const std::vector<StampEvidence>& evidence);

}  // namespace mlic
