#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <vector>

namespace ceres {
class CostFunction;
class Problem;
}  // namespace ceres

namespace mlic {

struct SmallFitSummary {
  bool usable = false;     // false: a residual could not be evaluated at the start, or the solve broke down
  bool converged = false;  // false as well where the iterations did not suffice
  int iterations = 0;
  double cost = 0.0;  // sum of rho_i(|r_i|^2) at the end
};

// A dense non-linear least-squares fit of a few dozen parameters at most, by Ceres (Levenberg-Marquardt, QR):
//   minimise over x:  sum_i rho_i(|r_i(x)|^2)
// Blocks of x are the caller's own doubles and are overwritten by Solve(); they must outlive the fit.
// Residuals are whitened by whoever adds them, or the information means nothing. Runs on the calling thread
// alone: same input, same bytes. Fits with thousands of unknowns belong to normal_equations.h.
class SmallFit {
 public:
  // r (rows) at the blocks' values, and where jacobians[k] is not null, d r / d block k (rows x its size, row
  // by row). jacobians itself is null where none is wanted. False where r does not exist.
  using Residual = std::function<bool(double const* const* blocks, double* r, double** jacobians)>;

  struct Block {
    double* values;
    int size;
  };

  SmallFit();
  ~SmallFit();

  // The rotation as a block of 4; it stays a unit quaternion. Call once, after a residual that uses it.
  void SetRotation(Eigen::Quaterniond* rotation);

  // huber: of |r|, from where on it counts linearly and no longer by its square; 0: nowhere.
  void Add(int rows, Residual residual, const std::vector<Block>& blocks, double huber = 0.0);

  // Takes over the cost function, which may come from ceres::AutoDiffCostFunction.
  void Add(ceres::CostFunction* cost, const std::vector<double*>& blocks, double huber = 0.0);

  SmallFitSummary Solve(int most_iterations);

  // sum_i rho_i' J_i^T J_i at the present values, over the given blocks in their order, other blocks fixed;
  // its inverse is their covariance. A rotation has three columns: a small left rotation in radians.
  Eigen::MatrixXd Information(const std::vector<double*>& blocks);

 private:
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<const double*> rotations_;
};

// d (left perturbation of q, rad) / d (x y z w of q): turns a Jacobian to a small left rotation into the one
// to the quaternion's block.
Eigen::Matrix<double, 3, 4> LeftPerturbationJacobian(const Eigen::Quaterniond& q);

// Writes d r / d block where Ceres asks for it.
template <typename Derived>
void StoreJacobian(const Eigen::MatrixBase<Derived>& J, int block, double** jacobians) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  if (jacobians == nullptr || jacobians[block] == nullptr) return;
  Eigen::Map<RowMajor> to(jacobians[block], J.rows(), J.cols());
  to = J;
}

}  // namespace mlic
