#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace mlic::sim {

// Where and when the beams of one scan go. All patterns look along x of the pattern's frame, with z up.
enum class ScanPatternKind {
  kSpinning,  // rings about z, one column of all rings after the other
  kRaster,    // solid state: rows from bottom to top, each swept across, back and forth
  kRosette    // two rotating prisms (Livox); never the same scan twice
};

struct LidarModel {
  ScanPatternKind kind = ScanPatternKind::kSpinning;
  double rate = 10.0;  // scans per second

  // Spinning.
  int rings = 32;
  double vertical_fov_deg[2] = {-20.0, 20.0};
  int azimuth_steps = 1024;
  bool clockwise = true;            // seen from above
  bool simultaneous_rings = false;  // all rings of a column fire at once (Ouster), else one after the other

  // Raster.
  double fov_deg[2] = {120.0, 25.0};  // horizontal, vertical
  int columns = 300;
  int rows = 80;

  // Rosette.
  double cone_fov_deg = 70.0;
  int points_per_scan = 20000;
  double prism_rates_hz[2] = {121.57, -77.73};

  // Rotation of the pattern's frame in the sensor's frame, for drivers with odd axes.
  Eigen::Quaterniond R_sensor_pattern = Eigen::Quaterniond::Identity();

  double min_range = 0.4;
  double max_range = 120.0;
  double range_noise = 0.02;          // standard deviation, m
  double beam_divergence_deg = 0.12;  // full angle; makes mixed pixels at edges
  double range_at_10_percent = 70.0;  // m: a perpendicular target of reflectance 0.1 is seen every other time
  double random_dropouts = 0.002;     // share lost for no reason

  // What real LiDARs do besides; none of it by default.
  std::vector<double> ring_bias;  // m, added to the ranges of each ring; empty: none
  double range_walk = 0.0;        // m that ranges grow for each tenfold weaker echo
  double packet_loss = 0.0;       // share of packets (a hundredth of a scan each) that never arrive
  double rain = 0.0;              // drops that send a beam back, per metre of its way

  double Period() const { return 1.0 / rate; }
};

// One beam. time: seconds after the scan's start; direction: unit, sensor frame.
struct Firing {
  double time;
  Eigen::Vector3d direction;
  std::uint16_t ring;
};

// The beams of scan `index`, in order of time.
std::vector<Firing> MakeScanPattern(const LidarModel& model, std::int64_t index);

// True if every scan has the same pattern.
inline bool IsRepeating(const LidarModel& model) { return model.kind != ScanPatternKind::kRosette; }

}  // namespace mlic::sim
