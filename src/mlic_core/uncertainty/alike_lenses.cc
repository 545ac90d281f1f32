#include "mlic_core/uncertainty/alike_lenses.h"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <vector>

#include "mlic_core/sensors/camera_model.h"
#include "mlic_core/uncertainty/intrinsics_observability.h"

namespace mlic {
namespace {

constexpr double kUsualTerm = 1.0;   // from: guard, the sigma of the terms' priors (problem/priors.cc)
constexpr double kFirstStep = 1e-4;  // of a term; from: structural, far below what matters
constexpr double kGrowth = 1.3;      // from step to step; from: structural
constexpr int kRadii = 60;           // at which lenses are compared; from: structural

// k1 k2 k3 of the numerator, k4 k5 k6 of the denominator.
using RadialTerms = Eigen::Matrix<double, 6, 1>;
constexpr int kPlaces[6] = {4, 5, 8, 9, 10, 11};  // among the parameters; from: definition, camera_model.h
constexpr int kFree[5] = {0, 1, 2, 4, 5};         // all but the first of the denominator; from: structural

double Numerator(const RadialTerms& k, double s) { return 1.0 + s * (k[0] + s * (k[1] + s * k[2])); }
double Denominator(const RadialTerms& k, double s) { return 1.0 + s * (k[3] + s * (k[4] + s * k[5])); }

// Radii (tangents) that see parts of the image of the same size, as far as the lens holds.
std::vector<double> RadiiOf(CameraIntrinsics lens, double radius) {
  lens.parameters[6] = lens.parameters[7] = 0.0;
  std::vector<double> radii;
  for (int i = 0; i < kRadii; ++i) {
    Eigen::Vector3d bearing;
    const double distance = radius * std::sqrt((i + 0.5) / kRadii);
    const Eigen::Vector2d pixel(lens.parameters[2] + distance, lens.parameters[3]);
    if (!Unproject(lens, pixel, &bearing)) break;
    radii.push_back(bearing.x() / bearing.z());
  }
  return radii;
}

// Lenses that project as one does.
class AlikeLenses {
 public:
  AlikeLenses(const RadialTerms& terms, double focal, std::vector<double> radii)
      : terms_(terms), focal_(focal), radii_(std::move(radii)) {}

  // How far the terms move on this side (-1, 1).
  RadialTerms Farthest(double side) const {
    RadialTerms farthest = RadialTerms::Zero();
    for (double step = kFirstStep; step < kUsualTerm; step *= kGrowth) {
      const RadialTerms terms = WithFirst(terms_[3] + side * step);
      if (!(Difference(terms) < kPatternError)) break;
      farthest = terms - terms_;
    }
    return farthest;
  }

 private:
  // The nearest lens with this first term of the denominator.
  RadialTerms WithFirst(double first) const {
    RadialTerms terms = terms_;
    terms[3] = first;
    const auto rows = static_cast<Eigen::Index>(radii_.size());
    const double last = radii_.back() * radii_.back();  // keeps columns of like size
    for (int pass = 0; pass < 3; ++pass) {              // weights follow the denominator
      Eigen::MatrixXd A(rows, 5);
      Eigen::VectorXd b(rows);
      for (Eigen::Index i = 0; i < rows; ++i) {
        const double r = radii_[static_cast<std::size_t>(i)], s = r * r, x = s / last;
        const double ratio = Numerator(terms_, s) / Denominator(terms_, s);
        const double weight = focal_ * r / Denominator(terms, s);
        A.row(i) << x, x * x, x * x * x, -ratio * x * x, -ratio * x * x * x;
        A.row(i) *= weight;
        b[i] = weight * (ratio * (1.0 + first * s) - 1.0);
      }
      const Eigen::VectorXd solution = A.colPivHouseholderQr().solve(b);
      const double power[5] = {last, last * last, last * last * last, last * last, last * last * last};
      for (int k = 0; k < 5; ++k) terms[kFree[k]] = solution[k] / power[k];
    }
    return terms;
  }

  // px, rms over the radii; infinite where there is a pole.
  double Difference(const RadialTerms& terms) const {
    double squares = 0.0;
    for (const double r : radii_) {
      const double s = r * r, below = Denominator(terms, s);
      if (!(below > 0.0)) return std::numeric_limits<double>::infinity();
      const double difference =
          focal_ * r * (Numerator(terms, s) / below - Numerator(terms_, s) / Denominator(terms_, s));
      squares += difference * difference;
    }
    return std::sqrt(squares / static_cast<double>(radii_.size()));
  }

  RadialTerms terms_;
  double focal_;  // px
  std::vector<double> radii_;
};

}  // namespace

Eigen::VectorXd SpreadOfAlikeLenses(const CameraIntrinsics& lens, double radius) {
  Eigen::VectorXd spread = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(lens.parameters.size()));
  if (lens.model != CameraModel::kRationalPolynomial) return spread;
  const std::vector<double> radii = RadiiOf(lens, radius);
  if (radii.size() < kRadii / 2) return spread;
  RadialTerms terms;
  for (int k = 0; k < 6; ++k) terms[k] = lens.parameters[kPlaces[k]];
  const AlikeLenses alike(terms, lens.parameters[0], radii);
  const RadialTerms above = alike.Farthest(1.0), below = alike.Farthest(-1.0);
  for (int k = 0; k < 6; ++k) {
    spread[kPlaces[k]] = std::sqrt(0.5 * (above[k] * above[k] + below[k] * below[k]));
  }
  return spread;
}

}  // namespace mlic
