#include "mlic_core/io/report/report.h"

#include <map>
#include <vector>

#include "mlic_core/common/error.h"
#include "mlic_core/io/report/page_texts.h"
#include "mlic_core/io/report/report_cameras.h"
#include "mlic_core/io/report/report_checks.h"
#include "mlic_core/io/report/report_course.h"
#include "mlic_core/io/report/report_data.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/report/report_ground.h"
#include "mlic_core/io/report/report_next_step.h"
#include "mlic_core/io/report/report_overlays.h"
#include "mlic_core/io/report/report_pairs.h"
#include "mlic_core/io/report/report_rig.h"
#include "mlic_core/io/report/report_tables.h"
#include "mlic_core/io/report/report_top_view.h"
#include "mlic_core/io/report/report_use.h"
#include "mlic_core/io/report/report_verdict.h"
#include "mlic_core/io/report/rig_drawing.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/result/result_names.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

struct Section {
  std::string id, title, content;
  bool folded = false;
};

// Only sections with content.
std::string Shown(const std::vector<Section>& sections) {
  std::string contents, html;
  for (const Section& section : sections) {
    if (section.content.empty()) continue;
    const std::string heading = "<h2>" + section.title + "</h2>";
    contents += "<a href=\"#" + section.id + "\">" + section.title + "</a>\n";
    html +=
        "<section id=\"" + section.id + "\">\n" +
        (section.folded ? "<details><summary>" + heading + "</summary>\n" + section.content + "</details>\n"
                        : heading + "\n" + section.content) +
        "</section>\n";
  }
  return "<nav>\n" + contents + "</nav>\n" + html;
}

std::string ColorOf(const std::string& sensor, const CalibrationResult& result) {
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    if (result.sensors[i].name == sensor) return SensorColor(i);
  }
  return "#5d6b7a";
}

std::string ResidualSection(const CalibrationResult& result) {
  std::string html = "<div class=\"grid\">\n";
  for (const ResidualSummary& residual : result.residuals) {
    const std::string color = ColorOf(residual.sensor, result);
    html += "<div class=\"card\"><h3><i style=\"background:" + color + "\"></i>" +
            EscapeXml(residual.sensor) + "</h3>\n" + HistogramFigure(residual, color) + "\n" +
            OverTimeFigure(residual, color) + "\n<p class=\"note\">assumed &sigma; " +
            ShortNumber(residual.sigma, 3) + " " + EscapeXml(residual.unit) + ", rms " +
            ShortNumber(residual.rms, 3) + " " + EscapeXml(residual.unit) + ", " +
            FixedNumber(100.0 * residual.inlier_share, 1) + "% inliers</p></div>\n";
  }
  return html +
         "</div>\n<p class=\"note\">Above: residuals in units of the assumed noise, black the normal "
         "distribution that "
         "they should follow. Below: their root mean square over the drive in the same units; dashed at "
         "1.</p>\n";
}

// page: a text with {{NAME}} in it; values by NAME.
std::string FillPage(const std::string& page, const std::map<std::string, std::string>& values) {
  std::string text;
  std::size_t at = 0;
  for (std::size_t open = page.find("{{"); open != std::string::npos; open = page.find("{{", at)) {
    const std::size_t close = page.find("}}", open);
    Check(close != std::string::npos, "the report's page has an open {{");
    text += page.substr(at, open - at) + values.at(page.substr(open + 2, close - open - 2));
    at = close + 2;
  }
  return text + page.substr(at);
}

}  // namespace

void WriteReport(const std::filesystem::path& path, const CalibrationResult& result,
                 const std::filesystem::path& place) {
  const RigDrawing drawing = DrawingOf(result);
  const bool turnable = !drawing.sensors.empty() && kThreeJs[0] != '\0';
  const std::vector<Section> sections = {
      {"checks", "Checks", ChecksTable(result)},
      {"next", "Next step", NextStep(result, place)},
      {"rig", "The rig", RigFigure(drawing, turnable)},
      {"sensors", "Where the sensors are", SensorTable(result)},
      {"change", "Change from the guess", ChangeFromGuess(drawing)},
      {"ground", "Over the ground", GroundTable(result)},
      {"frames", "About any sensor, frame and clock", result.Usable() ? FrameChoice(drawing) : ""},
      {"overlays", "The LiDARs on the photos", Overlays(result)},
      {"pairs", "Pairs of sensors", result.pairs.empty() ? "" : PairMatrix(result)},
      {"use", "What the sigmas mean in use", InUseSection(result)},
      {"intrinsics", "Camera intrinsics", CameraTable(result)},
      {"camera-residuals", "Camera residuals", CameraResiduals(result)},
      {"drive", "The drive from above", TopViewFigure(result)},
      {"motion", "How it moved", Motion(result)},
      {"convergence", "Convergence", Convergence(result)},
      {"residuals", "Residuals", result.residuals.empty() ? "" : ResidualSection(result)},
      {"halves", "Halves of the drive", HalvesTable(result)},
      {"imu", "IMU", result.sensors.empty() ? "" : ImuTable(result) + BiasOverTime(result)},
      {"run", "How it was made", HowItWasMade(result)},
      {"log", "Time and log", result.stages.empty() ? "" : StageTable(result), true},
  };
  WriteFileAtomically(path, FillPage(kPageHtml, {{"title", "MLIC: " + VerdictName(result.verdict)},
                                                 {"style", kStyleCss},
                                                 {"body", VerdictBlock(result) + Shown(sections)},
                                                 {"data", ReportData(result, drawing)},
                                                 {"three_notice", turnable ? kThreeNotice : ""},
                                                 {"three", turnable ? kThreeJs : ""},
                                                 {"rig_view", turnable ? kRigViewJs : ""},
                                                 {"script", kReportJs}}));
}

}  // namespace mlic
