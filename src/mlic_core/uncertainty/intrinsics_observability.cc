#include "mlic_core/uncertainty/intrinsics_observability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mlic_core/problem/inverse_in_limits.h"
#include "mlic_core/problem/priors.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

constexpr double kUsualTangential = 1e-3;  // of lenses; from: standard, as UsualSize
constexpr int kTangential[] = {6, 7};      // places of the tangential terms; from: structural
constexpr int kCentre = 2;                 // its first place; from: structural
// from: measured, kitti_0005 is above, simulated drives at 1e-4.
constexpr double kUncertainRatio = 5e-4;  // sigma of fy / fx

bool IsTangential(CameraModel model, int parameter) {
  return (model == CameraModel::kPlumbBob || model == CameraModel::kRationalPolynomial) &&
         (parameter == kTangential[0] || parameter == kTangential[1]);
}

// Terms of the rational model act together only: what one of them does, others undo, and where one stays
// behind, the focal length bends to what it should be. Their usual size, a prior (CalibrationPrior), bounds
// them.
bool ActsTogetherOnly(CameraModel model, int parameter) {
  return model == CameraModel::kRationalPolynomial && parameter >= 4 && !IsTangential(model, parameter);
}

// Of a term of the distortion, from nothing but that it is a lens's: docs/cameras.md. from: standard, the
// root mean squares of published calibrations
double UsualSize(CameraModel model, int parameter) {
  constexpr double kPlumbBob[] = {0.2, 0.24, kUsualTangential, kUsualTangential, 0.24};
  constexpr double kEquidistant[] = {0.04, 0.03, 0.03, 0.017};
  constexpr double kDoubleSphere[] = {0.2, 0.1};
  const int term = parameter - 4;
  switch (model) {
    case CameraModel::kPlumbBob:
      return kPlumbBob[term];
    case CameraModel::kRationalPolynomial:
      return IsTangential(model, parameter) ? kUsualTangential : 1.0;
    case CameraModel::kEquidistant:
      return kEquidistant[term];
    case CameraModel::kDoubleSphere:
      return kDoubleSphere[term];
  }
  return 0.0;
}

bool IsCentre(int parameter) { return parameter == kCentre || parameter == kCentre + 1; }

// The order in which parameters are given up: the highest rank first.
int Rank(CameraModel model, int parameter) {
  if (parameter < 4) return parameter < 2 ? 0 : 1;  // focal lengths, centre
  const int i = parameter - 4;
  switch (model) {
    case CameraModel::kPlumbBob: {
      constexpr int kRanks[] = {2, 3, 4, 4, 5};  // from: structural
      return kRanks[i];
    }
    case CameraModel::kRationalPolynomial:
      return 2;  // the tangential terms: the others are not given up
    case CameraModel::kEquidistant:
      return 2 + i;
    case CameraModel::kDoubleSphere:
      return 3 - i;  // xi before alpha
  }
  return 0;
}

// One of a grid over the image.
struct ImagePoint {
  Eigen::Vector2d pixel;
  Eigen::Vector3d bearing;
  CameraParameterJacobian J;  // of the pixel to the lens's parameters
};

std::vector<ImagePoint> ImageGrid(const CameraIntrinsics& intrinsics) {
  constexpr int kGrid = 20;  // from: structural
  std::vector<ImagePoint> points;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    ImagePoint point;
    point.pixel = {(i % kGrid + 0.5) / kGrid * intrinsics.width - 0.5,
                   (i / kGrid + 0.5) / kGrid * intrinsics.height - 0.5};
    CameraPointJacobian J_point;
    if (!Unproject(intrinsics, point.pixel, &point.bearing) ||
        !Project(intrinsics, point.bearing, &point.pixel, &J_point, &point.J))
      continue;
    points.push_back(point);
  }
  return points;
}

