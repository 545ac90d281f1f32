#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mlic_core/common/time.h"
#include "mlic_core/result/point_corrections.h"
#include "mlic_core/result/pose_over_ground.h"
#include "mlic_core/result/quality_check.h"
#include "mlic_core/result/run_record.h"
#include "mlic_core/result/sigma_in_use.h"
#include "mlic_core/sensors/images.h"
#include "mlic_core/sensors/rig.h"

namespace mlic {

// Standard deviations. translation: metres along the axes of the first frame (IMU, or a of T_a_b); rotation:
// a small left rotation in that frame, radians; time_offset: seconds.
struct PoseSigma {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  double time_offset = 0.0;
};

// A direction that the data do not show. It was held at the guess; sigma is what is then claimed along it
// (metres or radians or seconds).
struct UnobservableDirection {
  enum class Quantity { kTranslation, kRotation, kTimeOffset };
  Quantity quantity = Quantity::kTranslation;
  Eigen::Vector3d direction =
      Eigen::Vector3d::Zero();  // unit vector in the IMU frame; zero for a time offset
  double sigma = 0.0;
};

// Lengths of the reprojection errors of places of the LiDAR map in photos of a camera that no solve used, px.
struct HeldOutMatches {
  std::size_t count = 0;
  double median = 0.0;
  double rms = 0.0;
};

// By how much two parts of the drive, calibrated apart, differ in one quantity of a sensor: the later minus
// the earlier. Of parameters that a part alone does not show, sigma is zero.
struct HalvesDifference {
  enum class Quantity { kRotation, kTranslation, kTimeOffset, kIntrinsics };
  Quantity quantity = Quantity::kRotation;
  std::vector<double> difference;  // rad (small left rotation), m, s; of intrinsics each in its own unit
  std::vector<double> sigma;       // of the difference
  int directions = 0;              // that both parts show
  double squares = 0.0;            // of the differences along these, each of variance one
  // What a normal variable exceeds, in its sigmas, as rarely as these directions together differ by so much.
  double deviation = 0.0;
  double largest = 0.0;  // of the single parameters, in sigmas

