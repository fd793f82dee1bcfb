#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <vector>

#include "base/image/image.h"
#include "sim/world.h"

namespace rangegrasp::sim::internal {

/// What makers print into the empty regions of a package, in addition to the large print of its
/// label. Estimates from packages in a kitchen; coverage matters most.
struct FinePrint {
  /// Share of an empty label that lists, tables and bar codes fill.
  double coverage = 0.0;
  int pictures = 0;           ///< blotchy pictures, such as of food
  double grain_levels = 0.0;  ///< of 255: unevenness of paper and ink, in patches of half a mm
};

/// Adds fine print to a label, at a resolution that shows letters of 1.2 mm; the label's own marks
/// stay. O(texels); the result depends only on the arguments.
/// @param mm_per_texel  of the label.
/// @param seed          of this label's print.
image::Image WithFinePrint(const image::Image& label, double mm_per_texel, const FinePrint& print,
                           std::uint64_t seed);

/// Textures of a world's model, with fine print on the objects' labels, for the engine's renderer.
class TextureSet {
 public:
  explicit TextureSet(const World& world);
  /// Makes `model` point to these textures, for reading while this object lives.
  void PutInto(mjModel& model);

 private:
  std::vector<int> width_, height_;
  std::vector<mjtSize> address_;
  std::vector<mjtByte> data_;
};

}  // namespace rangegrasp::sim::internal
