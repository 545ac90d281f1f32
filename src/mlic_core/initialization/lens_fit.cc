#include "mlic_core/initialization/lens_fit.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/random.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/solver/small_fit.h"

namespace mlic {
namespace {

// What moves: log f, alpha, cx and cy (in image widths), left perturbation of R_imu_camera (rad), time offset
// (s); from: structural.
constexpr int kParameters = 8;
using Parameters = Eigen::Matrix<double, kParameters, 1>;

// The scales of the robust function in turn, px; from: derivation. The first is what the image's rim is off
// by with a focal length 15 percent off; each halves the one before.
constexpr double kScales[] = {16.0, 8.0, 4.0, kLensErrorScale};
constexpr int kIterations = 8;  // at each scale, the next goes on from there; from: guard
// Of two matches that give a first direction of translation; from: derivation: with half of the matches
// wrong, all 30 are bad in 0.02 percent of the pairs.
constexpr int kDraws = 30;

// Of what is known beforehand; from: definition. The field of view is asked for to 15 percent; alpha goes
// from 0 (perspective) to 1 (orthographic) with most lenses between 0 and 0.7.
constexpr double kFieldOfViewSigma = 0.15, kAlpha = 0.35, kAlphaSigma = 0.35;
constexpr double kCentreSigma = 0.015;  // image widths; from: measured, as UsualCentreSigma
// How far rotation and time offset may go from where a scale of the robust function begins; keeps them where
// the motion does not show them (a vehicle that only yaws). Judgement, not measured.
constexpr double kLensRotationSigma = 0.1;  // rad
constexpr double kLensTimeSigma = 0.05;     // s

LensHypothesis Moved(const LensHypothesis& from, const Parameters& step) {
  LensHypothesis to = from;
  std::vector<double>& p = to.lens.parameters;
  p[0] *= std::exp(step[0]);
  p[1] = p[0];
  p[5] += step[1];
  p[2] += step[2] * from.lens.width;
  p[3] += step[3] * from.lens.width;
  to.R_imu_camera = (ExpQuaternion(step.segment<3>(4)) * from.R_imu_camera).normalized();
  to.time_offset += step[7];
  return to;
}

struct Ray {
  Eigen::Vector3d direction;
  Eigen::Matrix<double, 3, 2> by_pixel;
};

// The unified model and its derivative; false where it has no bearing.
bool Unified(const std::vector<double>& p, const Eigen::Vector2d& pixel, Ray* ray) {
  const double f = p[0], alpha = p[5];
  const double x = (pixel.x() - p[2]) / f, y = (pixel.y() - p[3]) / f, rr = x * x + y * y;
  const double under_root = 1.0 - (2.0 * alpha - 1.0) * rr;
  constexpr double kLeast = 1e-3;  // from: guard; at the end of the domain the derivative has no bound
  if (!(under_root > kLeast)) return false;
  const double root = std::sqrt(under_root), below = alpha * root + 1.0 - alpha;
  if (!(below > kLeast)) return false;
  const double z = (1.0 - alpha * alpha * rr) / below;
  const double slope =
      (-alpha * alpha + z * alpha * (2.0 * alpha - 1.0) / (2.0 * root)) / below;  // of z to rr
  const Eigen::Vector3d m(x, y, z);
  const double norm = m.norm();
  ray->direction = m / norm;
  Eigen::Matrix<double, 3, 2> D;
  D << 1.0, 0.0, 0.0, 1.0, 2.0 * x * slope, 2.0 * y * slope;
  ray->by_pixel = (D - ray->direction * (ray->direction.transpose() * D)) / (norm * f);
  return true;
}

// One match under a hypothesis: both bearings in frame b, with their derivatives to the pixels.
struct TurnedMatch {
  Ray a, b;
  Eigen::Vector3d normal;  // a x b
  bool valid = false;

