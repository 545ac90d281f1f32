#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/problem/linearized_problem.h"

namespace mlic {

// Why the inverse of the information is too good a covariance for what cameras say, measured on the
// observations themselves. Two things are missing in it:
//
// - Landmarks are weighed by how well their own observations agree (LandmarkOptions::noise_of_each). An error
//   of the calibration makes observations disagree, and so takes weight from the very landmarks that would
//   show it. The loss (v + f) log(1 + s / v) of a landmark's squared residuals s (v: kPriorFreedom, f:
//   LandmarkFreedom) curves by 2 / (v + f) g g^T less than its weights say, g being the landmark's gradient:
//   three observations lose half of their information, ten a tenth.
// - Observations share errors: those of one landmark, those of the same seconds (trajectory, light, the
//   surfaces that happen to be in view), and those of one part of the image (lens, what patches look like
//   there). Each is measured by the scatter of the gradients' sums over such groups (Liang and Zeger,
//   Biometrika 1986), made larger by what the calibration follows of each group (Bell and McCaffrey, Survey
//   Methodology 2002); what each way has beyond single observations adds up (Cameron, Gelbach and Miller,
//   Journal of Business and Economic Statistics 2011). Groups are fewer than parameters, so that no matrix is
//   made of it: a camera's rotation, translation, time offset, readout and lens get one factor each, the mean
//   over their parameters, and never less than one. So do its rotation, translation and time offset to each
//   other sensor, which may be known far better than those to the IMU, by other observations.
//
// A third thing no observation shows: an error with a smooth pattern over the image, of which the lens model
// takes up what looks like a lens. It is as large as the pattern that it does not take up (ImagePattern), in
// any shape up to the third order, which is what lens models bend to.
struct CameraInflation {
  // Of two sensors, one of them a camera: a rotation, a translation or the difference of the time offsets.
  struct Relation {
    Eigen::MatrixXd directions;  // rows: by the calibration (Layout), as PairJacobian has them
    double growth;               // of its sigma as far as it is tracks'
  };

  Eigen::MatrixXd information;    // of the calibration (Layout): what observations of tracks add to it
  Eigen::MatrixXd self_weighing;  // what the first point takes of it
  Eigen::VectorXd growth;         // by the second, of each parameter's sigma as far as it is tracks'
  std::vector<Relation> relations;
  Eigen::MatrixXd pattern;             // covariance of the third's part in the calibration's gradient
  std::vector<double> pattern_errors;  // of each camera, px (ImagePattern::Rms)

  bool IsEmpty() const { return growth.size() == 0; }
};

// At a solution, with points of tracks and those on the map as they were solved (the latter are left out:
// what they have in common is in their noise). made_with: the options of the points of tracks, with a noise
// for each camera. covariance: of the calibration, all that the solve held taken as known. Empty without
// observations of tracks.
CameraInflation MeasureCameraInflation(const LinearizedProblem& linearized, const LandmarkOptions& made_with,
                                       const Eigen::MatrixXd& covariance);

// What the inflation adds to a covariance that was made as above. scale: of its variances, against those of
// the solve.
Eigen::MatrixXd VarianceOfInflation(const Eigen::MatrixXd& covariance, const CameraInflation& inflation,
                                    double scale);

// A line on each camera that it concerns.
std::vector<std::string> DescribeInflation(const CameraInflation& inflation, const Rig& rig,
                                           const CalibrationState& state);

}  // namespace mlic
