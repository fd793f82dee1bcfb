#include "mesh/mesh_object.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "base/words.h"
#include "geometry/mesh_file.h"
#include "sim/check/check.h"

namespace rangegrasp::objects {
namespace {

using Eigen::Vector3d;

// [m] A unit is guessed only if it gives a size between these limits: a die and a bottle.
constexpr double kLikelyMin_m = 0.02, kLikelyMax_m = 0.4;

// CoACD's plain C interface, as declared in its wheel's Python module; the wheel has no header.
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

// Values of CoACD's arguments.
constexpr int kAnyNumber = -1;
constexpr int kNoPreprocess = 2;           // the solid is closed
constexpr int kPreprocessResolution = 50;  // not used without preprocessing
constexpr int kDepth = 3;                  // of the search: CoACD's default
constexpr int kMaxHullVertices = 256;      // not used: fewer vertices would cut corners off
constexpr int kHulls = 0;
constexpr unsigned kSeed = 0;
// The search for good cuts: nodes and iterations of its tree, samples of a surface. A third of
// CoACD's defaults, in a tenth of their time. For six household shapes the results are the same
// within 1 % of their volumes.
constexpr int kNodes = 10, kRounds = 40, kSamples = 1000;
// Larger meshes are simplified first. More triangles take more time but do not improve the parts.
constexpr std::size_t kMaxTriangles = 2000;
// A part below this share of the solid's volume is a splinter; the engine refuses such hulls.
constexpr double kMinPart = 1e-5;

// CoACD's library, loaded at its first use and kept. Other commands need not load its 13 MB, and
// run without it. It is searched in the folders of the program's own libraries.
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
    return coacd;  // a sanitizer's runtime refuses libraries with RTLD_DEEPBIND
#endif
    // It contains its own spdlog, which must not be mixed with the program's.
    void* handle = dlopen("lib_coacd.so", RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
    if (handle == nullptr) return coacd;
    coacd.run = reinterpret_cast<CoacdRun>(dlsym(handle, "CoACD_run"));
    coacd.free = reinterpret_cast<CoacdFree>(dlsym(handle, "CoACD_freeMeshArray"));
    coacd.log = reinterpret_cast<CoacdLog>(dlsym(handle, "CoACD_setLogLevel"));
    return coacd;
  }();
  return library;
}

bool IsGltf(const std::filesystem::path& file) {
  const std::string ending = base::EndingOf(file);
  return ending == ".gltf" || ending == ".glb";
}

Eigen::AlignedBox3d BoxOf(const geometry::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) box.extend(mesh.vertices[corner]);
  }
  return box;
}

// Rotates the file's upward axis to z.
Eigen::Matrix3d Upright(Up up) {
  if (up == Up::kZ) return Eigen::Matrix3d::Identity();
  const Eigen::AngleAxisd turn = up == Up::kY
                                     ? Eigen::AngleAxisd(base::kPi / 2, Vector3d::UnitX())
                                     : Eigen::AngleAxisd(-base::kPi / 2, Vector3d::UnitY());
  return turn.toRotationMatrix();
}

std::string Length(double length_m) {
  return length_m >= 1.0 ? fmt::format("{:.4g} m", length_m)
                         : fmt::format("{:.4g} mm", length_m * base::kMmPerM);
}

// Length of a file's unit [m].
double UnitOf(const std::filesystem::path& file, double longest, const MeshObjectOptions& options,
              std::vector<std::string>& said) {
  if (options.unit) return MetersOf(*options.unit);
  if (IsGltf(file)) {
    said.emplace_back("unit: m, as in every glTF file");
    return MetersOf(LengthUnit::kM);
  }
  const auto guess = GuessUnit(longest);
  if (!guess) {
    throw base::InputError(
        fmt::format("{}: its longest side is {:.4g}, which is not between {} and {} in mm, cm or "
                    "m. Give the unit with --unit, or the size with --size-mm",
                    file.string(), longest, Length(kLikelyMin_m), Length(kLikelyMax_m)));
  }
  said.push_back(
      fmt::format("unit: {}, guessed from its longest side of {:.4g} (--unit overrides it)",
                  base::Word(*guess), longest));
  return MetersOf(*guess);
}

