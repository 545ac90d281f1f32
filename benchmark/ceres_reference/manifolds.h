#pragma once

#include "mlic_core/solver/ceres_compatibility.h"

namespace mlic::ceres_reference {

// How a parameter block moves by a step in its tangent space.
using PlusFunction = void (*)(const double* x, const double* step, double* moved);

// Right perturbation of a unit quaternion (x, y, z, w), as control points take it: x * Exp(step).
void PlusRight(const double* x, const double* step, double* moved);
// Left perturbation, as extrinsic rotations take it: Exp(step) * x.
void PlusLeft(const double* x, const double* step, double* moved);
// A 3 x 3 matrix, column by column: Exp(step) M (3), Exp(step) M (I + lower triangle row by row) (9),
// (I + lower triangle row by row) M (6).
void PlusAlignment(const double* x, const double* step, double* moved);
void PlusAccelerometer(const double* x, const double* step, double* moved);
void PlusGyroscope(const double* x, const double* step, double* moved);
// A plane (normal, offset, centre) by MovePlane, a point (position, anchor) by MovePoint.
void PlusPlane(const double* x, const double* step, double* moved);
void PlusPoint(const double* x, const double* step, double* moved);

// A block whose cost functions write the Jacobian of its tangent space (the own solver's perturbation) to the
// first `tangent` of its `ambient` columns and zeros to the rest. The Jacobian of Plus is then the identity
// over zeros, and their product, which is all that Ceres uses, is what the factor says.
class LiftedManifold : public CeresManifold {
 public:
  LiftedManifold(int ambient, int tangent, PlusFunction plus)
      : ambient_(ambient), tangent_(tangent), plus_(plus) {}

  bool Plus(const double* x, const double* step, double* moved) const override {
    plus_(x, step, moved);
    return true;
  }
#if MLIC_CERES_HAS_MANIFOLDS
  int AmbientSize() const override { return ambient_; }
  int TangentSize() const override { return tangent_; }
  bool PlusJacobian(const double*, double* jacobian) const override { return Lift(jacobian); }
  // Solver and covariance never call these.
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
#else
  int GlobalSize() const override { return ambient_; }
  int LocalSize() const override { return tangent_; }
  bool ComputeJacobian(const double*, double* jacobian) const override { return Lift(jacobian); }
#endif

 private:
  bool Lift(double* jacobian) const;  // ambient x tangent, row by row

  int ambient_, tangent_;
  PlusFunction plus_;
};

}  // namespace mlic::ceres_reference
