#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "mlic_core/factors/point_to_plane.h"
#include "mlic_core/problem/linear_terms.h"

namespace mlic {

// The LiDAR plane residuals of the joint problem.
class PlaneTerms {
 public:
  explicit PlaneTerms(const LinearizationPoint& at);

  // Adds the planes [begin, end) of one drive; couplings: one for each plane of the drive.
  void Add(std::size_t drive, std::size_t begin, std::size_t end, LandmarkCoupling* couplings,
           Accumulator* sum) const;

  // What Add adds to the cost.
  double Cost(std::size_t drive, std::size_t begin, std::size_t end) const;

 private:
  class RowBuffer;
  struct Segment;
  void Flush(const Segment& segment, RowBuffer* buffer, CouplingSlots* slots, LandmarkCoupling* landmark,
             Accumulator* sum) const;

  LinearizationPoint at_;
  std::vector<PointToPlane::Extrinsic> extrinsics_;
};

// The factor of points tied to the plane, its three parameters about the plane's centre.
PointToPlane PlaneFactor(const MapPlane& plane);

// The plane moved by a step in its three parameters.
void MovePlane(const Eigen::Vector3d& step, MapPlane* plane);

// The observations of one plane that lie within the trajectory, whitened and with Huber's weights taken in:
// each row and residual is divided by its sigma and multiplied by the square root of its weights.
struct PlaneRows {
  std::vector<std::size_t> observations;  // their places in the association
  Eigen::MatrixXd jacobian;               // a column for each, laid out as PointToPlane
  Eigen::VectorXd residuals;
  Eigen::VectorXd units;  // what a whitened residual of one, followed by all, would have as its column
};
PlaneRows RowsOfPlane(const PlaneAssociation& association, const CalibrationState& state, std::size_t drive,
                      std::size_t plane);

// Where groups begin among observations of one plane (places in the association), and the end: points that
// one LiDAR saw there within a second, which may share errors.
std::vector<Eigen::Index> GroupBegins(const PlaneAssociation& association,
                                      const std::vector<std::size_t>& observations);

// The information of the plane's own parameters, factored.
Eigen::LDLT<Eigen::Matrix3d> PlaneInformation(const PlaneRows& rows);

// Signed distances in metres of all observations of one drive to their planes, in their order.
std::vector<float> PlaneResiduals(const PlaneAssociation& association, const CalibrationState& state,
                                  std::size_t drive);

}  // namespace mlic
