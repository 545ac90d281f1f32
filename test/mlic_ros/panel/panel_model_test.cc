#include "mlic_ros/panel/panel_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mlic_core/common/duration_text.h"
#include "mlic_ros/display/status_text.h"

namespace mlic::panel_model_test {
namespace {

SensorStatus Found(const std::string& name) {
  SensorStatus sensor;
  sensor.name = name;
  sensor.frame_id = name + "_frame";
  sensor.state = SensorStatus::ESTIMATED;
  sensor.transform.rotation.w = sensor.guess.rotation.w = 1.0;
  return sensor;
}

TEST(StatusText, DurationsAreShort) {
  EXPECT_EQ(DurationText(-3.0), "0 s");
  EXPECT_EQ(DurationText(42.4), "42 s");
  EXPECT_EQ(DurationText(100.0), "2 min");
  EXPECT_EQ(DurationText(59.4 * 60.0), "59 min");
  EXPECT_EQ(DurationText(7500.0), "2 h 05 min");
}

TEST(StatusText, StageAndTimeLeftWhileItRunsAndTheVerdictAfter) {
  Status status;
  status.stage = "joint adjustment";
  status.stage_number = 4, status.stage_count = 12;
  status.run_progress = 0.35f, status.seconds_left = -1.0f;
  EXPECT_EQ(StageLine(status), "stage 4 of 12: joint adjustment");
  EXPECT_EQ(ProgressLine(status), "35 %, time left not known yet");
  status.seconds_left = 400.0f;
  EXPECT_EQ(ProgressLine(status), "35 %, about 7 min left");
  status.state = Status::PARTIAL;
  EXPECT_EQ(StageLine(status), "PARTIAL");
  status.run_progress = 1.0f;
  EXPECT_EQ(ProgressLine(status), "100 %");
}

TEST(PanelModel, ChangesKeepTheirSolveAndLeaveOutWhatWasNotMeasured) {
  Status status;
  status.changes = {std::numeric_limits<double>::quiet_NaN(), 1e300, 4.0, 0.0};
  status.solve_stages = {3, 4, 4, 5};
  const std::vector<CurvePoint> curve = ChangeCurve(status);
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_EQ(curve[0].solve, 1);
  EXPECT_EQ(curve[0].value, 1e6);
  EXPECT_EQ(curve[1].value, 4.0);
  EXPECT_EQ(curve[2].stage, 5);
  EXPECT_GT(curve[2].value, 0.0);  // has a place on a logarithmic axis
}

TEST(PanelModel, SigmasAreInMillimetresAndSolvesWithoutResidualsLeaveNoPoint) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Status status;
  status.largest_sigmas = {kNan, 0.012, 0.003};
  status.mean_squares = {kNan, 1.7, 0.98};
  status.solve_stages = {3, 4, 4};
  const std::vector<CurvePoint> sigmas = SigmaCurve(status), residuals = ResidualCurve(status);
  ASSERT_EQ(sigmas.size(), 2u);
  EXPECT_EQ(sigmas[0].solve, 1);
  EXPECT_NEAR(sigmas[0].value, 12.0, 1e-9);
  ASSERT_EQ(residuals.size(), 2u);
  EXPECT_EQ(residuals[1].value, 0.98);
}

TEST(PanelModel, TheTextOfALineStandsWhereTheCurveIsNot) {
  const Box left_above{0.0, 0.0, 60.0, 16.0}, left_below{0.0, 20.0, 60.0, 16.0},
      right_above{200.0, 0.0, 60.0, 16.0};
  const std::vector<Box> boxes{left_above, left_below, right_above};
  EXPECT_EQ(FreestBox(boxes, {}), 0u);
  EXPECT_EQ(FreestBox(boxes, {{10.0, 30.0}, {250.0, 30.0}}), 0u);
  EXPECT_EQ(FreestBox(boxes, {{10.0, 5.0}, {50.0, 30.0}, {250.0, 35.0}}), 2u)
      << "both to the left are crossed";
  EXPECT_EQ(FreestBox(boxes, {{-50.0, 8.0}, {300.0, 8.0}}), 1u) << "no point of the curve is in a box";
}

TEST(PanelModel, TheAxisHoldsAllValuesAndTheLine) {
  const LogAxis axis = FitLogAxis({{0, 250.0, 1}, {1, 0.04, 1}}, 1.0);
  EXPECT_EQ(axis.lowest, -2);
  EXPECT_EQ(axis.highest, 3);
  EXPECT_NEAR(axis.Place(1.0), 0.4, 1e-12);
  EXPECT_EQ(axis.Place(0.0), 0.0);
  EXPECT_EQ(axis.Place(1e9), 1.0);
  const LogAxis one = FitLogAxis({}, 1.0);
  EXPECT_GT(one.highest, one.lowest);
}

TEST(PanelModel, RowsSayOffsetSigmasAndChangeFromTheGuess) {
  Status status;
  SensorStatus sensor = Found("front");
  sensor.time_offset = -0.0123;
  sensor.has_sigma = true;
  sensor.sigma_rotation_deg = {0.01, 0.043, 0.02};
  sensor.sigma_translation = {0.002, 0.0011, 0.0005};
  sensor.has_guess = true;
  sensor.guess.translation.y = 0.05;
  sensor.guess.rotation.z = std::sin(0.5 * 2.0 * M_PI / 180.0);
  sensor.guess.rotation.w = -std::cos(0.5 * 2.0 * M_PI / 180.0);
  status.sensors = {sensor};
  const SensorRow row = SensorRows(status).at(0);
  EXPECT_EQ(row.frame, "front_frame");
  EXPECT_EQ(row.cells[1], "converging");
  EXPECT_EQ(row.cells[2], "-12.30");
  EXPECT_EQ(row.cells[3], "0.04");
  EXPECT_EQ(row.cells[4], "2.0");
  EXPECT_EQ(row.cells[5], "2.0 deg, 50 mm");
}

TEST(PanelModel, SensorsThatAreNotGivenHaveNoNumbers) {
  Status status;
  status.state = Status::PARTIAL;
  SensorStatus waiting = Found("camera"), rejected = Found("rear");
  waiting.state = SensorStatus::WAITING;
  rejected.state = SensorStatus::REJECTED;
  rejected.reason = "rear: it moved";
  status.sensors = {waiting, rejected};
  const std::vector<SensorRow> rows = SensorRows(status);
  EXPECT_EQ(rows[0].cells[1], "not found");
  EXPECT_EQ(rows[1].cells[1], "rejected");
  EXPECT_EQ(rows[1].note, "rear: it moved");
  for (const SensorRow& row : rows) EXPECT_EQ(row.cells[2], "-");
}

TEST(PanelModel, MessagesBeginWithTheWorstSigmasAndDoNotRepeatTheVerdict) {
  Status status;
  EXPECT_EQ(MessageLines(status), "");
  status.state = Status::INTERRUPTED;
  status.messages = {"INTERRUPTED: no result was written"};
  EXPECT_EQ(MessageLines(status), "no result was written\n");
  SensorStatus front = Found("front"), rear = Found("rear"), lost = Found("lost");
  for (SensorStatus* sensor : {&front, &rear}) sensor->state = SensorStatus::TRUSTED;
  lost.state = SensorStatus::REJECTED;
  for (SensorStatus* sensor : {&front, &rear, &lost}) sensor->has_sigma = true;
  front.sigma_rotation_deg[1] = 0.03, rear.sigma_translation[2] = 0.012, lost.sigma_translation[0] = 9.0;
  status.sensors = {front, rear, lost};
  status.state = Status::PARTIAL;
  status.messages = {"a", "b", "c", "d"};
  EXPECT_EQ(MessageLines(status), "2 sensors, worst sigma 0.03 deg, 12 mm\na\nb\nc\n");
  status.messages.clear();
  status.sensors[1].reason = "a direction of translation is not shown by the drive";
  EXPECT_EQ(MessageLines(status),
            "2 sensors, worst sigma 0.03 deg, 0.0000 mm, * not all of it shown by the drive\n");
}

TEST(PanelModel, TheViewFollowsTheMap) {
  Status status;
  EXPECT_FALSE(ViewOfMap(status));
  status.map_center.x = 3.0;
  status.map_radius = 10.0f;
  EXPECT_EQ(ViewOfMap(status)->x, 3.0);
  EXPECT_GT(ViewOfMap(status)->distance, 20.0);
  status.sensors = {Found("front")};
  status.sensors[0].transform.translation.z = 2.0;
  EXPECT_GT(ViewOfSensor(status).distance, 2.0);
  EXPECT_LT(ViewOfSensor(status).distance, ViewOfMap(status)->distance);
}

TEST(PanelModel, LegendAndRoundSayWhatTheSceneShows) {
  Status status;
  EXPECT_EQ(RoundText(status), "");
  EXPECT_EQ(LegendHtml(status), "");
  status.rounds = 9;
  EXPECT_EQ(RoundText(status), "latest of 9");
  status.shown_round = 3;
  EXPECT_EQ(RoundText(status), "round 3 of 9");
  status.legend = {"front", "off by 3 px"};
  status.legend_colours = {0x0000ff, 0xff7f0e};
  const std::string html = LegendHtml(status);
  EXPECT_NE(html.find("color:#0000ff"), std::string::npos);
  EXPECT_LT(html.find("#ff7f0e"), html.find("off&nbsp;by&nbsp;3&nbsp;px")) << "an entry is not broken";
}

TEST(PanelModel, HiddenSensorsHaveNoCheckInTheirBox) {
  Status status;
  status.sensors.resize(2);
  status.sensors[0].name = "front", status.sensors[1].name = "rear";
  status.hidden = {"rear"};
  const std::vector<SensorRow> rows = SensorRows(status);
  EXPECT_TRUE(rows.at(0).shown);
  EXPECT_FALSE(rows.at(1).shown);
}

}  // namespace
}  // namespace mlic::panel_model_test
