#pragma once

#include <cstddef>
#include <vector>

namespace mlic {

// Structure that a photo and a rendering of the LiDAR map share: where edges are and which way they run, not
// how bright either side is. At every pixel, the distribution of edge strength over orientation (modulo pi,
// so that inverted contrast is the same edge), blurred over the neighbourhood: the channel features of
// orientated gradients, CFOG (Ye, Bruzzone, Shan, Bovolo, Zhu, "Fast and robust matching for multimodal
// remote sensing image registration", 2019), kept as the Fourier coefficients 0, 2 and 4 of that
// distribution in place of samples of it. Edge strength saturates, so that one strong edge does not drown the
// rest. Coefficient 0 is kept relative to its wider surroundings: empty and crowded places differ by it.
struct StructureImage {
  static constexpr int kChannels = 5;  // from: structural

  int width = 0;
  int height = 0;
  std::vector<float> channels;  // row by row, the channels of a pixel together
  std::vector<float> energy;    // of each pixel, the sum of its channels' squares
  std::vector<float> known;     // of each pixel, 1, or 0: then its channels are 0
  std::vector<float> weight;    // of each pixel, how much it counts in a template, 0 to 1; 0 where not known

  // How many pixels of each row are known before each column, width + 1 numbers for each row.
  std::vector<int> known_before;

  bool AllKnown(int row, int begin, int end) const {
    const int* before = &known_before[static_cast<std::size_t>(row) * static_cast<std::size_t>(width + 1)];
    return before[end] - before[begin] == end - begin;
  }
  const float* Channels(int row) const {
    return &channels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width * kChannels)];
  }
  const float* Energy(int row) const {
    return &energy[static_cast<std::size_t>(row) * static_cast<std::size_t>(width)];
  }
  const float* Known(int row) const {
    return &known[static_cast<std::size_t>(row) * static_cast<std::size_t>(width)];
  }
  const float* Weight(int row) const {
    return &weight[static_cast<std::size_t>(row) * static_cast<std::size_t>(width)];
  }
};

// Level l is half as large as level l - 1; a pixel of level l covers 2 x 2 of level l - 1, so the pixel
// at x of level 0 is at (x + 0.5) / 2^l - 0.5 of level l.
using StructurePyramid = std::vector<StructureImage>;

inline double ToLevel(double x, int level) { return (x + 0.5) / (1 << level) - 0.5; }
inline double FromLevel(double x, int level) { return (x + 0.5) * (1 << level) - 0.5; }

}  // namespace mlic
