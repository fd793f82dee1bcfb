#pragma once

#include <cstdint>

#include "seam/stitching/mats.h"

namespace rangegrasp::stitching::internal {

/// The surface of one mat about its mean height: tows of fibres over and under each other, their
/// fuzz, and how much light they return.
class Tows {
 public:
  Tows(const MatTexture& texture, std::uint64_t seed);
  MatPoint At(double x_m, double y_m) const;

 private:
  // The tow that lies on top: where across it and along its visible part, and its place on it.
  struct Top {
    double across, along;  // 0 .. 1
    std::int64_t tow;
    double position;  // along the tow, in tow widths
    double away;      // how often this direction sends the light elsewhere
    std::uint64_t seed;
  };
  Top TopAt(double p, double q) const;
  double AwayAt(const Top& top) const;

  Weave weave_;
  std::uint64_t warp_seed_, weft_seed_, fuzz_seed_, wave_seed_;
  double px_, py_, qx_, qy_;  // p and q count tow widths across weft and warp
  double warp_away_, weft_away_;
  double relief_m_, fuzz_m_, fuzz_per_m_, wave_m_, waves_per_m_;
  double brightness_;
};

}  // namespace rangegrasp::stitching::internal
