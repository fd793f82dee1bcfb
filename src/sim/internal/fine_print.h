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

/// What makers print into the empty regions of a package, beside what a label in the model's folder
/// shows in large. Estimates of what stands on packages in a kitchen; coverage counts most.
struct FinePrint {
  /// Share of the label that lists, tables and bar codes fill, if it is empty.
  double coverage = 0.0;
  int pictures = 0;           ///< blotchy ones, as of food
  double grain_levels = 0.0;  ///< of 255: unevenness of paper and ink, in patches of half a mm
};

/// By the surface's word in the table of friction pairs: cardboard is printed all over, metal and
/// tubs less, bottles have a small label at the back, ceramics nothing.
FinePrint FinePrintOf(std::string_view surface);

/// A label with fine print, at so many texels that letters of 1.2 mm can be told apart. The label's
/// own marks stay where they are. O(texels); depends on the arguments alone.
/// @param mm_per_texel  of the label.
/// @param seed          of this label's print.
Texture WithFinePrint(const Texture& label, double mm_per_texel, const FinePrint& print,
                      std::uint64_t seed);

/// A model's textures, of which some were replaced; what the engine's renderer loads instead of its
/// own.
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
