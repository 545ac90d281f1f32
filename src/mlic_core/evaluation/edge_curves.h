#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace mlic {

// The edge between a darker and a brighter part of an image: places to a fraction of a pixel, in order, about
// a pixel apart. px.
using EdgeCurve = std::vector<Eigen::Vector2d>;

// All edges of an image (CV_8UC1) that are stronger than its texture. A place is the maximum of
// the gradient's size across the edge, by a parabola through three pixels (Devernay, INRIA report 2724,
// 1995); a curve goes on to the neighbouring place as long as the edge does not turn sharply, so that corners
// end it and a bent line stays one. Curves of fewer than `shortest` places are left out. Deterministic.
std::vector<EdgeCurve> TraceEdges(const cv::Mat& image, std::size_t shortest);

}  // namespace mlic
