#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace mlic {

// An image of palette indices, row by row from the top.
struct PaletteImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
  std::vector<std::array<std::uint8_t, 3>> palette;  // at most 256; colour 0 is transparent
};

// The image as a PNG file (RFC 2083; deflate with run lengths only, which suits sparse point maps).
std::string EncodePng(const PaletteImage& image);

std::string EncodeBase64(const std::string& bytes);

}  // namespace mlic