double ScaleOf(const std::filesystem::path& file, double longest, const MeshObjectOptions& options,
               std::vector<std::string>& said) {
  if (!(longest > 0.0)) throw base::InputError(file.string() + ": all its vertices are one point");
  const double scale =
      options.longest_m ? *options.longest_m / longest : UnitOf(file, longest, options, said);
  const double size_m = longest * scale;
  if (size_m < check::kMinSize_m || size_m > check::kMaxSize_m) {
    std::string cure = "--unit or --size-mm changes it";
    if (const auto likely = GuessUnit(longest)) {
      cure = fmt::format("is its unit {}? {}", base::Word(*likely), cure);
    }
    throw base::InputError(fmt::format(
        "{}: the object would be {} long; objects to grasp must be {} to {} long: {}",
        file.string(), Length(size_m), Length(check::kMinSize_m), Length(check::kMaxSize_m), cure));
  }
  return scale;
}

double AreaOf(const geometry::TriangleMesh& mesh) {
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d& p = mesh.vertices[a];
    area += 0.5 * (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm();
  }
  return area;
}

// Decomposes the solid and, if the result is not good enough, repeats this with half the concavity.
// Good enough means little volume outside the solid or, for thin walls, a small mean distance of
// the hulls from the surface: a tenth of the volume of a mug's wall is as thin as a sensor's noise.
void Cut(const geometry::TriangleMesh& solid, MeshObject& object) {
  constexpr double kMaxBeyond = 0.1;     // of the volume
  constexpr double kMaxStandOff = 3e-3;  // of the longest edge: 0.3 mm of 100 mm
  const auto coarse = geometry::Simplified(solid, kMaxTriangles);
  const double max_volume = kMaxStandOff * object.size_m.maxCoeff() * AreaOf(solid);
  for (const double concavity : {kConcavity, kConcavity / 2}) {
    object.hulls_O = ConvexParts(solid, concavity);
    object.overlap = geometry::OverlapOf(coarse, object.hulls_O);
    const double beyond = object.overlap.beyond;
    if (beyond <= kMaxBeyond || beyond * object.volume_m3 <= max_volume) return;
  }
}

// A number with six significant digits; -0 becomes 0.
std::string Number(double value) {
  const std::string text = fmt::format("{:.6g}", value);
  return text == "-0" ? "0" : text;
}

/// @param uv  of each triangle's corners; may be empty
std::string ObjText(const geometry::TriangleMesh& mesh,
                    const std::vector<std::array<Eigen::Vector2d, 3>>& uv = {}) {
  std::string text;
  // A tenth of a micrometer: far below the accuracy of a mesh.
  for (const Vector3d& v : mesh.vertices) {
    text += fmt::format("v {:.7f} {:.7f} {:.7f}\n", v.x(), v.y(), v.z());
  }
  for (const auto& corners : uv) {
    for (const auto& at : corners) text += fmt::format("vt {:.5f} {:.5f}\n", at.x(), at.y());
  }
  std::size_t corner = 1;
  for (const auto& [a, b, c] : mesh.triangles) {
    text += uv.empty() ? fmt::format("f {} {} {}\n", a + 1, b + 1, c + 1)
                       : fmt::format("f {}/{} {}/{} {}/{}\n", a + 1, corner, b + 1, corner + 1,
                                     c + 1, corner + 2);
    corner += 3;
  }
  return text;
}

