#include "mlic_sim/recorded_motion.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "mlic_core/common/error.h"

namespace mlic::sim {
namespace {

constexpr std::size_t kFewestPoses = 20;          // from: guard, five segments of the spline
constexpr double kPosesOfSegment = 4.0;           // from: structural, what is read off to 1e-6 m stays smooth
constexpr double kLatest = 0.1;                   // s, of the first reading, and before the end; from: guard
constexpr double kMargin = 1.0;                   // s, beyond the part; from: guard, of the spline's ends
constexpr double kLowest = 1.0;                   // m, over the ground; from: definition
constexpr int kDegree = 5, kTerms = kDegree + 1;  // from: structural, accelerations are smooth

using PoseRow = Eigen::Matrix<double, 1, 7>;  // position, quaternion (x y z w)

// The uniform B-spline of degree 5 whose support begins at zero, one unit for each segment, and its first two
// derivatives: sums of truncated powers (de Boor, A Practical Guide to Splines, chapter IX).
std::array<double, 3> Basis(double u) {
  constexpr std::array<double, kTerms + 1> kBinomials{1, -6, 15, -20, 15, -6, 1};  // from: derivation
  constexpr std::array<double, 3> kFactorials{120, 24, 6};                         // from: derivation
  std::array<double, 3> value{};
  for (int j = 0; j <= kTerms; ++j) {
    if (u <= j) break;
    for (int d = 0; d < 3; ++d) value[d] += kBinomials[j] * std::pow(u - j, kDegree - d) / kFactorials[d];
  }
  return value;
}

// s, of the knots.
double SpacingOf(const std::vector<TimedPose>& path) {
  return kPosesOfSegment * (path.back().time - path.front().time) / static_cast<double>(path.size() - 1);
}

class RecordedTrajectory : public Trajectory {
 public:
  explicit RecordedTrajectory(const std::vector<TimedPose>& path)
      : start_(path.front().time),
        spacing_(SpacingOf(path)),
        segments_(static_cast<int>(std::ceil((path.back().time - start_) / spacing_))) {
    const int count = segments_ + kDegree;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 7);
    Eigen::Vector4d last = path.front().pose.rotation.coeffs();
    for (const TimedPose& pose : path) {
      // A quaternion and its negative are the same rotation; neighbours must be close.
      Eigen::Vector4d rotation = pose.pose.rotation.coeffs();
      if (rotation.dot(last) < 0.0) rotation = -rotation;
      last = rotation;
      PoseRow row;
      row << pose.pose.translation.transpose(), rotation.transpose();
      const Weights weights = At(pose.time);
      for (int i = 0; i < kTerms; ++i) {
        right.row(weights.first + i) += weights.of[i][0] * row;
        for (int j = 0; j < kTerms; ++j) {
          entries.emplace_back(weights.first + i, weights.first + j, weights.of[i][0] * weights.of[j][0]);
        }
      }
    }
    // What no pose shows at the ends stays small. from: guard
    for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1e-12);
    Eigen::SparseMatrix<double> normal(count, count);
    normal.setFromTriplets(entries.begin(), entries.end());
    knots_ = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
  }

  RigidTransform PoseAt(double time) const override { return PoseOf(Value(At(time), 0)); }

  MotionState StateAt(double time) const override {
    const Weights weights = At(time);
    const PoseRow value = Value(weights, 0), first = Value(weights, 1), second = Value(weights, 2);
    const Eigen::Quaterniond q(value[6], value[3], value[4], value[5]);
    const Eigen::Quaterniond rate(first[6], first[3], first[4], first[5]);
    MotionState state;
    state.T_map_imu = PoseOf(value);
    state.velocity = first.head<3>().transpose();
    state.acceleration = second.head<3>().transpose();
    // Of q / |q|: what changes the length is along q and has no part in the vector.
    state.angular_velocity = 2.0 * (q.conjugate() * rate).vec() / q.squaredNorm();
    return state;
  }

 private:
  struct Weights {
    int first;                                     // knot
    std::array<std::array<double, 3>, kTerms> of;  // each knot's, and their derivatives by time
  };

