#include "mlic_core/io/checkpoint/serialize_stages.h"

#include <array>
#include <limits>

#include "mlic_core/io/checkpoint/archive_types.h"

// A field that is added to the state, or to what a stage hands on, is added here too:
// test/mlic_core/pipeline/stage_resume_test.cc compares a resumed run with an uninterrupted one bit for bit.
namespace mlic {

template <>
struct IsFlat<UniformKnots> : std::true_type {};
template <>
struct IsFlat<ImuSigma> : std::true_type {};
template <>
struct IsFlat<std::array<double, 2>> : std::true_type {};
template <>
struct IsFlat<BiasSteps> : std::true_type {};
template <>
struct IsFlat<PlaneNoise> : std::true_type {};
template <>
struct IsFlat<LandmarkNoise> : std::true_type {};
template <>
struct IsFlat<RingCorrection> : std::true_type {};
template <>
struct IsFlat<RangeCorrection> : std::true_type {};

// Splines are their knots and control points; the rest follows from these.
template <typename Spline>
void SplineFields(ByteWriter& archive, const Spline& spline) {
  archive(spline.knots(), spline.control_points());
}

template <typename Spline>
void SplineFields(ByteReader& archive, Spline& spline) {
  UniformKnots knots;
  auto control_points = spline.control_points();
  archive(knots, control_points);
  if (knots.count < 4 || control_points.size() != static_cast<std::size_t>(knots.count)) {
    archive.Fail();
    return;
  }
  spline = Spline(knots, std::move(control_points));
}

template <typename Archive>
void Fields(Archive& archive, So3Spline& spline) {
  SplineFields(archive, spline);
}

template <typename Archive>
void Fields(Archive& archive, PositionSpline& spline) {
  SplineFields(archive, spline);
}

// Dense matrices are their columns.
void Fields(ByteWriter& archive, Eigen::MatrixXd& matrix) {
  archive(static_cast<std::uint64_t>(matrix.cols()),
          std::vector<double>(matrix.data(), matrix.data() + matrix.size()));
}

void Fields(ByteReader& archive, Eigen::MatrixXd& matrix) {
  std::uint64_t columns = 0;
  std::vector<double> values;
  archive(columns, values);
  // A matrix without rows keeps its columns.
  const bool fits = columns == 0 ? values.empty() : values.size() % columns == 0;
  if (!fits || columns > std::numeric_limits<int>::max()) {
    archive.Fail();
    return;
  }
  const auto rows = static_cast<Eigen::Index>(columns == 0 ? 0 : values.size() / columns);
  matrix = Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, static_cast<Eigen::Index>(columns));
}

auto Members(DriveState& drive) {
  return std::tie(drive.trajectory.rotation, drive.trajectory.position, drive.bias.start, drive.bias.spacing,
                  drive.bias.knots);
}

auto Members(CameraCalibration& camera) {
  return std::tie(camera.sensor, camera.intrinsics, camera.rolling_shutter, camera.readout);
}
auto Members(CalibrationState& state) {
  return std::tie(state.lidars, state.rings, state.ranges, state.cameras, state.gyroscope_matrix,
                  state.accelerometer_matrix, state.accelerometer_axes, state.gravity,
                  state.accelerometer_lag, state.drives);
}

auto Members(AngularRateAlignment& alignment) {
  return std::tie(alignment.valid, alignment.failure, alignment.time_offset, alignment.R_imu_lidar,
                  alignment.gyroscope_bias, alignment.rotation_information, alignment.information_values,
                  alignment.information_directions, alignment.rotation_covariance,
                  alignment.rotation_directions_shown, alignment.time_offset_sigma, alignment.residual_rms,
                  alignment.inlier_share, alignment.peak_correlation, alignment.second_peak_ratio,
                  alignment.second_peak_offset, alignment.clock_drift, alignment.clock_drift_sigma);
}

template <>
struct IsFlat<ClockDrift> : std::true_type {};
auto Members(DriveOdometry& odometry) {
  return std::tie(odometry.lidars, odometry.alignments, odometry.clocks);
}
auto Members(Initialization& start) {
  return std::tie(start.state, start.imu_sigma, start.base_lidar, start.unaligned, start.loose,
                  start.problems, start.notes);
}

auto Members(FixedCameraParameters& held) {
  return std::tie(held.rotation, held.translation, held.time_offset, held.readout, held.intrinsics,
                  held.square_pixels, held.usual_centre);
}

template <>
struct IsFlat<PointLandmark> : std::true_type {};

auto Members(LandmarkObservation& o) { return std::tie(o.camera, o.sigma, o.time, o.pixel, o.shape); }
auto Members(LidarPointObservation& observation) {
  return std::tie(observation.lidar, observation.time, observation.position, observation.sigma_along,
                  observation.sigma_across);
}

