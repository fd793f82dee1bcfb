#include "mesh/mesh_object.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "base/words.h"
#include "geometry/mesh_file.h"

namespace rangegrasp::objects {
namespace {

using Eigen::Vector3d;

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

// What points up in the file points along z.
Eigen::Matrix3d Upright(Up up) {
  switch (up) {
    case Up::kY:
      return Eigen::AngleAxisd(base::kPi / 2, Vector3d::UnitX()).toRotationMatrix();
    case Up::kX:
      return Eigen::AngleAxisd(-base::kPi / 2, Vector3d::UnitY()).toRotationMatrix();
    case Up::kZ:
      break;
  }
  return Eigen::Matrix3d::Identity();
}

void Turn(const Eigen::Matrix3d& R, geometry::TriangleMesh& mesh) {
  for (Vector3d& v : mesh.vertices) v = R * v;
}

std::string Length(double length_m) {
  return length_m >= 1.0 ? fmt::format("{:.4g} m", length_m)
                         : fmt::format("{:.4g} mm", length_m * base::kMmPerM);
}

// [m] a file's number
double UnitOf(const std::filesystem::path& file, double longest, const MeshObjectOptions& options,
              std::vector<std::string>& said) {
  if (options.unit) return MetersOf(*options.unit);
  if (IsGltf(file)) {
    said.emplace_back("unit: m, as glTF says");
    return MetersOf(LengthUnit::kM);
  }
  const auto guess = GuessUnit(longest, options.sizes);
  if (!guess) {
    throw base::InputError(fmt::format(
        "{}: its longest edge is {:.4g}: in mm, cm and m alike that is not between {} and {}. Give "
        "its --unit, or its size with --height-mm or --size-mm",
        file.string(), longest, Length(options.sizes.likely_min_m),
        Length(options.sizes.likely_max_m)));
  }
  said.push_back(
      fmt::format("unit: {}, guessed since its longest edge is {:.4g} (--unit says "
                  "otherwise)",
                  base::Word(*guess), longest));
  return MetersOf(*guess);
}

double ScaleOf(const std::filesystem::path& file, const Vector3d& edges,
               const MeshObjectOptions& options, std::vector<std::string>& said) {
  const double longest = edges.maxCoeff();
  if (!(longest > 0.0)) throw base::InputError(file.string() + ": all its vertices are one point");
  if (options.height_m && !(edges.z() > 0.0)) {
    throw base::InputError(file.string() + ": is flat, it has no height to scale");
  }
  const double scale = options.height_m    ? *options.height_m / edges.z()
                       : options.longest_m ? *options.longest_m / longest
                                           : UnitOf(file, longest, options, said) * options.scale;
  const double size_m = longest * scale;
  if (size_m < options.sizes.min_m || size_m > options.sizes.max_m) {
    std::string cure = "--unit, --scale, --height-mm or --size-mm change it";
    if (const auto likely = GuessUnit(longest, options.sizes)) {
      cure = fmt::format("is its --unit {}? {}", base::Word(*likely), cure);
    }
    throw base::InputError(fmt::format(
        "{}: would be {} long; what a hand may want to grasp has {} to {}: {}", file.string(),
        Length(size_m), Length(options.sizes.min_m), Length(options.sizes.max_m), cure));
  }
  return scale;
}

// Unrolled round the z axis: u once round it, v from the bottom to the top.
std::vector<std::array<Eigen::Vector2d, 3>> Unrolled(const geometry::TriangleMesh& mesh,
                                                     const Eigen::AlignedBox3d& box) {
  std::vector<std::array<Eigen::Vector2d, 3>> uv;
  uv.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    auto& corners = uv.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d p = mesh.vertices[triangle.at(k)] - box.center();
      const double u = std::atan2(p.y(), p.x()) / (2.0 * base::kPi) + 0.5;
      corners.at(k) = {u, p.z() / box.sizes().z() + 0.5};
      // A triangle across the seam goes on beyond 1; textures repeat.
      const double ahead = corners.at(k).x() - corners.front().x();
      if (ahead > 0.5) corners.at(k).x() -= 1.0;
      if (ahead < -0.5) corners.at(k).x() += 1.0;
    }
  }
  return uv;
}

void Weigh(const geometry::TriangleMesh& solid, const MeshObjectOptions& options,
           MeshObject& object) {
  const geometry::MassProperties unit = geometry::MassPropertiesOf(solid);
  object.volume_m3 = unit.volume_m3;
  object.mass_kg = options.mass_kg.value_or(options.density_kg_m3 * unit.volume_m3);
  object.center_O = unit.center_M;
  object.inertia_O = object.mass_kg / unit.volume_m3 * unit.inertia_M;
}

}  // namespace

MeshObject MakeMeshObject(const std::filesystem::path& file, const MeshObjectOptions& options,
                          bool keep_uv) {
  MeshObject object;
  geometry::TexturedMesh given;
  if (keep_uv) {
    given = geometry::ReadTexturedMesh(file);
  } else {
    given.mesh = geometry::ReadMesh(file);
  }
  const Up up = options.up.value_or(IsGltf(file) ? Up::kY : Up::kZ);
  Turn(Upright(up), given.mesh);
  const double scale = ScaleOf(file, BoxOf(given.mesh).sizes(), options, object.said);
  for (Vector3d& v : given.mesh.vertices) v *= scale;

  geometry::Repaired repaired;
  try {
    repaired = geometry::RepairMesh(given.mesh, options.repair);
  } catch (const base::InputError& error) {
    throw base::InputError(file.string() + ": " + error.what());
  }
  for (const std::string& done : repaired.done) object.said.push_back("repaired: " + done);
  const Eigen::AlignedBox3d box = BoxOf(repaired.mesh);
  geometry::TriangleMesh& solid = repaired.mesh;
  for (Vector3d& v : solid.vertices) v -= box.center();
  object.size_m = box.sizes();
  Weigh(solid, options, object);

  if (!given.uv.empty()) {
    // Coordinates belong to the triangles of the file.
    object.seen_O = std::move(given.mesh);
    for (Vector3d& v : object.seen_O.vertices) v -= box.center();
    object.uv = std::move(given.uv);
    if (repaired.turned_inside_out) {
      for (auto& [a, b, c] : object.seen_O.triangles) std::swap(b, c);
      for (auto& [a, b, c] : object.uv) std::swap(b, c);
    }
  } else {
    object.seen_O = geometry::Simplified(solid, options.max_seen_triangles);
    if (object.seen_O.triangles.size() < solid.triangles.size()) {
      object.said.push_back(fmt::format("what is seen has {} of its {} triangles",
                                        object.seen_O.triangles.size(), solid.triangles.size()));
    }
    if (keep_uv) {
      object.uv = Unrolled(object.seen_O, BoxOf(object.seen_O));
      object.said.emplace_back(
          "it has no texture coordinates: the texture goes once round its z "
          "axis");
    }
  }
  Cut cut = CutFinely(solid, options.max_beyond, options.cut);
  object.hulls_O = std::move(cut.parts);
  object.overlap = cut.overlap;
  return object;
}

}  // namespace rangegrasp::objects
