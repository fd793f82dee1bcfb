#include "geometry/ray_caster.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/error.h"

namespace rangegrasp::geometry {
namespace {

constexpr std::size_t kPacket = 16;  // rays that are traced together

void CheckMesh(const TriangleMesh& mesh, std::size_t index) {
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v].allFinite()) continue;
    throw std::invalid_argument(fmt::format("mesh {}: vertex {} is not finite", index, v));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v < mesh.vertices.size()) continue;
      throw std::invalid_argument(fmt::format("mesh {}: triangle {} uses vertex {} of {}", index, t,
                                              v, mesh.vertices.size()));
    }
  }
}

/// A new buffer of `count` triples of numbers.
template <typename T>
T* NewBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  void* data = rtcSetNewGeometryBuffer(geometry, type, 0, format, 3 * sizeof(T), count);
  if (data == nullptr) throw base::RunError("Embree: out of memory for a mesh");
  return static_cast<T*>(data);
}

void FillGeometry(RTCGeometry geometry, const TriangleMesh& mesh) {
  auto* vertices =
      NewBuffer<float>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(p[axis]);
  }
  auto* indices = NewBuffer<std::uint32_t>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                           mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) indices = std::ranges::copy(triangle, indices).out;
}

// Slots after the last ray repeat it with a mask of 0, so that Embree skips them. When Embree
// processes a packet in halves, Debian's build asserts that every slot contains a valid ray.
void FillPacket(std::span<const Ray> rays, RTCRay16& packet, std::array<int, kPacket>& valid) {
  for (std::size_t i = 0; i < kPacket; ++i) {
    const Ray& ray = rays[std::min(i, rays.size() - 1)];
    packet.org_x[i] = ray.origin_W.x();
    packet.org_y[i] = ray.origin_W.y();
    packet.org_z[i] = ray.origin_W.z();
    packet.dir_x[i] = ray.direction_W.x();
    packet.dir_y[i] = ray.direction_W.y();
    packet.dir_z[i] = ray.direction_W.z();
    packet.tnear[i] = ray.near_m;
    packet.tfar[i] = ray.far_m;
    packet.time[i] = 0.0f;
    packet.mask[i] = ~0u;
    packet.id[i] = 0;
    packet.flags[i] = 0;
    valid[i] = i < rays.size() && ray.far_m > ray.near_m ? -1 : 0;
  }
}

/// Calls trace(index of the first ray, rays, which of the 16 slots have one, context) per packet.
template <typename Trace>
void ForPackets(std::span<const Ray> rays, RTCRay16& packet, Trace trace) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) std::array<int, kPacket> valid;
  for (std::size_t begin = 0; begin < rays.size(); begin += kPacket) {
    const auto part = rays.subspan(begin, std::min(kPacket, rays.size() - begin));
    FillPacket(part, packet, valid);
    trace(begin, part, valid, context);
  }
}

}  // namespace

struct RayCaster::Embree {
  RTCDevice device = rtcNewDevice("threads=1,user_threads=1,set_affinity=0");
  RTCScene scene = nullptr;

  Embree() {
    // "threads=1" alone lets TBB start a worker, which a fork would lose. The limit is static,
    // since lifting it starts the worker too; nothing else here uses TBB.
    static const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    if (device == nullptr) throw base::RunError("Embree: the device could not be created");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
  }
  ~Embree() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  void Attach(const TriangleMesh& mesh, unsigned id) {
    if (mesh.triangles.empty()) return;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
    FillGeometry(geometry, mesh);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
  }
};

RayCaster::RayCaster(std::span<const TriangleMesh* const> meshes) {
  for (std::size_t i = 0; i < meshes.size(); ++i) CheckMesh(*meshes[i], i);
  embree_ = std::make_shared<Embree>();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    embree_->Attach(*meshes[i], static_cast<unsigned>(i));
  }
  rtcCommitScene(embree_->scene);
  if (rtcGetDeviceError(embree_->device) != RTC_ERROR_NONE) {
    throw base::RunError("Embree: the scene could not be built");
  }
}

void RayCaster::FirstHits(std::span<const Ray> rays, std::vector<Hit>& hits) const {
  hits.resize(rays.size());
  alignas(64) RTCRayHit16 packet;
  ForPackets(rays, packet.ray, [&](std::size_t begin, auto part, auto& valid, auto& context) {
    std::ranges::fill(packet.hit.geomID, RTC_INVALID_GEOMETRY_ID);
    std::ranges::fill(packet.hit.instID[0], RTC_INVALID_GEOMETRY_ID);
    rtcIntersect16(valid.data(), embree_->scene, &context, &packet);
    for (std::size_t i = 0; i < part.size(); ++i) {
      Hit& hit = hits[begin + i];
      hit = Hit{};
      if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      hit.distance_m = packet.ray.tfar[i];
      hit.mesh = packet.hit.geomID[i];
      hit.triangle = packet.hit.primID[i];
      hit.second = packet.hit.u[i];
      hit.third = packet.hit.v[i];
      hit.normal_W =
          Eigen::Vector3f(packet.hit.Ng_x[i], packet.hit.Ng_y[i], packet.hit.Ng_z[i]).normalized();
      if (hit.normal_W.dot(part[i].direction_W) > 0.0f) hit.normal_W = -hit.normal_W;
    }
  });
}

void RayCaster::Blocked(std::span<const Ray> rays, std::vector<std::uint8_t>& blocked) const {
  blocked.resize(rays.size());
  alignas(64) RTCRay16 packet;
  ForPackets(rays, packet, [&](std::size_t begin, auto part, auto& valid, auto& context) {
    rtcOccluded16(valid.data(), embree_->scene, &context, &packet);
    // Embree marks an occluded ray by a negative tfar.
    for (std::size_t i = 0; i < part.size(); ++i) {
      blocked[begin + i] = valid[i] != 0 && packet.tfar[i] < 0.0f ? 1 : 0;
    }
  });
}

std::optional<std::size_t> MeshColors::TexelAt(const Hit& hit) const {
  if (!print) return std::nullopt;
  const auto& [a, b, c] = uv[hit.triangle];
  const Eigen::Vector2f at = (1.0f - hit.second - hit.third) * a + hit.second * b + hit.third * c;
  if (!at.allFinite()) return std::nullopt;
  const auto texel = [](float place, int size) {
    const float wrapped = place - std::floor(place);
    return static_cast<std::size_t>(
        std::min(static_cast<int>(wrapped * static_cast<float>(size)), size - 1));
  };
  return texel(at.y(), print->height) * static_cast<std::size_t>(print->width) +
         texel(at.x(), print->width);
}

std::optional<Rgb> MeshColors::PrintAt(const Hit& hit) const {
  const auto texel = TexelAt(hit);
  return texel ? std::optional(print->texels[*texel]) : std::nullopt;
}

std::optional<Rgb> MeshColors::At(const Hit& hit) const {
  if (const auto printed = PrintAt(hit)) return printed;
  return plain.empty() ? std::nullopt : std::optional(plain[hit.triangle]);
}

}  // namespace rangegrasp::geometry
