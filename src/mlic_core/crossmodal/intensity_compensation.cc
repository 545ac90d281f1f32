#include "mlic_core/crossmodal/intensity_compensation.h"

#include <algorithm>
#include <cmath>

#include "mlic_core/common/order_statistics.h"
#include "mlic_core/common/parallel.h"
#include "mlic_core/crossmodal/sensitivity_model.h"

namespace mlic {
namespace {

// from: guard, time and memory.
constexpr std::size_t kLooks = 24;       // at one patch that take part in the fit
constexpr std::size_t kPatches = 40000;  // that take part in the fit; from: guard, time and memory
constexpr int kMostRings = 256;          // from: guard, time and memory
constexpr float kDarkest = 0.004f;       // of the LiDAR's bright returns: what is darker is lost in noise
// from: derivation, surfaces of all directions show as much as their cosine: half of what is seen has less
// than sqrt(1/2).
constexpr float kUnknownIncidence = 0.7f;  // where there is no plane
// from: guard.
constexpr std::size_t kFewestShared = 30;  // patches that tell one LiDAR's contrast from another's
constexpr double kLeastCorrelation = 0.5;

class Compensation {
 public:
  Compensation(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces)
      : returns_(returns), surfaces_(surfaces) {
    for (const MapReturn& r : returns) {
      if (r.lidar >= rings_.size()) rings_.resize(r.lidar + 1, 1);
      rings_[r.lidar] = std::max(rings_[r.lidar], std::min<int>(r.ring + 1, kMostRings));
    }
    contrast_.assign(rings_.size(), 1.0f);
    MeasureLevels();
  }

  std::vector<float> Run() {
    ChooseLooks();
    SensitivityModel model(rings_);
    model.Fit(looks_, begin_);
    if (MatchContrasts(model)) {
      ChooseLooks();
      model.Fit(looks_, begin_);
    }
    return Brightness(model);
  }

 private:
  const MapReturn& At(std::size_t k) const { return returns_[surfaces_.order[k]]; }

  // The scale of each LiDAR's numbers: bright returns, and their middle.
  void MeasureLevels() {
    std::vector<std::vector<float>> samples(rings_.size());
    const std::size_t step = 1 + returns_.size() / 400000;
    for (std::size_t i = 0; i < returns_.size(); i += step)
      samples[returns_[i].lidar].push_back(returns_[i].intensity);
    for (auto& of_lidar : samples) {
      bright_.push_back(std::max(1e-6f, Quantile(of_lidar, 0.95)));
      level_.push_back(std::log(std::max(kDarkest * bright_.back(), Quantile(of_lidar, 0.5))));
    }
  }

  bool IsDark(const MapReturn& r) const { return !(r.intensity > kDarkest * bright_[r.lidar]); }

  PatchLook LookAt(std::size_t k) const {
    const MapReturn& r = At(k);
    PatchLook look;
    const float intensity = IsDark(r) ? kDarkest * bright_[r.lidar] : r.intensity;
    look.log_intensity = (std::log(intensity) - level_[r.lidar]) * contrast_[r.lidar];
    look.range = r.beam.norm();
    const Eigen::Vector3f& normal = surfaces_.surfaces[k].normal;
    look.cos_incidence = normal.isZero() ? kUnknownIncidence : std::abs(normal.dot(r.beam)) / look.range;
    look.lidar = r.lidar;
    look.ring = r.ring;
    return look;
  }

  void ChooseLooks() {
    looks_.clear();
    begin_.assign(1, 0);
    const std::vector<std::uint32_t>& patches = surfaces_.patches;
    const double step = std::max(1.0, static_cast<double>(patches.size() - 1) / kPatches);
    for (double p = 0.0; p < static_cast<double>(patches.size() - 1); p += step) {
      const std::size_t first = patches[static_cast<std::size_t>(p)],
                        last = patches[static_cast<std::size_t>(p) + 1];
      const std::size_t stride = 1 + (last - first) / kLooks;
      for (std::size_t k = first; k < last; k += stride) {
        const ReturnSurface& surface = surfaces_.surfaces[k];
        if (!surface.normal.isZero() && !surface.at_edge && !IsDark(At(k))) looks_.push_back(LookAt(k));
      }
      if (looks_.size() - begin_.back() < 4) {
        looks_.resize(begin_.back());
      } else {
        begin_.push_back(looks_.size());
      }
    }
  }

