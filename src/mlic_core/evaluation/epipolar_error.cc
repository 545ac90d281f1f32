#include "mlic_core/evaluation/epipolar_error.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/evaluation/pixel_distance.h"

namespace mlic {
namespace {

// The mean of the distances in both images; false where the geometry or a model does not reach.
bool Measure(const FreshMatch& match, const SensorResult& a, const SensorResult& b,
             const std::vector<StampedPose>& trajectory, double* error) {
  RigidTransform T_map_a, T_map_b;
  Eigen::Vector3d bearing_a, bearing_b;
  if (!PoseOfRow(a, trajectory, match.stamp_a, match.pixel_a.y(), &T_map_a) ||
      !PoseOfRow(b, trajectory, match.stamp_b, match.pixel_b.y(), &T_map_b) ||
      !Unproject(*a.intrinsics, match.pixel_a, &bearing_a) ||
      !Unproject(*b.intrinsics, match.pixel_b, &bearing_b)) {
    return false;
  }
  const RigidTransform T_b_a = T_map_b.Inverse() * T_map_a;
  const Eigen::Matrix3d R_b_a = T_b_a.rotation.toRotationMatrix();
  const Eigen::Vector3d normal_in_b = T_b_a.translation.cross(R_b_a * bearing_a);
  const Eigen::Vector3d normal_in_a = R_b_a.transpose() * bearing_b.cross(T_b_a.translation);
  double in_a = 0.0, in_b = 0.0;
  if (!PixelDistance(*a.intrinsics, bearing_a, normal_in_a.normalized(), &in_a) ||
      !PixelDistance(*b.intrinsics, bearing_b, normal_in_b.normalized(), &in_b)) {
    return false;
  }
  *error = 0.5 * (std::abs(in_a) + std::abs(in_b));
  return true;
}

const EpipolarStatistics* ErrorOf(const EpipolarColumn& column, const EpipolarStatistics& pair) {
  for (const EpipolarStatistics& error : column.errors) {
    if (error.a == pair.a && error.b == pair.b) return &error;
  }
  return nullptr;
}

}  // namespace

std::vector<EpipolarStatistics> MeasureEpipolarErrors(const std::vector<FreshMatch>& matches,
                                                      const CalibrationResult& calibration,
                                                      const std::vector<StampedPose>& trajectory) {
  struct Distances {
    std::vector<double> distances;
    std::set<std::pair<TimeNs, TimeNs>> images;
  };
  std::map<std::pair<std::string, std::string>, Distances> pairs;
  std::vector<std::pair<std::string, std::string>> order;
  for (const FreshMatch& match : matches) {
    const SensorResult* a = FindCamera(calibration, match.camera_a);
    const SensorResult* b = FindCamera(calibration, match.camera_b);
    double distance = 0.0;
    if (a == nullptr || b == nullptr || !Measure(match, *a, *b, trajectory, &distance)) continue;
    const auto [found, added] = pairs.try_emplace({match.camera_a, match.camera_b});
    if (added) order.push_back(found->first);
    found->second.distances.push_back(distance);
    found->second.images.emplace(match.stamp_a, match.stamp_b);
  }
  std::vector<EpipolarStatistics> errors;
  for (const auto& key : order) {
    Distances& pair = pairs[key];
    EpipolarStatistics error;
    error.a = key.first;
    error.b = key.second;
    error.image_pairs = pair.images.size();
    error.matches = pair.distances.size();
    for (const double distance : pair.distances) {
      error.mean += distance / static_cast<double>(pair.distances.size());
    }
    error.median = Median(pair.distances);
    errors.push_back(error);
  }
  return errors;
}

std::string TableOf(const std::vector<EpipolarColumn>& columns) {
  if (columns.empty() || columns.front().errors.empty()) return "no two cameras see the same\n";
  std::string table;
  char text[200];
  for (const EpipolarStatistics& pair : columns.front().errors) {
    std::snprintf(text, sizeof(text), " (%zu matches in %zu pairs of images):", pair.matches,
                  pair.image_pairs);
    table += pair.a + " / " + pair.b + text;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const EpipolarStatistics* error = ErrorOf(columns[c], pair);
      if (error == nullptr) continue;
      std::snprintf(text, sizeof(text), "%s %s median %.2f px, mean %.2f px", c > 0 ? ";" : "",
                    columns[c].name.c_str(), error->median, error->mean);
      table += text;
    }
    table += "\n";
  }
  return table;
}

std::string CsvOf(const std::vector<EpipolarColumn>& columns) {
  std::string csv = "calibration,a,b,image_pairs,matches,median_px,mean_px\n";
  char text[160];
  for (const EpipolarColumn& column : columns) {
    for (const EpipolarStatistics& error : column.errors) {
      std::snprintf(text, sizeof(text), ",%zu,%zu,%.6f,%.6f\n", error.image_pairs, error.matches,
                    error.median, error.mean);
      csv += column.name + "," + error.a + "," + error.b + text;
    }
  }
  return csv;
}

}  // namespace mlic
