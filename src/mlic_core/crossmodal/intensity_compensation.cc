#include "mlic_core/crossmodal/intensity_compensation.h"

#include <algorithm>
#include <cmath>

namespace mlic {

std::vector<float> CompensateIntensity(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces) {
  std::vector<float> result(returns.size());
  for (std::size_t k = 0; k < result.size(); ++k)
    result[k] = std::sqrt(std::clamp(returns[surfaces.order[k]].intensity / 255.0f, 0.0f, 1.0f));
  return result;
}

}  // namespace mlic
