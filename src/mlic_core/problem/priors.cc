#include "mlic_core/problem/priors.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/geometry/so3.h"
#include "mlic_core/sensors/bias_prior.h"
#include "mlic_core/sensors/imu_matrices.h"
#include "mlic_core/sensors/pinhole_model.h"

namespace mlic {
namespace {

void AddGuess(const ExtrinsicGuess& guess, const RigidTransform& T, int at, Eigen::MatrixXd* information,
              Eigen::VectorXd* gradient) {
  const Eigen::Vector3d rotation = Log(T.rotation * guess.T_imu_sensor.rotation.conjugate());
  const Eigen::Vector3d translation = T.translation - guess.T_imu_sensor.translation;
  for (int a = 0; a < 3; ++a) {
    const double rotation_weight = 1.0 / (guess.sigma_rotation[a] * guess.sigma_rotation[a]);
    const double translation_weight = 1.0 / (guess.sigma_translation[a] * guess.sigma_translation[a]);
    (*information)(at + a, at + a) = rotation_weight;
    (*information)(at + 3 + a, at + 3 + a) = translation_weight;
    (*gradient)[at + a] = rotation_weight * rotation[a];
    (*gradient)[at + 3 + a] = translation_weight * translation[a];
  }
}

// Of a camera's observations, the farthest from the centre of its image, px.
double SeenRadius(const JointProblem& problem, std::size_t camera, const Eigen::Vector2d& centre) {
  double farthest = 0.0;  // squared
  for (const DriveTerms& drive : problem.drives) {
    for (const LandmarkObservation& observation : drive.landmarks.observations) {
      if (observation.camera != static_cast<int>(camera)) continue;
      farthest = std::max(farthest, (observation.pixel - centre).squaredNorm());
    }
  }
  return std::sqrt(farthest);
}

// Numerator and denominator of the rational model trade along directions that no image shows: without a bound
// a step runs along them to where the model holds nowhere. Coefficients beyond one are large for any lens.
// Towards the edge of what they see noise would give them a fold or a pole: beyond the one nothing projects,
// so that no step may go on, and the corners of the image lie beyond both. So a lens magnifies as usual where
// it sees the corners, or the outermost of what it sees while its corners see nothing.
void AddDistortion(const JointProblem& problem, std::size_t camera, const CameraIntrinsics& intrinsics,
                   int at, Eigen::MatrixXd* information, Eigen::VectorXd* gradient) {
  if (intrinsics.model != CameraModel::kRationalPolynomial) return;
  for (std::size_t i = 4; i < intrinsics.parameters.size(); ++i) {
    const int row = at + static_cast<int>(i);
    (*information)(row, row) = 1.0;
    (*gradient)[row] = intrinsics.parameters[i];
  }
  // from: standard, root mean square of 21 published calibrations at the corners of their images
  constexpr double kUsualMagnification = 0.7;  // logarithm
  const double* const lens = intrinsics.parameters.data();
  const Eigen::Vector2d centre(lens[2], lens[3]);
  const Eigen::Vector2d corner = centre.cwiseAbs().cwiseMax(
      (Eigen::Vector2d(intrinsics.width - 1, intrinsics.height - 1) - centre).cwiseAbs());
  std::optional<Magnification> edge = PinholeMagnification(lens, true, corner.norm());
  if (!edge) edge = PinholeMagnification(lens, true, SeenRadius(problem, camera, centre));
  if (!edge) return;
  const auto count = static_cast<Eigen::Index>(intrinsics.parameters.size());
  const Eigen::VectorXd row = edge->gradient.head(count) / kUsualMagnification;
  information->block(at, at, count, count) += row * row.transpose();
  gradient->segment(at, count) += row * (edge->log / kUsualMagnification);
}

// Pixels are square to a thousandth, or those of anamorphic video.
void AddSquarePixels(const CameraIntrinsics& intrinsics, int at, Eigen::MatrixXd* information,
                     Eigen::VectorXd* gradient) {
  // from: measured, kitti_0005: focal lengths differ by 0.3 % without it.
  constexpr double kSquare = 1e-3;
  // from: standard, ITU-R BT.601: pixels of 10:11 and 59:54, the nearest to square, are 9 % off; half way.
  constexpr double kFarFromSquare = 0.045;
  const double difference = intrinsics.parameters[0] - intrinsics.parameters[1];
  if (std::abs(difference) > kFarFromSquare * intrinsics.parameters[0]) return;
  const double sigma = kSquare * intrinsics.parameters[0];
  const Eigen::Vector2d row(1.0 / sigma, -1.0 / sigma);
  information->block<2, 2>(at, at) += row * row.transpose();
  gradient->segment<2>(at) += row * (difference / sigma);
}

void AddUsualCentre(const CameraTerms& terms, const CameraIntrinsics& intrinsics, int at,
                    Eigen::MatrixXd* information, Eigen::VectorXd* gradient) {
  Eigen::Vector2d middle = 0.5 * Eigen::Vector2d(intrinsics.width - 1, intrinsics.height - 1);
  if (terms.given_intrinsics) middle = {(*terms.given_intrinsics)[2], (*terms.given_intrinsics)[3]};
  const double weight = 1.0 / (UsualCentreSigma(intrinsics) * UsualCentreSigma(intrinsics));
  for (int a = 0; a < 2; ++a) {
    (*information)(at + 2 + a, at + 2 + a) += weight;
    (*gradient)[at + 2 + a] += weight * (intrinsics.parameters[2 + a] - middle[a]);
  }
}

// About axes that the data show, the accelerometer's rotation is known to what soldered parts can be off by.
void AddImu(const ImuFreedom& imu, const CalibrationState& state, const Layout& layout,
            Eigen::MatrixXd* information, Eigen::VectorXd* gradient) {
  constexpr double kHeld = 1e-5;                  // rad; from: guard, far below what is not shown
  constexpr double kLoose = 10.0 * M_PI / 180.0;  // rad; from: guard, far above any misalignment
  const RotationAndTriangle accelerometer = SplitAccelerometerMatrix(state.accelerometer_matrix);
  const RotationAndTriangle gyroscope = SplitGyroscopeMatrix(state.gyroscope_matrix);
  Eigen::Matrix3d alignment = Eigen::Matrix3d::Identity() / (kHeld * kHeld);
  if (imu.alignment_sigma > 0.0) {
    const Eigen::Matrix3d others = Eigen::Matrix3d::Identity() - imu.alignment_shown;
    alignment =
        imu.alignment_shown / (kLoose * kLoose) + others / (imu.alignment_sigma * imu.alignment_sigma);
    gradient->segment<3>(layout.alignment) =
        alignment * Log(Eigen::Matrix3d(accelerometer.rotation * gyroscope.rotation.transpose()));
  }
  information->block<3, 3>(layout.alignment, layout.alignment) = alignment;
  constexpr double kHeldGravity = 1e-5;  // m/s^2; from: guard, far below any difference on the ground
  const double sigma = imu.gravity_sigma > 0.0 ? imu.gravity_sigma : kHeldGravity;
  (*information)(layout.gravity, layout.gravity) = 1.0 / (sigma * sigma);
  if (imu.gravity_sigma > 0.0) {
    (*gradient)[layout.gravity] = (state.gravity - kStandardGravity) / (sigma * sigma);
  }
  constexpr double kHeldLag = 1e-5;  // s; from: guard, far below what moves a lever arm
  const double lag_sigma = imu.lag_sigma > 0.0 ? imu.lag_sigma : kHeldLag;
  (*information)(layout.lag, layout.lag) = 1.0 / (lag_sigma * lag_sigma);
  if (imu.lag_sigma > 0.0) (*gradient)[layout.lag] = state.accelerometer_lag / (lag_sigma * lag_sigma);
  if (layout.matrices < 0) return;
  const double matrix_weight = 1.0 / (imu.matrix_sigma * imu.matrix_sigma);
  int at = layout.matrices;
  for (const Eigen::Matrix3d& triangle : {accelerometer.triangle, gyroscope.triangle}) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c, ++at) {
        (*information)(at, at) = matrix_weight;
        (*gradient)[at] = matrix_weight * (triangle(r, c) - (r == c ? 1.0 : 0.0));
      }
    }
  }
}

