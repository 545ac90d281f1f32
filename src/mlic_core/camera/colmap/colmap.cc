#include "mlic_core/camera/colmap/colmap.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "mlic_core/camera/colmap/colmap_camera.h"
#include "mlic_core/camera/colmap/colmap_database.h"
#include "mlic_core/camera/colmap/colmap_model.h"
#include "mlic_core/camera/colmap/colmap_process.h"
#include "mlic_core/common/error.h"
#include "mlic_core/common/parallel.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

// COLMAP's fisheye models go through the normalised image plane, so they end before 90 deg.
constexpr double kWidestAngle = 80.0 * M_PI / 180.0;  // from: derivation
constexpr std::size_t kFewestMatches = 15;            // of a pair, as COLMAP's mapper has it; from: standard
constexpr int kFewestKeyframes = 3;                   // from: structural, three views fix a scale
constexpr int kCells = 8;                             // from: structural

// Colour is left out, as COLMAP never sees the images. The matches are verified tracks of keyframes that lie
// far apart: few, but hardly one of them wrong, so fewer are asked for than COLMAP does by default; and a
// vehicle that drives forward is taken as it is.
constexpr std::pair<const char*, const char*> kMapperOptions[] = {{"extract_colors", "0"},
                                                                  {"num_threads", "1"},
                                                                  {"max_num_models", "3"},
                                                                  {"init_min_num_inliers", "30"},
                                                                  {"abs_pose_min_num_inliers", "12"},
                                                                  {"init_max_forward_motion", "1"},
                                                                  {"init_min_tri_angle", "8"}};

std::string Text(const char* format, double a, double b = 0.0) {
  char text[200];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

// Which features COLMAP's model can hold.
std::vector<std::vector<bool>> UsableFeatures(const ColmapInput& input) {
  const bool fisheye = ColmapModelFor(input.start.model) == ColmapModelId::kOpenCvFisheye;
  std::vector<std::vector<bool>> usable;
  for (const auto& pixels : input.keypoints) {
    std::vector<bool> good(pixels.size(), true);
    for (std::size_t i = 0; fisheye && i < pixels.size(); ++i) {
      Eigen::Vector3d bearing;
      good[i] =
          Unproject(input.start, pixels[i].cast<double>(), &bearing) && bearing.z() > std::cos(kWidestAngle);
    }
    usable.push_back(good);
  }
  return usable;
}

std::vector<PairMatches> UsableMatches(const ColmapInput& input) {
  const auto usable = UsableFeatures(input);
  std::vector<PairMatches> pairs;
  for (const PairMatches& pair : input.matches) {
    PairMatches kept{pair.keyframe_a, pair.keyframe_b, {}};
    for (const FeatureMatch& match : pair.matches) {
      if (usable[static_cast<std::size_t>(pair.keyframe_a)][static_cast<std::size_t>(match.a)] &&
          usable[static_cast<std::size_t>(pair.keyframe_b)][static_cast<std::size_t>(match.b)]) {
        kept.matches.push_back(match);
      }
    }
    if (kept.matches.size() >= kFewestMatches) pairs.push_back(kept);
  }
  return pairs;
}

// Why the mapper makes no model: newer versions fail with it, COLMAP 3.6 ends well with nothing made.
constexpr const char* kNoInitialPair =
    ": no two images with enough parallax and matches; record more translation in front of textured, lit "
    "surroundings, or give the camera's intrinsics";

// What the last line of COLMAP's output means for the user.
std::string Explain(const ProcessEnd& end, const fs::path& log) {
  const std::string& line = end.last_line;
  std::string meaning = "; see " + log.string();
  if (line.find("initial") != std::string::npos || line.find("failed to create") != std::string::npos) {
    meaning = kNoInitialPair;
  } else if (end.status >= 128) {
    meaning = " (signal " + std::to_string(end.status - 128) + "); see " + log.string();
  }
  return "COLMAP's mapper failed, its last line is '" + line + "'" + meaning;
}

// How many images the mapper says it has registered so far, in all its attempts.
std::size_t CountRegistered(const fs::path& log) {
  std::ifstream file(log);
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) count += line.rfind("Registering image", 0) == 0;
  return count;
}

fs::path LargestModel(const fs::path& sparse) {
  fs::path best;
  std::size_t most = 0;
  for (int i = 0; fs::exists(sparse / std::to_string(i) / "images.bin"); ++i) {
    const std::size_t images = ReadColmapModel(sparse / std::to_string(i)).images.size();
    if (images > most) {
      most = images;
      best = sparse / std::to_string(i);
    }
  }
  return best;
}

