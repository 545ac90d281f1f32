#include "mlic_core/association/ring_sums.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/problem/plane_terms.h"

namespace mlic {
namespace {

constexpr std::size_t kMostRings = 256;  // from: guard, LiDARs have up to 128
constexpr std::size_t kChunks = 4;       // from: structural, each has matrices of its own
constexpr double kLeastSpread = 1e-9;    // from: guard, rounding

// The middle of each LiDAR's view, as far as it takes part.
std::vector<Eigen::Vector3d> ViewCentres(const PlaneAssociation& association, std::size_t lidars) {
  std::vector<Eigen::Vector3d> centres(lidars, Eigen::Vector3d::Zero());
  for (const PlaneObservation& o : association.observations) {
    centres[o.lidar] += o.position.cast<double>().normalized();
  }
  return centres;
}

// How many rings each LiDAR numbers, over all drives.
std::vector<std::size_t> CountRings(const std::vector<DriveTerms>& drives, std::size_t lidars) {
  std::vector<std::size_t> rings(lidars, 0);
  for (const DriveTerms& drive : drives) {
    for (const PlaneObservation& o : drive.planes.observations) {
      rings[o.lidar] = std::max<std::size_t>(rings[o.lidar], o.ring + 1);
    }
  }
  for (std::size_t& count : rings) count = count > kMostRings ? 0 : count;
  return rings;
}

// Points of one part on one plane, whitened, and what they say of the plane.
class PartOfPlane {
 public:
  void Clear() {
    rows_.clear();
    information_.setZero();
    gradient_.setZero();
  }

  void Add(const PlaneObservation& o, double residual, const Eigen::Vector2d& by_ring,
           const Eigen::Vector3d& by_plane) {
    const double root = std::sqrt(o.weight) / o.sigma;
    rows_.push_back({o.ring, ElevationOf(o.position), root * residual, root * by_ring, root * by_plane});
    information_ += rows_.back().by_plane * rows_.back().by_plane.transpose();
    gradient_ += rows_.back().residual * rows_.back().by_plane;
  }

  // The plane solved for.
  void AddTo(RingSum* sum) const {
    if (rows_.empty()) return;
    const auto of_ring = [](const Row& a, const Row& b) { return a.ring < b.ring; };
    const auto [lowest, highest] = std::minmax_element(rows_.begin(), rows_.end(), of_ring);
    const Eigen::Index first = lowest->ring, count = highest->ring - lowest->ring + 1;
    const Eigen::Index starts[2] = {first, sum->equations.Rings() + first};
    const Eigen::Matrix3d root = RootOfInverse();
    Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(2 * count, 3);
    for (const Row& row : rows_) {
      const Eigen::Vector3d by_plane = root.transpose() * row.by_plane;
      for (int a = 0; a < 2; ++a) {
        const Eigen::Index at = row.ring + starts[a] - first;
        coupling.row(a * count + row.ring - first) += row.by_ring[a] * by_plane.transpose();
        sum->equations.gradient[at] += row.by_ring[a] * row.residual;
        for (int b = 0; b < 2; ++b) {
          sum->equations.information(at, row.ring + starts[b] - first) += row.by_ring[a] * row.by_ring[b];
        }
      }
      sum->points[row.ring].count += 1.0;
      sum->points[row.ring].elevation += row.elevation;
    }
    const Eigen::Vector3d along = root.transpose() * gradient_;
    for (int a = 0; a < 2; ++a) {
      const auto of_a = coupling.middleRows(a * count, count);
      sum->equations.gradient.segment(starts[a], count).noalias() -= of_a * along;
      for (int b = 0; b < 2; ++b) {
        sum->equations.information.block(starts[a], starts[b], count, count).noalias() -=
            of_a * coupling.middleRows(b * count, count).transpose();
      }
    }
  }

 private:
  struct Row {
    std::uint16_t ring;
    double elevation, residual;
    Eigen::Vector2d by_ring;
    Eigen::Vector3d by_plane;
  };

  // R R^T is the inverse of the plane's information, as far as the points show the plane.
  Eigen::Matrix3d RootOfInverse() const {
    const SymmetricEigen<3> eigen(information_);
    const double least = kLeastSpread * std::max(1e-300, eigen.eigenvalues()[2]);
    const Eigen::Vector3d inverse = eigen.eigenvalues().unaryExpr(
        [least](double value) { return value > least ? 1.0 / std::sqrt(value) : 0.0; });
    return eigen.eigenvectors() * inverse.asDiagonal();
  }

  std::vector<Row> rows_;
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_ = Eigen::Vector3d::Zero();
};

struct SumsOfDrive {
  const PlaneAssociation& association;
  const CalibrationState& state;
  const SplitSpline& trajectory;
  std::vector<float> residuals;
  std::vector<Eigen::Vector3d> centres;