  double Worst() const { return std::max(deviation, largest); }
};

// Which parts of a drive were calibrated apart: its halves; its first quarter and its second half; its first
// half and its last quarter.
enum class DriveParts { kHalves, kBeginning, kEnd };

// For people.
inline std::string NameOf(DriveParts parts) {
  switch (parts) {
    case DriveParts::kHalves:
      return "first and second half";
    case DriveParts::kBeginning:
      return "first quarter and second half";
    case DriveParts::kEnd:
      return "first half and last quarter";
  }
  return "";
}

// Of one sensor; quantities that a part alone does not show are left out.
struct SensorHalves {
  std::string sensor;  // its name
  DriveParts parts = DriveParts::kHalves;
  std::vector<HalvesDifference> quantities;
};

struct SensorResult {
  enum class Type { kLidar, kCamera };
  std::string name;
  Type type = Type::kLidar;
  std::string frame_id;
  std::string topic;   // empty: not known
  bool fixed = false;  // held where the rig file has it
  SensorCalibration calibration;
  PoseSigma sigma;
  std::optional<PoseSigma> bound;  // Cramer-Rao: what sigma would be were the noise white and nothing else
  std::array<bool, 3> translation_observable{true, true, true};
  std::array<bool, 3> rotation_observable{true, true, true};
  bool time_offset_observable = true;
  double drift_sigma = 0.0;    // s/s, where the clock's drift is estimated
  TimeNs clock_reference = 0;  // where its time offset holds; of the first drive
  std::vector<UnobservableDirection> unobservable;
  PointCorrections corrections;  // of a LiDAR; the calibration holds for points with them
  std::optional<CameraIntrinsics> intrinsics;
  std::vector<double> intrinsics_sigma;           // of each parameter, in its unit; empty: not known
  std::vector<bool> intrinsics_fixed;             // each parameter that the data do not show; empty: none
  std::optional<double> rolling_shutter_readout;  // s
  std::optional<double> readout_sigma;            // s
  std::optional<HeldOutMatches> held_out;         // of a camera that was matched to the map
  std::vector<SigmaInUse> in_use;                 // of T_imu_sensor; empty: not known
};

// T_a_b: points of sensor b into sensor a; time_offset of sigma: of the difference of the two offsets.
struct PairResult {
  std::string a, b;
  RigidTransform T_a_b;
  PoseSigma sigma;
  std::optional<PoseSigma> bound = {};  // as a sensor's
  // Directions along the axes of a that the data do not show. Told only of pairs without the IMU.
  std::vector<UnobservableDirection> unobservable = {};
  std::vector<SigmaInUse> in_use = {};  // empty: not known, or cameras that see nothing in common
};

// Absolute, as files and topics have it; TimedPose is one within a drive.
struct StampedPose {
  TimeNs time = 0;
  RigidTransform pose;
};

// A point of the final map: metres in the map frame of its drive.
struct MapPoint {
  Eigen::Vector3f position;
  float intensity = 0.0f;
  int lidar = 0;   // index in CalibrationResult::sensors
  int plane = -1;  // index of its plane in the map, -1 for none
};

// One round of association and solve of a joint adjustment.
struct RoundSummary {
  std::string stage;
  double change = 0.0;  // largest of a sensor, in its sigmas
};

// How one stage went, for the report.
struct StageSummary {
  std::string name;
  double seconds = 0.0;
  double processor_seconds = 0.0;  // of all threads together
  std::vector<std::string> lines;  // what was found, in plain words with numbers
};

// Mean reprojection errors by cells of a camera's image: what a model cannot follow stands out.
struct ResidualField {
  int columns = 0;
  int rows = 0;
  std::vector<Eigen::Vector2f> mean;  // px, projected minus seen; row by row
  std::vector<int> counts;
};

// Residual statistics of one sensor for the report.
struct ResidualSummary {
  std::string sensor;  // name, or "gyroscope", "accelerometer"
  std::string unit;    // "m", "px", "rad/s", "m/s^2"
  double sigma = 0.0;  // the noise level that the solve assumed
  double inlier_share = 1.0;
  std::vector<double> histogram;          // counts over [-5, 5] sigma, equal bins
  std::vector<double> over_time_seconds;  // centre of each time bin
  std::vector<double> over_time_rms;      // rms of each time bin, in units of `unit`
  double rms = 0.0;                       // of all, in units of `unit`; of each coordinate for cameras
  ResidualField over_image;               // cameras only
  double drift = 0.0;  // rms of the means over time bins beyond what white residuals leave, in their sigmas
  // Of gyroscope and accelerometer, of each time bin: by how much its samples alone would have the bias
  // beyond the one that is given, and the sigma of that where noise is white; in units of `unit`, along the
  // axes.
  std::vector<Eigen::Vector3d> bias_over_time, bias_sigma_over_time;
};

// Where one image sees a landmark, where the calibration projects it to, and where the same camera's images
// of the seconds before and after see it, in order of time (the place in this image among them). Pixels.
struct LandmarkProjection {
  Eigen::Vector2f observed;
  Eigen::Vector2f projected;
  std::vector<Eigen::Vector2f> track;
};

// One image of a camera with all landmarks that it sees.
struct CameraView {
  std::string camera;                         // its name
  std::shared_ptr<const ImageSource> images;  // where the photo can be loaded from
  std::size_t image = 0;
  std::vector<LandmarkProjection> observations;
};

// A LiDAR point in a photo: px; m along the ray; intensity as the driver writes it.
struct ProjectedPoint {
  Eigen::Vector2f pixel;
  float depth = 0.0f;
  float intensity = 0.0f;
};

// Where a place of the LiDAR map was found in a photo, and where the calibrations before and after the last
// stage project it to. Pixels.
struct MatchProjection {
  Eigen::Vector2f observed;
  Eigen::Vector2f before;
  Eigen::Vector2f after;
};

// One photo of a camera with what the LiDARs saw at that time, before and after the last stage.
struct CameraProjection {
  bool found = true;                          // else only the guess is shown
  std::string camera;                         // its name
  std::shared_ptr<const ImageSource> images;  // where the photo can be loaded from
  std::size_t image = 0;
  cv::Mat rendering;  // CV_32F, the map's intensity after the stage, 0 to 1; NaN where nothing is seen
  std::vector<ProjectedPoint> before, after;
  std::vector<ProjectedPoint> guess;  // with the poses of the rig file; empty without guesses
  std::vector<MatchProjection> matches;
};

// The images of one camera whose features took part in the solve.
struct CameraKeyframes {
  std::string camera;
  std::vector<TimeNs> stamps;  // as in the messages, in order
};

// Where the rig file has a sensor before it is calibrated.
struct GuessedPose {
  std::string name;
  RigidTransform T_imu_sensor;
};

// A sensor of the rig that is not given.
struct RejectedSensor {
  std::string name;
  SensorResult::Type type = SensorResult::Type::kLidar;
  std::string reason;  // one line for people, which names it
  // Of one that stands in pairs about CalibrationResult::root; empty: not known.
  std::string frame_id = {};
};

enum class Verdict {
  kTrusted,
  kPartial,  // of the sensors or pairs that are given; others were rejected
  kRefused,
};

// Whose axes the IMU's are. common: gyroscope and accelerometer are taken for aligned.
enum class ImuAxes { kCommon, kGyroscope };

// How well the accelerometer's axes are known against the gyroscope's (a small left rotation of
// accelerometer_matrix, rad), and about which axes of the IMU the data show it. held: unit vectors about
// which they do not. of_accelerometer: about which the IMU's axes are the accelerometer's.
struct ImuAlignment {
  ImuAxes axes = ImuAxes::kCommon;
  std::array<bool, 3> estimated{false, false, false};
  std::vector<Eigen::Vector3d> held, of_accelerometer;
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
};

struct CalibrationResult {
  Verdict verdict = Verdict::kRefused;
  std::vector<std::string> reasons;      // why it is refused or partial, each one line
  std::vector<RejectedSensor> rejected;  // a sensor for each reason against it
  std::vector<std::string> warnings;     // what to know of what is given
  std::vector<QualityCheck> checks;      // what the verdict rests on
  std::optional<RunRecord> run;          // none: not known
  std::string imu_frame_id;
  ImuCalibration imu;
  std::optional<ImuAlignment> alignment;  // none: not known, as of truths
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  std::vector<SensorResult> sensors;          // when refused: only those whose link to the IMU was shown
  std::vector<SensorResult> initial_sensors;  // the same before the joint adjustment, without sigmas
  std::vector<GuessedPose> guesses;           // of the rig file; for pictures, not kept in files
  std::vector<PairResult> pairs;
  std::optional<PoseOverGround> ground;  // none: the map does not show it
  // Where nothing ties the sensors to the IMU, but maps tie LiDARs to each other: the one that what is given
  // for use (launch file, URDF) is about, by the pairs with it. Empty: all is about the IMU.
  std::string root;
  std::vector<std::vector<StampedPose>> trajectories;  // T_map_imu, one for each drive, IMU clock
  std::vector<MapPoint> map;                           // of the first drive
  std::vector<StageSummary> stages;
  std::vector<RoundSummary> rounds;  // of all joint adjustments, in their order
  std::vector<ResidualSummary> residuals;
  std::vector<SensorHalves> halves;           // of the sensors that took part
  std::vector<CameraView> views;              // one of each camera; for pictures, not kept in files
  std::vector<CameraProjection> projections;  // one of each camera beside LiDARs; likewise
  std::vector<CameraKeyframes> keyframes;     // of all drives
  double peak_memory_megabytes = 0.0;

  bool Trusted() const { return verdict == Verdict::kTrusted; }
  // Whether the sensors that are given are good for use.
  bool Usable() const { return verdict != Verdict::kRefused; }
};

}  // namespace mlic
