#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mlic_core/geometry/timed_pose.h"
#include "mlic_core/lidar/plane_map.h"

namespace mlic {

// Observations of a point: one says nothing about anything else. from: derivation
constexpr std::size_t kFewestOfPoint = 2;

// A point tied to a plane.
struct PlaneObservation {
  Eigen::Vector3f position;  // LiDAR frame, its ring's correction applied
  float sigma;               // m, along the beam
  float cos_incidence;
  float intensity;
  std::int32_t lidar;
  std::uint16_t ring;
  double time;          // LiDAR clock
  float weight = 1.0f;  // beside the robust one: less than one for what its group shares
};

// One drive's planes and the points tied to each, in order of LiDAR and time. A plane that is seen for long
// is several (time_windows.h).
struct PlaneAssociation {
  std::vector<MapPlane> planes;
  std::vector<PlaneObservation> observations;
  std::vector<std::size_t> begin;  // of each plane's observations; one more than planes
};

// An observation of a point landmark.
struct LandmarkObservation {
  std::int32_t camera;
  float sigma;  // px, of each coordinate of shape * error
  double time;  // of the image, camera clock
  Eigen::Vector2d pixel;
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();  // errors that are not alike in all directions
};

// A point landmark as a LiDAR measured it: a place of the map that a camera found again. It ties the camera
// to the LiDAR at the beam's time.
struct LidarPointObservation {
  std::int32_t lidar = -1;                             // -1: none
  double time = 0.0;                                   // LiDAR clock
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // LiDAR frame
  float sigma_along = 0.0f;                            // m, along the beam
  float sigma_across = 0.0f;                           // m
};

// A point that cameras see. The anchor, a place near the cameras, is where its bearing and inverse distance
// are taken from as parameters, so that far points are well-behaved. Map frame.
struct PointLandmark {
  Eigen::Vector3d position;
  Eigen::Vector3d anchor;
};

// One drive's point landmarks and the observations of each.
struct LandmarkSet {
  std::vector<PointLandmark> points;
  std::vector<LandmarkObservation> observations;
  std::vector<std::size_t> begin;                   // of each point's observations; one more than points
  std::vector<LidarPointObservation> lidar_points;  // of each point; empty: of none

  bool IsOnMap(std::size_t point) const { return !lidar_points.empty() && lidar_points[point].lidar >= 0; }
};

// Poses of the IMU that the trajectory is drawn to while it is being initialised, all equally good.
struct PoseObservations {
  std::vector<TimedPose> T_map_imu;  // IMU clock
  double sigma_rotation = 1.0;       // rad
  double sigma_translation = 1.0;    // m
};

}  // namespace mlic
