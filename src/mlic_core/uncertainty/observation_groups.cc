#include "mlic_core/uncertainty/observation_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mlic {
namespace {

// from: measured, paper rig and kitti_0005: errors are shared over 1 to 3 s.
constexpr double kStretch = 3.0;           // s
constexpr int kFewestGroups = 4;           // that say something; from: guard
constexpr double kLeastNotFollowed = 0.2;  // of a group's errors; from: guard, division by it

}  // namespace

Eigen::VectorXd ScatterOfGroups(const ObservationGroups& groups, const Eigen::VectorXd& variances,
                                const Eigen::VectorXd& of_observations) {
  Eigen::VectorXd result = of_observations;
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    std::vector<double> moves;
    for (Eigen::Index g = 0; g < groups.moves.cols(); ++g) {
      if (!(groups.variance(i, g) > 0.0)) continue;
      const double followed = groups.variance(i, g) / variances[i];
      moves.push_back(groups.moves(i, g) / std::sqrt(std::max(kLeastNotFollowed, 1.0 - followed)));
    }
    if (moves.size() < kFewestGroups) continue;
    const double count = static_cast<double>(moves.size());
    const double mean = std::accumulate(moves.begin(), moves.end(), 0.0) / count;
    double squares = 0.0;
    for (const double move : moves) squares += (move - mean) * (move - mean);
    result[i] = squares * count / (count - 1.0);
  }
  return result;
}

ImageGroups::ImageGroups(const CalibrationState& state)
    : cells_(static_cast<Eigen::Index>(kCells * kCells * state.cameras.size())) {
  first_stretch_.push_back(0);
  for (const DriveState& drive : state.drives) {
    start_.push_back(drive.trajectory.Start());
    const double span = drive.trajectory.End() - drive.trajectory.Start();
    first_stretch_.push_back(first_stretch_.back() + static_cast<Eigen::Index>(span / kStretch) + 2);
  }
}

Eigen::Index ImageGroups::Stretch(std::size_t drive, double time, double later) const {
  return first_stretch_[drive] + static_cast<Eigen::Index>((time - start_[drive]) / kStretch + later);
}

Eigen::Index ImageGroups::Cell(const LandmarkObservation& o, const CameraIntrinsics& intrinsics) {
  const double size = static_cast<double>(std::max(intrinsics.width, intrinsics.height)) / kCells;
  const auto place = [&](double at) { return std::clamp(static_cast<int>(at / size), 0, kCells - 1); };
  return kCells * (kCells * o.camera + place(o.pixel.y())) + place(o.pixel.x());
}

}  // namespace mlic