// px, in the mean over the image, to first order.
double MeanDisplacement(const std::vector<ImagePoint>& points, const Eigen::VectorXd& change) {
  double sum = 0.0;
  for (const ImagePoint& point : points) sum += (point.J * change).norm();
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

// px, by which the image moves in the mean where the lens changes by so much, either way: along a combination
// of parameters that undo each other, a change can be far larger than first order bears. Infinite where less
// than half of the image is left.
double MeanDisplacementOf(const CameraIntrinsics& intrinsics, const std::vector<ImagePoint>& points,
                          const Eigen::VectorXd& change) {
  double largest = MeanDisplacement(points, change);
  for (const double sign : {-1.0, 1.0}) {
    CameraIntrinsics changed = intrinsics;
    for (int i = 0; i < change.size(); ++i) changed.parameters[i] += sign * change[i];
    double sum = 0.0;
    std::size_t count = 0;
    for (const ImagePoint& point : points) {
      Eigen::Vector2d pixel;
      if (!Project(changed, point.bearing, &pixel)) continue;
      sum += (pixel - point.pixel).norm();
      ++count;
    }
    if (2 * count < points.size()) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, sum / static_cast<double>(std::max<std::size_t>(1, count)));
  }
  return largest;
}

// The parameter that the data do not determine and that comes next; -1 if there is none. sensitivity: of this
// camera (PatternSensitivity).
int NextFixed(const CameraIntrinsics& intrinsics, const std::vector<ImagePoint>& image,
              const Eigen::MatrixXd& covariance, const FixedCameraParameters& fixed, double sensitivity,
              double limit) {
  const std::vector<bool>& held = fixed.intrinsics;
  int next = -1, highest = -1;
  double largest = 0.0;
  for (int i = 0; i < covariance.rows(); ++i) {
    if (held[i] || ActsTogetherOnly(intrinsics.model, i) || (fixed.usual_centre && IsCentre(i))) continue;
    const int rank = Rank(intrinsics.model, i);
    if (rank < highest) continue;
    const double sigma = std::sqrt(std::max(1e-300, covariance(i, i)));
    Eigen::VectorXd change = covariance.col(i) / sigma;
    for (int k = 0; k < change.size(); ++k) {
      if (ActsTogetherOnly(intrinsics.model, k)) change[k] = 0.0;
    }
    double excess = MeanDisplacementOf(intrinsics, image, change) / limit;
    if (IsTangential(intrinsics.model, i)) {
      excess = std::max(excess, kPatternError * sensitivity * sigma / kUsualTangential);
    }
    if (excess <= 1.0 || (rank == highest && excess <= largest)) continue;
    next = i;
    highest = rank;
    largest = excess;
  }
  return next;
}

// covariance: of the camera's intrinsics.
bool IsRatioUncertain(const CameraIntrinsics& intrinsics, const Eigen::MatrixXd& covariance,
                      const std::vector<bool>& held) {
  const double variance = covariance(0, 0) - 2.0 * covariance(0, 1) + covariance(1, 1);
  return !held[0] && !held[1] && std::sqrt(variance) > kUncertainRatio * intrinsics.parameters[0];
}

// Where all that is held stands in the vector of calibration parameters.
std::vector<int> HeldPlaces(const Layout& layout, const std::vector<FixedCameraParameters>& held) {
  std::vector<int> places;
  for (std::size_t c = 0; c < held.size(); ++c) {
    for (int i = 0; i < 7; ++i) {
      const bool is_held = i < 3 ? held[c].rotation : i < 6 ? held[c].translation : held[c].time_offset;
      if (is_held) places.push_back(layout.Camera(c) + i);
    }
    if (held[c].time_offset && layout.Drift(CameraId(c)) >= 0) places.push_back(layout.Drift(CameraId(c)));
    if (held[c].readout && layout.Readout(c) >= 0) places.push_back(layout.Readout(c));
    for (std::size_t i = 0; i < held[c].intrinsics.size(); ++i) {
      if (held[c].intrinsics[i]) places.push_back(layout.Intrinsics(c) + static_cast<int>(i));
    }
  }
  return places;
}