std::string Mjcf(const MeshObject& object, const ObjectLook& look) {
  const Eigen::Matrix3d& inertia = object.inertia_O;
  const sim::Surface& surface = look.surface;
  const sim::OpticalSurface& optical = surface.optical;
  const bool printed = !look.texture_png.empty();
  std::string text = fmt::format(
      R"(<mujoco model="{0}">
  <!-- {1:.3g} kg, {2:.0f} x {3:.0f} x {4:.0f} mm. Origin in the middle of the box round it. Made by rangegrasp add-object;
       numbers may be changed by hand. -->
  <custom>
    <text name="title" data="{5}"/>
    <text name="surface" data="{6}"/>
    <numeric name="albedo" data="{7}"/>
    <numeric name="gloss" data="{8}"/>
    <numeric name="clarity" data="{9}"/>
  </custom>
)",
      look.name, object.mass_kg, object.size_m.x() * base::kMmPerM,
      object.size_m.y() * base::kMmPerM, object.size_m.z() * base::kMmPerM,
      base::XmlEscaped(look.title), base::XmlEscaped(surface.name), Number(optical.albedo),
      Number(optical.gloss), Number(optical.clarity));
  text += fmt::format(
      R"(  <default>
    <default class="visual">
      <geom group="2" contype="0" conaffinity="0" type="mesh" material="label"/>
    </default>
    <default class="collision">
      <!-- Friction on the table's laminate (kinetic), spin and rolling resistance [m]. -->
      <geom group="3" condim="6" friction="{} 0.003 0.0005" solref="0.005 1" solimp="0.95 0.99 0.001 0.5 2"/>
    </default>
  </default>
  <asset>
)",
      Number(surface.on_laminate.kinetic_mu));
  if (printed) text += "    <texture name=\"label\" type=\"2d\" file=\"label.png\"/>\n";
  text += fmt::format("    <material name=\"label\" {} specular=\"{}\" shininess=\"{}\"/>\n",
                      printed ? std::string("texture=\"label\"")
                              : fmt::format("rgba=\"{0} {0} {0} 1\"", Number(optical.albedo)),
                      Number(surface.specular), Number(surface.shininess));
  text += "    <mesh name=\"visual\" file=\"visual.obj\"/>\n";
  for (std::size_t i = 0; i < object.hulls_O.size(); ++i) {
    text += fmt::format("    <mesh name=\"hull{0}\" file=\"hull{0}.obj\"/>\n", i);
  }
  text += fmt::format(
      R"(  </asset>
  <worldbody>
    <body name="{0}">
      <freejoint name="{0}"/>
      <inertial mass="{1}" pos="{2} {3} {4}" fullinertia="{5} {6} {7} {8} {9} {10}"/>
      <geom name="visual" class="visual" mesh="visual"/>
)",
      look.name, Number(object.mass_kg), Number(object.center_O.x()), Number(object.center_O.y()),
      Number(object.center_O.z()), Number(inertia(0, 0)), Number(inertia(1, 1)),
      Number(inertia(2, 2)), Number(inertia(0, 1)), Number(inertia(0, 2)), Number(inertia(1, 2)));
  for (std::size_t i = 0; i < object.hulls_O.size(); ++i) {
    text += fmt::format(
        "      <geom name=\"hull{0}\" class=\"collision\" type=\"mesh\" mesh=\"hull{0}\"/>\n", i);
  }
  return text + "    </body>\n  </worldbody>\n</mujoco>\n";
}

}  // namespace

double MetersOf(LengthUnit unit) {
  constexpr std::array kMeters = {0.001, 0.01, 1.0, 0.0254};  // in the order of the units
  return kMeters.at(static_cast<std::size_t>(unit));
}

std::optional<LengthUnit> GuessUnit(double longest) {
  constexpr double kTypical_m = 0.1;
  std::optional<LengthUnit> best;
  const auto distance = [&](LengthUnit unit) {
    return std::abs(std::log(longest * MetersOf(unit) / kTypical_m));
  };
  for (const LengthUnit unit : {LengthUnit::kMm, LengthUnit::kCm, LengthUnit::kM}) {
    const double size_m = longest * MetersOf(unit);
    if (size_m < kLikelyMin_m || size_m > kLikelyMax_m) continue;
    if (!best || distance(unit) < distance(*best)) best = unit;
  }
  return best;
}

bool CanCut() { return Library().there(); }

