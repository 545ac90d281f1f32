#include "mlic_core/pipeline/pair_stage.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mlic_core/initialization/lidars_alone.h"
#include "mlic_core/pipeline/adjustment_context.h"
#include "mlic_core/pipeline/kept_adjustment.h"
#include "mlic_core/pipeline/pair_adjustment.h"
#include "mlic_core/pipeline/pair_cameras.h"
#include "mlic_core/summary/pair_assembly.h"

namespace mlic {
namespace {

// Whether it is only that the motion does not tie the sensors to the IMU: what else speaks against the
// recording speaks against its maps as well.
bool OnlyNotTied(const CalibrationResult& result) {
  return std::all_of(result.checks.begin(), result.checks.end(), [](const QualityCheck& check) {
    return check.Passed() || !check.refuses || check.name == "convergence" ||
           check.name.rfind("excitation_", 0) == 0;
  });
}

// The cameras' pairs; why others are in none joins the reasons.
std::vector<PairResult> CameraPairs(const StageContext& context, const Adjustment* whole,
                                    const std::vector<PairResult>& known, const Adjustment& lidars,
                                    LidarsAlone* alone) {
  if (!WithCameras(context)) return {};
  PairedCameras paired = PairCameras(context, whole, known, lidars, alone);
  CalibrationResult* result = context.result;
  for (const SensorProblem& problem : paired.problems) {
    result->reasons.push_back(problem.reason);
    std::vector<RejectedSensor>& rejected = result->rejected;
    const bool known = std::any_of(rejected.begin(), rejected.end(), [&](const RejectedSensor& sensor) {
      return sensor.name == problem.sensor;
    });
    if (!known) rejected.push_back({problem.sensor, SensorResult::Type::kCamera, problem.reason});
  }
  // These are of the poses that the pairs give; those of the calibration that was refused are of others.
  for (CameraProjection& projection : paired.projections) {
    std::vector<CameraProjection>& all = result->projections;
    const auto same = std::find_if(all.begin(), all.end(), [&](const CameraProjection& other) {
      return other.camera == projection.camera;
    });
    (same == all.end() ? *all.emplace(same) : *same) = std::move(projection);
  }
  return std::move(paired.pairs);
}

// Those further pairs that are not there yet.
void AddMissing(const std::vector<PairResult>& further, std::vector<PairResult>* pairs) {
  for (const PairResult& pair : further) {
    const bool there = std::any_of(pairs->begin(), pairs->end(), [&](const PairResult& other) {
      return other.a == pair.a && other.b == pair.b;
    });
    if (!there) pairs->push_back(pair);
  }
}

}  // namespace

bool WithCameras(const StageContext& context) {
  return !context.rig.cameras.empty() && !context.options.check_of;
}

void PairStage(const StageContext& context, const DriveOdometry& odometry, const Adjustment* whole) {
  CalibrationResult* result = context.result;
  if (result->verdict != Verdict::kRefused) return;
  std::vector<PairResult> pairs = PairsOfRefused(whole, *result);
  result->pairs.clear();
  const bool any = context.rig.lidars.size() > 1 || WithCameras(context);
  if (!any || !OnlyNotTied(*result)) return;
  // Without what the gyroscope shows of the clocks, pairs are less well known: only for what is missing.
  const std::optional<std::string> root = RootOf(context.rig, pairs);
  if (root && TieAll(context.rig, *root, pairs)) {
    return AssemblePairs(context.rig, *root, *whole, std::move(pairs), result);
  }
  constexpr const char* kFile = "pair_adjustment";
  LidarsAlone alone = InitializeLidarsAlone(context.rig, context.dataset, odometry, context.cancellation);
  Adjustment adjustment;
  {
    StageClock stage("pairs without the IMU", context);
    for (const std::string& note : alone.start.notes) stage.Line(note);
    const std::vector<std::string>& problems = alone.start.problems;
    result->reasons.insert(result->reasons.end(), problems.begin(), problems.end());
    if (alone.start.state.drives.empty()) {
      stage.Line("no sensor is found in a LiDAR's map");
      if (root) AssemblePairs(context.rig, *root, *whole, std::move(pairs), result);
      return;
    }
    const AdjustmentContext of_stage{alone.rig, alone.dataset, context.observer,
                                     ContextOf(context, &stage).monitor};
    bool found;
    adjustment = TakeOver(context, kFile, StartPairAdjustment(alone), &found);
    if (found) stage.TakeOver(adjustment.lines, " up to round " + std::to_string(adjustment.rounds.done));
    adjustment = AdjustPairs(std::move(adjustment), of_stage,
                             [&](const Adjustment& now) { Keep(context, stage, kFile, now); });
  }
  const std::vector<PairResult> of_cameras = CameraPairs(context, whole, pairs, adjustment, &alone);
  if (root && !CanGivePairs(adjustment)) {
    return AssemblePairs(context.rig, *root, *whole, std::move(pairs), result);
  }
  AddMissing(MakeLidarPairs(alone, adjustment), &pairs);
  AddMissing(of_cameras, &pairs);
  const std::string of_maps = alone.rig.lidars[alone.root].name;
  AssemblePairs(context.rig, RootOf(context.rig, pairs, of_maps).value_or(of_maps), adjustment,
                std::move(pairs), result);
}

}  // namespace mlic