  // Epipolar error in px; whitening: what one unit of t . normal counts.
  double Error(const Eigen::Vector3d& t, double* whitening = nullptr) const {
    const double variance = (a.by_pixel.transpose() * b.direction.cross(t)).squaredNorm() +
                            (b.by_pixel.transpose() * t.cross(a.direction)).squaredNorm();
    constexpr double kLeastVariance = 1e-12;  // of a match at the epipole, rad^2; from: guard
    const double inverse = 1.0 / std::sqrt(variance + kLeastVariance);
    if (whitening != nullptr) *whitening = inverse;
    return t.dot(normal) * inverse;
  }
};
using TurnedMatches = std::vector<TurnedMatch>;

// The matches of one pair as rows of a least-squares problem: r / sqrt(r^2 + scale^2), whose square is Geman
// and McClure's function; 1 where the hypothesis has no bearing or the trajectory ends.
class PairRows {
 public:
  PairRows(const PixelMatches& pair, const SplitSpline& T_map_imu) : pair_(pair), T_map_imu_(T_map_imu) {}

  int count() const { return static_cast<int>(pair_.pixels_a.size()); }

  void NewScale(double scale) {
    scale_ = scale;
    direction_.setZero();
  }

  bool Evaluate(const LensHypothesis& start, const Parameters& x, double* r, double* jacobian) {
    const TurnedMatches matches = Turn(Moved(start, x));
    FindDirection(matches);
    Eigen::Map<Eigen::VectorXd> rows(r, count());
    for (int i = 0; i < count(); ++i)
      rows[i] = matches[i].valid ? Bounded(matches[i].Error(direction_)) : 1.0;
    if (jacobian == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kParameters, Eigen::RowMajor>> J(jacobian, count(),
                                                                                      kParameters);
    constexpr double kStep = 1e-6;  // from: derivation, near the root of the rounding error
    for (int k = 0; k < kParameters; ++k) {
      const TurnedMatches moved = Turn(Moved(start, x + kStep * Parameters::Unit(k)));
      for (int i = 0; i < count(); ++i) {
        J(i, k) = matches[i].valid && moved[i].valid ? (Bounded(moved[i].Error(direction_)) - rows[i]) / kStep
                                                     : 0.0;
      }
    }
    TakeOutDirection(matches, &J);
    return true;
  }

  std::vector<double> Errors(const LensHypothesis& at) const {
    std::vector<double> errors;
    for (const TurnedMatch& match : Turn(at)) {
      if (match.valid) errors.push_back(std::abs(match.Error(direction_)));
    }
    return errors;
  }

 private:
  double Bounded(double r) const { return r / std::sqrt(r * r + scale_ * scale_); }
  double BoundedSlope(double r) const { return scale_ * scale_ / std::pow(r * r + scale_ * scale_, 1.5); }

  TurnedMatches Turn(const LensHypothesis& at) const {
    TurnedMatches matches(pair_.pixels_a.size());
    const double time_a = pair_.time_a + at.time_offset, time_b = pair_.time_b + at.time_offset;
    if (!T_map_imu_.Contains(time_a) || !T_map_imu_.Contains(time_b)) return matches;
    const So3Spline& rotation = T_map_imu_.rotation;
    const Eigen::Matrix3d R = (at.R_imu_camera.conjugate() * rotation.Rotation(time_b).conjugate() *
                               rotation.Rotation(time_a) * at.R_imu_camera)
                                  .toRotationMatrix();
    for (std::size_t i = 0; i < matches.size(); ++i) {
      TurnedMatch& match = matches[i];
      match.valid = Unified(at.lens.parameters, pair_.pixels_a[i], &match.a) &&
                    Unified(at.lens.parameters, pair_.pixels_b[i], &match.b);
      match.a.direction = (R * match.a.direction).eval();
      match.a.by_pixel = (R * match.a.by_pixel).eval();
      match.normal = match.a.direction.cross(match.b.direction);
    }
    return matches;
  }

  double Cost(const TurnedMatches& matches, const Eigen::Vector3d& t) const {
    double cost = 0.0;
    for (const TurnedMatch& match : matches) {
      const double r = match.valid ? Bounded(match.Error(t)) : 1.0;
      cost += r * r;
    }
    return cost;
  }

  // The direction that agrees best with most, by draws of two matches and re-weighted least squares; from the
  // last one where there is one.
  void FindDirection(const TurnedMatches& matches) {
    const bool known = !direction_.isZero();
    if (!known) direction_ = Eigen::Vector3d::UnitZ();
    double best = Cost(matches, direction_);
    if (!known) {
      Random random(1);
      for (int draw = 0; draw < kDraws; ++draw) {
        const TurnedMatch& m = matches[random.Next() % matches.size()];
        const TurnedMatch& n = matches[random.Next() % matches.size()];
        if (m.valid && n.valid) Try(matches, m.normal.cross(n.normal), &best);
      }
    }
    constexpr int kRounds = 5;  // from: guard; each starts where the last ended
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (const TurnedMatch& match : matches) {
        if (!match.valid) continue;
        double whitening;
        const double r = match.Error(direction_, &whitening);
        const double above = r * r + scale_ * scale_;
        sum += whitening * whitening / (above * above) * match.normal * match.normal.transpose();
      }
      const double before = best;
      Try(matches, SymmetricEigen<3>(sum).eigenvectors().col(0), &best);
      if (!(best < 0.9999 * before)) break;
    }
  }

