#include "mlic_core/io/report/report.h"

#include <cstdlib>
#include <sstream>
#include <vector>

#include "mlic_core/common/random.h"
#include "mlic_core/io/pictures/track_picture.h"
#include "mlic_core/io/report/embedded_image.h"
#include "mlic_core/io/report/page_texts.h"
#include "mlic_core/io/report/report_checks.h"
#include "mlic_core/io/report/report_figures.h"
#include "mlic_core/io/report/report_next_step.h"
#include "mlic_core/io/report/report_verdict.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"
#include "support/source_directory.h"

namespace mlic::report_test {
namespace {

std::string ReportOf(const CalibrationResult& result) {
  TemporaryDirectory directory;
  WriteReport(directory.Path() / "report.html", result, "/data/my drive");
  return ReadFile(directory.Path() / "report.html");
}

TEST(Report, TrustedSaysSoFirstAndMarksWhatIsUnobservable) {
  const std::string html = ReportOf(SampleResult());
  EXPECT_LT(html.find("<h1>Trusted</h1>"), html.find("front_lidar"));
  EXPECT_TRUE(Contains(html, "<b>unobservable</b>"));
  EXPECT_TRUE(Contains(html, "the common z of all LiDARs"));
  EXPECT_TRUE(Contains(html, "data:image/png;base64,"));
  EXPECT_TRUE(Contains(html, "translation along (0.00, 0.02, 1.00), known to &plusmn; 100.0 mm"));
  EXPECT_TRUE(Contains(html, "1423 planes"));
}

TEST(Report, ShowsTheChecksThatFailedFirst) {
  const std::string html = ReportOf(SampleResult());
  EXPECT_TRUE(Contains(html, "1 of 2 checks passed"));
  EXPECT_LT(html.find("<b>coverage_image</b>"), html.find("<b>convergence</b>"));
  EXPECT_TRUE(Contains(html, "turn so that structure crosses all of it"));
  EXPECT_TRUE(Contains(html, "share of the image in which landmarks are seen"));
  EXPECT_TRUE(Contains(html,
                       "<td>front_lidar</td><td>first half and last quarter</td><td class=\"n\">5.73"
                       "<small>&plusmn; 11.46</small>"));
}

// Twenty sensors do not make twenty rows of one check, before they are unfolded.
TEST(Report, GivesOneRowToEachKindOfCheckThatPassed) {
  CalibrationResult result = SampleResult();
  QualityCheck check = result.checks[0];
  check.name = "whiteness";
  result.checks.clear();
  for (const double value : {0.2, 0.9, 0.4}) {
    check.sensor = "lidar_" + std::to_string(result.checks.size());
    check.value = value;
    result.checks.push_back(check);
  }
  const std::string html = ChecksTable(result), shown = html.substr(0, html.find("<details>"));
  EXPECT_TRUE(Contains(shown, "lidar_1<small>of 3, nearest to its limit</small>"));
  EXPECT_FALSE(Contains(shown, "lidar_0"));
  EXPECT_TRUE(Contains(html.substr(shown.size()), "lidar_0"));
  result.checks[0].value = 1671.0;
  result.checks[0].limit = 2000.0;
  EXPECT_TRUE(Contains(ChecksTable(result), ">1671<")) << "a count in full";
}

TEST(Report, ExplainsEachCheckOfTheDocuments) {
  const std::string document = ReadFile(SourceDirectory() + "/docs/outputs.md");
  const std::size_t begin = document.find("\n### checks"), end = document.find("\n## ", begin);
  ASSERT_NE(begin, std::string::npos);
  int names = 0;
  for (std::size_t row = document.find("\n| `", begin); row < end; row = document.find("\n| `", row + 1)) {
    const std::string cell = document.substr(row + 3, document.find('|', row + 3) - row - 3);
    for (std::size_t at = cell.find('`'); at != std::string::npos; at = cell.find('`', at + 1)) {
      const std::size_t close = cell.find('`', at + 1);
      EXPECT_NE(MeaningOf(cell.substr(at + 1, close - at - 1)), "") << cell;
      at = close;
      ++names;
    }
  }
  EXPECT_GE(names, 18);
}

// What a reader needs first stands first; the log is last and folded.
TEST(Report, IsOrderedByUse) {
  const std::string html = ReportOf(SampleResult());
  std::size_t last = 0;
  for (const char* part : {"<h1>Trusted</h1>", "id=\"checks\"", "id=\"next\"", "id=\"rig\"", "id=\"sensors\"",
                           "id=\"frames\"", "id=\"overlays\"", "id=\"pairs\"", "id=\"convergence\"",
                           "id=\"run\"", "id=\"log\">\n<details><summary>"}) {
    const std::size_t at = html.find(part);
    ASSERT_NE(at, std::string::npos) << part;
    EXPECT_GT(at, last) << part;
    last = at;
  }
}

TEST(Report, PairsAreAMatrixColouredByTheirSigmas) {
  CalibrationResult result = SampleResult();
  result.pairs[0].sigma.translation = {0.0012, 0.0234, 0.001};
  result.pairs[1].sigma.rotation = {0.001, 0.012, 0.001};
  const std::string html = ReportOf(result);
  // 23 of 50 mm, 47 percent.
  EXPECT_TRUE(Contains(html, "<td class=\"shade4\" title=\"front_lidar / left_lidar: rotation"));
  EXPECT_TRUE(Contains(html, ">0.003&deg;<br>23.4 mm</td>"));
  EXPECT_TRUE(Contains(html, "<td class=\"marked\" title=\"front_lidar / right_lidar: rotation"));
  EXPECT_TRUE(Contains(html, "in part unobservable"));
  EXPECT_TRUE(Contains(html, "<summary>poses of all 6 pairs</summary>"));
}

TEST(Report, SaysWhatTheSigmasMeanInUse) {
  CalibrationResult result = SampleResult();
  const std::string html = ReportOf(result);
  EXPECT_TRUE(Contains(html,
                       "<td><b>cam_front</b></td><td data-label=\"points known to\">front_lidar</td>"
                       "<td class=\"n\" data-label=\"median at 10 m, px\">0.28</td>"
                       "<td class=\"n\" data-label=\"worst at 10 m, px\">0.55</td>"
                       "<td class=\"n\" data-label=\"median at 50 m, px\">0.38</td>"
                       "<td class=\"n\" data-label=\"worst at 50 m, px\">0.75</td>"));
  EXPECT_TRUE(Contains(html, "<h3>left_lidar to front_lidar</h3>"));
  EXPECT_TRUE(Contains(html, "<h3>left_lidar to the IMU</h3>"));
  EXPECT_TRUE(Contains(html, "at 50 m: 0.23 cm, worst 0.45 cm"));
  // Twelve sectors at two distances, of three pairs of LiDARs and three LiDARs.
  std::size_t sectors = 0;
  for (std::size_t at = html.find("class=\"sector\""); at != std::string::npos;
       at = html.find("class=\"sector\"", at + 1)) {
    ++sectors;
  }
  EXPECT_EQ(sectors, 12u * 2u * 6u);
  EXPECT_TRUE(Contains(html, "<td>height</td><td class=\"n\">1.7000 m</td><td class=\"n\">0.1000 m</td>"));
  for (SensorResult& sensor : result.sensors) sensor.in_use.clear();
  for (PairResult& pair : result.pairs) pair.in_use.clear();
  result.ground.reset();
  const std::string without = ReportOf(result);
  EXPECT_FALSE(Contains(without, "id=\"use\""));
  EXPECT_FALSE(Contains(without, "id=\"ground\""));
}

TEST(Report, DrawsTheRigStillWithItsGuess) {
  CalibrationResult result = SampleResult();
  const std::string html = ReportOf(result);
  EXPECT_TRUE(Contains(html, "aria-label=\"the rig from above\""));
  EXPECT_TRUE(Contains(html, "aria-label=\"the rig from the left\""));
  EXPECT_TRUE(Contains(html, "Thin or dashed: the guess"));
  EXPECT_EQ(Contains(html, "MLIC was built without three.js"), kThreeJs[0] == '\0');
  EXPECT_EQ(Contains(html, "Copyright (c) 2010-2019 three.js authors"), kThreeJs[0] != '\0');
  result.guesses.clear();
  EXPECT_FALSE(Contains(ReportOf(result), "Thin or dashed: the guess"));
}

TEST(Report, LaysTheGuessOverTheResultOnThePhoto) {
  CalibrationResult result = SampleResult();
  EXPECT_TRUE(Contains(ReportOf(result), "left of the line the rig file's guess, right of it the result"));
  EXPECT_TRUE(Contains(ReportOf(result), " m (red) to "));
  result.projections[0].guess.clear();
  EXPECT_TRUE(Contains(ReportOf(result), "left of the line before the photos were matched"));
  result.projections.clear();
  EXPECT_FALSE(Contains(ReportOf(result), "id=\"overlays\""));
}

// Guesses are 10, 5 and 2 cm off along the IMU's axes, and 0.07 rad about z.
TEST(Report, SaysByHowMuchTheGuessWasOff) {
  CalibrationResult result = SampleResult();
  const std::string html = ReportOf(result), section = html.substr(html.find("id=\"change\""));
  EXPECT_TRUE(Contains(
      section.substr(0, section.find("</section>")),
      "data-label=\"turned by, &deg;\">4.011</td><td class=\"n\" data-label=\"x, mm\">-100.0</td>"
      "<td class=\"n\" data-label=\"y, mm\">50.0</td><td class=\"n\" data-label=\"z, mm\">-20.0</td>"));
  result.guesses.clear();
  EXPECT_FALSE(Contains(ReportOf(result), "id=\"change\""));
}

TEST(Report, ShowsHowItCameAbout) {
  CalibrationResult result = SampleResult();
  const std::string html = ReportOf(result);
  EXPECT_TRUE(Contains(html, "aria-label=\"change of the calibration by rounds\""));
  EXPECT_TRUE(Contains(html, "</i>joint with cameras</span>"));
  EXPECT_TRUE(Contains(html, "aria-label=\"angular rates of the IMU\""));
  EXPECT_TRUE(Contains(html, "aria-label=\"bias of the gyroscope over time\""));
  EXPECT_FALSE(Contains(html, "bias of the accelerometer over time")) << "there is none in the sample";
  EXPECT_TRUE(Contains(html, "<code>calibrate --rig rig.yaml --bag &#39;drive &lt;1&gt;.bag&#39;</code>"));
  EXPECT_TRUE(Contains(html, "<td>/data/drive &lt;1&gt;.bag</td><td><code>0f3c</code></td>"));
  EXPECT_TRUE(Contains(html, "<tr><th>intrinsics</th><td>trajectory</td></tr>"));
  result.rounds.clear();
  result.trajectories.clear();
  result.run.reset();
  const std::string without = ReportOf(result);
  for (const char* id : {"id=\"convergence\"", "id=\"motion\"", "id=\"run\""}) {
    EXPECT_FALSE(Contains(without, id)) << id;
  }
}

// Ten times more is one step up, whatever the values.
TEST(PlotFigure, OfPowersOfTen) {
  const auto heights = [](bool logarithmic) {
    const std::string svg = PlotFigure(
        {"sample", "round", {{"#123456", {{1, 0.01}, {2, 0.1}, {3, 1.0}, {4, -1.0}}}}, {}, logarithmic});
    const std::size_t at = svg.find("points=\"") + 8;
    std::istringstream points(svg.substr(at, svg.find('"', at) - at));
    std::vector<double> found;
    double x = 0.0, y = 0.0;
    for (char comma = 0; points >> x >> comma >> y;) found.push_back(y);
    return found;
  };
  const std::vector<double> powers = heights(true), plain = heights(false);
  ASSERT_EQ(powers.size(), 3u) << "what is not positive has no logarithm";
  EXPECT_NEAR(powers[0] - powers[1], powers[1] - powers[2], 0.11);
  EXPECT_GT(powers[0] - powers[1], 20.0);
  ASSERT_EQ(plain.size(), 4u);
  EXPECT_LT(plain[0] - plain[1], 0.2 * (plain[1] - plain[2]));
}

TEST(Report, SaysWhereTheTimeWent) {
  const std::string html = ReportOf(SampleResult());
  EXPECT_TRUE(Contains(html, "<td>odometry</td><td class=\"n\">11.7</td><td class=\"n\">44.1</td>"));
  EXPECT_TRUE(Contains(html, "<b>44.0</b></td><td class=\"n\"><b>145.8</b>")) << "the sums";
}

TEST(Report, OpensOffline) {
  const std::string html = ReportOf(SampleResult());
  for (const char* outside :
       {"src=\"http", "href=\"http", "src=\"/", "<script src", "<link", "@import", "url("}) {
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  }
  EXPECT_EQ(html.find("{{"), std::string::npos) << "a place of the page that nothing fills";
}

TEST(Report, RefusedGivesReasonsEscaped) {
  CalibrationResult result;
  result.reasons = {"turned by 3 deg < 20 deg & stood still"};
  const std::string html = ReportOf(result);
  EXPECT_TRUE(Contains(html, "<h1>Refused</h1>"));
  EXPECT_TRUE(Contains(html, "turned by 3 deg &lt; 20 deg &amp; stood still"));
  EXPECT_TRUE(Contains(html, "Record again with turns"));
  EXPECT_EQ(html.find("<h1>Trusted"), std::string::npos);
}

TEST(Report, PartialNamesTheRejectedAndStillSaysHowToUseTheRest) {
  CalibrationResult result = SampleResult();
  result.verdict = Verdict::kPartial;
  result.reasons = {"cam_left: its images are dark"};
  const std::string html = ReportOf(result);
  EXPECT_TRUE(Contains(html, "<h1>Partial</h1>"));
  EXPECT_TRUE(Contains(html, "cam_left: its images are dark"));
  EXPECT_TRUE(Contains(html, "static_transforms.launch"));
  EXPECT_FALSE(Contains(html, "Record again with turns"));
}

TEST(Report, OfPairsAloneSaysAboutWhatTheyStand) {
  CalibrationResult result = SampleResult();
  result.verdict = Verdict::kPartial;
  result.root = "front_lidar";
  result.sensors.clear();
  result.pairs[0].unobservable = {
      {UnobservableDirection::Quantity::kTranslation, Eigen::Vector3d::UnitZ(), 0.2}};
  const std::string html = ReportOf(result);
  EXPECT_FALSE(Contains(html, "<b>0</b>")) << "no count of sensors where there are none";
  EXPECT_TRUE(Contains(html, "Some directions of the pairs, marked <b>unobservable</b> below"));
  EXPECT_TRUE(Contains(html, "href=\"#frames\">about front_lidar</a>"));
}

// A straight drive: along the way, and in time, nothing shows where one LiDAR is to the other.
TEST(Report, LargestSigmasOfPairsAreOfWhatIsShown) {
  using Quantity = UnobservableDirection::Quantity;
  CalibrationResult result;
  result.root = "roof";
  PairResult pair;
  pair.a = "roof";
  pair.b = "front";
  const Eigen::Vector3d way(0.6, 0.0, 0.8);
  pair.sigma.translation = (0.2 * way).array().square().matrix();
  pair.sigma.translation += Eigen::Vector3d(1e-6, 4e-6, 1e-6);
  pair.sigma.translation = pair.sigma.translation.cwiseSqrt();
  pair.sigma.rotation = {1e-4, 2e-4, 3e-4};
  pair.sigma.time_offset = 0.05;
  pair.unobservable = {{Quantity::kTranslation, way, 0.2},
                       {Quantity::kTimeOffset, Eigen::Vector3d::Zero(), 0.05}};
  result.pairs = {pair};
  const LargestSigmas largest = FindLargestSigmas(result);
  EXPECT_NEAR(largest.translation, 2e-3, 1e-9);
  EXPECT_NEAR(largest.rotation, 3e-4, 1e-12);
  EXPECT_EQ(largest.time_offset, 0.0);
}

TEST(Report, AdviceWorksFromAnyFolder) {
  const std::string html = ReportOf(SampleResult());
  EXPECT_TRUE(Contains(html, "<code>roslaunch &#39;/data/my drive/static_transforms.launch&#39;</code>"));
  EXPECT_TRUE(
      Contains(html, "<code>rosrun mlic verify --calibration &#39;/data/my drive/calibration.yaml&#39; "));
  EXPECT_TRUE(
      Contains(html, "&lt;xacro:include filename=&quot;/data/my drive/sensors_macro.xacro&quot;/&gt;"));
}

TEST(Report, LowInlierShareBecomesAHint) {
  CalibrationResult result = SampleResult();
  EXPECT_EQ(ReportOf(result).find("are inliers; look"), std::string::npos);
  result.residuals[1].inlier_share = 0.6;
  EXPECT_TRUE(Contains(ReportOf(result), "left_lidar: only 60 percent"));
}

TEST(Report, CamerasAreShownByCellsAndOnThePhoto) {
  CalibrationResult result = SampleResult();
  const std::string html = ReportOf(result);
  EXPECT_TRUE(Contains(html, "rms 0.410 px of each coordinate"));
  // Nine of ten mean errors are below 0.08 px and a cell is 80 px wide.
  EXPECT_TRUE(Contains(html, "arrows: mean errors &times; 1000"));
  EXPECT_TRUE(Contains(html, "data:image/jpeg;base64,"));
  EXPECT_TRUE(Contains(html, "512 held-out matches with the LiDAR map: off by 0.31 px"));
  result.views.clear();
  result.residuals.pop_back();
  EXPECT_EQ(ReportOf(result).find("Camera residuals"), std::string::npos);
}

// Arrows are magnified so that they can be seen, and the factor is said.
TEST(TrackPicture, ArrowsPointFromTheObservationToTheProjection) {
  const CameraView view = SampleResult().views.front();
  const cv::Mat photo = view.images->Load(1), picture = DrawTracks(photo, view);
  ASSERT_EQ(picture.type(), CV_8UC3);
  ASSERT_EQ(picture.size(), photo.size());
  const int factor = ArrowMagnification(view, photo.cols);
  EXPECT_EQ(factor, 100);  // 0.36 px become 36 of the 42.7 px allowed
  const auto colour = [&](const Eigen::Vector2f& at) {
    return picture.at<cv::Vec3b>(static_cast<int>(at.y()), static_cast<int>(at.x()));
  };
  const LandmarkProjection& observation = view.observations[30];
  const cv::Vec3b along =
      colour(observation.observed + 0.5f * factor * (observation.projected - observation.observed));
  EXPECT_GT(along[2], along[0] + 60) << "red where the arrow is";
  const cv::Vec3b against =
      colour(observation.observed - 0.3f * factor * (observation.projected - observation.observed));
  EXPECT_LE(against[2] - against[0], 30) << "not red where it is not";
}

TEST(Base64, KnownValues) {
  EXPECT_EQ(EncodeBase64(""), "");
  EXPECT_EQ(EncodeBase64("f"), "Zg==");
  EXPECT_EQ(EncodeBase64("fo"), "Zm8=");
  EXPECT_EQ(EncodeBase64("foo"), "Zm9v");
  EXPECT_EQ(EncodeBase64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(EncodeBase64(std::string("\xff\xfe\xfd")), "//79");
}

TEST(EmbeddedImage, SaysItsKindAndBeginsWithItsMagic) {
  const cv::Mat picture(7, 5, CV_8UC4, cv::Scalar(1, 2, 3, 4));
  EXPECT_EQ(EmbedPng(picture).rfind("data:image/png;base64," + EncodeBase64("\x89PNG\r\n"), 0), 0u);
  EXPECT_EQ(
      EmbedJpeg(cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)), 90).rfind("data:image/jpeg;base64,/9j/", 0), 0u);
}

}  // namespace
}  // namespace mlic::report_test
