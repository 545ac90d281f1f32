#include "mlic_core/io/report/report_overlays.h"

#include "mlic_core/io/pictures/projection_picture.h"
#include "mlic_core/io/report/embedded_image.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

constexpr int kQuality = 85;  // of JPEG; from: structural, how the report looks

std::string Overlay(const CameraProjection& projection) {
  const cv::Mat photo = projection.images->Load(projection.image);
  const bool guessed = !projection.guess.empty();
  const std::string first = guessed ? "at the guess" : "before";
  const OverlayPair pictures = DrawOverlays(photo, projection);
  const std::string name = EscapeXml(projection.camera);
  const auto image = [&](const cv::Mat& picture, const std::string& kind, const std::string& alt) {
    return "<img class=\"" + kind + "\" width=\"" + std::to_string(picture.cols) + "\" height=\"" +
           std::to_string(picture.rows) + "\" alt=\"" + alt + "\" src=\"" + EmbedJpeg(picture, kQuality) +
           "\">\n";
  };
  const std::string depths = "points from " + FixedNumber(pictures.range.near, 1) + " m (red) to " +
                             FixedNumber(pictures.range.far, 0) + " m (blue)";
  if (!projection.found) {
    return "<figure><figcaption><b>" + name + "</b>: not found; the rig file's guess, " + depths +
           "</figcaption>\n" +
           image(pictures.before, "guess", "LiDAR points on the photo of " + name + ", " + first) +
           "</figure>\n";
  }
  return "<figure class=\"compare\"><figcaption><b>" + name + "</b>: left of the line " +
         (guessed ? "the rig file's guess" : "before the photos were matched") +
         ", right of it the result; " + depths + "</figcaption>\n<div class=\"pictures\">\n" +
         image(pictures.after, "after", "LiDAR points on the photo of " + name + ", as found") +
         image(pictures.before, "before", "LiDAR points on the photo of " + name + ", " + first) +
         "<span class=\"line\"></span></div>\n<input type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
         "aria-label=\"from the result to the guess, " +
         name + "\">\n</figure>\n";
}

}  // namespace

std::string Overlays(const CalibrationResult& result) {
  std::string html;
  for (const CameraProjection& projection : result.projections) html += Overlay(projection);
  if (html.empty()) return "";
  return html +
         "<p class=\"note\">Points of the LiDARs within a tenth of a second of the photo. Where the "
         "calibration is right, edges of the points lie on edges of the photo. The guess changes "
         "poses only: intrinsics and time offsets are those found. More views are in "
         "<code>images/NAME_projection.png</code>.</p>\n";
}

}  // namespace mlic