  void Try(const TurnedMatches& matches, const Eigen::Vector3d& direction, double* best) {
    if (!(direction.norm() > 1e-12)) return;
    const double cost = Cost(matches, direction.normalized());
    if (!(cost < *best)) return;
    *best = cost;
    direction_ = direction.normalized();
  }

  // Variable projection (Kaufman's): the part of J that no turn of the direction makes up for.
  template <typename Jacobian>
  void TakeOutDirection(const TurnedMatches& matches, Jacobian* J) const {
    Eigen::Matrix<double, 3, 2> tangents;
    tangents.col(0) = direction_.unitOrthogonal();
    tangents.col(1) = direction_.cross(tangents.col(0));
    Eigen::Matrix<double, Eigen::Dynamic, 2> J_t = Eigen::Matrix<double, Eigen::Dynamic, 2>::Zero(count(), 2);
    for (int i = 0; i < count(); ++i) {
      if (!matches[i].valid) continue;
      double whitening;
      const double r = matches[i].Error(direction_, &whitening);
      J_t.row(i) = BoundedSlope(r) * whitening * matches[i].normal.transpose() * tangents;
    }
    const Eigen::Matrix2d square = J_t.transpose() * J_t + 1e-12 * Eigen::Matrix2d::Identity();
    const Eigen::Matrix<double, 2, kParameters> gain = square.inverse() * (J_t.transpose() * *J);
    *J -= J_t * gain;
  }

