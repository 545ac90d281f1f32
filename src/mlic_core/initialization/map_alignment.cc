#include "mlic_core/initialization/map_alignment.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/geometry/symmetric_matrix.h"

namespace mlic {
namespace {

constexpr std::size_t kFewestPlanes = 20;   // from: guard, fewer do not tell one place from another
constexpr std::size_t kCoarsePlanes = 150;  // of b in the search from all starts; from: guard, time
constexpr std::size_t kFinePlanes = 600;    // of b where the best places are refined; from: guard, time
constexpr std::size_t kMostTargets = 3000;  // planes of a; from: guard, time
constexpr std::size_t kRefined = 24;        // places; from: guard, time
// m that a difference of one between normals counts for. from: derivation, about a room's size
constexpr double kDirectionLength = 3.0;
constexpr double kMostApart = 3.0;       // m along the planes, of a pair; from: structural, root voxels
constexpr double kSameDirection = 0.95;  // cosine, 18 deg; from: guard, normals are good to few degrees
constexpr double kOnPlane = 0.15;        // m; from: derivation, three of the planes' 5 cm
// What counts as another place. from: guard, beyond what the joint rounds bridge
constexpr double kOtherAngle = 5.0 * M_PI / 180.0, kOtherDistance = 0.5;

using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;

// Places and unit normals of planes, one in each column.
struct Patches {
  Eigen::Matrix3Xd centers, normals;
  Eigen::VectorXd weights;
};

// Every so many of the planes, at most `most`; those with most points come first in equal steps of time.
Patches PatchesOf(const std::vector<MapPlane>& planes, std::size_t most) {
  const std::size_t count = std::min(most, planes.size());
  Patches patches;
  patches.centers.resize(3, static_cast<Eigen::Index>(count));
  patches.normals = patches.centers;
  for (std::size_t i = 0; i < count; ++i) {
    const MapPlane& plane = planes[i * planes.size() / count];
    patches.centers.col(static_cast<Eigen::Index>(i)) = plane.center;
    patches.normals.col(static_cast<Eigen::Index>(i)) = plane.plane.normal;
  }
  // Neighbours within some 30 deg.
  const Eigen::MatrixXd cosines = patches.normals.transpose() * patches.normals;
  patches.weights = cosines.cwiseMax(0.0).array().pow(8.0).rowwise().sum().inverse();
  patches.weights /= patches.weights.sum();
  return patches;
}

// The planes of a with what nearest ones are looked up by.
class Targets {
 public:
  explicit Targets(const Patches& patches) : patches_(patches) {
    keys_.resize(6, patches.centers.cols());
    keys_ << patches.centers, kDirectionLength * patches.normals;
    half_norms_ = 0.5 * keys_.colwise().squaredNorm();
  }

  // Of each column of moved the nearest by place and direction.
  std::vector<Eigen::Index> Nearest(const Columns& moved) const {
    const Eigen::MatrixXd similar = (keys_.transpose() * moved).colwise() - half_norms_;
    std::vector<Eigen::Index> nearest(static_cast<std::size_t>(moved.cols()));
    for (Eigen::Index i = 0; i < moved.cols(); ++i) {
      similar.col(i).maxCoeff(&nearest[static_cast<std::size_t>(i)]);
    }
    return nearest;
  }
  const Patches& patches() const { return patches_; }

 private:
  const Patches& patches_;
  Columns keys_;
  Eigen::VectorXd half_norms_;
};

Columns Moved(const Patches& patches, const RigidTransform& T) {
  Columns moved(6, patches.centers.cols());
  const Eigen::Matrix3d R = T.rotation.toRotationMatrix();
  moved.topRows<3>() = (R * patches.centers).colwise() + T.translation;
  moved.bottomRows<3>() = kDirectionLength * R * patches.normals;
  return moved;
}

// Weighted share of the planes of b that lie on one of a.
double ShareOnPlanes(const Targets& a, const Patches& b, const RigidTransform& T) {
  const Columns moved = Moved(b, T);
  const std::vector<Eigen::Index> nearest = a.Nearest(moved);
  double share = 0.0;
  for (Eigen::Index i = 0; i < moved.cols(); ++i) {
    const Eigen::Index j = nearest[static_cast<std::size_t>(i)];
    const Eigen::Vector3d normal = a.patches().normals.col(j);
    const Eigen::Vector3d apart = moved.col(i).head<3>() - a.patches().centers.col(j);
    const bool on_plane = std::abs(normal.dot(apart)) < kOnPlane && apart.norm() < kMostApart &&
                          normal.dot(moved.col(i).tail<3>()) > kSameDirection * kDirectionLength;
    if (on_plane) share += b.weights[i];
  }
  return share;
}

// Gauss-Newton on distances to planes and differences of normals, with the kernel of Geman and McClure, whose
// width falls from `wide` to `narrow` (m).
RigidTransform Draw(const Targets& a, const Patches& b, RigidTransform T, int rounds, double wide,
                    double narrow) {
  for (int round = 0; round < rounds; ++round) {
    const double width = wide * std::pow(narrow / wide, round / std::max(1.0, rounds - 1.0));
    const Columns moved = Moved(b, T);
    const std::vector<Eigen::Index> nearest = a.Nearest(moved);
    Eigen::Matrix<double, 6, 6> H = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index i = 0; i < moved.cols(); ++i) {
      const Eigen::Index j = nearest[static_cast<std::size_t>(i)];
      const Eigen::Vector3d normal = a.patches().normals.col(j);
      const Eigen::Vector3d p = moved.col(i).head<3>(), n = moved.col(i).tail<3>() / kDirectionLength;
      const Eigen::Vector3d apart = p - a.patches().centers.col(j);
      const double distance = normal.dot(apart);
      // Beside the plane's patch it is another's.
      const double beside = std::max(0.0, apart.norm() - kMostApart);
      const Eigen::Vector3d turned = n - normal;
      const double squared = distance * distance + beside * beside + turned.squaredNorm();
      const double kernel = width * width / (width * width + squared);
      const double weight = b.weights[i] * kernel * kernel;
      Eigen::Matrix<double, 6, 1> J;
      J << p.cross(normal), normal;
      H += weight * J * J.transpose();
      g += weight * distance * J;
      // A left turn phi moves n by phi x n.
      const Eigen::Matrix3d of_turn = -Hat(n);
      H.topLeftCorner<3, 3>() += weight * of_turn.transpose() * of_turn;
      g.head<3>() += weight * of_turn.transpose() * turned;
    }
    const Eigen::Matrix<double, 6, 1> step = -SolveSymmetric(H, g);
    if (!step.allFinite()) return T;
    const Eigen::Quaterniond turn = ExpQuaternion(step.head<3>());
    T = {(turn * T.rotation).normalized(), turn * T.translation + step.tail<3>()};
  }
  return T;
}

struct Place {
  RigidTransform T;
  double share = 0.0;
};

bool IsOther(const RigidTransform& T, const RigidTransform& place) {
  return AngleBetween(T.rotation, place.rotation) > kOtherAngle ||
         (T.translation - place.translation).norm() > kOtherDistance;
}

// Best first. Equal ones in the order of their starts.
void Sort(std::vector<Place>* places) {
  std::stable_sort(places->begin(), places->end(),
                   [](const Place& x, const Place& y) { return x.share > y.share; });
}

// One of each place, the best first.
std::vector<Place> Distinct(const std::vector<Place>& sorted, std::size_t most) {
  std::vector<Place> distinct;
  for (const Place& place : sorted) {
    if (distinct.size() == most) break;
    if (std::all_of(distinct.begin(), distinct.end(),
                    [&](const Place& other) { return IsOther(place.T, other.T); })) {
      distinct.push_back(place);
    }
  }
  return distinct;
}

}  // namespace