// A lens of which nothing moves is given, by an earlier calibration: what is held of it is no doubt of this
// one's.
bool IsLensGiven(const FixedCameraParameters& held) {
  return !held.intrinsics.empty() &&
         std::find(held.intrinsics.begin(), held.intrinsics.end(), false) == held.intrinsics.end();
}

Eigen::MatrixXd WithUsualCentres(Eigen::MatrixXd information, const CalibrationState& state,
                                 const Layout& layout, const std::vector<FixedCameraParameters>& fixed) {
  for (std::size_t c = 0; c < fixed.size(); ++c) {
    if (!fixed[c].usual_centre) continue;
    const double sigma = UsualCentreSigma(state.cameras[c].intrinsics);
    information.diagonal().segment<2>(layout.Intrinsics(c) + kCentre).array() += 1.0 / (sigma * sigma);
  }
  return information;
}

}  // namespace

std::vector<double> ImageDisplacements(const CameraIntrinsics& intrinsics) {
  const std::vector<ImagePoint> image = ImageGrid(intrinsics);
  const int count = static_cast<int>(intrinsics.parameters.size());
  std::vector<double> displacements;
  for (int i = 0; i < count; ++i) {
    displacements.push_back(std::max(1e-9, MeanDisplacement(image, Eigen::VectorXd::Unit(count, i))));
  }
  return displacements;
}

Eigen::VectorXd CalibrationLimits(const CalibrationState& state, const Layout& layout) {
  Eigen::VectorXd limits = Eigen::VectorXd::Ones(layout.calibration);
  for (std::size_t s = 0; s < layout.order.size(); ++s) {
    const int at = Layout::Sensor(s);
    limits.segment<3>(at).setConstant(kRotationLimit);
    limits.segment<3>(at + 3).setConstant(kTranslationLimit);
    limits[at + 6] = kTimeLimit;
    if (layout.drift[s] >= 0) limits[layout.drift[s]] = kDriftLimit;
  }
  limits[layout.lag] = kTimeLimit;
  for (std::size_t c = 0; c < state.cameras.size(); ++c) {
    if (layout.Readout(c) >= 0) limits[layout.Readout(c)] = kTimeLimit;
    const std::vector<double> displacements = ImageDisplacements(state.cameras[c].intrinsics);
    for (std::size_t i = 0; i < displacements.size(); ++i) {
      limits[layout.Intrinsics(c) + static_cast<int>(i)] = 1.0 / displacements[i];
    }
  }
  return limits;
}

void PlaceHeldTangentialTerms(const std::vector<CameraTerms>& cameras, CalibrationState* state) {
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (IsLensGiven(cameras[c].fixed)) continue;
    CameraIntrinsics& intrinsics = state->cameras[c].intrinsics;
    const std::vector<bool>& held = cameras[c].fixed.intrinsics;
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (!held[i] || !IsTangential(intrinsics.model, static_cast<int>(i))) continue;
      intrinsics.parameters[i] = cameras[c].given_intrinsics ? (*cameras[c].given_intrinsics)[i] : 0.0;
    }
  }
}

Eigen::MatrixXd InformationWithFixed(const Eigen::MatrixXd& information, const CalibrationState& state,
                                     const Layout& layout, const std::vector<FixedCameraParameters>& held) {
  Eigen::MatrixXd result = information;
  const Eigen::VectorXd limits = CalibrationLimits(state, layout);
  for (const int at : HeldPlaces(layout, held)) {
    result.row(at).setZero();
    result.col(at).setZero();
    result(at, at) = 1e6 / (limits[at] * limits[at]);  // a thousandth of the limit
  }
  return result;
}

