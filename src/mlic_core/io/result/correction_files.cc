#include "mlic_core/io/result/correction_files.h"

#include "mlic_core/io/text_file.h"

namespace mlic {
namespace {

const char* const kMeaning =
    "# What the points of %NAME need added to where the driver has them, for the extrinsics to hold:\n"
    "#   to the range (m)       range_offset + range_slope * elevation + range of its ring\n"
    "#                          + range_walk * log10(intensity / reference_intensity), where these are "
    "given\n"
    "#                          (the logarithm at least -2 and at most 2),\n"
    "#   to the elevation (rad) elevation of its ring.\n"
    "# elevation: above the plane across the LiDAR's z axis. Rings as the driver numbers them in its "
    "messages;\n"
    "# those that are not listed need none of their own.\n"
    "# velodyne_pointcloud, file `calibration`: rings count the lasers by their vert_correction from below. "
    "Add\n"
    "#   range, range_offset and range_slope * vert_correction to dist_correction (_x and _y too), elevation "
    "to\n"
    "#   vert_correction; export --format rings --velodyne FILE does. There is no place for range_walk.\n"
    "# Ouster, file `metadata`: elevation in degrees to beam_altitude_angles; there is no place for ranges "
    "of beams.\n"
    "# Hesai, CSV of angle corrections: elevation in degrees to the laser's Elevation; none for ranges.\n"
    "# A driver that corrects its points with this is a sensor to calibrate anew: corrections count once.\n";

std::string RingText(const PointCorrections::Ring& ring) {
  return "{ring: " + std::to_string(ring.ring) + ", range: " + FixedNumber(ring.range, 6) +
         ", elevation: " + FixedNumber(ring.elevation, 7) + "}";
}

std::string OffsetsText(const PointCorrections& corrections, const std::string& between) {
  return "range_offset: " + FixedNumber(corrections.range_offset, 6) + between +
         "range_slope: " + FixedNumber(corrections.range_slope, 6) +
         (corrections.range_walk == 0.0
              ? ""
              : between + "range_walk: " + FixedNumber(corrections.range_walk, 6) + between +
                    "reference_intensity: " + FixedNumber(corrections.reference_intensity, 6));
}

}  // namespace

std::string CorrectionsText(const PointCorrections& corrections) {
  std::string rings;
  for (const PointCorrections::Ring& ring : corrections.rings) {
    rings += (rings.empty() ? "" : ",\n              ") + RingText(ring);
  }
  return "{" + OffsetsText(corrections, ", ") + ",\n      rings: [" + rings + "]}";
}

PointCorrections ReadCorrections(const YamlReader& sensor) {
  PointCorrections corrections;
  if (!sensor.Has("corrections")) return corrections;
  const YamlReader node = sensor.Get("corrections");
  const auto number = [](const YamlReader& of, const char* key) {
    return of.Get(key, "give a number").Number();
  };
  corrections.range_offset = number(node, "range_offset");
  corrections.range_slope = number(node, "range_slope");
  if (node.Has("range_walk")) {
    corrections.range_walk = number(node, "range_walk");
    corrections.reference_intensity = number(node, "reference_intensity");
  }
  for (const YamlReader& element : node.Get("rings", "give a list, or [] for none").Elements()) {
    const double ring = number(element, "ring");
    if (ring < 0.0 || ring > 65535.0) element.Get("ring").Fail("expected the number of a ring");
    corrections.rings.push_back(
        {static_cast<int>(ring), number(element, "range"), number(element, "elevation")});
  }
  return corrections;
}

std::vector<ExportedFile> CorrectionFiles(const CalibrationResult& result) {
  std::vector<ExportedFile> files;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.corrections.Any()) continue;
    std::string text = kMeaning;
    const std::string name = "%NAME";
    text.replace(text.find(name), name.size(), sensor.name);
    text += OffsetsText(sensor.corrections, "\n") +
            "\nrings:" + (sensor.corrections.rings.empty() ? " []" : "") + "\n";
    for (const PointCorrections::Ring& ring : sensor.corrections.rings)
      text += "  - " + RingText(ring) + "\n";
    files.push_back({sensor.name + ".yaml", text});
  }
  return files;
}

}  // namespace mlic