// The first is small, and each is near the one before.
void AddBiases(const BiasCourse& course, const BiasSteps& steps, int at, Eigen::MatrixXd* information,
               Eigen::VectorXd* gradient) {
  // from: derivation, of the sigmas.
  constexpr double kGyroscopeWeight = 1.0 / (kGyroscopeBiasSigma * kGyroscopeBiasSigma);
  // from: derivation, of the sigmas.
  constexpr double kAccelerometerWeight = 1.0 / (kAccelerometerBiasSigma * kAccelerometerBiasSigma);
  for (int a = 0; a < Layout::kOfBias; ++a) {
    const double weight = a < 3 ? kGyroscopeWeight : kAccelerometerWeight;
    (*information)(at + a, at + a) += weight;
    (*gradient)[at + a] += weight * course.knots[0][a];
    const double sigma = a < 3 ? steps.gyroscope : steps.accelerometer;
    for (int later = 1; later < static_cast<int>(course.knots.size()); ++later) {
      const int now = at + Layout::kOfBias * later + a, before = now - Layout::kOfBias;
      const double of_step = 1.0 / (sigma * sigma);
      const double step = course.knots[later][a] - course.knots[later - 1][a];
      (*information)(now, now) += of_step;
      (*information)(before, before) += of_step;
      (*information)(now, before) -= of_step;
      (*information)(before, now) -= of_step;
      (*gradient)[now] += of_step * step;
      (*gradient)[before] -= of_step * step;
    }
  }
}

}  // namespace

