#include "mlic_core/io/result/velodyne_calibration.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "mlic_core/io/text_file.h"
#include "mlic_core/io/yaml_reader.h"

namespace mlic {
namespace {

const char* const kAdded = "# MLIC has added the corrections of ";

// In the driver's order of rings.
std::vector<YamlReader> LasersFromBelow(const YamlReader& file) {
  const std::vector<YamlReader> lasers =
      file.Get("lasers", "expected a calibration file of velodyne_pointcloud").Elements();
  std::vector<std::pair<double, std::size_t>> order;  // elevation, index
  for (const YamlReader& laser : lasers) {
    order.emplace_back(laser.Get("vert_correction", "expected the laser's elevation in rad").Number(),
                       order.size());
  }
  std::sort(order.begin(), order.end());
  std::vector<YamlReader>
      from_below;  // and not the lasers sorted: to assign a node of yaml-cpp changes its file
  for (const auto& [elevation, index] : order) from_below.push_back(lasers[index]);
  return from_below;
}

// Numbers of the text to be others, by where they stand.
class Replacements {
 public:
  void Add(const YamlReader& number, double added) {
    if (added != 0.0) numbers_[number.Offset()] = {number.Text().size(), number.Number() + added};
  }
  std::string In(const std::string& text) const {
    constexpr int kDecimals = 9;  // from: structural, below a micrometre and a microradian
    std::string out;
    std::size_t done = 0;
    for (const auto& [offset, number] : numbers_) {
      out += text.substr(done, offset - done) + FixedNumber(number.value, kDecimals);
      done = offset + number.size;
    }
    return out + text.substr(done);
  }

 private:
  struct Number {
    std::size_t size = 0;  // of the text that it replaces
    double value = 0.0;
  };
  std::map<std::size_t, Number> numbers_;
};

}  // namespace

std::string WithCorrections(const std::filesystem::path& file, const std::string& lidar,
                            const PointCorrections& corrections) {
  const std::string text = ReadFile(file);
  const YamlReader root = YamlReader::Open(file);
  if (text.rfind(kAdded, 0) == 0)
    root.Fail("has corrections in it already, which count once; give the file as it was before");
  const std::vector<YamlReader> lasers = LasersFromBelow(root);
  std::vector<PointCorrections::Ring> rings(lasers.size());
  for (const PointCorrections::Ring& ring : corrections.rings) {
    if (static_cast<std::size_t>(ring.ring) >= lasers.size()) {
      root.Get("lasers").Fail("has " + std::to_string(lasers.size()) + " lasers, and ring " +
                              std::to_string(ring.ring) + " of " + lidar + " has a correction");
    }
    rings[static_cast<std::size_t>(ring.ring)] = ring;
  }
  Replacements replacements;
  for (std::size_t k = 0; k < lasers.size(); ++k) {
    const YamlReader elevation = lasers[k].Get("vert_correction");
    const double range =
        corrections.range_offset + corrections.range_slope * elevation.Number() + rings[k].range;
    replacements.Add(elevation, rings[k].elevation);
    replacements.Add(lasers[k].Get("dist_correction", "expected the laser's range correction in m"), range);
    for (const char* near : {"dist_correction_x", "dist_correction_y"}) {
      if (lasers[k].Has(near)) replacements.Add(lasers[k].Get(near), range);
    }
  }
  return kAdded + lidar + "; calibrate it anew with them.\n" + replacements.In(text);
}

}  // namespace mlic