  Weights At(double time) const {
    const double at = std::clamp((time - start_) / spacing_, 0.0, static_cast<double>(segments_));
    Weights weights;
    weights.first = std::min(static_cast<int>(at), segments_ - 1);
    for (int i = 0; i < kTerms; ++i) {
      weights.of[i] = Basis(at - weights.first + kDegree - i);
      weights.of[i][1] /= spacing_;
      weights.of[i][2] /= spacing_ * spacing_;
    }
    return weights;
  }

  PoseRow Value(const Weights& weights, int derivative) const {
    PoseRow value = PoseRow::Zero();
    for (int i = 0; i < kTerms; ++i) value += weights.of[i][derivative] * knots_.row(weights.first + i);
    return value;
  }

  static RigidTransform PoseOf(const PoseRow& value) {
    return {Eigen::Quaterniond(value[6], value[3], value[4], value[5]).normalized(),
            value.head<3>().transpose()};
  }

  double start_, spacing_;  // s
  int segments_;
  Eigen::MatrixXd knots_;
};

// The spline is shown nothing where poses lie further apart than its knots.
void CheckSteps(const std::vector<TimedPose>& path) {
  const double longest = SpacingOf(path);
  for (std::size_t k = 1; k < path.size(); ++k) {
    const double step = path[k].time - path[k - 1].time;
    if (step > 0.0 && step <= longest) continue;
    throw InputError("the recorded path has its poses " + std::to_string(k) + " and " +
                     std::to_string(k + 1) + " " + std::to_string(step) +
                     " s apart; expected steps above zero of at most " + std::to_string(longest) +
                     " s, four times their mean");
  }
}

}  // namespace

RecordedMotion PartOf(const RecordedMotion& whole, double begin, double duration) {
  if (whole.path.empty()) throw InputError("the recorded path holds no pose; expected one in each line");
  const double start = whole.path.front().time + begin;
  RecordedMotion part;
  Eigen::AlignedBox3d box;
  for (const TimedPose& pose : whole.path) {
    const double time = pose.time - start;
    if (time < -kMargin || time > duration + kMargin) continue;
    part.path.push_back({time, pose.pose});
    box.extend(pose.pose.translation);
  }
  if (part.path.empty() || part.path.front().time > 0.0 || part.path.back().time < duration) {
    throw InputError("the recorded path lasts " +
                     std::to_string(whole.path.back().time - whole.path.front().time) +
                     " s; expected the whole of what was asked for, from " + std::to_string(begin) +
                     " s to " + std::to_string(begin + duration) + " s");
  }
  const bool across = box.sizes().y() > box.sizes().x();
  const RigidTransform turn{
      Eigen::Quaterniond(Eigen::AngleAxisd(across ? -M_PI / 2.0 : 0.0, Eigen::Vector3d::UnitZ())),
      Eigen::Vector3d::Zero()};
  const Eigen::Vector3d middle(box.center().x(), box.center().y(), box.min().z() - kLowest);
  for (TimedPose& pose : part.path) {
    pose.pose.translation -= middle;
    pose.pose = turn * pose.pose;
  }
  for (const ImuSample& reading : whole.readings) {
    const double time = reading.time - start;
    if (time < 0.0 || time > duration) continue;
    part.readings.push_back(reading);
    part.readings.back().time = time;
  }
  if (!whole.readings.empty() && (part.readings.empty() || part.readings.front().time > kLatest ||
                                  part.readings.back().time < duration - kLatest)) {
    throw InputError(
        "the readings do not cover the part of the path; expected those of the same clock, from " +
        std::to_string(begin) + " s after the first pose for " + std::to_string(duration) + " s");
  }
  return part;
}

std::unique_ptr<Trajectory> MakeRecordedTrajectory(const std::vector<TimedPose>& path) {
  if (path.size() < kFewestPoses) {
    throw InputError("the recorded path has " + std::to_string(path.size()) + " poses; expected at least " +
                     std::to_string(kFewestPoses));
  }
  CheckSteps(path);
  return std::make_unique<RecordedTrajectory>(path);
}

}  // namespace mlic::sim
