#include "mlic_sim/camera_renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "mlic_core/common/parallel.h"
#include "mlic_core/common/random.h"

namespace mlic::sim {
namespace {

// Constants of this file, from: definition of the simulated cameras.

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFarthest = 300.0f;  // m
constexpr int kBand = 16;            // rows of one part of the work
constexpr int kGammaSteps = 16384;
// An automatic exposure: meters a grid of rays at some instants before the picture; is longest at the first
// level of light, with 1 that of a white wall in the sun; and leaves pictures at the second.
constexpr int kMeterRays = 8;                                   // of one instant, in each direction
constexpr double kMeterInstants[] = {0.1, 0.2, 0.3, 0.4, 0.5};  // s
constexpr double kLongestLight = 0.1, kMeanLevel = 0.3, kLargestGain = 8.0;
constexpr int kShutterSamples = 4;  // instants of one exposure, one for each place of a 2 x 2 pattern of rays

// Standard normal but for its tails (a sum of four uniform numbers), from one hash.
float NoiseOf(std::uint64_t key) {
  std::uint64_t z = key * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  z ^= z >> 31;
  const auto sum = static_cast<float>((z & 0xFFFF) + ((z >> 16) & 0xFFFF) + ((z >> 32) & 0xFFFF) + (z >> 48));
  return (sum - 131070.0f) * (1.7320508f / 65536.0f);
}

// sRGB's curve, near to what cameras use.
double GammaOf(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

// What moves has no shadows: half of the light from all around, and the sun on what faces it.
Vector3f LightOfMoving(const Lighting& lighting, const RayHit& hit) {
  const Vector3f albedo = ReflectanceOf(hit.material, hit.position, hit.normal, hit.object).albedo;
  const float facing = std::max(0.0f, hit.normal.cast<float>().dot(lighting.to_sun));
  const Vector3f around = 0.5f * SkyRadiance(lighting, Vector3f::UnitZ()) + lighting.bounce;
  return albedo.cwiseProduct(around + (lighting.outdoors ? facing : 0.0f) * lighting.sun);
}

}  // namespace

// Of one instant.
struct CameraRenderer::RowPose {
  Eigen::Matrix3f R_map_camera;
  Vector3f origin;
  MovingObjects::Instant moving;
};

CameraRenderer::CameraRenderer(const SimulatedCamera& camera, const World& world, const Lighting& lighting,
                               const SurfaceTextures& textures, const Trajectory& trajectory,
                               const std::vector<double>& times)
    : camera_(camera),
      world_(world),
      lighting_(lighting),
      textures_(textures),
      trajectory_(trajectory),
      columns_(camera.intrinsics.width + 2),
      mean_exposure_(camera.exposure) {
  const int width = camera_.intrinsics.width, height = camera_.intrinsics.height;
  bearings_.resize(static_cast<std::size_t>(columns_ * (height + 2)));
  vignette_.resize(static_cast<std::size_t>(width * height));
  const bool fisheye = camera_.intrinsics.model == CameraModel::kEquidistant ||
                       camera_.intrinsics.model == CameraModel::kDoubleSphere;
  // A fisheye's image circle ends a little beyond its stated field of view.
  const double least_cosine =
      fisheye ? std::cos(std::min(M_PI, (0.5 * camera_.fov_deg + 4.0) * M_PI / 180.0)) : 0.0;
  const double corner = 0.25 * (width * width + height * height);
  ParallelFor(static_cast<std::size_t>(height + 2), [&](std::size_t r) {
    const int v = static_cast<int>(r) - 1;
    for (int u = -1; u <= width; ++u) {
      Vector3d bearing;
      const bool seen = Unproject(camera_.intrinsics, {u, v}, &bearing) && bearing.z() > least_cosine;
      bearings_[r * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(u + 1)] =
          seen ? bearing.cast<float>().eval() : Vector3f::Constant(std::nanf("")).eval();
      if (v < 0 || v >= height || u < 0 || u >= width) continue;
      const double x = u - 0.5 * (width - 1), y = v - 0.5 * (height - 1);
      double share = 1.0 - camera_.vignetting * (x * x + y * y) / corner;
      if (fisheye && seen) share *= std::clamp((bearing.z() - least_cosine) / 0.05, 0.0, 1.0);
      vignette_[static_cast<std::size_t>(v * width + u)] = static_cast<float>(share);
    }
  });
  for (int i = 0; i <= kGammaSteps; ++i) {
    gamma_.push_back(
        static_cast<std::uint8_t>(std::lround(255.0 * GammaOf(static_cast<double>(i) / kGammaSteps))));
  }
  if (camera_.shortest_exposure > 0.0 && !times.empty()) {
    double sum = 0.0;
    for (const double time : times) sum += AutomaticLength(MeteredLight(time));
    mean_exposure_ = sum / static_cast<double>(times.size());
  }
}

double CameraRenderer::MeteredLight(double time) const {
  static_assert(kMeterRays == RayPacket::kSize, "a row of rays is one packet");
  double sum = 0.0;
  int count = 0;
  for (const double before : kMeterInstants) {
    const double instant = time - before;
    const RigidTransform T = trajectory_.PoseAt(instant) * camera_.calibration.T_imu_sensor;
    const Eigen::Matrix3f R = T.rotation.toRotationMatrix().cast<float>();
    const MovingObjects::Instant moving = world_.moving().At(instant);
    for (int row = 0; row < kMeterRays; ++row) {
      RayPacket packet;
      const int v = (2 * row + 1) * camera_.intrinsics.height / (2 * kMeterRays);
      for (int lane = 0; lane < kMeterRays; ++lane) {
        const int u = (2 * lane + 1) * camera_.intrinsics.width / (2 * kMeterRays);
        const Vector3f& bearing = bearings_[static_cast<std::size_t>((v + 1) * columns_ + u + 1)];
        packet.valid[lane] = std::isfinite(bearing.sum()) ? -1 : 0;
        if (packet.valid[lane] == 0) continue;
        const Vector3f direction = (R * bearing).normalized();
        for (int c = 0; c < 3; ++c) {
          packet.origin[c][lane] = static_cast<float>(T.translation[c]);
          packet.direction[c][lane] = direction[c];
        }
      }
      world_.CastPacket(kFarthest, packet);
      const auto angle = static_cast<float>(camera_.fov_deg * M_PI / 180.0 / kMeterRays);
      for (int lane = 0; lane < kMeterRays; ++lane) {
        if (packet.valid[lane] == 0) continue;
        float light[3];
        Shade(packet, lane, moving, angle, light);
        sum += 0.299 * light[0] + 0.587 * light[1] + 0.114 * light[2];
        ++count;
      }
    }
  }
  return count == 0 ? kMeanLevel : std::max(1e-3, sum / count);
}

double CameraRenderer::AutomaticLength(double light) const {
  return std::clamp(camera_.exposure * kLongestLight / light, camera_.shortest_exposure, camera_.exposure);
}

CameraRenderer::Exposure CameraRenderer::ExposureOf(double time, bool with_noise) const {
  if (!with_noise) return {time, mean_exposure_, camera_.gain};
  // Every camera drifts on its own.
  const double phase = camera_.calibration.T_imu_sensor.translation.sum();
  const double gain = camera_.gain * (1.0 + camera_.exposure_drift * std::sin(0.31 * time + 10.0 * phase));
  if (camera_.shortest_exposure == 0.0) return {time, camera_.exposure, gain};
  const double light = MeteredLight(time), length = AutomaticLength(light);
  return {time + 0.5 * (length - mean_exposure_), length, std::min(kLargestGain, kMeanLevel / light) * gain};
}

std::vector<CameraRenderer::RowPose> CameraRenderer::PosesOf(const Exposure& exposure, int sample_row) const {
  const double row = 0.5 * (sample_row + 0.5) - 0.5;
  const double row_time =
      exposure.middle + (camera_.rolling_shutter ? camera_.readout * row / camera_.intrinsics.height : 0.0);
  std::vector<RowPose> poses;
  for (int k = 0; k < (exposure.length > 0.0 ? kShutterSamples : 1); ++k) {
    const double shift = exposure.length * ((k + 0.5) / kShutterSamples - 0.5);
    const double time_of_pose = row_time + (exposure.length > 0.0 ? shift : 0.0);
    const RigidTransform T = trajectory_.PoseAt(time_of_pose) * camera_.calibration.T_imu_sensor;
    poses.push_back({T.rotation.toRotationMatrix().cast<float>(), T.translation.cast<float>(),
                     world_.moving().At(time_of_pose)});
  }
  return poses;
}

void CameraRenderer::Shade(const RayPacket& packet, int lane, const MovingObjects::Instant& moving,
                           float pixel_angle, float* light) const {
  const Vector3f direction(packet.direction[0][lane], packet.direction[1][lane], packet.direction[2][lane]);
  const float range = packet.range[lane];
  const Vector3f origin(packet.origin[0][lane], packet.origin[1][lane], packet.origin[2][lane]);
  const std::optional<RayHit> in_front =
      moving.Cast(origin.cast<double>(), direction.cast<double>(), std::min(range, kFarthest));
  Vector3f color;
  if (in_front) {
    color = LightOfMoving(lighting_, *in_front);
  } else if (range > kFarthest) {
    color = SkyRadiance(lighting_, direction);
  } else {
    color = textures_.Radiance(packet.triangle[lane], origin + range * direction, direction,
                               0.8f * pixel_angle * range);
  }
  for (int c = 0; c < 3; ++c) light[c] = color[c];
}

// Rays of one row of the doubled resolution, border of one included on either side.
void CameraRenderer::TraceRow(const Exposure& exposure, int sample_row, std::vector<float>& light) const {
  const int width = camera_.intrinsics.width;
  const int samples = 2 * width + 2;
  light.assign(static_cast<std::size_t>(3 * samples), 0.0f);
  const std::vector<RowPose> poses = PosesOf(exposure, sample_row);
  // Bearings lie a quarter of a pixel from the pixels' centres.
  const int upper = (sample_row + 1) / 2;  // of two rows of bearings_; row 0 is pixel row -1
  const float down = (sample_row + 1) % 2 == 0 ? 0.25f : 0.75f;
  const Vector3f* first = &bearings_[static_cast<std::size_t>(upper * columns_)];
  const Vector3f* second = first + columns_;
  for (int begin = 0; begin < samples; begin += RayPacket::kSize) {
    RayPacket packet;
    const RowPose* pose_of[RayPacket::kSize];
    float angle = 0.0f;
    bool any = false;
    for (int lane = 0; lane < RayPacket::kSize; ++lane) {
      const int s = begin + lane - 1;  // sample column, from -1
      packet.valid[lane] = 0;
      if (s > 2 * width) continue;
      const int left = (s + 1) / 2;
      const float across = (s + 1) % 2 == 0 ? 0.25f : 0.75f;
      const Vector3f a = first[left] + across * (first[left + 1] - first[left]);
      const Vector3f b = second[left] + across * (second[left + 1] - second[left]);
      const Vector3f bearing = a + down * (b - a);
      if (!std::isfinite(bearing.sum())) continue;
      angle = (first[left + 1] - first[left]).norm();
      // Each place of the 2 x 2 pattern has an instant of its own.
      const int instant = ((s & 1) + 2 * (sample_row & 1) + 3 * ((s >> 1) & 1)) % kShutterSamples;
      const RowPose& pose = poses.size() == 1 ? poses[0] : poses[static_cast<std::size_t>(instant)];
      const Vector3f direction = (pose.R_map_camera * bearing).normalized();
      for (int c = 0; c < 3; ++c)
        packet.origin[c][lane] = pose.origin[c], packet.direction[c][lane] = direction[c];
      pose_of[lane] = &pose;
      packet.valid[lane] = -1;
      any = true;
    }
    if (!any) continue;
    world_.CastPacket(kFarthest, packet);
    for (int lane = 0; lane < RayPacket::kSize; ++lane) {
      if (packet.valid[lane] != 0)
        Shade(packet, lane, pose_of[lane]->moving, angle,
              &light[static_cast<std::size_t>(3 * (begin + lane))]);
    }
  }
}

cv::Mat CameraRenderer::RenderLight(const Exposure& exposure, int begin, int end) const {
  const int width = camera_.intrinsics.width;
  cv::Mat image(end - begin, width, CV_32FC3);
  // The last four rows of samples, filtered along the row already.
  std::vector<float> light;
  std::vector<std::vector<float>> rows;
  const auto filtered = [&](int sample_row) {
    TraceRow(exposure, sample_row, light);
    std::vector<float> row(static_cast<std::size_t>(3 * width));
    for (int u = 0; u < width; ++u) {
      const float* s = &light[static_cast<std::size_t>(6 * u)];
      for (int c = 0; c < 3; ++c) {
        row[static_cast<std::size_t>(3 * u + c)] =
            0.125f * (s[c] + s[9 + c]) + 0.375f * (s[3 + c] + s[6 + c]);
      }
    }
    return row;
  };
  for (int v = begin; v < end; ++v) {
    if (rows.size() == 4) rows.erase(rows.begin(), rows.begin() + 2);
    while (rows.size() < 4) rows.push_back(filtered(2 * v - 1 + static_cast<int>(rows.size())));
    float* out = image.ptr<float>(v - begin);
    for (std::size_t i = 0; i < static_cast<std::size_t>(3 * width); ++i) {
      out[i] = 0.125f * (rows[0][i] + rows[3][i]) + 0.375f * (rows[1][i] + rows[2][i]);
    }
  }
  return image;
}

void CameraRenderer::Expose(const cv::Mat& light, int row, float gain, bool with_noise, std::uint64_t seed,
                            cv::Mat& image) const {
  const int width = camera_.intrinsics.width;
  const float* in = light.ptr<float>();
  std::uint8_t* out = image.ptr<std::uint8_t>(row);
  const auto well = static_cast<float>(camera_.full_well);
  const auto read_variance = static_cast<float>(camera_.read_noise * camera_.read_noise);
  const auto develop = [&](float value, std::uint64_t key) {
    if (with_noise)
      value += std::sqrt(std::max(0.0f, value) * well + read_variance) / well * NoiseOf(seed + key);
    return gamma_[static_cast<std::size_t>(std::clamp(value, 0.0f, 1.0f) * kGammaSteps + 0.5f)];
  };
  for (int u = 0; u < width; ++u) {
    const std::size_t pixel = static_cast<std::size_t>(row * width + u);
    const float share = gain * vignette_[pixel];
    const float* rgb = in + 3 * u;
    const std::uint64_t key = 4 * static_cast<std::uint64_t>(pixel);
    switch (camera_.encoding) {
      case ImageEncoding::kMono8:
      case ImageEncoding::kMonoJpeg:
        out[u] = develop(share * (0.299f * rgb[0] + 0.587f * rgb[1] + 0.114f * rgb[2]), key);
        break;
      case ImageEncoding::kBayerRggb8:
        out[u] = develop(share * rgb[(row & 1) + (u & 1)], key);
        break;
      case ImageEncoding::kBgr8:
      case ImageEncoding::kJpeg:
        for (int c = 0; c < 3; ++c)
          out[3 * u + c] = develop(share * rgb[2 - c], key + static_cast<std::uint64_t>(c));
        break;
    }
  }
}

cv::Mat CameraRenderer::Render(double time, bool with_noise, std::uint64_t seed) const {
  const int width = camera_.intrinsics.width, height = camera_.intrinsics.height;
  const bool color = camera_.encoding == ImageEncoding::kBgr8 || camera_.encoding == ImageEncoding::kJpeg;
  cv::Mat image(height, width, color ? CV_8UC3 : CV_8UC1);
  const Exposure exposure = ExposureOf(time, with_noise);
  const std::uint64_t noise_seed = Random(seed).Next();
  ParallelFor(static_cast<std::size_t>((height + kBand - 1) / kBand), [&](std::size_t band) {
    const int begin = static_cast<int>(band) * kBand, end = std::min(height, begin + kBand);
    const cv::Mat light = RenderLight(exposure, begin, end);
    for (int v = begin; v < end; ++v) {
      Expose(light.row(v - begin), v, static_cast<float>(exposure.gain), with_noise, noise_seed, image);
    }
  });
  return image;
}

}  // namespace mlic::sim
