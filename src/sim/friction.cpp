#include "sim/friction.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/words.h"

namespace rangegrasp::sim {

const std::vector<SurfaceFriction>& FrictionTable() {
  static const std::vector<SurfaceFriction> table = {
      // surface, glove {static, kinetic}, on laminate {static, kinetic}
      {"cardboard", {0.60, 0.50}, {0.30, 0.25}}, {"painted_metal", {0.60, 0.50}, {0.25, 0.20}},
      {"plastic", {0.50, 0.40}, {0.25, 0.20}},   {"hdpe", {0.50, 0.40}, {0.25, 0.20}},
      {"pet", {0.50, 0.40}, {0.25, 0.20}},       {"ceramic", {0.70, 0.55}, {0.35, 0.30}},
  };
  return table;
}

const SurfaceFriction& FrictionOf(std::string_view surface) {
  const auto& table = FrictionTable();
  const auto row = std::find_if(table.begin(), table.end(),
                                [&](const SurfaceFriction& r) { return r.surface == surface; });
  if (row != table.end()) return *row;
  std::vector<std::string> known;
  for (const SurfaceFriction& r : table) known.emplace_back(r.surface);
  throw core::InputError(fmt::format("surface \"{}\" has no friction; known surfaces: {}", surface,
                                     core::Join(known)));
}

FrictionPair GloveFriction(std::string_view surface, const PhysicsOptions& options) {
  if (options.glove_friction) return {*options.glove_friction, *options.glove_friction};
  FrictionPair pair = FrictionOf(surface).glove;
  pair.static_mu = options.kinetic_only
                       ? pair.kinetic_mu
                       : std::max(pair.kinetic_mu, pair.static_mu + options.static_friction_offset);
  return pair;
}

}  // namespace rangegrasp::sim
