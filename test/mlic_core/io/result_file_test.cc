#include "mlic_core/io/result/result_file.h"

#include "mlic_core/geometry/so3.h"
#include "mlic_core/io/text_file.h"
#include "support/files.h"
#include "support/sample_result.h"

namespace mlic::result_file_test {
namespace {

void ExpectSame(const RigidTransform& a, const RigidTransform& b) {
  EXPECT_LT(AngleBetween(a.rotation, b.rotation), 1e-11);
  EXPECT_LT((a.translation - b.translation).norm(), 1e-9);
}

void ExpectSame(const PoseSigma& a, const PoseSigma& b) {
  EXPECT_LT((a.translation - b.translation).norm(), 1e-11);
  EXPECT_LT((a.rotation - b.rotation).norm(), 1e-11);
  EXPECT_NEAR(a.time_offset, b.time_offset, 1e-12);
}

// As YAML 1.1 has them, by which PyYAML reads.
TEST(ShortNumber, HasAPointBeforeAnExponent) {
  EXPECT_EQ(ShortNumber(1e-5, 12), "1.0e-05");
  EXPECT_EQ(ShortNumber(-3e20, 6), "-3.0e+20");
  EXPECT_EQ(ShortNumber(1.5e-7, 12), "1.5e-07");
  EXPECT_EQ(ShortNumber(0.02, 12), "0.02");
  EXPECT_EQ(ShortNumber(-0.0, 12), "0");
}

TEST(ResultFile, SaysOfEachCheckWhetherItPassed) {
  TemporaryDirectory directory;
  WriteCalibrationFile(directory.Path() / "calibration.yaml", SampleResult());
  const std::string text = ReadFile(directory.Path() / "calibration.yaml");
  EXPECT_TRUE(Contains(
      text, "{name: convergence, value: 0.083, limit: 1, bound: most, unit: \"sigma\", passed: true"));
  EXPECT_TRUE(Contains(text, "sensor: cam_front, value: 0.375, limit: 0.5, bound: least"));
  EXPECT_TRUE(Contains(text, "passed: false, remedy: \"turn so that structure crosses all of it\"}"));
}

TEST(ResultFile, RoundTripKeepsEverything) {
  TemporaryDirectory directory;
  CalibrationResult result = SampleResult();
  result.sensors[0].calibration.clock_drift = -4.25e-5;
  result.sensors[0].drift_sigma = 1.25e-6;
  result.sensors[0].clock_reference = 1700000030123456789;
  result.sensors[0].corrections = {0.0125, -0.25, 0.015, 40.0, {{0, 0.004, -0.00125}, {63, -0.5, 0.25}}};
  WriteCalibrationFile(directory.Path() / "calibration.yaml", result);
  const CalibrationResult copy = ReadCalibrationFile(directory.Path() / "calibration.yaml");
  EXPECT_EQ(copy.Trusted(), result.Trusted());
  EXPECT_EQ(copy.reasons, result.reasons);
  EXPECT_EQ(copy.warnings, result.warnings);
  ASSERT_EQ(copy.checks.size(), result.checks.size());
  for (std::size_t i = 0; i < copy.checks.size(); ++i) {
    const QualityCheck &a = result.checks[i], &b = copy.checks[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.sensor, b.sensor);
    EXPECT_EQ(a.value, b.value);
    EXPECT_EQ(a.limit, b.limit);
    EXPECT_EQ(a.unit, b.unit);
    EXPECT_EQ(a.bound, b.bound);
    EXPECT_EQ(a.Passed(), b.Passed());
    EXPECT_EQ(a.remedy, b.remedy);
  }
  EXPECT_EQ(copy.imu_frame_id, result.imu_frame_id);
  EXPECT_LT((copy.imu.gyroscope_bias - result.imu.gyroscope_bias).norm(), 1e-12);
  EXPECT_LT((copy.imu.accelerometer_bias - result.imu.accelerometer_bias).norm(), 1e-12);
  EXPECT_LT((copy.imu.gyroscope_matrix - result.imu.gyroscope_matrix).norm(), 1e-11);
  EXPECT_LT((copy.imu.accelerometer_matrix - result.imu.accelerometer_matrix).norm(), 1e-11);
  EXPECT_LT((copy.gravity - result.gravity).norm(), 1e-10);
  ASSERT_TRUE(copy.alignment.has_value());
  EXPECT_EQ(copy.alignment->axes, result.alignment->axes);
  EXPECT_EQ(copy.alignment->estimated, result.alignment->estimated);
  EXPECT_EQ(copy.alignment->held, result.alignment->held);
  EXPECT_EQ(copy.alignment->of_accelerometer, result.alignment->of_accelerometer);
  EXPECT_LT((copy.alignment->sigma - result.alignment->sigma).norm(), 1e-12);
  ASSERT_EQ(copy.sensors.size(), result.sensors.size());
  for (std::size_t i = 0; i < copy.sensors.size(); ++i) {
    const SensorResult &a = result.sensors[i], &b = copy.sensors[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.type, b.type);
    EXPECT_EQ(a.frame_id, b.frame_id);
    ExpectSame(a.calibration.T_imu_sensor, b.calibration.T_imu_sensor);
    ExpectSame(a.sigma, b.sigma);
    ASSERT_TRUE(a.bound && b.bound);
    ExpectSame(*a.bound, *b.bound);
    EXPECT_NEAR(a.calibration.time_offset, b.calibration.time_offset, 1e-9);
    ASSERT_EQ(a.calibration.clock_drift.has_value(), b.calibration.clock_drift.has_value());
    if (a.calibration.clock_drift) {
      EXPECT_NEAR(*a.calibration.clock_drift, *b.calibration.clock_drift, 1e-10);
      EXPECT_NEAR(a.drift_sigma, b.drift_sigma, 1e-12);
      EXPECT_EQ(a.clock_reference, b.clock_reference);
    }
    EXPECT_EQ(a.corrections.range_offset, b.corrections.range_offset);
    EXPECT_EQ(a.corrections.range_slope, b.corrections.range_slope);
    EXPECT_EQ(a.corrections.range_walk, b.corrections.range_walk);
    EXPECT_EQ(a.corrections.reference_intensity, b.corrections.reference_intensity);
    ASSERT_EQ(a.corrections.rings.size(), b.corrections.rings.size());
    for (std::size_t k = 0; k < a.corrections.rings.size(); ++k) {
      EXPECT_EQ(a.corrections.rings[k].ring, b.corrections.rings[k].ring);
      EXPECT_EQ(a.corrections.rings[k].range, b.corrections.rings[k].range);
      EXPECT_EQ(a.corrections.rings[k].elevation, b.corrections.rings[k].elevation);
    }
    EXPECT_EQ(a.translation_observable, b.translation_observable);
    EXPECT_EQ(a.rotation_observable, b.rotation_observable);
    EXPECT_EQ(a.time_offset_observable, b.time_offset_observable);
    ASSERT_EQ(a.unobservable.size(), b.unobservable.size());
    for (std::size_t k = 0; k < a.unobservable.size(); ++k) {
      EXPECT_EQ(a.unobservable[k].quantity, b.unobservable[k].quantity);
      EXPECT_LT((a.unobservable[k].direction - b.unobservable[k].direction).norm(), 1e-8);
      EXPECT_NEAR(a.unobservable[k].sigma, b.unobservable[k].sigma, 1e-11);
    }
    ASSERT_EQ(a.intrinsics.has_value(), b.intrinsics.has_value());
    if (a.intrinsics) {
      EXPECT_EQ(a.intrinsics->width, b.intrinsics->width);
      EXPECT_EQ(a.intrinsics->height, b.intrinsics->height);
      EXPECT_EQ(a.intrinsics->model, b.intrinsics->model);
      EXPECT_EQ(a.intrinsics->parameters, b.intrinsics->parameters);
    }
    EXPECT_EQ(a.intrinsics_sigma, b.intrinsics_sigma);
    EXPECT_EQ(a.intrinsics_fixed, b.intrinsics_fixed);
    EXPECT_EQ(a.rolling_shutter_readout, b.rolling_shutter_readout);
    EXPECT_EQ(a.readout_sigma, b.readout_sigma);
    ASSERT_EQ(a.held_out.has_value(), b.held_out.has_value());
    if (!a.held_out) continue;
    EXPECT_EQ(a.held_out->count, b.held_out->count);
    EXPECT_EQ(a.held_out->median, b.held_out->median);
    EXPECT_EQ(a.held_out->rms, b.held_out->rms);
  }
  ASSERT_EQ(copy.pairs.size(), result.pairs.size());
  for (std::size_t i = 0; i < copy.pairs.size(); ++i) {
    EXPECT_EQ(copy.pairs[i].a, result.pairs[i].a);
    EXPECT_EQ(copy.pairs[i].b, result.pairs[i].b);
    ExpectSame(copy.pairs[i].T_a_b, result.pairs[i].T_a_b);
    ExpectSame(copy.pairs[i].sigma, result.pairs[i].sigma);
    ASSERT_EQ(copy.pairs[i].bound.has_value(), result.pairs[i].bound.has_value());
    if (result.pairs[i].bound) ExpectSame(*copy.pairs[i].bound, *result.pairs[i].bound);
  }
}

TEST(ResultFile, KeepsSigmasInUseAndTheGround) {
  TemporaryDirectory directory;
  const CalibrationResult result = SampleResult();
  const std::filesystem::path file = directory.Path() / "calibration.yaml";
  WriteCalibrationFile(file, result);
  const std::string text = ReadFile(file);
  EXPECT_TRUE(Contains(text, "use: {px_at_10m: [0.275, 0.55], px_at_50m: [0.375, 0.75]}")) << text;
  EXPECT_TRUE(Contains(text, "use: {cm_at_10m: [0.165, 0.33], cm_at_10m_by_sector: [0.2475, "));
  EXPECT_TRUE(Contains(text, "ground: {height: 1.70000, roll_deg: 0.5730, pitch_deg: -1.1459"));
  const CalibrationResult copy = ReadCalibrationFile(file);
  const auto expect_same = [](const std::vector<SigmaInUse>& a, const std::vector<SigmaInUse>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].where, b[i].where);
      EXPECT_EQ(a[i].distance, b[i].distance);
      EXPECT_NEAR(a[i].median, b[i].median, 1e-3 * b[i].median);
      EXPECT_NEAR(a[i].worst, b[i].worst, 1e-3 * b[i].worst);
      ASSERT_EQ(a[i].sectors.size(), b[i].sectors.size());
      for (std::size_t k = 0; k < a[i].sectors.size(); ++k) {
        EXPECT_NEAR(a[i].sectors[k], b[i].sectors[k], 1e-3 * b[i].sectors[k]);
      }
    }
  };
  for (std::size_t s = 0; s < copy.sensors.size(); ++s) {
    expect_same(copy.sensors[s].in_use, result.sensors[s].in_use);
  }
  for (std::size_t p = 0; p < copy.pairs.size(); ++p) {
    expect_same(copy.pairs[p].in_use, result.pairs[p].in_use);
  }
  ASSERT_TRUE(copy.ground);
  EXPECT_NEAR(copy.ground->mean.pitch, result.ground->mean.pitch, 1e-6);
  EXPECT_NEAR(copy.ground->sigma.height, result.ground->sigma.height, 1e-5);
  EXPECT_NEAR(copy.ground->scatter.roll, result.ground->scatter.roll, 1e-6);
  EXPECT_EQ(copy.ground->places, 57u);
}

