#include "mlic_core/lidar/plane_map.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "mlic_core/common/parallel.h"
#include "mlic_core/geometry/octree_key.h"
#include "mlic_core/geometry/symmetric_matrix.h"
#include "mlic_core/lidar/plane_cells.h"

namespace mlic {
namespace {

constexpr int kLevels = 3;  // splits below the root
// from: measured, trials, LiDAR, open 1, 2 and 7: halved and doubled, together with kFewestScans, results
// change by at most 0.70 sigma (a car), sigmas from 0.94 to 1.14 times.
constexpr double kFewestPoints = 20.0;   // of a plane
constexpr int kFewestScans = 4;          // that see a plane; from: measured, with kFewestPoints
constexpr double kGrazingCosine = 0.26;  // 75 deg; from: definition, docs/method.md section 6
constexpr double kGateSigmas = 3.0;      // from: derivation, 0.3 % of normal errors lie beyond
// A plane may scatter by this much of its points' noise, and its points count for less by as much: real
// surfaces are rough, and what scatters because the state is still wrong is what shows that
// it is.
// from: measured, kitti_0005 and cars: 1.5 leaves the yaw 0.6 deg off.
constexpr double kThicknessSigmas = 3.0;

// By which limits are wider for what was a plane in the map before, and narrower for what was none.
// from: measured, trials, LiDAR, open 401, 403, 404, 412, 425 and 427: against none, results change by at
// most 0.5 sigma, in up to three rounds less.
constexpr double kHysteresis = 1.25;

constexpr int kRootBits = 17;  // of a key, along an axis; from: structural
using Voxels = Octree<kRootBits, kLevels>;

// The axes of the grid, in rows: cubes that stand on a corner. Their faces lean by 35 deg from the vertical
// at least and by 55 deg from the horizontal, so no floor or wall lies along one. A face along a wall would
// deal its points to both sides by their noise: two planes of half the scatter, whose points then follow the
// state that dealt them and hold it where it is.
const Eigen::Matrix3f& GridAxes() {
  static const Eigen::Matrix3f kAxes = [] {
    const double a = std::sqrt(2.0 / 3.0), b = std::sqrt(1.0 / 6.0), c = std::sqrt(0.5),
                 up = std::sqrt(1.0 / 3.0);
    Eigen::Matrix3d axes;
    axes << a, 0.0, up, -b, c, up, -b, -c, up;
    return Eigen::Matrix3f(axes.cast<float>());
  }();
  return kAxes;
}

std::uint64_t VoxelKey(const Eigen::Vector3f& position, double root) {
  const Eigen::Vector3f p = GridAxes() * position;
  const double leaf = root / (1 << kLevels);
  const auto cell = [&](int axis) { return static_cast<std::int64_t>(std::floor(p[axis] / leaf)); };
  return Voxels::KeyOf({cell(0), cell(1), cell(2)});
}

// One root voxel during one stretch of time.
class RootVoxel {
 public:
  // stretch: of time, from the voxel's first on.
  RootVoxel(const std::vector<MapSample>& samples, const std::vector<PlaneNoise>& noise,
            const std::vector<std::uint64_t>& last_voxels, const std::vector<KeyedIndex>& keyed,
            std::size_t stretch, std::vector<MapPlane>* planes)
      : samples_(samples),
        noise_(noise),
        last_voxels_(last_voxels),
        keyed_(keyed),
        stretch_(stretch),
        planes_(planes) {}

  void Split() { Split(0, keyed_.size(), 0); }

 private:
  void Split(std::size_t begin, std::size_t end, int level) {
    if (static_cast<double>(end - begin) < kFewestPoints / kHysteresis) return;
    if (TryPlane(begin, end, IdOf(begin, level))) return;
    if (level == kLevels) return;
    Voxels::ForEachChild(keyed_, begin, end, level,
                         [&](std::size_t first, std::size_t last) { Split(first, last, level + 1); });
  }

  struct Fit {
    Plane plane;
    Eigen::Vector3d center, axis_u, axis_v;
    double thickness = 0.0, width = 0.0;
  };

