#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "mlic_core/evaluation/edge_curves.h"
#include "mlic_core/sensors/camera_intrinsics.h"

namespace mlic {

// The figure of merit of a calibration harp (Tang et al., "High-precision camera distortion measurements with
// a calibration harp", JOSA A 2012): how far places of straight edges are from straight lines once the
// intrinsics have undone the distortion. The places of a straight edge lie in a plane through the camera's
// centre, whatever the lens: instead of an undistorted image, which a fisheye past 90 deg has not, their
// bearings are taken, a plane is fitted to those of an edge, and the distance to it is told in pixels of the
// photo.

// One edge of a photo: means of a few neighbouring places, which have less noise. px.
using HarpEdge = std::vector<Eigen::Vector2d>;

// Where a camera sees anything: every place is bright in some photo of bars that fill the image by turns. The
// dark rim around the image of a fisheye is left out, which would bend the edges that run into it.
class LitPart {
 public:
  // photo: CV_8UC1 or CV_8UC3; all of one size.
  void Add(const cv::Mat& photo);
  // CV_8UC1, 0 where no photo is bright, nor close to there. There must have been a photo.
  cv::Mat Mask() const;

 private:
  cv::Mat brightest_;
};

// The long edges of a photo (CV_8UC1 or CV_8UC3), straight or not, where the mask is not 0.
std::vector<HarpEdge> FindHarpEdges(const cv::Mat& photo, const cv::Mat& mask);

// An edge as the intrinsics see it.
struct HarpLine {
  std::vector<Eigen::Vector2d> places;  // px, in order along the edge
  std::vector<double> distances;        // px, to the fitted line; positive: to the right of it
};

struct HarpErrors {
  std::size_t lines = 0;
  std::size_t places = 0;
  double rms = 0.0;      // px
  double largest = 0.0;  // px
};

struct HarpPhoto {
  std::string name;
  std::vector<HarpLine> lines;
  HarpErrors errors;
};

struct HarpMeasurement {
  std::vector<HarpPhoto> photos;
  HarpErrors all;
};

// Left out: edges that bend by more than any lens that was calibrated at all does (corners, curved things),
// and places that leave their edge's smooth course. InputError when no photo shows a straight edge.
HarpMeasurement MeasureHarp(const std::vector<std::string>& names,
                            const std::vector<std::vector<HarpEdge>>& edges,
                            const CameraIntrinsics& intrinsics);

// Counts of the distances, px: equal bins from -`limit` to +`limit`.
struct HarpHistogram {
  double limit = 0.0;
  std::vector<std::size_t> counts;
};
HarpHistogram HistogramOf(const HarpMeasurement& measurement);

// The measurement under one set of intrinsics.
struct HarpColumn {
  std::string name;  // "calibration" or "truth"
  HarpMeasurement measurement;
};

// For people, one line for each photo and one for all.
std::string TableOf(const std::vector<HarpColumn>& columns);
// intrinsics,photo,lines,places,rms_px,largest_px; photo "all" for all together.
std::string CsvOf(const std::vector<HarpColumn>& columns);
// intrinsics,from_px,to_px,places
std::string HistogramCsvOf(const std::vector<HarpColumn>& columns);
// One line that ends an evaluation.
std::string Conclusion(const std::string& camera, const HarpMeasurement& measurement);

// The photo (CV_8UC1 or CV_8UC3) in muted colours with its edges, each place moved away from its line by its
// distance, magnified; the factor stands in the legend, the histogram of the whole measurement below.
cv::Mat DrawHarp(const cv::Mat& photo, const HarpPhoto& lines, const HarpMeasurement& measurement);

}  // namespace mlic