// As versions before wrote it.
TEST(ResultFile, NeedsNeitherSigmasInUseNorTheGround) {
  TemporaryDirectory directory;
  CalibrationResult result = SampleResult();
  result.ground.reset();
  for (SensorResult& sensor : result.sensors) sensor.in_use.clear();
  for (PairResult& pair : result.pairs) pair.in_use.clear();
  const std::filesystem::path file = directory.Path() / "calibration.yaml";
  WriteCalibrationFile(file, result);
  EXPECT_FALSE(Contains(ReadFile(file), "use:"));
  EXPECT_FALSE(Contains(ReadFile(file), "ground:"));
  const CalibrationResult copy = ReadCalibrationFile(file);
  EXPECT_FALSE(copy.ground);
  EXPECT_EQ(copy.pairs.size(), result.pairs.size());
  EXPECT_TRUE(copy.pairs[0].in_use.empty());
}

TEST(ResultFile, PairsAboutARootKeepFramesAndUnobservableDirections) {
  using Quantity = UnobservableDirection::Quantity;
  TemporaryDirectory directory;
  CalibrationResult result;
  result.verdict = Verdict::kPartial;
  result.root = "roof";
  result.rejected = {{"front", SensorResult::Type::kLidar, "parked", "front_link"},
                     {"roof", SensorResult::Type::kLidar, "parked", "roof_link"}};
  PairResult pair{"front", "roof", {}, {}};
  pair.unobservable = {{Quantity::kTranslation, Eigen::Vector3d::UnitX(), 0.1},
                       {Quantity::kTimeOffset, Eigen::Vector3d::Zero(), 0.03}};
  result.pairs = {pair};
  WriteCalibrationFile(directory.Path() / "calibration.yaml", result);
  const CalibrationResult copy = ReadCalibrationFile(directory.Path() / "calibration.yaml");
  EXPECT_EQ(copy.verdict, Verdict::kPartial);
  EXPECT_EQ(copy.root, "roof");
  ASSERT_EQ(copy.rejected.size(), 2u);
  EXPECT_EQ(copy.rejected[1].frame_id, "roof_link");
  ASSERT_EQ(copy.pairs.size(), 1u);
  ASSERT_EQ(copy.pairs[0].unobservable.size(), 2u);
  EXPECT_EQ(copy.pairs[0].unobservable[0].direction, Eigen::Vector3d::UnitX());
  EXPECT_NEAR(copy.pairs[0].unobservable[1].sigma, 0.03, 1e-12);
}

