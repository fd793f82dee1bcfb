#include "sim/friction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/words.h"

namespace rangegrasp::sim {

const std::vector<SurfaceFriction>& FrictionTable() {
  static const std::vector<SurfaceFriction> table = {
      // surface, glove {middle, low, high, kinetic}, on laminate {static, kinetic}
      {"cardboard", {0.60, 0.45, 0.80, 0.50}, {0.30, 0.25}},
      {"painted_metal", {0.60, 0.40, 0.80, 0.50}, {0.25, 0.20}},
      {"plastic", {0.50, 0.35, 0.70, 0.40}, {0.25, 0.20}},
      {"hdpe", {0.50, 0.35, 0.70, 0.40}, {0.25, 0.20}},
      {"pet", {0.50, 0.35, 0.70, 0.40}, {0.25, 0.20}},
      {"ceramic", {0.70, 0.50, 1.00, 0.55}, {0.35, 0.30}},
      // A melamine face: taken for a plastic's.
      {kTableSurface, {0.50, 0.35, 0.70, 0.40}, {0.25, 0.20}},
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

namespace {

// In the proportion of the table's two numbers.
FrictionPair PairOf(const GloveRange& range, double static_mu) {
  return {static_mu, static_mu * range.kinetic / range.middle};
}

}  // namespace

FrictionPair DrawnFriction(const GloveRange& range, double u) {
  const double width = range.high - range.low;
  const double at_mode = (range.middle - range.low) / width;
  const double mu = u < at_mode
                        ? range.low + std::sqrt(u * width * (range.middle - range.low))
                        : range.high - std::sqrt((1.0 - u) * width * (range.high - range.middle));
  return PairOf(range, mu);
}

FrictionPair GloveFriction(std::string_view surface, const PhysicsOptions& options, double u) {
  if (options.glove_friction) return {*options.glove_friction, *options.glove_friction};
  const GloveRange& range = FrictionOf(surface).glove;
  switch (options.friction) {
    case FrictionChoice::kDrawn:
      return DrawnFriction(range, u);
    case FrictionChoice::kLow:
      return PairOf(range, range.low);
    case FrictionChoice::kHigh:
      return PairOf(range, range.high);
    case FrictionChoice::kKinetic:
      return {range.kinetic, range.kinetic};
    case FrictionChoice::kMiddle:
      break;
  }
  return PairOf(range, range.middle);
}

FrictionPair GloveFriction(std::string_view surface, const PhysicsOptions& options) {
  PhysicsOptions middle = options;
  if (middle.friction == FrictionChoice::kDrawn) middle.friction = FrictionChoice::kMiddle;
  return GloveFriction(surface, middle, 0.0);
}

}  // namespace rangegrasp::sim
