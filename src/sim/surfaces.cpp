#include "sim/surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/installation.h"
#include "base/words.h"
#include "base/yaml_map.h"

namespace rangegrasp::sim {
namespace {

// The kinetic coefficient keeps its tabulated ratio to the static one.
FrictionPair PairOf(const GloveRange& range, double static_mu) {
  return {static_mu, static_mu * range.kinetic / range.middle};
}

double Triangular(const GloveRange& range, double u) {
  const double width = range.high - range.low;
  const double at_mode = (range.middle - range.low) / width;
  return u < at_mode ? range.low + std::sqrt(u * width * (range.middle - range.low))
                     : range.high - std::sqrt((1.0 - u) * width * (range.high - range.middle));
}

constexpr const char* kFileName = "surfaces.yaml";
constexpr double kMaxFriction = 3.0;  // rubber on rubber

void ReadGlove(base::YamlMap map, GloveRange& glove) {
  for (const char* key : {"static", "from", "to", "kinetic"}) map.Require(key);
  map.Read("static", glove.middle, 0.01, kMaxFriction);
  map.Read("from", glove.low, 0.01, kMaxFriction);
  map.Read("to", glove.high, 0.01, kMaxFriction);
  map.Read("kinetic", glove.kinetic, 0.01, kMaxFriction);
  if (!(glove.low < glove.middle)) map.Fail("from", "must be below `static`");
  if (!(glove.high > glove.middle)) map.Fail("to", "must be above `static`");
  if (glove.kinetic > glove.middle) map.Fail("kinetic", "must not be above `static`");
  map.Finish();
}

void ReadLaminate(base::YamlMap map, FrictionPair& pair) {
  for (const char* key : {"static", "kinetic"}) map.Require(key);
  map.Read("static", pair.static_mu, 0.01, kMaxFriction);
  map.Read("kinetic", pair.kinetic_mu, 0.01, kMaxFriction);
  if (pair.kinetic_mu > pair.static_mu) map.Fail("kinetic", "must not be above `static`");
  map.Finish();
}

Surface ReadSurface(base::YamlMap map, const std::string& name) {
  Surface surface;
  surface.name = name;
  for (const char* key : {"glove", "laminate"}) map.Require(key);
  ReadGlove(map.Child("glove"), surface.glove);
  ReadLaminate(map.Child("laminate"), surface.on_laminate);
  map.Read("albedo", surface.optical.albedo, 0.0, 1.0);
  map.Read("gloss", surface.optical.gloss, 0.0, 1.0);
  map.Read("clarity", surface.optical.clarity, 0.0, 1.0);
  map.Read("specular", surface.specular, 0.0, 1.0);
  map.Read("shininess", surface.shininess, 0.0, 1.0);
  map.Read("density_kg_m3", surface.density_kg_m3, kMinDensity_kg_m3, kMaxDensity_kg_m3);
  map.Finish();
  return surface;
}

}  // namespace

FrictionPair GloveFriction(const GloveRange& range, const PhysicsOptions& options,
                           std::optional<double> u) {
  if (options.glove_friction) return {*options.glove_friction, *options.glove_friction};
  switch (options.friction) {
    case FrictionChoice::kLow:
      return PairOf(range, range.low);
    case FrictionChoice::kHigh:
      return PairOf(range, range.high);
    case FrictionChoice::kKinetic:
      return {range.kinetic, range.kinetic};
    case FrictionChoice::kDrawn:
      return PairOf(range, u ? Triangular(range, *u) : range.middle);
    case FrictionChoice::kMiddle:
      break;
  }
  return PairOf(range, range.middle);
}

std::filesystem::path ShippedSurfaces() { return base::DataFolder() / "models" / kFileName; }

std::vector<std::filesystem::path> SurfaceFiles(const std::filesystem::path& object_mjcf) {
  const auto folder = std::filesystem::absolute(object_mjcf).lexically_normal().parent_path();
  std::vector<std::filesystem::path> files;
  for (const auto& file :
       {folder / kFileName, folder.parent_path() / kFileName, ShippedSurfaces()}) {
    const bool known = std::ranges::find(files, file) != files.end();
    std::error_code error;
    // Also of a link to nothing: who reads it says what is wrong with it.
    const bool is_there = std::filesystem::exists(std::filesystem::symlink_status(file, error));
    if (!known && is_there) files.push_back(file);
  }
  return files;
}

std::vector<Surface> ReadSurfaces(const std::filesystem::path& file) {
  base::YamlMap map = base::YamlMap::FromFile(file);
  std::vector<Surface> surfaces;
  for (const std::string& name : map.Names()) {
    surfaces.push_back(ReadSurface(map.Child(name), name));
  }
  return surfaces;
}

std::vector<Surface> SurfacesFor(const std::filesystem::path& object_mjcf) {
  std::vector<Surface> all;
  for (const auto& file : SurfaceFiles(object_mjcf)) {
    for (Surface& surface : ReadSurfaces(file)) {
      const bool known = std::ranges::find(all, surface.name, &Surface::name) != all.end();
      if (!known) all.push_back(std::move(surface));
    }
  }
  return all;
}

const Surface& FindSurface(const std::vector<Surface>& surfaces, std::string_view name) {
  const auto found = std::ranges::find(surfaces, name, &Surface::name);
  if (found != surfaces.end()) return *found;
  std::vector<std::string> known;
  for (const Surface& surface : surfaces) known.push_back(surface.name);
  throw base::InputError(
      fmt::format("unknown surface \"{}\"; known surfaces: {}; a file surfaces.yaml in the "
                  "object's folder or the one above can add it",
                  name, base::Join(known)));
}

}  // namespace rangegrasp::sim