TEST(ResultFile, RefusedKeepsReasons) {
  TemporaryDirectory directory;
  CalibrationResult result;
  result.reasons = {"the vehicle stood still: turn it", "quotes \" and: colons # survive"};
  WriteCalibrationFile(directory.Path() / "calibration.yaml", result);
  const CalibrationResult copy = ReadCalibrationFile(directory.Path() / "calibration.yaml");
  EXPECT_FALSE(copy.Trusted());
  EXPECT_EQ(copy.reasons, result.reasons);
  EXPECT_TRUE(copy.sensors.empty());
}

TEST(ResultFile, PartialNamesTheRejectedWithAllReasons) {
  TemporaryDirectory directory;
  CalibrationResult result = SampleResult();
  result.verdict = Verdict::kPartial;
  result.rejected = {{"cam_left", SensorResult::Type::kCamera, "cam_left: dark"},
                     {"low_lidar", SensorResult::Type::kLidar, "low_lidar: lost"},
                     {"cam_left", SensorResult::Type::kCamera, "cam_left: too few"}};
  WriteCalibrationFile(directory.Path() / "calibration.yaml", result);
  const CalibrationResult copy = ReadCalibrationFile(directory.Path() / "calibration.yaml");
  EXPECT_EQ(copy.verdict, Verdict::kPartial);
  EXPECT_EQ(copy.sensors.size(), result.sensors.size());
  ASSERT_EQ(copy.rejected.size(), 2u);
  EXPECT_EQ(copy.rejected[0].name, "cam_left");
  EXPECT_EQ(copy.rejected[0].type, SensorResult::Type::kCamera);
  EXPECT_EQ(copy.rejected[0].reason, "cam_left: dark; cam_left: too few");
  EXPECT_EQ(copy.rejected[1].name, "low_lidar");
  EXPECT_EQ(copy.rejected[1].type, SensorResult::Type::kLidar);
}