  // LiDARs may report a power of the light: the spread of brightness over patches that two of them saw tells.
  // All are brought to the contrast of the one with most patches. True if anything changed.
  bool MatchContrasts(const SensitivityModel& model) {
    const std::size_t lidars = rings_.size();
    struct Moments {
      double n = 0.0, a = 0.0, b = 0.0, aa = 0.0, ab = 0.0, bb = 0.0;
    };
    std::vector<Moments> moments(lidars * lidars);
    std::vector<double> sum(lidars), count(lidars);
    for (std::size_t p = 0; p + 1 < begin_.size(); ++p) {
      std::fill(sum.begin(), sum.end(), 0.0);
      std::fill(count.begin(), count.end(), 0.0);
      for (std::size_t k = begin_[p]; k < begin_[p + 1]; ++k) {
        sum[looks_[k].lidar] += looks_[k].log_intensity - model.LogFactor(looks_[k]);
        count[looks_[k].lidar] += 1.0;
      }
      for (std::size_t i = 0; i < lidars; ++i) {
        for (std::size_t j = 0; j < lidars; ++j) {
          if (count[i] < 3.0 || count[j] < 3.0) continue;
          Moments& m = moments[i * lidars + j];
          const double a = sum[i] / count[i], b = sum[j] / count[j];
          m.n += 1.0, m.a += a, m.b += b, m.aa += a * a, m.ab += a * b, m.bb += b * b;
        }
      }
    }
    // From the LiDAR with most patches to its neighbours and on, each time over the best link.
    std::vector<double> ratio(lidars, 0.0);
    std::size_t base = 0;
    for (std::size_t l = 0; l < lidars; ++l) {
      if (moments[l * lidars + l].n > moments[base * lidars + base].n) base = l;
    }
    ratio[base] = 1.0;
    bool changed = false;
    for (;;) {
      double most = kFewestShared;
      std::size_t from = 0, to = lidars;
      for (std::size_t i = 0; i < lidars; ++i) {
        for (std::size_t j = 0; j < lidars; ++j) {
          if (ratio[i] > 0.0 && ratio[j] == 0.0 && moments[i * lidars + j].n > most) {
            most = moments[i * lidars + j].n, from = i, to = j;
          }
        }
      }
      if (to == lidars) break;
      const Moments& m = moments[from * lidars + to];
      const double aa = m.aa - m.a * m.a / m.n, ab = m.ab - m.a * m.b / m.n, bb = m.bb - m.b * m.b / m.n;
      const bool alike = ab > kLeastCorrelation * std::sqrt(aa * bb);
      ratio[to] = ratio[from] * (alike ? std::clamp(std::sqrt(aa / bb), 0.3, 3.0) : 1.0);
      if (std::abs(ratio[to] - 1.0) > 0.05) {
        contrast_[to] = static_cast<float>(ratio[to]);
        changed = true;
      }
    }
    return changed;
  }

  std::vector<float> Brightness(const SensitivityModel& model) const {
    std::vector<float> result(returns_.size());
    ParallelChunks(result.size(), 256, [&](std::size_t, std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        const PatchLook look = LookAt(k);
        result[k] = look.log_intensity - static_cast<float>(model.LogFactor(look));
      }
    });
    std::vector<float> sample;
    const std::size_t step = 1 + result.size() / 400000;
    for (std::size_t k = 0; k < result.size(); k += step) sample.push_back(result[k]);
    const float white = Quantile(sample, 0.98), spread = white - Quantile(sample, 0.02);
    const bool has_scale = spread > 1e-3f;
    ParallelChunks(result.size(), 256, [&](std::size_t, std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        result[k] = has_scale ? std::min(1.0f, std::exp(0.5f * (result[k] - white))) : 0.5f;
      }
    });
    return result;
  }

  const std::vector<MapReturn>& returns_;
  const MapSurfaces& surfaces_;
  std::vector<int> rings_;
  std::vector<float> bright_, level_, contrast_;  // of each LiDAR
  std::vector<PatchLook> looks_;
  std::vector<std::size_t> begin_;
};

}  // namespace

std::vector<float> CompensateIntensity(const std::vector<MapReturn>& returns, const MapSurfaces& surfaces) {
  return Compensation(returns, surfaces).Run();
}

}  // namespace mlic
