#pragma once

#include <opencv2/core/mat.hpp>

namespace mlic {

// Edges of one level of an image. Part of structure_features.h.

// moments: CV_32FC(5): of each pixel's edge, strength r in 0..1 and direction phi of its gradient, r times
// (1, cos 2 phi, sin 2 phi, cos 4 phi, sin 4 phi). known: CV_32FC1, 1 or 0. trust: CV_32FC1, 0 to 1, how much
// a pixel counts.
struct EdgeMap {
  cv::Mat moments;
  cv::Mat known;
  cv::Mat trust;
};

// What lies under each pixel; as in RenderedStructure.
struct SurfaceImage {
  cv::Mat points;
  cv::Mat normals;
  cv::Mat range;
};

// Edges of intensity. image: CV_32FC1, any value where known (CV_32FC1, 0 to 1) is 0. Strength is relative to
// what is usual in the image.
EdgeMap IntensityEdges(const cv::Mat& image, const cv::Mat& known, double sigma);

// Adds edges between a surface and what lies behind it, where known, and lowers the trust to `trust` as far
// from them as `reach` (px).
void AddDepthEdges(const SurfaceImage& surface, double sigma, double reach, float weight, float trust,
                   EdgeMap* edges);

// Adds edges between surfaces that face different ways, where known.
void AddOrientationEdges(const SurfaceImage& surface, double sigma, float weight, EdgeMap* edges);

// Half the size: the mean of 2 x 2 pixels weighted by `known`, and the mean of `known`. Odd last rows and
// columns are left out. Outputs may be the inputs.
void HalveKnown(const cv::Mat& image, const cv::Mat& known, cv::Mat* half_image, cv::Mat* half_known);

// Half the size: the nearest surface of 2 x 2 pixels.
SurfaceImage HalveNearest(const SurfaceImage& surface);

}  // namespace mlic
