#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/crossmodal/intensity_map.h"
#include "mlic_core/result/result.h"

namespace mlic {

// A scan and the photo taken with it, nothing moving.
struct ScanPhoto {
  std::vector<MapReturn> returns;  // LiDAR frame; points of one moment
  cv::Mat photo;                   // CV_8UC1 or CV_8UC3 (BGR), all of one size
  cv::Mat mask;                    // CV_8UC1, 0: ignore; may be empty
};

struct PairRegistration {
  // The LiDAR takes the IMU's place: imu_frame_id is its frame, its own extrinsic is the identity, and the
  // camera's is T_lidar_camera. Intrinsics are held at the rig's: one still scan does not tell them from the
  // extrinsic. Refused when the photo does not show the scan's structure at one clear place, or a rotation is
  // not determined; translations that are not are held at the guess and said to be.
  CalibrationResult result;
  double score_before = 0.0, score_after = 0.0;  // of structure, -1 to 1
  double score_elsewhere = 0.0;                  // the highest at poses turned away by degrees
  double nid_before = 1.0, nid_after = 1.0;      // mean over the photos
  bool matched = false;                          // whether single matches were good enough to refine the pose
};

// Registers the rig's only camera to its only LiDAR by the renderer, the structure features, the matcher and
// PnP of the joint calibration. The guess is T_imu_lidar^-1 T_imu_camera of the rig, its sigma the camera's,
// and the LiDAR's too where it has a guess and is not known exactly. Throws InputError for a rig that does
// not fit.
PairRegistration RegisterPairs(const Rig& rig, const std::vector<ScanPhoto>& pairs);

// The points of a scan in its photo, at most `largest`.
std::vector<ProjectedPoint> ProjectScan(const std::vector<MapReturn>& returns, const CameraIntrinsics& camera,
                                        const RigidTransform& T_camera_body, std::size_t largest);

}  // namespace mlic
