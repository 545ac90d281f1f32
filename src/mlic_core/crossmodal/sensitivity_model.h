#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace mlic {

// One look at a patch of the map.
struct PatchLook {
  float log_intensity;
  float range;          // m
  float cos_incidence;  // 0 to 1
  std::uint16_t lidar;
  std::uint16_t ring;
};

// How a LiDAR's intensity depends on anything but the surface, as the logarithm of a factor:
//   range_l(log2 range) + incidence_l(log2 cosine) + ring_l(ring),
// the first two linear between nodes.
class SensitivityModel {
 public:
  // rings: of each LiDAR, how many it numbers.
  explicit SensitivityModel(const std::vector<int>& rings);

  // From looks at patches: [begin[p], begin[p+1]) are of patch p, whose brightness is unknown. Least squares
  // with the patches eliminated, redone with smaller weights for what does not fit. Functions are drawn to
  // smoothness, where there are no data, and rings to be alike. The result does not depend on the number of
  // threads.
  void Fit(const std::vector<PatchLook>& looks, const std::vector<std::size_t>& begin);

  // Of one look.
  double LogFactor(const PatchLook& look) const;

 private:
  static constexpr int kRangeNodes = 12;      // 0.5 m to 180 m; from: structural
  static constexpr int kIncidenceNodes = 10;  // cosines of 0.044 to 1; from: structural
  static constexpr int kEntries = 5;          // that one look touches; from: structural

  struct Row {
    int index[kEntries];
    double value[kEntries];
  };
  Row RowOf(const PatchLook& look) const;
  void AddPrior(double scale, Eigen::MatrixXd* H) const;

  std::vector<int> first_;  // parameter of each LiDAR, and the count of all
  Eigen::VectorXd parameters_;
};

}  // namespace mlic