TEST(ResultFile, KeepsHowItWasMade) {
  TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "calibration.yaml";
  CalibrationResult result = SampleResult();
  result.run.reset();
  WriteCalibrationFile(path, result);
  EXPECT_FALSE(ReadCalibrationFile(path).run);
  result.run = RunRecord{"1.2.3",
                         "rosrun mlic calibrate --rig 'a \"rig\": 1.yaml'",
                         {{"/data/a b.bag", "00ff00ff00ff00ff"}, {"/data/\n.yaml", "0123456789abcdef"}},
                         {{"start", "0"}, {"matcher", "classical"}}};
  WriteCalibrationFile(path, result);
  const std::optional<RunRecord> run = ReadCalibrationFile(path).run;
  ASSERT_TRUE(run);
  EXPECT_EQ(run->version, result.run->version);
  EXPECT_EQ(run->command, result.run->command);
  EXPECT_EQ(run->options, result.run->options);
  ASSERT_EQ(run->inputs.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(run->inputs[i].path, result.run->inputs[i].path);
    EXPECT_EQ(run->inputs[i].hash, result.run->inputs[i].hash);
  }
}

TEST(ResultFile, TruthFileWithFewKeys) {
  TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "truth.yaml";
  WriteFileAtomically(path,
                      "format: mlic_calibration/1\nimu: {frame_id: imu_link}\nsensors:\n  velodyne:\n"
                      "    type: lidar\n    T_imu_sensor: {translation: [0.8, -0.3, 0.8], "
                      "rotation: [-0.007412088, 0.001015086, 0.000385188, 0.999971941]}\n");
  const CalibrationResult truth = ReadCalibrationFile(path);
  ASSERT_EQ(truth.sensors.size(), 1u);
  EXPECT_TRUE(truth.Trusted());
  EXPECT_EQ(truth.sensors[0].calibration.time_offset, 0.0);
  EXPECT_NEAR(truth.sensors[0].calibration.T_imu_sensor.rotation.norm(), 1.0, 1e-15);
  EXPECT_TRUE(truth.imu.gyroscope_matrix.isIdentity(0.0));
}