  const PixelMatches& pair_;
  const SplitSpline& T_map_imu_;
  Eigen::Vector3d direction_ = Eigen::Vector3d::Zero();  // of the translation, frame b; zero: not known
  double scale_ = 1.0;                                   // px
};

double CentredHalfFieldOfView(const CameraIntrinsics& lens) {
  Ray edge;
  std::vector<double> centred = lens.parameters;
  centred[2] = centred[3] = 0.0;
  if (!Unified(centred, {0.5 * lens.width, 0.0}, &edge)) return M_PI;
  return std::atan2(edge.direction.x(), edge.direction.z());
}

constexpr int kPriorRows = 8;  // from: structural

// Deviations from what is known beforehand in sigmas, with the weight that an error of 1 px has.
bool PriorRows(const LensHypothesis& start, double half_field_of_view, double scale,
               double const* const* blocks, double* r, double** jacobians) {
  const auto rows = [&](const Parameters& x) {
    const CameraIntrinsics lens = Moved(start, x).lens;
    const std::vector<double>& p = lens.parameters;
    Eigen::Matrix<double, kPriorRows, 1> of_x;
    of_x << std::log(CentredHalfFieldOfView(lens) / half_field_of_view) / kFieldOfViewSigma,
        (p[5] - kAlpha) / kAlphaSigma, (p[2] - 0.5 * (lens.width - 1)) / (kCentreSigma * lens.width),
        (p[3] - 0.5 * (lens.height - 1)) / (kCentreSigma * lens.width), x.segment<3>(4) / kLensRotationSigma,
        x[7] / kLensTimeSigma;
    return (of_x / scale).eval();
  };
  const Parameters x = Eigen::Map<const Parameters>(blocks[0]);
  Eigen::Map<Eigen::Matrix<double, kPriorRows, 1>> values(r);
  values = rows(x);
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, kPriorRows, kParameters, Eigen::RowMajor>> J(jacobians[0]);
  constexpr double kStep = 1e-6;  // from: derivation, near the root of the rounding error
  for (int k = 0; k < kParameters; ++k) J.col(k) = (rows(x + kStep * Parameters::Unit(k)) - values) / kStep;
  return true;
}

}  // namespace

std::optional<LensFit> FitLens(const std::vector<PixelMatches>& pairs,
                               const std::vector<const SplitSpline*>& T_map_imu, double half_field_of_view,
                               const LensHypothesis& start) {
  std::vector<PairRows> rows;
  int count = 0;
  for (const PixelMatches& pair : pairs) {
    if (pair.pixels_a.empty()) continue;
    rows.emplace_back(pair, *T_map_imu[pair.drive]);
    count += rows.back().count();
  }
  LensFit fit;
  fit.at = start;
  for (const double scale : kScales) {
    const LensHypothesis from = fit.at;
    Parameters x = Parameters::Zero();
    SmallFit solver;
    for (PairRows& pair : rows) {
      pair.NewScale(scale);
      solver.Add(pair.count(),
                 [&](double const* const* blocks, double* r, double** jacobians) {
                   return pair.Evaluate(from, Eigen::Map<const Parameters>(blocks[0]), r,
                                        jacobians == nullptr ? nullptr : jacobians[0]);
                 },
                 {{x.data(), kParameters}});
    }
    solver.Add(kPriorRows,
               [&](double const* const* blocks, double* r, double** jacobians) {
                 return PriorRows(from, half_field_of_view, scale, blocks, r, jacobians);
               },
               {{x.data(), kParameters}});
    const SmallFitSummary summary = solver.Solve(kIterations);
    if (!summary.usable || !x.allFinite()) return std::nullopt;
    fit.at = Moved(from, x);
    fit.cost = summary.cost / std::max(1, count);
  }
  std::vector<double> errors;
  for (const PairRows& pair : rows) {
    const std::vector<double> of_pair = pair.Errors(fit.at);
    errors.insert(errors.end(), of_pair.begin(), of_pair.end());
  }
  const auto agrees = [](double error) { return error < kLensErrorScale; };
  fit.inlier_share =
      static_cast<double>(std::count_if(errors.begin(), errors.end(), agrees)) / std::max(1, count);
  return fit;
}

std::optional<CameraIntrinsics> UnifiedLens(int width, int height, double half_field_of_view, double alpha) {
  const double below = alpha + (1.0 - alpha) * std::cos(half_field_of_view);
  const double f = 0.5 * width * below / std::sin(half_field_of_view);
  CameraIntrinsics lens{
      CameraModel::kDoubleSphere, width, height, {f, f, 0.5 * (width - 1), 0.5 * (height - 1), 0.0, alpha}};
  // Images end well before the model's domain does, and a focal length is a quarter of the width in the
  // widest; from: guard.
  constexpr double kBeyondEdge = 1.2, kShortest = 0.05;
  Ray ray;
  const Eigen::Vector2d beyond(0.5 * (width - 1) + 0.5 * kBeyondEdge * width, 0.5 * (height - 1));
  if (!(f > kShortest * width) || !Unified(lens.parameters, beyond, &ray)) return std::nullopt;
  return lens;
}

}  // namespace mlic