  static Fit FitPlane(const PointCluster& cluster, const Eigen::Vector3d& anchor) {
    const SymmetricEigen<3> eigen(cluster.Covariance());
    Fit fit;
    fit.center = anchor + cluster.Mean();
    fit.plane.normal = eigen.eigenvectors().col(0);
    fit.plane.offset = fit.plane.normal.dot(fit.center);
    fit.thickness = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]));
    fit.width = std::sqrt(std::max(0.0, eigen.eigenvalues()[1]));
    fit.axis_u = eigen.eigenvectors().col(2) * std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
    fit.axis_v = eigen.eigenvectors().col(1) * fit.width;
    return fit;
  }

  const MapSample& Sample(std::size_t k) const { return samples_[keyed_[k].index]; }

  // Of the voxel of this level that a sample is in: its key behind a one, which tells levels apart, and the
  // stretch.
  std::uint64_t IdOf(std::size_t k, int level) const {
    constexpr std::uint64_t kStretches = 4;  // that differ; from: structural, what 64 bits leave
    const int bits = 3 * (kRootBits + level);
    const std::uint64_t key = keyed_[k].key >> (3 * (kLevels - level));
    return kStretches * ((std::uint64_t{1} << bits) | key) + stretch_ % kStretches;
  }

  double Tolerance(std::uint64_t voxel) const {
    if (last_voxels_.empty()) return 1.0;
    const bool was_plane = std::binary_search(last_voxels_.begin(), last_voxels_.end(), voxel);
    return was_plane ? kHysteresis : 1.0 / kHysteresis;
  }

  // True if the voxel needs no further splitting.
  bool TryPlane(std::size_t begin, std::size_t end, std::uint64_t voxel) {
    const Eigen::Vector3d anchor = Sample(begin).position.cast<double>();
    PointCluster all;
    for (std::size_t k = begin; k < end; ++k) all.Add(Sample(k).position.cast<double>() - anchor);
    const Fit fit = FitPlane(all, anchor);
    double variance = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const MapSample& s = Sample(k);
      const double cosine = fit.plane.normal.dot(s.view.cast<double>());
      const double sigma = noise_[s.lidar].Sigma(cosine);
      variance += sigma * sigma;
    }
    const double expected = std::sqrt(variance / static_cast<double>(end - begin));
    const double tolerance = Tolerance(voxel);
    if (fit.thickness > tolerance * kThicknessSigmas * expected ||
        tolerance * fit.width < 3.0 * fit.thickness)
      return false;
    for (const double side : {1.0, -1.0}) AddSide(begin, end, anchor, fit, side, voxel);
    return true;
  }

  // Points as a side of a plane sees them.
  struct Seen {
    std::vector<std::size_t> places;  // in keyed_
    std::vector<bool> steep;          // not at grazing incidence
    std::vector<PointAtPlane> points;
    double gate = 0.0;  // its thickness in the mean, m
  };

  // Those that do not see the other side.
  Seen SeenBy(std::size_t begin, std::size_t end, const Fit& fit) const {
    Eigen::Matrix<double, 2, 3> axes;
    axes << fit.axis_u.normalized().transpose(), fit.axis_v.normalized().transpose();
    Seen seen;
    double sigmas = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      const MapSample& s = Sample(k);
      const double cosine = fit.plane.normal.dot(s.view.cast<double>());
      if (cosine < -kGrazingCosine) continue;
      const double sigma = noise_[s.lidar].Sigma(std::max(kGrazingCosine, cosine));
      const Eigen::Vector3d p = s.position.cast<double>();
      seen.places.push_back(k);
      seen.steep.push_back(cosine >= kGrazingCosine);
      seen.points.push_back({axes * (p - fit.center), fit.plane.SignedDistance(p), sigma});
      sigmas += sigma;
    }
    seen.gate =
        2.0 * kGateSigmas * sigmas / static_cast<double>(std::max<std::size_t>(1, seen.places.size()));
    return seen;
  }

  // Those within the gate and outside of what is left out.
  static Seen Within(const Seen& seen, const std::vector<bool>& left_out) {
    Seen within;
    within.gate = seen.gate;
    for (std::size_t k = 0; k < seen.places.size(); ++k) {
      const PointAtPlane& point = seen.points[k];
      if (!seen.steep[k] || std::abs(point.distance) > kGateSigmas * point.sigma || left_out[k]) continue;
      within.places.push_back(seen.places[k]);
      within.steep.push_back(true);
      within.points.push_back(point);
    }
    return within;
  }

  void AddSide(std::size_t begin, std::size_t end, const Eigen::Vector3d& anchor, Fit fit, double side,
               std::uint64_t voxel) {
    constexpr int kPasses = 4;  // from: definition, three fits and the last, without relief
    fit.plane.normal *= side;
    fit.plane.offset *= side;
    const auto fewest = static_cast<std::size_t>(std::ceil(kFewestPoints / Tolerance(voxel)));
    std::vector<std::uint32_t> members;
    double inflation = 1.0;
    // Later passes take the gate from the trimmed fit of the one before, and leave out where other surfaces
    // meet that plane; the last one leaves out relief, too.
    for (int pass = 0; pass < kPasses; ++pass) {
      const Seen seen = SeenBy(begin, end, fit);
      if (seen.places.size() < fewest) return;
      Seen within = Within(seen, pass == 0 ? std::vector<bool>(seen.places.size(), false)
                                           : FindMixed(seen.points, kGateSigmas * inflation, seen.gate));
      if (pass == kPasses - 1) within = Within(within, FindRelief(within.points, within.gate));
      if (within.places.size() < fewest) return;
      members.clear();
      double squares = 0.0;
      PointCluster cluster;
      for (std::size_t k = 0; k < within.places.size(); ++k) {
        members.push_back(keyed_[within.places[k]].index);
        squares += std::pow(within.points[k].distance / within.points[k].sigma, 2);
        cluster.Add(Sample(within.places[k]).position.cast<double>() - anchor);
      }
      inflation = std::max(1.0, std::sqrt(squares / static_cast<double>(members.size())));
      const Eigen::Vector3d old_normal = fit.plane.normal;
      fit = FitPlane(cluster, anchor);
      if (fit.plane.normal.dot(old_normal) < 0.0) {
        fit.plane.normal = -fit.plane.normal;
        fit.plane.offset = -fit.plane.offset;
      }
    }
    std::sort(members.begin(), members.end());
    if (Tolerance(voxel) * fit.width < 3.0 * fit.thickness || ScanCount(members) < kFewestScans) return;
    MapPlane plane;
    plane.voxel = voxel;
    plane.plane = fit.plane;
    plane.center = fit.center;
    plane.axis_u = fit.axis_u;
    plane.axis_v = fit.axis_v;
    plane.inflation = inflation;
    plane.start = samples_[members[0]].time;
    for (const std::uint32_t m : members) plane.start = std::min(plane.start, samples_[m].time);
    plane.samples = std::move(members);
    planes_->push_back(std::move(plane));
  }

  // Samples come in order of (lidar, scan), so changes count scans.
  int ScanCount(const std::vector<std::uint32_t>& members) const {
    int count = 0, lidar = -1, scan = -1;
    for (const std::uint32_t m : members) {
      if (samples_[m].lidar == lidar && samples_[m].scan == scan) continue;
      lidar = samples_[m].lidar;
      scan = samples_[m].scan;
      ++count;
    }
    return count;
  }

  const std::vector<MapSample>& samples_;
  const std::vector<PlaneNoise>& noise_;
  const std::vector<std::uint64_t>& last_voxels_;
  const std::vector<KeyedIndex>& keyed_;
  std::size_t stretch_;
  std::vector<MapPlane>* planes_;
};

