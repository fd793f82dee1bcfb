#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace rangegrasp::sim::internal {

/// A texture: rgb, row by row.
struct Texture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

/// What makers print into the empty regions of a package, in addition to the large print of its
/// label. Estimates from packages in a kitchen; coverage matters most.
struct FinePrint {
  /// Share of an empty label that lists, tables and bar codes fill.
  double coverage = 0.0;
  int pictures = 0;           ///< blotchy pictures, such as of food
  double grain_levels = 0.0;  ///< of 255: unevenness of paper and ink, in patches of half a mm
};

/// Fine print by the surface's name: cardboard is printed all over, metal and tubs less. Bottles
/// have a small label at the back, ceramics have no print.
FinePrint FinePrintOf(std::string_view surface);

/// Adds fine print to a label, at a resolution that shows letters of 1.2 mm; the label's own marks
/// stay. O(texels); the result depends only on the arguments.
/// @param mm_per_texel  of the label.
/// @param seed          of this label's print.
Texture WithFinePrint(const Texture& label, double mm_per_texel, const FinePrint& print,
                      std::uint64_t seed);

/// Textures of a model, some of them replaced, for the engine's renderer.
class TextureSet {
 public:
  /// The textures of a model, with fine print on the objects' labels.
  /// @param objects   root bodies of the objects.
  /// @param surfaces  names of their surfaces, one each.
  TextureSet(const mjModel* model, const std::vector<int>& objects,
             const std::vector<std::string>& surfaces);
  /// Makes `model` point to these textures, for reading while this object lives.
  void PutInto(mjModel& model);

 private:
  std::vector<int> width_, height_;
  std::vector<mjtSize> address_;
  std::vector<mjtByte> data_;
};

}  // namespace rangegrasp::sim::internal