// Fills poses, points, observations and the figures of quality.
ColmapModel Summarize(const ColmapReconstruction& reconstruction, const ColmapInput& input) {
  ColmapModel model;
  const CameraIntrinsics& camera = reconstruction.camera;
  model.intrinsics =
      camera.model == input.start.model ? camera : FitCameraModel(camera, input.start.model, kWidestAngle);
  model.points = reconstruction.points;
  model.T_world_camera.resize(input.keypoints.size());
  std::set<int> cells;
  double squares = 0.0;
  for (const auto& image : reconstruction.images) {
    model.T_world_camera.at(static_cast<std::size_t>(image.keyframe)) = image.T_camera_world.Inverse();
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      Eigen::Vector2d projected;
      if (image.points[i] < 0 ||
          !Project(camera, image.T_camera_world * model.points[static_cast<std::size_t>(image.points[i])],
                   &projected)) {
        continue;
      }
      const Eigen::Vector2d& pixel = image.pixels[i];
      squares += (projected - pixel).squaredNorm();
      const int column = static_cast<int>(kCells * (pixel.x() + 0.5) / camera.width);
      const int row = static_cast<int>(kCells * (pixel.y() + 0.5) / camera.height);
      cells.insert(kCells * std::clamp(row, 0, kCells - 1) + std::clamp(column, 0, kCells - 1));
      model.observations.push_back({image.keyframe, pixel.cast<float>(), 0.5f});
      model.observed_points.push_back(image.points[i]);
    }
  }
  model.registered_share =
      static_cast<double>(reconstruction.images.size()) / static_cast<double>(input.keypoints.size());
  model.coverage = static_cast<double>(cells.size()) / (kCells * kCells);
  if (!model.observations.empty()) {
    model.reprojection_rms = std::sqrt(squares / static_cast<double>(model.observations.size()));
  }
  return model;
}

void FindDoubts(const ColmapOptions& options, ColmapModel* model) {
  if (model->registered_share < options.least_registered_share) {
    model->problems.push_back(Text("COLMAP registered %.0f%% of the keyframes, expected %.0f%%",
                                   100.0 * model->registered_share, 100.0 * options.least_registered_share));
  }
  if (!(model->reprojection_rms <= options.largest_rms)) {
    model->problems.push_back(Text("COLMAP's points are off by %.2f px (rms), expected at most %.2f",
                                   model->reprojection_rms, options.largest_rms));
  }
  if (model->coverage < options.least_coverage) {
    model->problems.push_back(Text("COLMAP's points cover %.0f%% of the image, expected %.0f%%",
                                   100.0 * model->coverage, 100.0 * options.least_coverage));
  }
}

// The commands in turn; the problem of the first that fails, or nothing.
class Runner {
 public:
  Runner(const ColmapOptions& options, const fs::path& directory, const CancellationToken& cancellation,
         const ColmapProgress& progress)
      : options_(options),
        directory_(directory),
        log_(directory / "colmap.log"),
        cancellation_(cancellation),
        progress_(progress) {
    std::error_code error;
    fs::remove_all(directory, error);
    fs::create_directories(directory / "sparse", error);
    if (error) throw InputError(directory.string() + ": cannot be written: " + error.message());
  }

  fs::path Database() const { return directory_ / "database.db"; }
  bool installed() const { return installed_; }

  std::string CreateDatabase() {
    return Run({options_.program, "database_creator", "--database_path", Database().string()});
  }

  std::string Map(std::size_t keyframes) {
    const std::size_t least = std::max<std::size_t>(3, std::min<std::size_t>(10, keyframes / 3));
    const auto meanwhile = [&] {
      if (progress_) progress_(std::min(0.95, static_cast<double>(CountRegistered(log_)) / keyframes));
    };
    std::vector<std::string> command{options_.program,  "mapper",
                                     "--database_path", Database().string(),
                                     "--image_path",    directory_.string(),
                                     "--output_path",   (directory_ / "sparse").string()};
    for (const auto& [key, value] : kMapperOptions) {
      command.push_back(std::string("--Mapper.") + key);
      command.push_back(value);
    }
    command.insert(command.end(), {"--Mapper.min_model_size", std::to_string(least)});
    return Run(command, meanwhile);
  }

  std::string RefinePrincipalPoint(const fs::path& model, const fs::path& refined) {
    fs::create_directories(refined);
    return Run({options_.program, "bundle_adjuster", "--input_path", model.string(), "--output_path",
                refined.string(), "--BundleAdjustment.refine_principal_point", "1"});
  }

