#include "mesh/convex_parts.h"

#include <dlfcn.h>

#include <cstdint>

#include "base/error.h"
#include "geometry/hull.h"

namespace rangegrasp::objects {
namespace {

// CoACD's plain C interface, as its wheel's Python module declares it; the wheel has no header.
struct CoacdMesh {
  double* vertices = nullptr;
  std::uint64_t vertex_count = 0;
  int* triangles = nullptr;
  std::uint64_t triangle_count = 0;
};
struct CoacdMeshes {
  CoacdMesh* meshes = nullptr;
  std::uint64_t count = 0;
};
using CoacdRun = CoacdMeshes (*)(const CoacdMesh& input, double threshold, int max_hulls,
                                 int preprocess, int preprocess_resolution, int resolution,
                                 int nodes, int iterations, int depth, bool pca, bool merge,
                                 bool decimate, int max_hull_vertices, bool extrude,
                                 double extrude_margin, int approximation, unsigned seed,
                                 bool real_metric);
using CoacdFree = void (*)(CoacdMeshes);
using CoacdLog = void (*)(const char*);

// CoACD's values of these arguments.
constexpr int kAnyNumber = -1;
constexpr int kNoPreprocess = 2;           // the solid is closed
constexpr int kPreprocessResolution = 50;  // not used then
constexpr int kDepth = 3;                  // of the search: CoACD's default
constexpr int kMaxHullVertices = 256;      // not used: fewer vertices would cut corners off
constexpr int kHulls = 0;
constexpr unsigned kSeed = 0;

// Loaded when it is needed, and kept: what does not cut meshes does not wait for 13 MB, and runs
// without it. It is looked for where the program's own libraries stand.
struct Coacd {
  CoacdRun run = nullptr;
  CoacdFree free = nullptr;
  CoacdLog log = nullptr;
  bool there() const { return run != nullptr && free != nullptr && log != nullptr; }
};

const Coacd& Library() {
  static const Coacd library = [] {
    Coacd coacd;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return coacd;  // a sanitizer's run time refuses a library that binds to itself first
#endif
    // It holds a spdlog of its own, which must not be mistaken for the program's.
    void* handle = dlopen("lib_coacd.so", RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
    if (handle == nullptr) return coacd;
    coacd.run = reinterpret_cast<CoacdRun>(dlsym(handle, "CoACD_run"));
    coacd.free = reinterpret_cast<CoacdFree>(dlsym(handle, "CoACD_freeMeshArray"));
    coacd.log = reinterpret_cast<CoacdLog>(dlsym(handle, "CoACD_setLogLevel"));
    return coacd;
  }();
  return library;
}

geometry::TriangleMesh HullOf(const CoacdMesh& part) {
  geometry::Points points;
  for (std::uint64_t i = 0; i < part.vertex_count; ++i) {
    points.emplace_back(part.vertices[3 * i], part.vertices[3 * i + 1], part.vertices[3 * i + 2]);
  }
  return geometry::ConvexHull(points);
}

}  // namespace

bool CanCut() { return Library().there(); }

std::vector<geometry::TriangleMesh> ConvexParts(const geometry::TriangleMesh& solid,
                                                const CutOptions& options) {
  const Coacd& coacd = Library();
  if (!coacd.there()) {
    throw base::RunError(
        "CoACD's library lib_coacd.so is not there: scripts/setup fetches it (PyPI wheel coacd)");
  }
  coacd.log("off");
  const geometry::TriangleMesh input = geometry::Simplified(solid, options.max_triangles);
  std::vector<double> vertices;
  for (const Eigen::Vector3d& v : input.vertices) {
    vertices.insert(vertices.end(), {v.x(), v.y(), v.z()});
  }
  std::vector<int> triangles;
  for (const auto& triangle : input.triangles) {
    for (const std::uint32_t corner : triangle) triangles.push_back(static_cast<int>(corner));
  }
  const CoacdMesh mesh{vertices.data(), input.vertices.size(), triangles.data(),
                       input.triangles.size()};
  const CoacdMeshes found = coacd.run(mesh, options.concavity, kAnyNumber, kNoPreprocess,
                                      kPreprocessResolution, options.samples, options.nodes,
                                      options.rounds, kDepth, /*pca=*/false, /*merge=*/true,
                                      /*decimate=*/false, kMaxHullVertices, /*extrude=*/false,
                                      /*extrude_margin=*/0.01, kHulls, kSeed,
                                      /*real_metric=*/false);
  const double min_volume = options.min_part * geometry::Volume(solid);
  std::vector<geometry::TriangleMesh> parts;
  for (std::uint64_t i = 0; i < found.count; ++i) {
    geometry::TriangleMesh hull = HullOf(found.meshes[i]);
    if (geometry::Volume(hull) > min_volume) parts.push_back(std::move(hull));
  }
  coacd.free(found);
  if (parts.empty()) throw base::RunError("CoACD found no convex part");
  return parts;
}

Cut CutFinely(const geometry::TriangleMesh& solid, double max_beyond, const CutOptions& options) {
  const geometry::TriangleMesh coarse = geometry::Simplified(solid, options.max_triangles);
  const auto cut = [&](const CutOptions& how) {
    Cut result{ConvexParts(solid, how), {}};
    result.overlap = geometry::OverlapOf(coarse, result.parts);
    return result;
  };
  Cut first = cut(options);
  if (first.overlap.beyond <= max_beyond) return first;
  CutOptions finer = options;
  finer.concavity /= 2;
  return cut(finer);
}

}  // namespace rangegrasp::objects