std::vector<geometry::TriangleMesh> ConvexParts(const geometry::TriangleMesh& solid,
                                                double concavity) {
  const Coacd& coacd = Library();
  if (!coacd.there()) {
    throw base::RunError(
        "CoACD's library lib_coacd.so is missing: scripts/setup installs it (PyPI wheel coacd)");
  }
  coacd.log("off");
  const geometry::TriangleMesh input = geometry::Simplified(solid, kMaxTriangles);
  std::vector<double> vertices;
  for (const auto& v : input.vertices) vertices.insert(vertices.end(), v.begin(), v.end());
  std::vector<int> triangles;
  for (const auto& t : input.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  const CoacdMesh mesh{vertices.data(), input.vertices.size(), triangles.data(),
                       input.triangles.size()};
  const CoacdMeshes found =
      coacd.run(mesh, concavity, kAnyNumber, kNoPreprocess, kPreprocessResolution, kSamples, kNodes,
                kRounds, kDepth, /*pca=*/false, /*merge=*/true,
                /*decimate=*/false, kMaxHullVertices, /*extrude=*/false,
                /*extrude_margin=*/0.01, kHulls, kSeed,
                /*real_metric=*/false);
  const double min_volume = kMinPart * geometry::Volume(solid);
  std::vector<geometry::TriangleMesh> parts;
  for (std::uint64_t i = 0; i < found.count; ++i) {
    const CoacdMesh& part = found.meshes[i];
    geometry::Points corners;
    for (std::uint64_t k = 0; k < part.vertex_count; ++k) {
      corners.push_back(Eigen::Map<const Vector3d>(part.vertices + 3 * k));
    }
    geometry::TriangleMesh hull = geometry::ConvexHull(corners);
    if (geometry::Volume(hull) > min_volume) parts.push_back(std::move(hull));
  }
  coacd.free(found);
  if (parts.empty()) throw base::RunError("CoACD found no convex part");
  return parts;
}

MeshObject MakeMeshObject(const std::filesystem::path& file, const MeshObjectOptions& options,
                          bool keep_uv) {
  MeshObject object;
  auto given = keep_uv ? geometry::ReadTexturedMesh(file)
                       : geometry::TexturedMesh{geometry::ReadMesh(file), {}};
  if (keep_uv && given.uv.empty()) {
    throw base::InputError(file.string() + ": has no texture coordinates for a texture");
  }
  const Eigen::Matrix3d R = Upright(options.up.value_or(IsGltf(file) ? Up::kY : Up::kZ));
  for (Vector3d& v : given.mesh.vertices) v = R * v;
  const double scale = ScaleOf(file, BoxOf(given.mesh).sizes().maxCoeff(), options, object.said);
  for (Vector3d& v : given.mesh.vertices) v *= scale;

  geometry::Repaired repaired;
  try {
    repaired = geometry::RepairMesh(given.mesh, options.max_hole);
  } catch (const base::InputError& error) {
    throw base::InputError(file.string() + ": " + error.what());
  }
  for (const std::string& done : repaired.done) object.said.push_back("repaired: " + done);
  const Eigen::AlignedBox3d box = BoxOf(repaired.mesh);
  geometry::TriangleMesh& solid = repaired.mesh;
  for (Vector3d& v : solid.vertices) v -= box.center();
  object.size_m = box.sizes();
  const geometry::MassProperties unit = geometry::MassPropertiesOf(solid);
  object.volume_m3 = unit.volume_m3;
  object.mass_kg = options.mass_kg.value_or(options.density_kg_m3 * unit.volume_m3);
  object.center_O = unit.center_M;
  object.inertia_O = object.mass_kg / unit.volume_m3 * unit.inertia_M;

  if (!given.uv.empty()) {
    // The texture coordinates belong to the triangles of the file.
    object.seen_O = std::move(given.mesh);
    for (Vector3d& v : object.seen_O.vertices) v -= box.center();
    object.uv = std::move(given.uv);
    if (repaired.turned_inside_out) {
      for (auto& [a, b, c] : object.seen_O.triangles) std::swap(b, c);
      for (auto& [a, b, c] : object.uv) std::swap(b, c);
    }
  } else {
    constexpr std::size_t kMaxSeen = 40000;  // triangles of 0.5 mm on an object of 100 mm
    object.seen_O = geometry::Simplified(solid, kMaxSeen);
    if (object.seen_O.triangles.size() < solid.triangles.size()) {
      object.said.push_back(fmt::format("the visible mesh has {} of its {} triangles",
                                        object.seen_O.triangles.size(), solid.triangles.size()));
    }
  }
  Cut(solid, object);
  return object;
}

std::string ObjectNameFrom(const std::string& text) {
  std::string name;
  for (const unsigned char c : text) {
    name += std::isalnum(c) ? static_cast<char>(std::tolower(c)) : '_';
  }
  return name;
}

std::map<std::string, std::string> ObjectFiles(const MeshObject& object, const ObjectLook& look) {
  std::map<std::string, std::string> files;
  files[look.name + ".xml"] = Mjcf(object, look);
  files["visual.obj"] = ObjText(object.seen_O, object.uv);
  for (std::size_t i = 0; i < object.hulls_O.size(); ++i) {
    files[fmt::format("hull{}.obj", i)] = ObjText(object.hulls_O[i]);
  }
  if (!look.texture_png.empty()) files["label.png"] = look.texture_png;
  return files;
}

}  // namespace rangegrasp::objects
