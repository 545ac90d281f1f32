#pragma once

#include <opencv2/core/mat.hpp>

#include "mlic_core/crossmodal/structure_image.h"

namespace mlic {

struct StructureOptions {
  int levels = 4;  // from: guard, speed: the widest search is 10 px at the coarsest
  // Level at which places are found to a fraction of a pixel; finer ones are not used. More than 0 for maps
  // that are much coarser than the photo, such as of one scan.
  int finest_level = 0;         // from: structural
  double gradient_sigma = 1.0;  // px at each level: of the Gaussian whose derivative finds edges
  double channel_sigma = 1.5;   // px at each level: of the blur over the neighbourhood
  // Weights of the rendering's edges of depth and of surface orientation beside those of intensity (1). Edges
  // of depth are fattened on one side by the beam's width. Both halved, eight views of matcher_test give 521
  // matches with errors of 0.42 px (rms) for 528 of 0.43 px; doubled as kLeastSharpness
  // (structure_matcher.cc).
  double depth_weight = 0.5;   // from: measured
  double normal_weight = 0.5;  // from: measured
  // How much pixels count around edges of depth, as far as those are felt, and those of no plane, whatever
  // edge they show: beams are as wide as some pixels and miss the sides of recesses and ledges, which the
  // photo shows in a light of their own, and from below as a rule. Measured: a third of a pixel of bias. At
  // the finest level only: coarser levels are there to find the place.
  double depth_trust = 0.05;  // from: measured
  // Orientation, too, is kept relative to its wider surroundings: a floor seen from near the ground is all
  // horizontal strokes in photo and rendering alike, and would correlate wherever it is laid.
  bool relative_orientation = false;
};

// The rendered map as the features need it. All of one size.
struct RenderedStructure {
  cv::Mat intensity;  // CV_32FC1; NaN where nothing was seen
  cv::Mat points;     // CV_32FC3: the surface point under each pixel, m, in any frame; may be empty
  cv::Mat normals;    // CV_32FC3: its unit normal in the same frame; zero where unknown
  cv::Mat range;      // CV_32FC1: its distance from the camera, m; 0 or NaN where nothing was seen
};

// gray: CV_8UC1; mask: CV_8UC1 of the same size, 0: ignore; may be empty.
StructurePyramid PhotoStructure(const cv::Mat& gray, const cv::Mat& mask, const StructureOptions& options);

// Edges of intensity, of depth (steps off the neighbour's plane, so a slanted floor has none) and of surface
// orientation.
StructurePyramid MapStructure(const RenderedStructure& rendering, const StructureOptions& options);

}  // namespace mlic
