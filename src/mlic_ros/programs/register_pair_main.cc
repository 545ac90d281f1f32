// register_pair --cloud FILE.pcd --image FILE.png [--cloud ... --image ...] --rig RIG.yaml --output DIR:
// where a camera sits on a LiDAR, from scans and the photos taken with them, nothing moving. The LiDAR takes
// the IMU's place in calibration.yaml. Exit statuses: see program.h.
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/crossmodal/structure_alignment.h"
#include "mlic_core/ingest/image_stream.h"
#include "mlic_core/io/output_directory.h"
#include "mlic_core/io/result/point_cloud_reader.h"
#include "mlic_core/io/rig/rig_file.h"
#include "mlic_core/io/text_file.h"
#include "mlic_core/io/write_results.h"
#include "mlic_core/pipeline/still_pair.h"
#include "mlic_ros/programs/program.h"

namespace mlic {
namespace {

namespace fs = std::filesystem;

constexpr float kLeastRange = 0.5f;  // m: nearer returns are of the sensor's own mount; from: guard

struct RegisterOptions {
  std::vector<std::string> clouds, images;
  fs::path rig, output;
};

cv::Mat LoadPhoto(const fs::path& path) {
  if (!fs::exists(path)) throw InputError(path.string() + ": no such file");
  cv::Mat photo;
  try {
    photo = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    photo.release();
  }
  if (photo.empty()) throw InputError(path.string() + ": not an image; expected PNG or JPEG");
  return photo;
}

std::vector<MapReturn> LoadReturns(const fs::path& path) {
  if (!fs::exists(path)) throw InputError(path.string() + ": no such file");
  std::vector<MapReturn> returns;
  for (const CloudPoint& point : ReadPointCloudFile(path)) {
    if (point.position.norm() < kLeastRange) continue;
    MapReturn r;
    r.position = r.beam = point.position;
    r.intensity = point.intensity;
    r.ring = point.ring;
    returns.push_back(r);
  }
  if (returns.size() < 1000) {
    throw InputError(path.string() + ": has " + std::to_string(returns.size()) +
                     " points beyond 0.5 m; expected at least 1000");
  }
  return returns;
}

std::vector<ScanPhoto> LoadPairs(const RegisterOptions& options, const Rig& rig) {
  if (options.clouds.size() != options.images.size()) {
    throw InputError(std::to_string(options.clouds.size()) + " clouds and " +
                     std::to_string(options.images.size()) +
                     " images given; expected one --image for each --cloud, in the same order");
  }
  std::vector<ScanPhoto> pairs;
  for (std::size_t i = 0; i < options.clouds.size(); ++i) {
    ScanPhoto pair;
    pair.photo = LoadPhoto(options.images[i]);
    pair.returns = LoadReturns(options.clouds[i]);
    if (i > 0 && pair.photo.size() != pairs[0].photo.size()) {
      throw InputError(options.images[i] + ": is not of the size of " + options.images[0] +
                       "; all images must be of one camera");
    }
    if (rig.cameras.size() == 1 && !rig.cameras[0].mask.empty()) {
      pair.mask = LoadMask(options.rig.parent_path() / rig.cameras[0].mask, rig.cameras[0].name,
                           pair.photo.cols, pair.photo.rows);
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

std::string Describe(const PairRegistration& done) {
  char text[400];
  std::snprintf(text, sizeof(text),
                "structure score %.4f at the guess, %.4f now, at most %.4f where turned %.0f deg away\n"
                "NID %.4f at the guess, %.4f now\n%s\n",
                done.score_before, done.score_after, done.score_elsewhere, mlic::kAwayDegrees,
                done.nid_before, done.nid_after,
                done.matched ? "refined by single matches"
                             : "from all pixels together: single matches are too few or agree no better");
  std::string out = text;
  if (!done.result.Trusted()) return out;
  const SensorResult& camera = done.result.sensors[1];
  const RigidTransform& T = camera.calibration.T_imu_sensor;
  std::snprintf(text, sizeof(text),
                "T_lidar_camera: translation %.4f %.4f %.4f m, rotation (x y z w) %.6f %.6f %.6f %.6f\n",
                T.translation.x(), T.translation.y(), T.translation.z(), T.rotation.x(), T.rotation.y(),
                T.rotation.z(), T.rotation.w());
  out += text;
  const Eigen::Vector3d turn = camera.sigma.rotation * 180.0 / M_PI, shift = camera.sigma.translation;
  std::snprintf(text, sizeof(text), "sigma: translation %.3f %.3f %.3f m, rotation %.3f %.3f %.3f deg\n",
                shift.x(), shift.y(), shift.z(), turn.x(), turn.y(), turn.z());
  return out + text;
}

int Register(const RegisterOptions& options) {
  OutputDirectory output(options.output, "register_pair");
  const Rig rig = LoadRigFile(options.rig);
  const PairRegistration done = RegisterPairs(rig, LoadPairs(options, rig));
  const std::string text = Describe(done);
  const std::vector<std::string> kept = output.Replace([&](const fs::path& directory) {
    WriteResults(directory, done.result, output.Path());
    WriteFileAtomically(directory / "log.txt", text);
  });
  for (const std::string& line : kept) std::fprintf(stderr, "register_pair: %s\n", line.c_str());
  std::fputs(text.c_str(), stdout);
  if (done.result.Trusted()) return kTrusted;
  std::fprintf(stderr, "register_pair: refused: %s\n", done.result.reasons.front().c_str());
  return kRefused;
}

}  // namespace
}  // namespace mlic

int main(int argc, char** argv) {
  mlic::RegisterOptions options;
  CLI::App app("Registers a camera to a LiDAR from still scans and the photos taken with them",
               "register_pair");
  std::string rig, output;
  app.add_option("--cloud", options.clouds, "PCD file of a scan, LiDAR frame; may be given several times")
      ->required()
      ->type_name("FILE");
  app.add_option("--image", options.images, "the photo taken with it; one for each --cloud, in order")
      ->required()
      ->type_name("FILE");
  app.add_option("--rig", rig, "rig file with one LiDAR and one camera with intrinsics and a guess")
      ->required()
      ->type_name("FILE");
  app.add_option("--output", output, "directory for the results, empty or new or of an earlier run")
      ->required()
      ->type_name("DIR");
  mlic::Describe(
      app,
      {{mlic::kTrusted, "registered"},
       {mlic::kRefused, "refused: the photo does not show the scan's structure at one clear place"}},
      "rosrun mlic register_pair --cloud scan.pcd --image photo.png --rig rig.yaml --output result");
  int status = 0;
  if (!mlic::ParseArguments(app, argc, argv, status)) return status;
  options.rig = rig;
  options.output = output;
  return mlic::RunProgram("register_pair", [&] { return mlic::Register(options); });
}