 private:
  std::string Run(const std::vector<std::string>& command, const std::function<void()>& meanwhile = {}) {
    const ProcessEnd end = RunProcess(command, log_, cancellation_, meanwhile);
    if (!end.found) {
      installed_ = false;
      return "COLMAP is not installed (no program '" + options_.program +
             "'): apt-get install colmap, or give the cameras' intrinsics in the rig file";
    }
    return end.Good() ? "" : Explain(end, log_);
  }

  const ColmapOptions& options_;
  const fs::path directory_;
  const fs::path log_;
  const CancellationToken& cancellation_;
  const ColmapProgress& progress_;
  bool installed_ = true;
};

}  // namespace

ColmapInput ColmapInputFromTracks(const TrackSet& tracks, int camera, const CameraIntrinsics& start) {
  ColmapInput input;
  input.start = start;
  std::vector<int> local(tracks.keyframes.size(), -1);
  for (std::size_t k = 0; k < tracks.keyframes.size(); ++k) {
    if (tracks.keyframes[k].camera != camera) continue;
    local[k] = static_cast<int>(input.keyframes.size());
    input.keyframes.push_back(static_cast<int>(k));
  }
  input.keypoints.resize(input.keyframes.size());
  std::map<std::pair<int, int>, std::vector<FeatureMatch>> pairs;
  for (const Track& track : tracks.tracks) {
    std::vector<std::pair<int, int>> observations;  // keyframe, keypoint
    for (const TrackObservation& observation : track.observations) {
      const int keyframe = local[static_cast<std::size_t>(observation.keyframe)];
      if (keyframe < 0) continue;
      auto& points = input.keypoints[static_cast<std::size_t>(keyframe)];
      observations.emplace_back(keyframe, static_cast<int>(points.size()));
      points.push_back(observation.pixel);
    }
    for (std::size_t a = 0; a < observations.size(); ++a) {
      for (std::size_t b = a + 1; b < observations.size(); ++b) {
        pairs[{observations[a].first, observations[b].first}].push_back(
            {observations[a].second, observations[b].second, 1.0f});
      }
    }
  }
  for (auto& [pair, matches] : pairs) input.matches.push_back({pair.first, pair.second, std::move(matches)});
  return input;
}

ColmapOutcome RunColmap(const ColmapInput& input, const ColmapOptions& options, const fs::path& directory,
                        const CancellationToken& cancellation, const ColmapProgress& progress) {
  const std::vector<PairMatches> matches = UsableMatches(input);
  if (static_cast<int>(input.keypoints.size()) < kFewestKeyframes || matches.empty()) {
    return {{},
            "too few keyframes or matches for COLMAP (" + std::to_string(input.keypoints.size()) +
                " keyframes, " + std::to_string(matches.size()) + " pairs with " +
                std::to_string(kFewestMatches) + " matches); the images are dark, blurred or without texture",
            true};
  }
  Runner runner(options, directory, cancellation, progress);
  std::string problem = runner.CreateDatabase();
  if (!problem.empty()) return {{}, problem, runner.installed()};
  FillColmapDatabase(runner.Database(), ToColmapModel(input.start), input.keypoints, matches);
  problem = runner.Map(input.keypoints.size());
  const fs::path mapped = LargestModel(directory / "sparse");
  if (mapped.empty()) {
    return {{}, problem.empty() ? std::string("COLMAP made no model") + kNoInitialPair : problem, true};
  }
  const fs::path refined = directory / "refined";
  const fs::path chosen = runner.RefinePrincipalPoint(mapped, refined).empty() ? refined : mapped;
  ColmapModel model = Summarize(ReadColmapModel(chosen), input);
  FindDoubts(options, &model);
  return {model, "", true};
}

std::vector<ColmapOutcome> RunColmap(const std::vector<ColmapInput>& inputs, const ColmapOptions& options,
                                     const fs::path& directory, const CancellationToken& cancellation,
                                     const ColmapProgress& progress) {
  std::vector<ColmapOutcome> outcomes(inputs.size());
  std::vector<double> done(inputs.size(), 0.0);
  std::mutex mutex;
  const auto tell = [&](std::size_t i, double fraction) {
    if (!progress) return;
    const std::lock_guard<std::mutex> lock(mutex);
    done[i] = fraction;
    double sum = 0.0;
    for (const double of_input : done) sum += of_input;
    progress(sum / static_cast<double>(done.size()));
  };
  ParallelFor(inputs.size(), [&](std::size_t i) {
    const std::string folder = inputs[i].folder.empty() ? std::to_string(i) : inputs[i].folder;
    outcomes[i] = RunColmap(inputs[i], options, directory / folder, cancellation,
                            [&](double fraction) { tell(i, fraction); });
    tell(i, 1.0);
  });
  return outcomes;
}

}  // namespace mlic
