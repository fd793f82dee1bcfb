#pragma once

#include "seam/stitching/mats.h"

namespace rangegrasp::seam {

/// Bright, matte mats without any texture, so that only their shape remains.
inline MatOptions Smooth(EdgeShape shape) {
  MatOptions options;
  options.shape = shape;
  options.texture.weave_relief_m = 0.0;
  options.texture.fuzz_m = 0.0;
  options.texture.waviness_m = 0.0;
  options.texture.fray_m = 0.0;
  options.texture.filaments_per_m = 0.0;
  options.texture.loose_filaments_per_m2 = 0.0;
  options.texture.detached_share = 0.0;
  options.texture.gloss = 0.0;
  options.texture.darkness = 0.0;
  options.texture.steep_rad = 0.75;
  return options;
}

}  // namespace rangegrasp::seam
