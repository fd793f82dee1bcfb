#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace rangegrasp::objects {

/// Unit of a mesh file's numbers. Only glTF says its own (metres).
enum class LengthUnit { kMm, kCm, kM, kInch };
constexpr std::array<std::string_view, 4> WordsOf(LengthUnit) { return {"mm", "cm", "m", "inch"}; }

/// [m]
double MetersOf(LengthUnit unit);

/// What a hand may want to grasp: longest edge of the box round it.
struct SizeRange {
  double min_m = 0.005;
  double max_m = 1.0;
  /// Without a unit it is guessed only where the size comes to lie within these: a dice, a bottle.
  double likely_min_m = 0.02;
  double likely_max_m = 0.4;
  double typical_m = 0.1;  ///< of two likely ones, the one nearer to it in proportion
};

/// The unit (mm, cm or m) that makes `longest` of a file's numbers a likely size; nullopt if none
/// does.
std::optional<LengthUnit> GuessUnit(double longest, const SizeRange& sizes = {});

}  // namespace rangegrasp::objects
