#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mlic_core/common/progress.h"
#include "mlic_core/sensors/images.h"
#include "mlic_core/sensors/measurements.h"
#include "mlic_core/sensors/rig.h"
#include "mlic_sim/lidar_scanner.h"
#include "mlic_sim/sensor_set.h"
#include "mlic_sim/simulation_options.h"

namespace mlic::sim {

// Constants of this file, from: definition; errors of the guess as in the paper of MLIC.

// Absolute time of the drive's time 0.
constexpr TimeNs kSimulationEpoch = 1700000000LL * 1000000000LL;

struct SimulatedImuMessage {
  TimeNs received;   // when a recorder would have got it; the order of delivery
  TimeNs stamp;      // IMU clock
  ImuSample sample;  // time: s since kSimulationEpoch
};

struct SimulatedScan {
  TimeNs received;
  std::size_t lidar;                   // index in SensorSet::lidars
  TimeNs start;                        // LiDAR clock: time 0 of the points
  TimeNs stamp;                        // of the header: start, or end of the scan
  std::vector<SimulatedPoint> points;  // every beam in order of time, also those without return
};

struct SimulatedImage {
  TimeNs received;
  std::size_t camera;  // index in SensorSet::cameras
  TimeNs stamp;        // camera clock: the middle of row 0's exposure
  cv::Mat pixels;      // as CameraRenderer::Render makes them
};

// Receives a drive, message after message in order of `received`, in the calling thread.
class DriveSink {
 public:
  virtual ~DriveSink() = default;
  virtual void OnImu(const SimulatedImuMessage& message) = 0;
  virtual void OnScan(SimulatedScan scan) = 0;
  virtual void OnImage(SimulatedImage image) = 0;
};

// Simulates a drive. Scans and images are made in parallel, a second of the drive at a time, so memory stays
// bounded; the bytes do not depend on the number of threads. Throws InputError for a duration that is too
// short for a scan or an image.
void Simulate(const SensorSet& sensors, const SimulationOptions& options, DriveSink& sink,
              const CancellationToken& cancellation = {});

// The same in memory, as a loader would give it, without beams that did not return. on_scan (optional) sees
// every scan before it is stored, in order of time for each LiDAR: a place to filter it. Images are rendered
// when they are asked for (Drive::cameras).
Drive SimulateDrive(const SensorSet& sensors, const SimulationOptions& options,
                    const std::function<void(LidarScan&)>& on_scan = nullptr);

// The sensor's truth for the IMU's stamped readings: a gyroscope's low-pass shows the motion later than it
// was, as if the sensor's own clock were behind by that much more.
SensorCalibration AsTheImuSeesIt(const SimulatedImu& imu, SensorCalibration calibration);

// The truth of the LiDARs in the core's terms.
std::vector<SensorCalibration> TrueCalibrations(const SensorSet& sensors);

struct GuessOptions {
  bool with_guess = true;
  double rotation_error_deg = 4.81;  // about a random axis
  double translation_error = 0.1;    // m, in a random direction
  std::uint64_t seed = 1;
};

// The rig file's content for the set, with perturbed initial guesses or with none; time offsets are not
// given.
Rig RigFromSensorSet(const SensorSet& sensors, const GuessOptions& options);

}  // namespace mlic::sim