  // [begin, end): observations of one plane by one LiDAR.
  void Add(std::size_t plane, std::size_t begin, std::size_t end, std::array<PartOfPlane, 4>* parts,
           QuartersOfRings* sums) const;
  void AddPlane(std::size_t plane, std::array<PartOfPlane, 4>* parts,
                std::vector<QuartersOfRings>* sums) const;
};

void SumsOfDrive::Add(std::size_t plane, std::size_t begin, std::size_t end,
                      std::array<PartOfPlane, 4>* parts, QuartersOfRings* sums) const {
  const std::int32_t lidar = association.observations[begin].lidar;
  const PointToPlane factor = PlaneFactor(association.planes[plane]);
  const PointToPlane::Extrinsic extrinsic{state.lidars[lidar].T_imu_sensor.rotation.toRotationMatrix(),
                                          state.lidars[lidar].T_imu_sensor.translation};
  const Eigen::Vector3d& centre = centres[lidar];
  for (PartOfPlane& part : *parts) part.Clear();
  for (std::size_t k = begin; k < end; ++k) {
    const PlaneObservation& o = association.observations[k];
    const double t = state.lidars[lidar].OnImuClock(o.time, trajectory.Middle());
    if (std::abs(residuals[k]) > 3.0f * o.sigma || !trajectory.Contains(t)) continue;
    const Eigen::Vector3d x = o.position.cast<double>();
    std::array<double, PointToPlane::kColumns> row;
    factor.Evaluate(trajectory, {trajectory.rotation.knots(), t}, {trajectory.position.knots(), t}, extrinsic,
                    x, row.data());
    const bool right = centre.x() * x.y() < centre.y() * x.x();
    const bool late = t > trajectory.Middle();
    (*parts)[2 * late + right].Add(
        o, residuals[k],
        RingJacobian(o, residuals[k], association.planes[plane], state.lidars[lidar], trajectory),
        Eigen::Map<const Eigen::Vector3d>(row.data() + PointToPlane::kPlane));
  }
  for (int quarter = 0; quarter < 4; ++quarter) (*parts)[quarter].AddTo(&(*sums)[quarter]);
}

void SumsOfDrive::AddPlane(std::size_t plane, std::array<PartOfPlane, 4>* parts,
                           std::vector<QuartersOfRings>* sums) const {
  for (std::size_t begin = association.begin[plane], end; begin < association.begin[plane + 1]; begin = end) {
    const std::int32_t lidar = association.observations[begin].lidar;
    end = begin + 1;
    while (end < association.begin[plane + 1] && association.observations[end].lidar == lidar) ++end;
    if (!(*sums)[lidar][0].points.empty()) Add(plane, begin, end, parts, &(*sums)[lidar]);
  }
}

}  // namespace

void RingSum::Add(const RingSum& other) {
  equations.information += other.equations.information;
  equations.gradient += other.equations.gradient;
  for (std::size_t r = 0; r < points.size(); ++r) {
    points[r].count += other.points[r].count;
    points[r].elevation += other.points[r].elevation;
  }
}

std::vector<QuartersOfRings> SumRings(const std::vector<DriveTerms>& drives, const CalibrationState& state) {
  const std::size_t lidars = state.lidars.size();
  std::vector<QuartersOfRings> none;
  for (const std::size_t rings : CountRings(drives, lidars)) {
    const RingSum sum(rings);
    none.push_back({sum, sum, sum, sum});
  }
  std::vector<std::vector<QuartersOfRings>> chunks(kChunks, none);
  for (std::size_t d = 0; d < drives.size(); ++d) {
    const PlaneAssociation& association = drives[d].planes;
    const SumsOfDrive of_drive{association, state, state.drives[d].trajectory,
                               PlaneResiduals(association, state, d), ViewCentres(association, lidars)};
    ParallelChunks(association.planes.size(), kChunks,
                   [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                     std::array<PartOfPlane, 4> parts;
                     for (std::size_t p = begin; p < end; ++p) of_drive.AddPlane(p, &parts, &chunks[chunk]);
                   });
  }
  for (std::size_t c = 1; c < kChunks; ++c) {
    for (std::size_t l = 0; l < lidars; ++l) {
      for (int quarter = 0; quarter < 4; ++quarter) chunks[0][l][quarter].Add(chunks[c][l][quarter]);
    }
  }
  return std::move(chunks[0]);
}

Eigen::Vector2d RingJacobian(const PlaneObservation& o, double residual, const MapPlane& plane,
                             const SensorCalibration& lidar, const SplitSpline& trajectory) {
  const So3Spline& rotation = trajectory.rotation;
  const double t = lidar.OnImuClock(o.time, trajectory.Middle());
  const Eigen::Matrix3d R_map_imu = rotation.Evaluate(SplineBasis(rotation.knots(), t)).rotation;
  const Eigen::Vector3d normal =
      lidar.T_imu_sensor.rotation.conjugate() * (R_map_imu.transpose() * plane.plane.normal);
  const Eigen::Vector3d x = o.position.cast<double>();
  return {-1.0, normal.dot(ElevationTangent(x * (1.0 + residual / x.norm()))) / o.cos_incidence};
}

Eigen::Vector3d ElevationTangent(const Eigen::Vector3d& x) {
  const double across = std::hypot(x.x(), x.y());
  if (across < 1e-3) return Eigen::Vector3d::Zero();
  return Eigen::Vector3d(-x.z() * x.x() / across, -x.z() * x.y() / across, across);
}

double ElevationOf(const Eigen::Vector3f& position) {
  const Eigen::Vector3d x = position.cast<double>();
  return std::asin(x.z() / x.norm());
}

}  // namespace mlic
