#include "mlic_core/trajectory/spline_basis.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/error.h"

namespace mlic {

UniformKnots UniformKnots::Covering(double start, double end, double spacing) {
  Check(end > start && spacing > 0.0, "UniformKnots: empty span");
  const int segments = std::max(1, static_cast<int>(std::ceil((end - start) / spacing - 1e-9)));
  return {start, spacing, segments + 3};
}

SplineBasis::SplineBasis(const UniformKnots& knots, double time)
    : first(std::clamp(static_cast<int>(std::floor((time - knots.start) / knots.spacing)), 0,
                       knots.Segments() - 1)) {
  const double u = (time - knots.start) / knots.spacing - first;
  const double u2 = u * u;
  const double u3 = u2 * u;
  const double rate = 1.0 / knots.spacing;
  lambda << 1.0, (5.0 + 3.0 * u - 3.0 * u2 + u3) / 6.0, (1.0 + 3.0 * u + 3.0 * u2 - 2.0 * u3) / 6.0, u3 / 6.0;
  lambda_dot << 0.0, (1.0 - 2.0 * u + u2) * (0.5 * rate), (0.5 + u - u2) * rate, u2 * (0.5 * rate);
  const double rate2 = rate * rate;
  lambda_ddot << 0.0, (u - 1.0) * rate2, (1.0 - 2.0 * u) * rate2, u * rate2;
}

}  // namespace mlic