// As the first MLIC wrote it that wrote calibration.yaml; by hand the line of the version is easily left out.
TEST(ResultFile, ReadsEarlierFiles) {
  const std::string text =
      "verdict: refused\n"
      "reasons:\n"
      "  - \"turn more\"\n"
      "imu:\n"
      "  frame_id: \"imu_link\"\n"
      "  gyroscope_bias: [0.01, -0.02, 0.03]\n"
      "  accelerometer_bias: [0.1, 0.2, -0.3]\n"
      "  gravity: [0, 0, -9.81]  # in the map\n"
      "  gyroscope_matrix: [1, 0, 0, 0, 1, 0, 0, 0, 1]  # measured = matrix * true + bias\n"
      "  accelerometer_matrix: [1, 0.001, 0, 0, 1, 0, 0, 0, 1]\n"
      "sensors:\n"
      "  cam_front:\n"
      "    type: camera\n"
      "    frame_id: \"cam_front\"\n"
      "    T_imu_sensor: {translation: [1.2, 0, 0.3], rotation: [-0.5, 0.5, -0.5, 0.5]}\n"
      "    sigma: {translation: [0.001, 0.002, 0.003], rotation_deg: [0.01, 0.02, 0.03], time_offset: "
      "1e-05}\n"
      "    observable: {translation: [true, true, false], rotation: [true, true, true], time_offset: true}\n"
      "    unobservable: [{quantity: translation, direction: [0, 0, 1], sigma: 0.4}]\n"
      "    time_offset: 0.012500000\n"
      "    intrinsics: {model: plumb_bob, image_size: [1280, 720], params: [600, 601, 640, 360, -0.1, 0.01, "
      "0, 0, 0]}\n"
      "    rolling_shutter_readout: 0.020000000\n"
      "pairs:\n"
      "  cam_front/lidar: {T_a_b: {translation: [0, 0, 1], rotation: [0, 0, 0, 1]}, sigma: {translation: "
      "[0.001, 0.001, 0.001], rotation_deg: [0.01, 0.01, 0.01], time_offset: 1e-05}}\n";
  TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "c.yaml";
  for (const char* const version : {"format: mlic_calibration/1\n", ""}) {
    WriteFileAtomically(path, version + text);
    const CalibrationResult result = ReadCalibrationFile(path);
    EXPECT_EQ(result.verdict, Verdict::kRefused);
    EXPECT_EQ(result.reasons, std::vector<std::string>{"turn more"});
    EXPECT_EQ(result.imu.accelerometer_matrix(0, 1), 0.001);
    EXPECT_EQ(result.imu.accelerometer_lag, 0.0);
    ASSERT_EQ(result.sensors.size(), 1u);
    const SensorResult& camera = result.sensors[0];
    EXPECT_EQ(camera.calibration.T_imu_sensor.translation, Eigen::Vector3d(1.2, 0.0, 0.3));
    EXPECT_EQ(camera.calibration.time_offset, 0.0125);
    EXPECT_FALSE(camera.translation_observable[2]);
    ASSERT_TRUE(camera.intrinsics);
    EXPECT_EQ(camera.intrinsics->width, 1280);
    EXPECT_EQ(camera.rolling_shutter_readout, 0.02);
    EXPECT_TRUE(camera.in_use.empty());
    ASSERT_EQ(result.pairs.size(), 1u);
    EXPECT_EQ(result.pairs[0].T_a_b.translation.z(), 1.0);
  }
}

