#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <sstream>
#include <vector>

#include "mlic_core/io/report/page_texts.h"
#include "mlic_core/io/report/report.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"
#include "support/source_directory.h"

namespace mlic::report_browser_test {
namespace {

using Seen = std::map<std::string, std::string>;

// A browser without a screen uses the report at several widths, each in a frame of its own
// (report_probe.js): what it saw, by name. One start for all, as that takes most of the time.
std::map<int, Seen> Probe(const std::string& browser, const std::vector<int>& widths) {
  TemporaryDirectory directory;
  const std::filesystem::path page = directory.Path() / "report.html", out = directory.Path() / "out.html",
                              around = directory.Path() / "around.html";
  WriteReport(page, SampleResult(), "/data/a folder with a rather long name/for the drive of one Monday");
  std::string html = ReadFile(page);
  const std::string collect =
      "<script>window.probeErrors=[];addEventListener('error',(e)=>probeErrors.push(e.message));"
      "console.error=(...all)=>probeErrors.push(all.join(' '));</script>";
  html.insert(html.find("<head>") + 6, collect);
  html.insert(
      html.rfind("</body>"),
      "<script>" + ReadFile(SourceDirectory() + "/test/mlic_core/io/report_probe.js") + "</script>\n");
  WriteFileAtomically(page, html);
  // A window is never narrower than 500 px, a frame in it may be.
  std::string frames =
      "<!DOCTYPE html><script>addEventListener('message',(e)=>{const place=document."
      "createElement('pre');place.className='probe';place.textContent=e.data;document.body."
      "append(place);});</script><body>";
  for (const int width : widths) {
    frames += "<iframe src=\"report.html\" width=\"" + std::to_string(width) +
              "\" height=\"900\" style=\"border:0\"></iframe>";
  }
  WriteFileAtomically(around, frames);
  // The probe does its work while the page loads. Time of the page that goes on after it is spent drawing the
  // same frames by software, which costs more than the rest.
  const std::string command = "timeout 120 " + browser +
                              " --headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader "
                              "--enable-unsafe-swiftshader --hide-scrollbars --user-data-dir=" +
                              (directory.Path() / "profile").string() +
                              " --window-size=1500,1000 --virtual-time-budget=1000 --dump-dom file://" +
                              around.string() + " >" + out.string() + " 2>/dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  std::istringstream lines(ReadFile(out));
  std::map<int, Seen> of_widths;
  Seen seen;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    if (line.rfind("</pre>", 0) == 0) {
      of_widths[std::stoi(seen["width"])] = seen;
      seen.clear();
    } else if (equals != std::string::npos) {
      seen[line.substr(0, equals)] = line.substr(equals + 1);
    }
  }
  return of_widths;
}

std::string Browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (std::system(("command -v " + std::string(name) + " >/dev/null 2>&1").c_str()) == 0) return name;
  }
  return "";
}

void ExpectItWorksAndFits(int width, Seen seen) {
  SCOPED_TRACE("at " + std::to_string(width) + " px");
  EXPECT_EQ(seen["errors"], "");
  EXPECT_EQ(seen["width"], std::to_string(width));
  EXPECT_LE(std::stoi(seen["overflow"]), 0);
  EXPECT_EQ(seen["sticking_out"], "");
  EXPECT_EQ(seen["clip_before"], "inset(0px 50% 0px 0px)");
  EXPECT_EQ(seen["clip_after"], "inset(0px 20% 0px 0px)");

  const CalibrationResult result = SampleResult();
  const SensorCalibration &left = result.sensors[1].calibration, &front = result.sensors[0].calibration;
  const RigidTransform T_left_front = left.T_imu_sensor.Inverse() * front.T_imu_sensor;
  const Eigen::Vector3d& p = T_left_front.translation;
  EXPECT_EQ(seen["row"].rfind("front_lidar|" + FixedNumber(p.x(), 4) + "|" + FixedNumber(p.y(), 4) + "|" +
                                  FixedNumber(p.z(), 4) + "|",
                              0),
            0u)
      << seen["row"];
  EXPECT_NE(seen["row"].find("|" + FixedNumber(1e3 * (front.time_offset - left.time_offset), 3) + "|"),
            std::string::npos)
      << seen["row"];
  const Eigen::Quaterniond q = T_left_front.rotation;
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  std::istringstream words(seen["publisher"]);
  std::string rosrun, package, program, parent, child;
  double numbers[7];
  words >> rosrun >> package >> program;
  for (double& number : numbers) words >> number;
  words >> parent >> child;
  EXPECT_EQ(program + " " + parent + " " + child,
            "static_transform_publisher left_lidar_link front_lidar_link");
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(numbers[k], p[k], 2e-9);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(numbers[3 + k], sign * q.coeffs()[k], 2e-9);
  EXPECT_EQ(seen["about_base"],
            "rosrun tf2_ros static_transform_publisher 0.000000000 0.000000000 1.500000000 0.000000000 "
            "0.000000000 0.000000000 1.000000000 base_link imu_link");

  EXPECT_EQ(seen["turnable"], kThreeJs[0] == '\0' ? "false" : "true");
  if (seen["turnable"] != "true") return;
  EXPECT_EQ(seen["turned"], "true");
  EXPECT_EQ(seen["still_hidden"], "true");
}

TEST(ReportInBrowser, WorksAndFits) {
  const std::string browser = Browser();
  if (browser.empty()) GTEST_SKIP() << "no chromium on this machine";
  const std::vector<int> widths{400, 1400};
  const std::map<int, Seen> seen = Probe(browser, widths);
  ASSERT_EQ(seen.size(), widths.size());
  for (const int width : widths) ExpectItWorksAndFits(width, seen.at(width));
}

}  // namespace
}  // namespace mlic::report_browser_test
