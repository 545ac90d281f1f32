#include "mlic_core/inspection/camera_findings.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <set>

#include "mlic_core/common/error.h"
#include "mlic_core/common/order_statistics.h"
#include "mlic_core/ingest/drive_notes.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {
namespace {

// Constants of this file, from: definition, the limits of docs/inspection.md.
constexpr double kPassShare = 0.1;                    // of the images
constexpr double kFailShare = 0.7;                    // of the images
constexpr double kLeastDetail = 0.62;                 // see ImageSample; defocused by 2 pixels it is 0.53
constexpr double kOffCentre = 0.15;                   // of the image's width or height
constexpr double kTooNarrow = 5.0, kTooWide = 260.0;  // deg

double GradientRms(const cv::Mat& gray) {
  double squares = 0.0;
  for (int y = 0; y + 1 < gray.rows; ++y) {
    const std::uint8_t *row = gray.ptr<std::uint8_t>(y), *next = gray.ptr<std::uint8_t>(y + 1);
    for (int x = 0; x + 1 < gray.cols; ++x) {
      const int along = row[x + 1] - row[x], down = next[x] - row[x];
      squares += along * along + down * down;
    }
  }
  return std::sqrt(squares / std::max(1.0, static_cast<double>(gray.rows - 1) * (gray.cols - 1)));
}

double FineDetail(const cv::Mat& gray) {
  cv::Mat half;
  cv::resize(gray, half, cv::Size(), 0.5, 0.5, cv::INTER_AREA);
  const double coarse = GradientRms(half);
  return coarse > 0.0 ? GradientRms(gray) / coarse : 0.0;
}

// FNV-1a over the pixels.
std::uint64_t Digest(const cv::Mat& gray) {
  constexpr std::uint64_t kOffset = 14695981039346656037ULL, kPrime = 1099511628211ULL;  // from: standard
  std::uint64_t digest = kOffset;
  for (int y = 0; y < gray.rows; ++y) {
    const std::uint8_t* row = gray.ptr<std::uint8_t>(y);
    for (int x = 0; x < gray.cols; ++x) digest = (digest ^ row[x]) * kPrime;
  }
  return digest;
}

Grade GradeOfShare(double share) {
  return share > kFailShare ? Grade::kFail : share > kPassShare ? Grade::kWarn : Grade::kPass;
}

// The images for which `bad` is true, with their places.
Finding ShareFinding(const CameraSurvey& camera, const std::string& check, TimeNs begin,
                     const std::function<bool(std::size_t)>& bad) {
  std::vector<double> places;
  for (std::size_t i = 0; i < camera.samples.size(); ++i) {
    if (bad(i)) places.push_back(SecondsSince(begin, camera.samples[i].record));
  }
  const double share = static_cast<double>(places.size()) / static_cast<double>(camera.samples.size());
  return {GradeOfShare(share),
          camera.config.name,
          check,
          std::to_string(places.size()) + " of " + std::to_string(camera.samples.size()) + " sampled images" +
              (places.empty() ? "" : ", " + PlacesText(places)),
          Number(100.0 * kPassShare) + " %",
          ""};
}

Finding DecodingFinding(const CameraSurvey& camera) {
  const std::size_t all = camera.samples.size() + camera.undecodable;
  const double share =
      static_cast<double>(camera.undecodable) / static_cast<double>(std::max<std::size_t>(1, all));
  return {all == 0 ? Grade::kFail : GradeOfShare(share),
          camera.config.name,
          "decoding",
          std::to_string(camera.undecodable) + " of " + std::to_string(all) +
              " sampled images cannot be decoded" +
              (camera.first_fault.empty() ? "" : "; the first: " + camera.first_fault),
          Number(100.0 * kPassShare) + " %",
          "check the driver's encoding and the network"};
}

Finding FormatFinding(const CameraSurvey& camera) {
  std::set<std::string> formats;
  for (const ImageSample& s : camera.samples) {
    formats.insert(std::to_string(s.width) + " x " + std::to_string(s.height) + " " + s.encoding);
  }
  std::string text;
  for (const std::string& format : formats) text += (text.empty() ? "" : ", ") + format;
  return {formats.size() > 1 ? Grade::kFail : Grade::kPass,
          camera.config.name,
          "size and encoding",
          text,
          "one for all images",
          "set the driver to one size, and record one camera on a topic"};
}

Finding ExposureFinding(const CameraSurvey& camera, TimeNs begin) {
  std::vector<double> brightness;
  for (const ImageSample& s : camera.samples) brightness.push_back(s.brightness);
  Finding finding = ShareFinding(camera, "dark, overexposed or without structure", begin,
                                 [&](std::size_t i) { return !camera.samples[i].quality.IsExposed(); });
  finding.measured += ", mean brightness " + Number(Median(brightness), "%.0f") + " of 255";
  finding.remedy = "record in light, set exposure; take off the lens cap";
  return finding;
}

Finding BlurFinding(const CameraSurvey& camera, TimeNs begin) {
  std::vector<double> detail;
  for (const ImageSample& s : camera.samples) detail.push_back(s.detail);
  Finding finding = ShareFinding(camera, "blur", begin, [&](std::size_t i) {
    const ImageSample& s = camera.samples[i];
    return s.quality.IsExposed() && s.detail < kLeastDetail;
  });
  finding.measured += ", fine detail " + Number(Median(detail), "%.2f") + " in the median";
  finding.limit += " with detail below " + Number(kLeastDetail) + " (0.5: none)";
  finding.remedy = "focus the lens, clean it, expose shorter; move more slowly";
  return finding;
}

Finding FrozenFinding(const CameraSurvey& camera, TimeNs begin, bool vehicle_moves) {
  Finding finding = ShareFinding(camera, "frozen images", begin, [&](std::size_t i) {
    return i > 0 && camera.samples[i].digest == camera.samples[i - 1].digest;
  });
  if (!vehicle_moves) finding.grade = Grade::kPass;
  finding.remedy = "the driver repeats its last image: check camera and cable";
  return finding;
}

Finding LensFinding(const CameraSurvey& camera) {
  const CameraConfig& config = camera.config;
  const ImageSample& image = camera.samples.front();
  Finding finding{Grade::kPass,           config.name,
                  "lens in the rig file", "",
                  "goes with the images", "correct model, fov_deg or intrinsics in the rig file"};
  if (config.intrinsics) {
    const std::vector<double>& k = *config.intrinsics;
    const double off = std::max(std::abs(k[2] / image.width - 0.5), std::abs(k[3] / image.height - 0.5));
    finding.measured =
        "intrinsics, principal point " + Number(100.0 * off, "%.0f") + " % off the image's middle";
    if (off > kOffCentre) {
      finding.grade = Grade::kFail;
      finding.remedy = "these intrinsics belong to images of another size: correct or remove them";
    }
    return finding;
  }
  try {
    const double fov = config.fov_deg.value_or(0.0);
    finding.measured = "field of view " + Number(fov) + " deg";
    if (fov < kTooNarrow || fov > kTooWide) finding.grade = Grade::kFail;
    IntrinsicsFromFieldOfView(config.model, image.width, image.height, fov);
  } catch (const InputError& error) {
    finding.grade = Grade::kFail;
    finding.measured = error.what();
  }
  return finding;
}

Findings RectifiedFindings(const CameraSurvey& camera) {
  if (camera.config.topic.find("rect") == std::string::npos) return {};
  return {
      {Grade::kWarn, camera.config.name, "raw images", "rectified, by the topic's name", "raw",
       "record image_raw: rectification hides the lens, and its intrinsics are then those of the result"}};
}

}  // namespace

ImageSample MeasureImage(const cv::Mat& image) {
  ImageSample sample;
  const cv::Mat gray = ToGray(image);
  sample.width = gray.cols;
  sample.height = gray.rows;
  sample.quality = MeasureImageQuality(gray, cv::Mat());
  sample.brightness = cv::mean(gray)[0];
  sample.detail = FineDetail(gray);
  sample.digest = Digest(gray);
  return sample;
}

Findings CameraFindings(const CameraSurvey& camera, TimeNs begin, bool vehicle_moves) {
  Findings findings{DecodingFinding(camera)};
  if (camera.samples.empty()) return findings;
  findings.push_back(FormatFinding(camera));
  findings.push_back(LensFinding(camera));
  Append(RectifiedFindings(camera), &findings);
  findings.push_back(ExposureFinding(camera, begin));
  findings.push_back(BlurFinding(camera, begin));
  findings.push_back(FrozenFinding(camera, begin, vehicle_moves));
  return findings;
}

}  // namespace mlic
