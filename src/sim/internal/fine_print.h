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
/// label. Estimates from packages in a kitchen; coverage counts most.
struct FinePrint {
  /// Share of the label that lists, tables and bar codes fill, if it is empty.
  double coverage = 0.0;
  int pictures = 0;           ///< blotchy ones, as of food
  double grain_levels = 0.0;  ///< of 255: unevenness of paper and ink, in patches of half a mm
};

/// By the surface's name: cardboard is printed all over, metal and tubs less, bottles have a small
/// label at the back, ceramics nothing.
FinePrint FinePrintOf(std::string_view surface);

/// A label with fine print, at a resolution that resolves letters of 1.2 mm; its own marks stay.
/// O(texels); depends on the arguments alone.
/// @param mm_per_texel  of the label.
/// @param seed          of this label's print.
Texture WithFinePrint(const Texture& label, double mm_per_texel, const FinePrint& print,
                      std::uint64_t seed);

/// A model's textures, some of them replaced, for the engine's renderer to load.
class TextureSet {
 public:
  /// Those of a model, with fine print on the objects' labels.
  /// @param objects   root bodies of the objects.
  /// @param surfaces  their words, one each.
  TextureSet(const mjModel* model, const std::vector<int>& objects,
             const std::vector<std::string>& surfaces);
  /// Lets `model` point to them: for reading while this lives.
  void PutInto(mjModel& model);

 private:
  std::vector<int> width_, height_;
  std::vector<mjtSize> address_;
  std::vector<mjtByte> data_;
};

}  // namespace rangegrasp::sim::internal