TEST(ResultFile, SaysWhatIsWrong) {
  TemporaryDirectory directory;
  const std::filesystem::path path = directory.Path() / "c.yaml";
  const auto error_of = [&](const std::string& text) {
    WriteFileAtomically(path, text);
    return InputErrorOf([&] { ReadCalibrationFile(path); });
  };
  EXPECT_TRUE(Contains(error_of("imu: {topic: /imu}\nlidars: {}\n"),
                       "key 'sensors' is missing; give the calibrated sensors"));
  EXPECT_TRUE(
      Contains(error_of("format: other/2\nsensors: {}\n"), "c.yaml:1: format: 'other/2' is not known"));
  EXPECT_TRUE(
      Contains(error_of("format: mlic_calibration/2\nsensors: {}\n"),
               "c.yaml:1: format: 'mlic_calibration/2' was written by a newer MLIC than this one, which "
               "reads up to mlic_calibration/1"));
  EXPECT_TRUE(
      Contains(error_of("format: mlic_rig/1\n"), "another kind of file; expected mlic_calibration/1"));
  for (const char* version : {"", "/", "/0", "/-1", "/1x", "/01", "/99999999999"}) {
    EXPECT_TRUE(Contains(error_of(std::string("format: mlic_calibration") + version + "\n"), "is not known"))
        << version;
  }
  EXPECT_TRUE(Contains(error_of("format: mlic_calibration/1\nsensors:\n  a: {type: lidar}\n"),
                       "c.yaml:3: sensors.a: key 'T_imu_sensor' is missing"));
}

}  // namespace
}  // namespace mlic::result_file_test
