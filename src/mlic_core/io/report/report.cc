#include "mlic_core/io/report/report.h"

#include "mlic_core/io/report/report_cameras.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/report/report_tables.h"
#include "mlic_core/io/report/report_top_view.h"
#include "mlic_core/io/report/report_verdict.h"
#include "mlic_core/io/result/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

const char* const kStyle = R"(
:root{--ink:#1c2530;--soft:#5d6b7a;--line:#dde3ea;--paper:#fff;--ground:#f3f5f8}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);font:15px/1.5 "DejaVu Sans",Verdana,"Segoe UI",sans-serif}
main{max-width:1160px;margin:0 auto;padding:24px}
section{background:var(--paper);border:1px solid var(--line);border-radius:8px;padding:18px 22px;margin:0 0 18px}
h1{margin:0;font-size:30px}h2{margin:0 0 12px;font-size:18px}h3{margin:0 0 6px;font-size:14px}
.verdict{border-left:8px solid}.verdict ul{margin:6px 0 10px}
.trusted{border-left-color:#1e8449}.trusted h1{color:#1e8449}.partial{border-left-color:#b7950b}.partial h1{color:#b7950b}.refused{border-left-color:#c0392b}.refused h1{color:#c0392b}
.lead{font-size:17px;margin:4px 0 10px}
.tiles{display:flex;flex-wrap:wrap;gap:10px;margin-top:12px}
.tile{background:var(--ground);border-radius:6px;padding:8px 14px;min-width:130px}
.tile b{display:block;font-size:20px}.tile span{color:var(--soft);font-size:12px}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:13px}
th{color:var(--soft);font-weight:600;text-align:left;padding:5px 9px;white-space:nowrap}
td{padding:5px 9px;border-top:1px solid var(--line);vertical-align:top}
.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
td small{display:block;color:var(--soft);font-size:11px}
.marked{background:#fff4dc}.marked b{color:#9a6700}
i{display:inline-block;width:11px;height:11px;border-radius:3px;margin-right:6px}
.note,.none{color:var(--soft);font-size:12px;margin:8px 0 0}
.legend{margin:8px 0 0;font-size:13px}.legend span{margin-right:18px}
svg{width:100%;height:auto;display:block}svg text{font-size:10px;fill:#5d6b7a}svg .big{font-size:20px;fill:#222}
svg.map{border:1px solid var(--line);max-height:760px;background:#fff}
.path{fill:none;stroke:#111;stroke-width:2.5;stroke-linejoin:round}
.axis{stroke:#9aa7b4}.guide{stroke:#9aa7b4;stroke-dasharray:4 3}.expected{fill:none;stroke:#222;stroke-width:1.2}
.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(330px,1fr));gap:16px}
.card{border:1px solid var(--line);border-radius:6px;padding:10px 12px;break-inside:avoid}
.bar{height:11px;background:#2f6fb5;border-radius:3px;margin-top:4px}
.stages td:nth-child(5){color:var(--soft)}
)";

std::string Section(const std::string& title, const std::string& content) {
  return "<section>\n<h2>" + title + "</h2>\n" + content + "</section>\n";
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

}  // namespace

void WriteReport(const std::filesystem::path& path, const CalibrationResult& result,
                 const std::filesystem::path& place) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>MLIC calibration report</title>\n<style>";
  html += std::string(kStyle) + "</style>\n</head>\n<body>\n<main>\n" + VerdictBlock(result);
  html += Section("Sensors", SensorTable(result));
  const std::string cameras = CameraTable(result);
  if (!cameras.empty()) html += Section("Camera intrinsics", cameras);
  const std::string camera_residuals = CameraResiduals(result);
  if (!camera_residuals.empty()) html += Section("Camera residuals", camera_residuals);
  const std::string top_view = TopViewFigure(result);
  if (!top_view.empty()) html += Section("The first drive from above", top_view);
  if (!result.pairs.empty()) html += Section("Pairs of sensors", PairTable(result));
  if (!result.halves.empty()) html += Section("Halves of the drive", HalvesTable(result));
  if (!result.sensors.empty()) html += Section("IMU", ImuTable(result));
  if (!result.residuals.empty()) html += Section("Residuals", ResidualSection(result));
  if (!result.stages.empty()) html += Section("Stages", StageTable(result));
  std::string steps = "<ul>\n";
  for (const std::string& step : NextSteps(result, place)) steps += "<li>" + EscapeXml(step) + "</li>\n";
  html += Section("What to do next", steps + "</ul>\n");
  WriteFileAtomically(path, html + "</main>\n</body>\n</html>\n");
}

}  // namespace mlic
