#pragma once

#include <string>
#include <vector>

#include "mlic_core/association/point_landmarks.h"
#include "mlic_core/camera/tracks/tracks.h"
#include "mlic_core/common/progress.h"
#include "mlic_core/initialization/camera_rotation.h"
#include "mlic_core/initialization/lens_search.h"
#include "mlic_core/problem/joint_problem.h"
#include "mlic_core/problem/state.h"
#include "mlic_core/sensors/sensor_problem.h"

namespace mlic {

// Intrinsics that a camera starts with.
struct CameraStart {
  CameraIntrinsics intrinsics;
  bool from_field_of_view = false;  // focal length good to some ten per cent, no distortion
  double readout = 0.0;             // s, of rolling shutters
  bool intrinsics_held = false, readout_held = false;
};

// From the rig file: the intrinsics where given, else from the field of view. The image's size comes from the
// first drive that has the camera's images. Throws InputError for a camera that has neither.
std::vector<CameraStart> StartFromRig(const Rig& rig, const Dataset& dataset);

// What the initialisation of the cameras found; problems: of the cameras that it lost.
struct CameraInitialization {
  std::vector<CameraCalibration> cameras;
  std::vector<FixedCameraParameters> held;  // fixed cameras, and intrinsics that the data do not determine
  std::vector<LandmarkNoise> noise;         // of each camera, for LandmarkOptions
  std::vector<bool> found;                  // cameras that can take part in the joint solve
  std::vector<LandmarkSet> landmarks;       // of each drive, at the cameras found
  Eigen::MatrixXd information;              // of the calibration of a state with these cameras and no LiDARs
  std::vector<SensorProblem> problems;
  std::vector<std::string> notes;
};

// docs/method.md, section 7.5: time offset and rotation of every camera from visual rotations against the
// trajectory's, then rounds of triangulation on the trajectory and of solving extrinsics, offsets, intrinsics
// and landmarks with the trajectory held, all cameras together. tracks: of each drive. state: its drives'
// trajectories are used.
CameraInitialization InitializeCameras(const Rig& rig, const std::vector<CameraStart>& start,
                                       const std::vector<TrackSet>& tracks, const CalibrationState& state,
                                       const CancellationToken& cancellation);

// Goes on from cameras so found, with other tracks.
void AdjustCamerasFurther(const Rig& rig, const std::vector<CameraStart>& start,
                          const std::vector<TrackSet>& tracks, const CalibrationState& state,
                          const CancellationToken& cancellation, CameraInitialization* cameras);

// The parts of it, which a rig without LiDARs uses as well (camera_imu.h).

// A camera before anything is estimated: from the rig file and its start.
CameraCalibration CameraAsGiven(const CameraConfig& config, const CameraStart& start);

struct CameraAlignment {
  CameraRotation rotation;
  std::optional<LensHypothesis> lens;  // where the intrinsics come from a field of view; one that is there
                                       // already is only fitted again
};

// Rotation, time offset and, where it only comes from the field of view, the lens of a camera from its
// matches and the trajectories (of each drive). False: its images do not turn as the IMU does.
bool AlignCamera(const CameraConfig& config, const CameraStart& start, const std::vector<PixelMatches>& pairs,
                 const std::vector<const SplitSpline*>& T_map_imu, CameraCalibration* camera,
                 CameraAlignment* alignment);
std::string AlignmentNote(const std::string& name, const CameraCalibration& camera,
                          const CameraRotation& rotation);
std::string AlignmentProblem(const std::string& name);

// The rounds of AdjustCameras: the first five get ever tighter and let ever more intrinsics move, the others
// go on until the calibration moves by less than a tenth of its sigmas.
struct AdjustmentRounds {
  int first = 0;
  int end = 12;
};

struct CameraAdjustment {
  // What takes part beside the cameras and what is held of the trajectories; AdjustCameras sets the
  // landmarks and the cameras' terms. Without drives: the IMU has no say, as the trajectories are held.
  JointProblem problem;
  AdjustmentRounds rounds;
};

// Rounds of triangulation and solve from the state. result: found is read, the landmarks and what belongs to
// them are written.
void AdjustCameras(const Rig& rig, const std::vector<CameraStart>& start, const std::vector<TrackSet>& tracks,
                   CameraAdjustment adjustment, const CancellationToken& cancellation,
                   CalibrationState* state, CameraInitialization* result);

// Gives up cameras with too few observations or with ones that scatter too much; says so, or how good the
// others are.
void JudgeCameras(const Rig& rig, CameraInitialization* result);

}  // namespace mlic