ImuFreedom FreedomOf(const ImuConfig& imu) {
  // Of the accelerometer's lag, s. from: derivation, low-passes of second order with cut-offs of 10 to 50 Hz
  // delay by 22 to 5 ms, and those of gyroscope and accelerometer need not be alike
  constexpr double kLagSigma = 10e-3;
  ImuFreedom freedom;
  freedom.alignment_sigma = imu.alignment_sigma;
  freedom.gravity_sigma = imu.gravity ? 0.0 : kGravitySigma;
  freedom.lag_sigma = kLagSigma;
  return freedom;
}

double UsualCentreSigma(const CameraIntrinsics& intrinsics) {
  // from: measured, calibrations of KITTI and EuRoC: up to 1.2 percent.
  constexpr double kShare = 0.015;  // of the image's width
  return kShare * intrinsics.width;
}

void CalibrationPrior(const JointProblem& problem, const CalibrationState& state, const Layout& layout,
                      Eigen::MatrixXd* information, Eigen::VectorXd* gradient) {
  *information = Eigen::MatrixXd::Zero(layout.calibration, layout.calibration);
  *gradient = Eigen::VectorXd::Zero(layout.calibration);
  for (std::size_t i = 0; i < state.lidars.size(); ++i) {
    const std::optional<ExtrinsicGuess>& guess = problem.lidars[i].guess;
    if (guess) AddGuess(*guess, state.lidars[i].T_imu_sensor, Layout::Lidar(i), information, gradient);
    const double sigma = problem.lidars[i].time_offset_sigma;
    if (sigma == 0.0) continue;
    const int offset = Layout::Lidar(i) + 6;
    (*information)(offset, offset) = 1.0 / (sigma * sigma);
    (*gradient)[offset] =
        (state.lidars[i].time_offset - problem.lidars[i].given_time_offset) / (sigma * sigma);
  }
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    const CameraTerms& terms = problem.cameras[c];
    if (terms.guess) {
      AddGuess(*terms.guess, state.cameras[c].sensor.T_imu_sensor, layout.Camera(c), information, gradient);
    }
    AddDistortion(problem, c, state.cameras[c].intrinsics, layout.Intrinsics(c), information, gradient);
    if (terms.fixed.square_pixels) {
      AddSquarePixels(state.cameras[c].intrinsics, layout.Intrinsics(c), information, gradient);
    }
    if (terms.fixed.usual_centre) {
      AddUsualCentre(terms, state.cameras[c].intrinsics, layout.Intrinsics(c), information, gradient);
    }
    if (layout.Readout(c) < 0) continue;
    // A rolling shutter takes between nothing and an image's period to read out.
    constexpr double kReadoutWeight = 1.0 / (0.05 * 0.05);  // from: derivation, an image's period at 20 Hz
    (*information)(layout.Readout(c), layout.Readout(c)) = kReadoutWeight;
    (*gradient)[layout.Readout(c)] = kReadoutWeight * state.cameras[c].readout;
  }
  for (std::size_t s = 0; s < layout.order.size(); ++s) {
    if (layout.drift[s] < 0) continue;
    // Crystals drift apart by so much; what drifts more is no crystal, and may do so by any amount.
    const double drift = *state.Sensor(layout.order.At(s)).clock_drift;
    const double weight = 1.0 / (kFastestCrystals * kFastestCrystals + drift * drift);
    (*information)(layout.drift[s], layout.drift[s]) = weight;
    (*gradient)[layout.drift[s]] = weight * drift;
  }
  AddImu(problem.imu, state, layout, information, gradient);
  // Biases are held with the trajectory, and then the problem does not say how they walk.
  if (problem.fix_trajectory) return;
  for (std::size_t d = 0; d < state.drives.size(); ++d) {
    const BiasCourse& course = state.drives[d].bias;
    const BiasSteps steps = course.IsConstant() ? BiasSteps() : problem.drives[d].bias_steps;
    AddBiases(course, steps, layout.Bias(d, 0), information, gradient);
  }
}

void AddHeldTranslations(const JointProblem& problem, const CalibrationState& state,
                         Eigen::MatrixXd* information, Eigen::VectorXd* gradient) {
  // A micrometre: 1e6 times less than what is held, and weak enough for double precision beside the rest.
  constexpr double kWeight = 1e12;  // 1 / m^2; from: structural
  const SensorOrder order = state.Sensors();
  for (const Eigen::VectorXd& row : problem.held_translations) {
    double off = 0.0;  // m
    for (std::size_t s = 0; s < order.size(); ++s) {
      const std::optional<ExtrinsicGuess>& guess = GuessOf(order.At(s), problem);
      if (!guess) continue;
      off += row.segment<3>(Layout::Sensor(s) + 3)
                 .dot(state.Sensor(order.At(s)).T_imu_sensor.translation - guess->T_imu_sensor.translation);
    }
    information->topLeftCorner(row.size(), row.size()) += kWeight * row * row.transpose();
    gradient->head(row.size()) += kWeight * off * row;
  }
}

}  // namespace mlic
