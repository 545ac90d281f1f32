#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "mlic_core/geometry/rigid_transform.h"
#include "mlic_core/sensors/camera_model.h"

namespace mlic {

// A model as COLMAP writes it. Its scale and frame are its own.
struct ColmapReconstruction {
  struct Image {
    int keyframe = 0;
    RigidTransform T_camera_world;
    std::vector<Eigen::Vector2d> pixels;  // a pixel's centre at integer coordinates
    std::vector<int> points;              // index of the point of each pixel, -1 for none
  };
  CameraIntrinsics camera;
  std::vector<Image> images;  // by keyframe
  std::vector<Eigen::Vector3d> points;
};

// Reads cameras.bin, images.bin and points3D.bin of a database that FillColmapDatabase filled. Throws
// InputError, one line, when they are not whole.
ColmapReconstruction ReadColmapModel(const std::filesystem::path& directory);

}  // namespace mlic