// The samples [begin, end) of one root voxel, cut into stretches of time from the first sample on; each keeps
// their order.
std::vector<std::vector<KeyedIndex>> CutByTime(const std::vector<MapSample>& samples, const KeyedIndex* begin,
                                               const KeyedIndex* end, double longest) {
  std::vector<double> times;
  times.reserve(end - begin);
  for (const KeyedIndex* k = begin; k != end; ++k) times.push_back(samples[k->index].time);
  std::sort(times.begin(), times.end());
  std::vector<double> starts;
  for (const double t : times) {
    if (starts.empty() || t > starts.back() + longest) starts.push_back(t);
  }
  std::vector<std::vector<KeyedIndex>> stretches(starts.size());
  for (const KeyedIndex* k = begin; k != end; ++k) {
    const auto after = std::upper_bound(starts.begin(), starts.end(), samples[k->index].time);
    stretches[after - starts.begin() - 1].push_back(*k);
  }
  return stretches;
}

}  // namespace

std::vector<MapPlane> BuildPlaneMap(const std::vector<MapSample>& samples,
                                    const std::vector<PlaneNoise>& noise, const PlaneMapOptions& options) {
  std::vector<KeyedIndex> keyed(samples.size());
  ParallelChunks(samples.size(), 64, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      keyed[i] = {VoxelKey(samples[i].position, options.root_voxel), static_cast<std::uint32_t>(i)};
    }
  });
  tbb::parallel_sort(keyed.begin(), keyed.end());
  std::vector<std::size_t> roots;
  for (std::size_t k = 0; k < keyed.size(); ++k) {
    if (k == 0 || Voxels::RootOf(keyed[k].key) != Voxels::RootOf(keyed[k - 1].key)) roots.push_back(k);
  }
  roots.push_back(keyed.size());
  std::vector<std::vector<MapPlane>> found(roots.size() - 1);
  ParallelFor(found.size(), [&](std::size_t r) {
    const KeyedIndex* first = keyed.data();
    const auto stretches = CutByTime(samples, first + roots[r], first + roots[r + 1], options.longest);
    for (std::size_t s = 0; s < stretches.size(); ++s) {
      RootVoxel(samples, noise, options.last_voxels, stretches[s], s, &found[r]).Split();
    }
  });
  std::vector<MapPlane> planes;
  for (auto& of_root : found) std::move(of_root.begin(), of_root.end(), std::back_inserter(planes));
  if (planes.size() > options.largest_count) {
    const auto rank = [&](const MapPlane& plane) {
      const bool kept =
          std::binary_search(options.last_voxels.begin(), options.last_voxels.end(), plane.voxel);
      return (kept ? kHysteresis : 1.0) * static_cast<double>(plane.samples.size());
    };
    std::stable_sort(planes.begin(), planes.end(),
                     [&](const MapPlane& a, const MapPlane& b) { return rank(a) > rank(b); });
    planes.resize(options.largest_count);
  }
  std::stable_sort(planes.begin(), planes.end(),
                   [](const MapPlane& a, const MapPlane& b) { return a.start < b.start; });
  return planes;
}

}  // namespace mlic