Eigen::MatrixXd WithVarianceOfHeldTerms(const Eigen::MatrixXd& information, const CalibrationState& state,
                                        const Layout& layout, const std::vector<FixedCameraParameters>& held,
                                        const Eigen::MatrixXd& prior) {
  const Eigen::MatrixXd known = InformationWithFixed(information, state, layout, held) + prior;
  std::vector<int> considered;
  std::vector<double> sizes;
  for (std::size_t c = 0; c < held.size(); ++c) {
    if (IsLensGiven(held[c])) continue;
    for (std::size_t i = 4; i < held[c].intrinsics.size(); ++i) {
      if (!held[c].intrinsics[i]) continue;
      considered.push_back(layout.Intrinsics(c) + static_cast<int>(i));
      sizes.push_back(UsualSize(state.cameras[c].intrinsics.model, static_cast<int>(i)));
    }
  }
  if (considered.empty()) return known;
  Eigen::MatrixXd coupling(information.rows(), considered.size());
  for (std::size_t k = 0; k < considered.size(); ++k) coupling.col(k) = information.col(considered[k]);
  for (const int at : HeldPlaces(layout, held)) coupling.row(at).setZero();
  Eigen::MatrixXd own =
      coupling.transpose() * InverseInLimits(known, CalibrationLimits(state, layout)) * coupling;
  for (std::size_t k = 0; k < considered.size(); ++k) own(k, k) += 1.0 / (sizes[k] * sizes[k]);
  Eigen::MatrixXd result = known;
  for (std::size_t k = 0; k < considered.size(); ++k) {
    result.col(considered[k]) = coupling.col(k);
    result.row(considered[k]) = coupling.col(k).transpose();
  }
  for (std::size_t k = 0; k < considered.size(); ++k) {
    for (std::size_t l = 0; l < considered.size(); ++l) result(considered[k], considered[l]) = own(k, l);
  }
  return result;
}

std::vector<double> PatternSensitivity(const std::vector<DriveTerms>& drives, std::size_t cameras) {
  std::vector<double> squares(cameras, 0.0);
  for (const DriveTerms& drive : drives) {
    for (const LandmarkObservation& o : drive.landmarks.observations) {
      squares[o.camera] += o.shape.cast<double>().squaredNorm() / (o.sigma * o.sigma);
    }
  }
  for (double& value : squares) value = std::sqrt(value);
  return squares;
}

std::vector<FixedCameraParameters> HoldUndeterminedIntrinsics(
    const Eigen::MatrixXd& information, const CalibrationState& state, const Layout& layout,
    const std::vector<FixedCameraParameters>& start, const std::vector<double>& sensitivity, double limit) {
  std::vector<FixedCameraParameters> held = start;
  held.resize(state.cameras.size());
  for (std::size_t c = 0; c < held.size(); ++c) {
    held[c].intrinsics.resize(state.cameras[c].intrinsics.parameters.size(), false);
  }
  const Eigen::VectorXd limits = CalibrationLimits(state, layout);
  std::vector<std::vector<ImagePoint>> images;
  for (const CameraCalibration& camera : state.cameras) images.push_back(ImageGrid(camera.intrinsics));
  while (true) {
    const Eigen::MatrixXd covariance = InverseInLimits(
        InformationWithFixed(WithUsualCentres(information, state, layout, held), state, layout, held),
        limits);
    bool changed = false;
    // One parameter of each camera at a time.
    for (std::size_t c = 0; c < held.size(); ++c) {
      const int at = layout.Intrinsics(c), count = static_cast<int>(held[c].intrinsics.size());
      const Eigen::MatrixXd own = covariance.block(at, at, count, count);
      held[c].square_pixels = IsRatioUncertain(state.cameras[c].intrinsics, own, held[c].intrinsics);
      const int next = NextFixed(state.cameras[c].intrinsics, images[c], own, held[c], sensitivity[c], limit);
      if (next < 0) continue;
      if (IsCentre(next)) {
        held[c].usual_centre = changed = true;
        continue;
      }
      held[c].intrinsics[next] = true;
      // A lens is off its axis in one direction: both terms or none.
      if (IsTangential(state.cameras[c].intrinsics.model, next)) {
        for (const int i : kTangential) held[c].intrinsics[i] = true;
      }
      changed = true;
    }
    if (!changed) return held;
  }
}

}  // namespace mlic
