#include "mlic_core/evaluation/movements.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mlic_core/evaluation/smallest_cover.h"
#include "mlic_core/evaluation/truth_comparison.h"
#include "mlic_core/geometry/so3.h"
#include "mlic_core/sensors/observability_limits.h"

namespace mlic {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  // from: structural
constexpr std::size_t kImu = 0;                                     // the sensors follow; from: structural

// T_a_b before and now, sigmas of both; sigma.time_offset and clock: of offset_b - offset_a, NaN where not
// compared.
struct Relation {
  std::size_t a = 0, b = 0;
  RigidTransform before, now;
  PoseSigma sigma;
  double clock = kNone;
};

PoseSigma OfBoth(const PoseSigma& first, const PoseSigma& second) {
  PoseSigma sigma;
  sigma.translation = (first.translation.cwiseAbs2() + second.translation.cwiseAbs2()).cwiseSqrt();
  sigma.rotation = (first.rotation.cwiseAbs2() + second.rotation.cwiseAbs2()).cwiseSqrt();
  sigma.time_offset = std::hypot(first.time_offset, second.time_offset);
  return sigma;
}

// The offset of a clock that drifts holds for its own drive only.
double OffsetChange(const SensorResult& now, const SensorResult& before) {
  if (now.calibration.clock_drift || before.calibration.clock_drift) return kNone;
  return now.calibration.time_offset - before.calibration.time_offset;
}

// What sensors of both calibrations are called.
std::vector<std::string> Bodies(const CalibrationResult& check, const CalibrationResult& calibration) {
  std::vector<std::string> names{kImuBody};
  for (const SensorResult& sensor : calibration.sensors) {
    const bool in_pairs = std::any_of(check.pairs.begin(), check.pairs.end(), [&](const PairResult& pair) {
      return pair.a == sensor.name || pair.b == sensor.name;
    });
    if (in_pairs || FindSensor(check, sensor.name) != nullptr) names.push_back(sensor.name);
  }
  return names;
}

std::vector<Relation> Relations(const std::vector<std::string>& bodies, const CalibrationResult& check,
                                const CalibrationResult& calibration) {
  std::vector<Relation> relations;
  const auto place = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(bodies.begin() + 1, bodies.end(), name) - bodies.begin());
  };
  const auto clock = [&](const std::string& name) {
    const SensorResult* now = FindSensor(check, name);
    return now == nullptr ? kNone : OffsetChange(*now, *FindSensor(calibration, name));
  };
  for (const SensorResult& now : check.sensors) {
    const std::size_t at = place(now.name);
    if (at == bodies.size()) continue;
    const SensorResult& before = *FindSensor(calibration, now.name);
    relations.push_back({kImu, at, before.calibration.T_imu_sensor, now.calibration.T_imu_sensor,
                         OfBoth(now.sigma, before.sigma), clock(now.name)});
  }
  for (const PairResult& now : check.pairs) {
    const std::size_t a = place(now.a), b = place(now.b);
    if (a == bodies.size() || b == bodies.size()) continue;
    const auto before = std::find_if(calibration.pairs.begin(), calibration.pairs.end(),
                                     [&](const PairResult& p) { return p.a == now.a && p.b == now.b; });
    if (before == calibration.pairs.end()) continue;
    relations.push_back(
        {a, b, before->T_a_b, now.T_a_b, OfBoth(now.sigma, before->sigma), clock(now.b) - clock(now.a)});
  }
  return relations;
}

struct Change {
  Eigen::Vector3d rotation, translation;  // in a's axes
};

Change ChangeOf(const Relation& relation) {
  return {Log(Eigen::Quaterniond(relation.now.rotation * relation.before.rotation.conjugate()).normalized()),
          relation.now.translation - relation.before.translation};
}

double MostSigmas(const Eigen::Vector3d& change, const Eigen::Vector3d& sigma) {
  double most = kNone;
  for (int k = 0; k < 3; ++k) {
    if (sigma[k] > 0.0) most = std::fmax(most, std::abs(change[k]) / sigma[k]);
  }
  return most;
}

// In sigmas, NaN where the relation is not compared.
double MountDiffers(const Relation& relation) {
  const Change change = ChangeOf(relation);
  return std::fmax(MostSigmas(change.rotation, relation.sigma.rotation),
                   MostSigmas(change.translation, relation.sigma.translation));
}

double ClockDiffers(const Relation& relation) {
  return relation.sigma.time_offset > 0.0 ? std::abs(relation.clock) / relation.sigma.time_offset : kNone;
}

template <typename Sigmas>
std::vector<Difference> Differences(const std::vector<Relation>& relations, const Sigmas& sigmas) {
  std::vector<Difference> differences;
  for (const Relation& relation : relations) {
    const double differs = sigmas(relation);
    if (!std::isnan(differs)) differences.push_back({relation.a, relation.b, differs});
  }
  return differences;
}

