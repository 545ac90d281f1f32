#pragma once

// Names of the stages, for people: in progress, log, report and times; the plan of a run (run_plan.h) is made
// of them. The joint adjustments are named by their landmarks (joint_adjustment.h).
namespace mlic::stage_names {

constexpr const char* kLoading = "loading";  // LoadDataset says so too (bag_loader.cc)
constexpr const char* kOdometry = "LiDAR odometry";
constexpr const char* kInitialization = "initialisation";
constexpr const char* kEachLidar = "plane adjustment of each LiDAR";
constexpr const char* kFeatures = "image features";
constexpr const char* kTracks = "tracks of each camera";
constexpr const char* kColmap = "intrinsics by COLMAP";
constexpr const char* kCameras = "camera initialisation";
constexpr const char* kFirstSharedTracks = "first tracks across cameras";
constexpr const char* kFirstSharedCameras = "cameras on first shared tracks";
constexpr const char* kSharedTracks = "tracks across cameras";
constexpr const char* kSharedCameras = "cameras on shared tracks";
constexpr const char* kHalves = "halves of the drive";
constexpr const char* kResult = "result";

}  // namespace mlic::stage_names
