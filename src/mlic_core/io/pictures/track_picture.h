#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

#include "mlic_core/result/result.h"

namespace mlic {

// The photo (CV_8UC1 or CV_8UC3) in muted colours with what the camera sees of the landmarks: a ring where
// each was seen, a blue line along its track through the images before and after, and a red arrow from there
// towards where the calibration projects it, magnified by a factor that the legend states. Photos narrower
// than 800 px are enlarged by a whole factor.
cv::Mat DrawTracks(const cv::Mat& photo, const CameraView& view);

// The factor by which DrawTracks magnifies the arrows: 1, 2 or 5 times a power of ten, so that the longest
// tenth of them just begins to exceed a thirtieth of the image's width.
int ArrowMagnification(const CameraView& view, int image_width);

// Loads the photo of each view and writes DIRECTORY/NAME_tracks.png.
void WriteTrackPictures(const std::filesystem::path& directory, const std::vector<CameraView>& views);

}  // namespace mlic