auto Members(LandmarkSet& set) { return std::tie(set.points, set.observations, set.begin, set.lidar_points); }
// Of the problem what rounds hand on: planes are found anew in each, and guesses are the rig file's.
auto Members(ImuSigmaCourse& sigma) { return std::tie(sigma.usual, sigma.start, sigma.length, sigma.growth); }
auto Members(DriveTerms& drive) {
  return std::tie(drive.imu_sigma, drive.bias_steps, drive.plane_voxels, drive.landmarks);
}
auto Members(StampCourse& course) {
  return std::tie(course.times, course.shifts, course.walk, course.jitter);
}
auto Members(MatchNoise& noise) { return std::tie(noise.scale, noise.shift, noise.smear); }
auto Members(CameraTerms& camera) { return std::tie(camera.fixed, camera.given_intrinsics); }
auto Members(RoundSummary& round) { return std::tie(round.stage, round.change); }
auto Members(Adjustment& adjustment) {
  return std::tie(
      adjustment.state, adjustment.contradicted_guesses, adjustment.plane_noise, adjustment.problem.drives,
      adjustment.problem.cameras, adjustment.cameras.landmark_options.noise, adjustment.cameras.stamp_courses,
      adjustment.cameras.twins, adjustment.cameras.sigmas, adjustment.map.cameras_before,
      adjustment.map.noise, adjustment.map.held_out, adjustment.rounds.landmarks, adjustment.rounds.done,
      adjustment.rounds.last_move, adjustment.rounds.most_points, adjustment.rounds.last_growth,
      adjustment.rounds.landmark_rounds, adjustment.rounds.points_per_scan, adjustment.rounds.noise_measured,
      adjustment.rounds.clocks_freed, adjustment.rounds.stamps_settled, adjustment.rounds.matrices_judged,
      adjustment.rounds.biases_judged, adjustment.rounds.ranges_measured, adjustment.rounds.walks_dropped,
      adjustment.rounds.history, adjustment.alignment_covariance, adjustment.noise_information,
      adjustment.problem.imu.alignment_shown, adjustment.problem.imu.alignment_sigma,
      adjustment.problem.imu.gravity_sigma, adjustment.problem.imu.matrix_sigma,
      adjustment.problem.estimate_imu_matrices, adjustment.lines);
}

template <>
struct IsFlat<FeatureMatch> : std::true_type {};
template <>
struct IsFlat<TrackObservation> : std::true_type {};

auto Members(Keyframe& keyframe) { return std::tie(keyframe.camera, keyframe.image, keyframe.time); }
auto Members(FeatureSet& features) {
  return std::tie(features.pixels, features.scales, features.angles, features.scores,
                  features.descriptor_size, features.descriptors, features.float_descriptors, features.width,
                  features.height);
}

auto Members(PairMatches& pair) { return std::tie(pair.keyframe_a, pair.keyframe_b, pair.matches); }
auto Members(ImageFeatures& features) {
  return std::tie(features.keyframes, features.features, features.followed);
}

auto Members(Track& track) { return std::tie(track.observations); }
auto Members(TrackSet& tracks) { return std::tie(tracks.keyframes, tracks.tracks); }

auto Members(SensorProblem& problem) { return std::tie(problem.sensor, problem.reason); }
auto Members(CameraInitialization& cameras) {
  return std::tie(cameras.cameras, cameras.held, cameras.noise, cameras.found, cameras.problems,
                  cameras.notes);
}

std::vector<char> ToBytes(const DriveOdometry& odometry) { return WrittenBytes(odometry); }
std::vector<char> ToBytes(const Initialization& start) { return WrittenBytes(start); }
std::vector<char> ToBytes(const Adjustment& adjustment) { return WrittenBytes(adjustment); }
std::vector<char> ToBytes(const ImageFeatures& features) { return WrittenBytes(features); }
std::vector<char> ToBytes(const TrackSet& tracks) { return WrittenBytes(tracks); }
std::vector<char> ToBytes(const CameraInitialization& cameras) { return WrittenBytes(cameras); }

bool FromBytes(const std::vector<char>& bytes, DriveOdometry* odometry) { return ReadBytes(bytes, odometry); }
bool FromBytes(const std::vector<char>& bytes, Initialization* start) { return ReadBytes(bytes, start); }
bool FromBytes(const std::vector<char>& bytes, Adjustment* adjustment) {
  return ReadBytes(bytes, adjustment);
}
bool FromBytes(const std::vector<char>& bytes, ImageFeatures* features) { return ReadBytes(bytes, features); }
bool FromBytes(const std::vector<char>& bytes, TrackSet* tracks) { return ReadBytes(bytes, tracks); }
bool FromBytes(const std::vector<char>& bytes, CameraInitialization* cameras) {
  return ReadBytes(bytes, cameras);
}

}  // namespace mlic
