#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mlic_core/crossmodal/map_returns.h"

namespace mlic {

// What the neighbourhood of a return says about the surface that sent it.
struct ReturnSurface {
  Eigen::Vector3f position;                          // with less range noise
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // unit, towards the sensor; zero: no plane
  float spacing = 0.0f;                              // m
  float weight = 1.0f;                               // as of SurfacePoint
  bool at_edge = false;                              // the plane is that of a neighbourhood beside its own
  bool stray = false;  // lies alone beside dense surfaces: the mean of two that its beam hit, or noise
};

// A small patch that is a plane.
struct SurfacePlane {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit
  double thickness = 0.0;                            // m, standard deviation
  double count = 0.0;                                // of its points
  double spacing = 4.0;                              // m, between them; 0: of one line of a scan
  std::uint32_t begin = 0, end = 0;                  // over MapSurfaces::order
};

// Points that lie near each other: [begin, end) of the map's points, all within radius of the center. Their
// order is random, so that the first k of them are an even choice.
struct MapCell {
  Eigen::Vector3f center;
  float radius = 0.0f;  // m
  std::uint32_t begin = 0, end = 0;
};

// Returns sorted into an octree (root 4 m, leaves 0.125 m) and what it says of each.
struct MapSurfaces {
  std::vector<std::uint32_t> order;     // of the returns, cell after cell
  std::vector<MapCell> cells;           // over `order`
  std::vector<std::uint32_t> patches;   // over `order`: [patches[k], patches[k+1]) are of one small patch
  std::vector<ReturnSurface> surfaces;  // in order of `order`
  std::vector<SurfacePlane> planes;     // the patches that are planes
  std::vector<double> beam_spacing;     // rad, between neighbouring beams of each LiDAR
  double range_noise = 0.0;             // m, as measured
};

// What a return may lie off its plane by (sigma, m). cosine: of the beam to the normal.
double NoiseOffPlane(double cosine, double range_noise);

// Describes a return as one of the plane, its range corrected towards it along its beam by the share that the
// noises of both suggest. beam_spacing: rad, of its LiDAR. False, and nothing changed, where it lies off.
bool PlaceOnPlane(const MapReturn& r, const SurfacePlane& plane, double beam_spacing, double range_noise,
                  ReturnSurface* surface);

// The octree is split where there are points enough to tell more, until they fit a plane within their noise.
MapSurfaces FindSurfaces(const std::vector<MapReturn>& returns);

}  // namespace mlic
