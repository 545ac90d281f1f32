#include "mlic_core/lidar/azimuth_time.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdlib>
#include <map>

#include "mlic_core/common/order_statistics.h"

namespace mlic {
namespace {

constexpr double kTurn = 2.0 * M_PI;  // from: structural
// from: guard, some degrees of a turn.
constexpr double kSeamSlack = 10.0 * M_PI / 180.0;  // how far the lasers' azimuths differ at one firing
// from: guard, nearly all do of a spinning LiDAR, half of others.
constexpr double kSteadyShare = 0.8;  // of the steps must go the common way

double Wrapped(double angle) { return std::remainder(angle, kTurn); }

// Points that were measured one after the other, as indices, with their azimuths.
struct Sweep {
  std::vector<std::size_t> points;
  std::vector<double> azimuths;
};

bool HasReturn(const Eigen::Vector3f& point) { return point.allFinite() && point.squaredNorm() > 1e-6f; }

std::vector<Sweep> SplitByRing(const std::vector<Eigen::Vector3f>& points,
                               const std::vector<std::uint16_t>& rings) {
  std::map<std::uint16_t, Sweep> sweeps;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!HasReturn(points[i])) continue;
    Sweep& sweep = sweeps[rings.empty() ? 0 : rings[i]];
    sweep.points.push_back(i);
    sweep.azimuths.push_back(std::atan2(points[i].y(), points[i].x()));
  }
  std::vector<Sweep> result;
  for (auto& entry : sweeps) result.push_back(std::move(entry.second));
  std::stable_sort(result.begin(), result.end(),
                   [](const Sweep& a, const Sweep& b) { return a.points.size() > b.points.size(); });
  return result;
}

bool CoversTheCircle(const std::vector<Sweep>& sweeps) {
  std::bitset<72> seen;
  for (const Sweep& sweep : sweeps) {
    for (const double azimuth : sweep.azimuths) {
      seen.set(std::min<std::size_t>(71, static_cast<std::size_t>((azimuth + M_PI) / kTurn * 72.0)));
    }
  }
  return seen.count() >= 60;
}

// Several lasers in firing order jitter by degrees from point to point: then steps are taken over many
// points.
std::size_t StepLength(const Sweep& sweep, bool one_laser) {
  return one_laser ? 1 : std::max<std::size_t>(1, sweep.points.size() / 200);
}

// +1 for rising azimuth (counter-clockwise seen from above), -1 for falling, 0 when it does neither steadily.
int DirectionOfSpin(const std::vector<Sweep>& sweeps, bool one_laser) {
  std::size_t rising = 0, falling = 0;
  for (const Sweep& sweep : sweeps) {
    const std::size_t step = StepLength(sweep, one_laser);
    for (std::size_t i = step; i < sweep.azimuths.size(); i += step) {
      const double change = Wrapped(sweep.azimuths[i] - sweep.azimuths[i - step]);
      if (change > 0.0) ++rising;
      if (change < 0.0) ++falling;
    }
  }
  const double total = static_cast<double>(rising + falling);
  if (static_cast<double>(rising) >= kSteadyShare * total && rising > 0) return 1;
  if (static_cast<double>(falling) >= kSteadyShare * total && falling > 0) return -1;
  return 0;
}

// The azimuth where the revolution starts: the median over the fullest rings, for in others the first returns
// lack.
double StartOfRevolution(const std::vector<Sweep>& sweeps) {
  const double reference = sweeps.front().azimuths.front();
  std::vector<double> differences;
  for (std::size_t i = 0; i < (sweeps.size() + 3) / 4; ++i) {
    differences.push_back(Wrapped(sweeps[i].azimuths.front() - reference));
  }
  return reference + Median(std::move(differences));
}

// Angle passed since `start` for each point of the sweep, in the direction of spin.
std::vector<double> AnglePassed(const Sweep& sweep, double start, int direction, bool one_laser) {
  double passed = std::fmod(direction * (sweep.azimuths.front() - start), kTurn);
  if (passed < 0.0) passed += kTurn;
  if (passed > kTurn - kSeamSlack) passed -= kTurn;
  const std::size_t step = StepLength(sweep, one_laser);
  std::vector<double> result;
  result.reserve(sweep.azimuths.size());
  double reference = sweep.azimuths.front();
  for (std::size_t i = 0; i < sweep.azimuths.size(); ++i) {
    const double change = direction * Wrapped(sweep.azimuths[i] - reference);
    result.push_back(passed + change);
    if (i % step == 0 && (!one_laser || change > 0.0)) {
      passed += change;
      reference = sweep.azimuths[i];
    }
  }
  return result;
}

}  // namespace

std::optional<std::vector<float>> TimesFromAzimuth(const std::vector<Eigen::Vector3f>& points,
                                                   const std::vector<std::uint16_t>& rings, double period) {
  const std::vector<Sweep> sweeps = SplitByRing(points, rings);
  if (sweeps.empty() || !CoversTheCircle(sweeps)) return std::nullopt;
  const bool one_laser = !rings.empty();
  const int direction = DirectionOfSpin(sweeps, one_laser);
  if (direction == 0) return std::nullopt;

  const double start = StartOfRevolution(sweeps);
  std::vector<float> times(points.size(), 0.0f);
  for (const Sweep& sweep : sweeps) {
    const std::vector<double> passed = AnglePassed(sweep, start, direction, one_laser);
    for (std::size_t i = 0; i < passed.size(); ++i) {
      // Without ring numbers, ring after ring passes the start anew; with them there is one turn.
      double share = passed[i] / kTurn;
      if (!one_laser && passed.back() > 1.5 * kTurn) share -= std::floor(share);
      times[sweep.points[i]] = static_cast<float>(period * std::clamp(share, 0.0, 1.0));
    }
  }
  return times;
}

}  // namespace mlic
