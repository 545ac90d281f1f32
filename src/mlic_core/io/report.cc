#include "mlic_core/io/report.h"

#include "mlic_core/io/export_frames.h"
#include "mlic_core/io/text_file.h"

namespace mlic {

void WriteReport(const std::filesystem::path& path, const CalibrationResult& result) {
  std::string html = "<!DOCTYPE html><html lang=\"en\"><meta charset=\"utf-8\"><title>MLIC</title><h1>";
  html += result.trusted ? "Trusted" : "Refused";
  html += "</h1>\n";
  for (const std::string& reason : result.reasons) html += "<p>" + EscapeXml(reason) + "</p>\n";
  WriteFileAtomically(path, html + "</html>\n");
}

}  // namespace mlic
