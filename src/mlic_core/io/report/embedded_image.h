#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace mlic {

// Images as data URIs (RFC 2397) for HTML. picture: 8 bits, BGR or, for PNG, BGRA.
std::string EmbedPng(const cv::Mat& picture);
std::string EmbedJpeg(const cv::Mat& picture, int quality);

std::string EncodeBase64(const std::string& bytes);

}  // namespace mlic
