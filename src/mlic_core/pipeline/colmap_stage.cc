// The part of camera_stages.h that runs COLMAP.
#include <cstdio>

#include "mlic_core/camera/colmap/colmap.h"
#include "mlic_core/pipeline/camera_stages.h"
#include "mlic_core/pipeline/stage_names.h"

namespace mlic {
namespace {

// Of the drive with the most observations of the camera; COLMAP takes one drive at a time.
ColmapInput RichestInput(const std::vector<TrackSet>& tracks, std::size_t camera,
                         const CameraIntrinsics& start) {
  ColmapInput richest;
  std::size_t most = 0;
  for (const TrackSet& drive : tracks) {
    ColmapInput input = ColmapInputFromTracks(drive, static_cast<int>(camera), start);
    std::size_t observations = 0;
    for (const auto& pixels : input.keypoints) observations += pixels.size();
    if (observations < most) continue;
    most = observations;
    richest = std::move(input);
  }
  return richest;
}

// What the stage says of one camera; whether its intrinsics are to be taken.
bool Judge(const std::string& name, const ColmapOutcome& outcome, std::vector<std::string>* lines) {
  if (!outcome.model) {
    lines->push_back(name + " keeps the start from its field of view: " + outcome.problem);
    return false;
  }
  const ColmapModel& model = *outcome.model;
  char line[200];
  std::snprintf(line, sizeof(line),
                "%s: focal length %.1f px, %.0f %% of the images registered, %.2f px rms, %.0f %% of the "
                "image covered",
                name.c_str(), model.intrinsics.parameters[0], 100.0 * model.registered_share,
                model.reprojection_rms, 100.0 * model.coverage);
  lines->push_back(line);
  for (const std::string& problem : model.problems) {
    lines->push_back(name + " keeps the start from its field of view: " + problem);
  }
  return model.problems.empty();
}

// Runs COLMAP on the cameras that need it. The intrinsics of those found, and what is to be said.
CameraInitialization IntrinsicsByColmap(const StageContext& context, const std::vector<bool>& wanted,
                                        const std::vector<TrackSet>& tracks,
                                        const std::vector<CameraStart>& start, bool* installed,
                                        StageClock* stage) {
  CameraInitialization result;
  result.cameras.resize(start.size());
  result.found.assign(start.size(), false);
  std::vector<std::size_t> asked;
  std::vector<ColmapInput> inputs;
  for (std::size_t c = 0; c < start.size(); ++c) {
    if (!wanted[c] || !start[c].from_field_of_view) continue;
    asked.push_back(c);
    inputs.push_back(RichestInput(tracks, c, start[c].intrinsics));
    inputs.back().folder = context.rig.cameras[c].name;
  }
  const std::filesystem::path directory = context.options.colmap_directory.empty()
                                              ? std::filesystem::temp_directory_path() / "mlic_colmap"
                                              : context.options.colmap_directory;
  const auto outcomes = RunColmap(inputs, {}, directory, context.cancellation,
                                  [stage](double fraction) { stage->Progress(fraction); });
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (!outcomes[i].installed) {
      *installed = false;
      result.notes = {outcomes[i].problem + "; the cameras keep the start from their fields of view"};
      return result;
    }
    const std::size_t c = asked[i];
    result.found[c] = Judge(context.rig.cameras[c].name, outcomes[i], &result.notes);
    if (result.found[c]) result.cameras[c].intrinsics = outcomes[i].model->intrinsics;
  }
  return result;
}

}  // namespace

bool ColmapStage(const StageContext& context, const std::vector<bool>& asked,
                 const std::vector<TrackSet>& tracks, std::vector<CameraStart>* start) {
  constexpr const char* kName = "colmap";
  StageClock stage(stage_names::kColmap, context);
  CameraInitialization result;
  bool installed = true;
  if (context.Load(kName, &result)) {
    stage.TakeOver({});
  } else {
    result = IntrinsicsByColmap(context, asked, tracks, *start, &installed, &stage);
    // Without COLMAP nothing is kept: it may be there when the run is taken up again.
    if (installed) context.Save(kName, result);
  }
  for (const std::string& note : result.notes) stage.Line(note);
  if (!installed) context.result->warnings.push_back(result.notes.front());
  bool changed = false;
  for (std::size_t c = 0; c < result.found.size(); ++c) {
    if (!result.found[c]) continue;
    (*start)[c] = {result.cameras[c].intrinsics, false};
    changed = true;
  }
  return changed;
}

}  // namespace mlic