Movement MovementOf(const Eigen::Vector3d& change, const Eigen::Vector3d& sigma, double largest_sigma,
                    double limit) {
  Movement movement;
  movement.value = change.norm();
  movement.sigmas = MostSigmas(change, sigma);
  movement.shown = kNone;
  for (int k = 0; k < 3; ++k) {
    if (!(sigma[k] <= largest_sigma) || sigma[k] == 0.0) {
      movement.not_checked.emplace_back(1, "xyz"[k]);
    } else {
      movement.shown = std::fmax(movement.shown, limit * sigma[k]);
    }
  }
  return movement;
}

// By how much of what counts as shown the relation is uncertain, along the axis that it shows least.
double Vagueness(const Relation& relation) {
  return std::max(relation.sigma.rotation.maxCoeff() / kRotationLimit,
                  relation.sigma.translation.maxCoeff() / kTranslationLimit);
}

// The relation that tells most of the body's pose, or of its clock, among those with bodies that stayed, with
// this body as its b.
template <typename Value>
std::optional<Relation> BestRelation(const std::vector<Relation>& relations, std::size_t body,
                                     const BodySet& moved, const Value& vagueness) {
  const Relation* best = nullptr;
  for (const Relation& relation : relations) {
    if (relation.a != body && relation.b != body) continue;
    if (moved.count(relation.a == body ? relation.b : relation.a) != 0) continue;
    if (std::isnan(vagueness(relation))) continue;
    if (best == nullptr || vagueness(relation) < vagueness(*best)) best = &relation;
  }
  if (best == nullptr) return std::nullopt;
  return *best;
}

// With the body as b; its sigmas stay along the axes of the pair's first sensor.
Relation SeenFrom(const Relation& relation, std::size_t body) {
  if (relation.b == body) return relation;
  Relation turned = relation;
  std::swap(turned.a, turned.b);
  turned.before = relation.before.Inverse();
  turned.now = relation.now.Inverse();
  turned.clock = -relation.clock;
  return turned;
}

BodyMovement MovementOfBody(const std::vector<std::string>& bodies, const std::vector<Relation>& relations,
                            std::size_t body, const std::pair<Cover, Cover>& moved, double limit) {
  BodyMovement result;
  result.name = bodies[body];
  result.rotation.sigmas = result.translation.sigmas = result.clock.sigmas = kNone;
  result.rotation.shown = result.translation.shown = result.clock.shown = kNone;
  if (const auto best = BestRelation(relations, body, moved.first.bodies, Vagueness)) {
    const Relation seen = SeenFrom(*best, body);
    result.against = bodies[seen.a];
    const Change change = ChangeOf(*best);
    result.rotation = MovementOf(change.rotation, best->sigma.rotation, kRotationLimit, limit);
    result.translation = MovementOf(change.translation, best->sigma.translation, kTranslationLimit, limit);
    result.translation.value = (seen.now.translation - seen.before.translation).norm();
    if (moved.first.bodies.count(body) != 0) {
      result.rotation.told = result.rotation.sigmas > limit;
      // Told by another relation where not by this one.
      result.translation.told = result.translation.sigmas > limit || !result.rotation.told;
    }
  }
  const auto time_sigma = [](const Relation& relation) {
    return std::isnan(ClockDiffers(relation)) ? kNone : relation.sigma.time_offset;
  };
  if (const auto best = BestRelation(relations, body, moved.second.bodies, time_sigma)) {
    result.clock.value = SeenFrom(*best, body).clock;
    result.clock.sigmas = ClockDiffers(*best);
    if (best->sigma.time_offset <= kTimeLimit) result.clock.shown = limit * best->sigma.time_offset;
    result.clock.told = moved.second.bodies.count(body) != 0;
  }
  return result;
}

}  // namespace

Movements FindMovements(const CalibrationResult& check, const CalibrationResult& calibration, double limit) {
  const std::vector<std::string> bodies = Bodies(check, calibration);
  const std::vector<Relation> relations = Relations(bodies, check, calibration);
  const std::vector<Difference> mounts = Differences(relations, MountDiffers);
  const std::vector<Difference> clocks = Differences(relations, ClockDiffers);
  const std::pair<Cover, Cover> moved{SmallestCover(mounts, limit, kImu), SmallestCover(clocks, limit, kImu)};
  Movements movements;
  movements.imu_moved = moved.first.bodies.count(kImu) != 0;
  movements.imu_clock_shifted = moved.second.bodies.count(kImu) != 0;
  for (std::size_t body = 1; body < bodies.size(); ++body) {
    movements.sensors.push_back(MovementOfBody(bodies, relations, body, moved, limit));
  }
  BodySet instead = moved.first.or_instead;
  instead.insert(moved.second.or_instead.begin(), moved.second.or_instead.end());
  for (const std::size_t body : instead) movements.or_instead.push_back(bodies[body]);
  const auto take_worst = [&](const std::vector<Difference>& differences, const Cover& cover,
                              const std::string& what) {
    for (const Difference& d : differences) {
      if (cover.bodies.count(d.a) != 0 || cover.bodies.count(d.b) != 0 || d.sigmas < movements.worst)
        continue;
      movements.worst = d.sigmas;
      movements.worst_of = what + " of " + bodies[d.b] + " to " + bodies[d.a];
    }
  };
  take_worst(mounts, moved.first, "pose");
  take_worst(clocks, moved.second, "time offset");
  return movements;
}

}  // namespace mlic