bool MapAlignment::IsClear() const {
  // from: measured, cars of two to four LiDARs: right places have 0.32 to 0.93, others at most 0.48 of that.
  constexpr double kLeastShare = 0.25, kMostElsewhere = 0.7;
  return share > kLeastShare && share_elsewhere < kMostElsewhere * share;
}

std::vector<RigidTransform> AllRotations() {
  // Super-Fibonacci spirals (Alexa, CVPR 2022).
  constexpr int kCount = 1200;                         // from: derivation, about 25 deg apart
  constexpr double kPsi = 1.533751168755204288118041;  // from: paper
  std::vector<RigidTransform> rotations;
  for (int i = 0; i < kCount; ++i) {
    const double s = i + 0.5, r = std::sqrt(s / kCount), q = std::sqrt(1.0 - s / kCount);
    const double alpha = 2.0 * M_PI * s / std::sqrt(2.0), beta = 2.0 * M_PI * s / kPsi;
    rotations.push_back(
        {Eigen::Quaterniond(q * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha), q * std::sin(beta)),
         Eigen::Vector3d::Zero()});
  }
  return rotations;
}

std::vector<RigidTransform> RotationsAbout(const RigidTransform& guess, const Eigen::Vector3d& sigma) {
  std::vector<RigidTransform> rotations;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Eigen::Vector3d turn = Eigen::Vector3d(x, y, z).cwiseProduct(sigma);
        rotations.push_back({ExpQuaternion(turn) * guess.rotation, guess.translation});
      }
    }
  }
  return rotations;
}

double ShareOfPlanes(const std::vector<MapPlane>& a, const std::vector<MapPlane>& b,
                     const RigidTransform& T_a_b) {
  const Patches of_a = PatchesOf(a, kMostTargets);
  return ShareOnPlanes(Targets(of_a), PatchesOf(b, kFinePlanes), T_a_b);
}

std::optional<MapAlignment> AlignMaps(const std::vector<MapPlane>& a, const std::vector<MapPlane>& b,
                                      const std::vector<RigidTransform>& starts,
                                      const std::function<bool(const RigidTransform&)>& plausible) {
  if (std::min(a.size(), b.size()) < kFewestPlanes) return std::nullopt;
  const Patches coarse_a = PatchesOf(a, kMostTargets / 3), fine_a = PatchesOf(a, kMostTargets);
  const Patches coarse_b = PatchesOf(b, kCoarsePlanes), fine_b = PatchesOf(b, kFinePlanes);
  const Targets coarse(coarse_a), fine(fine_a);
  std::vector<Place> places(starts.size());
  ParallelFor(starts.size(), [&](std::size_t k) {
    const RigidTransform T = Draw(coarse, coarse_b, starts[k], 15, 3.0, 0.3);
    places[k] = {T, ShareOnPlanes(coarse, coarse_b, T)};
  });
  Sort(&places);
  std::vector<Place> refined = Distinct(places, kRefined);
  ParallelFor(refined.size(), [&](std::size_t k) {
    refined[k].T = Draw(fine, fine_b, refined[k].T, 15, 0.6, 0.1);
    refined[k].share = plausible(refined[k].T) ? ShareOnPlanes(fine, fine_b, refined[k].T) : 0.0;
  });
  Sort(&refined);
  if (refined.empty() || refined[0].share == 0.0) return std::nullopt;
  MapAlignment alignment{refined[0].T, refined[0].share, 0.0};
  for (const Place& place : refined) {
    if (IsOther(place.T, alignment.T_a_b)) {
      alignment.share_elsewhere = std::max(alignment.share_elsewhere, place.share);
    }
  }
  return alignment;
}

}  // namespace mlic
