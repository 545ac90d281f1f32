#include "mlic_sim/world.h"

#if __has_include(<embree4/rtcore.h>) && defined(MLIC_EMBREE_4)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mlic_core/common/error.h"

namespace mlic::sim {

using Eigen::Vector3d;

struct World::Embree {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  explicit Embree(const Mesh& mesh) {
    device = rtcNewDevice(nullptr);
    if (device == nullptr) throw InternalError("Embree: no device");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices().size()));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles().size()));
    for (const Eigen::Vector3f& v : mesh.vertices()) {
      for (int i = 0; i < 3; ++i) *vertices++ = v[i];
    }
    for (const Triangle& t : mesh.triangles()) {
      for (std::uint32_t v : t.vertices) *indices++ = v;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
  }
  ~Embree() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

World::World(Mesh mesh, InfraredLook infrared, MovingObjects moving)
    : mesh_(std::move(mesh)),
      infrared_(infrared),
      moving_(std::move(moving)),
      embree_(std::make_unique<Embree>(mesh_)) {}
World::~World() = default;

std::optional<RayHit> World::Cast(const Vector3d& origin, const Vector3d& direction, double max_range) const {
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tfar = static_cast<float>(max_range);
  ray.ray.mask = std::numeric_limits<unsigned>::max();
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(embree_->scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(embree_->scene, &context, &ray);
#endif
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  const Triangle& triangle = mesh_.triangles()[ray.hit.primID];
  const Vector3d a = mesh_.vertices()[triangle.vertices[0]].cast<double>();
  const Vector3d b = mesh_.vertices()[triangle.vertices[1]].cast<double>();
  const Vector3d c = mesh_.vertices()[triangle.vertices[2]].cast<double>();
  Vector3d normal = (b - a).cross(c - a).normalized();
  const double along = normal.dot(direction);
  // A ray that runs within the plane has no point of its own there.
  if (std::abs(along) < 1e-6) return std::nullopt;
  RayHit hit;
  hit.range = normal.dot(a - origin) / along;
  hit.position = origin + hit.range * direction;
  hit.normal = along > 0.0 ? Vector3d(-normal) : normal;
  hit.material = triangle.material;
  hit.object = triangle.object;
  return hit;
}

std::optional<RayHit> World::CastAt(double time, const Vector3d& origin, const Vector3d& direction,
                                    double max_range) const {
  const std::optional<RayHit> still = Cast(origin, direction, max_range);
  if (moving_.IsEmpty()) return still;
  const std::optional<RayHit> moving =
      moving_.At(time).Cast(origin, direction, still ? std::min(still->range, max_range) : max_range);
  return moving ? moving : still;
}

void World::CastPacket(float max_range, RayPacket& packet) const {
  RTCRayHit8 rays;
  static_assert(RayPacket::kSize == 8, "Embree's packets of eight are used");
  for (int i = 0; i < RayPacket::kSize; ++i) {
    rays.ray.org_x[i] = packet.origin[0][i];
    rays.ray.org_y[i] = packet.origin[1][i];
    rays.ray.org_z[i] = packet.origin[2][i];
    rays.ray.dir_x[i] = packet.direction[0][i];
    rays.ray.dir_y[i] = packet.direction[1][i];
    rays.ray.dir_z[i] = packet.direction[2][i];
    rays.ray.tnear[i] = 0.0f;
    rays.ray.tfar[i] = max_range;
    rays.ray.time[i] = 0.0f;
    rays.ray.mask[i] = std::numeric_limits<unsigned>::max();
    rays.ray.id[i] = 0;
    rays.ray.flags[i] = 0;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(packet.valid, embree_->scene, &rays, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(packet.valid, embree_->scene, &context, &rays);
#endif
  for (int i = 0; i < RayPacket::kSize; ++i) {
    const bool hit = packet.valid[i] != 0 && rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    packet.range[i] = hit ? rays.ray.tfar[i] : std::numeric_limits<float>::infinity();
    packet.triangle[i] = hit ? rays.hit.primID[i] : 0;
  }
}

bool World::IsOccluded(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                       float max_range) const {
  RTCRay ray{};
  ray.org_x = origin.x(), ray.org_y = origin.y(), ray.org_z = origin.z();
  ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
  ray.tfar = max_range;
  ray.mask = std::numeric_limits<unsigned>::max();
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(embree_->scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(embree_->scene, &context, &ray);
#endif
  return ray.tfar < 0.0f;  // Embree's mark of a hit
}

}  // namespace mlic::sim
