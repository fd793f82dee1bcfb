#pragma once

#include <cstdint>

#include "seam/stitching/mats.h"

namespace rangegrasp::stitching::internal {

/// Fibres that stand off the mats: single filaments about the edge and elsewhere, and bundles that
/// have come off the edge. Each is a thin ridge, short along y.
class Filaments {
 public:
  Filaments(const MatTexture& texture, double edge_height_m, std::uint64_t seed);
  /// The highest ridge above the surface at (x, y), where the edge is at x - across.
  /// return_strength is meant for a height above 0.
  MatPoint NearEdge(double across_m, double y_m) const;
  MatPoint Elsewhere(double x_m, double y_m) const;

 private:
  void Detached(double across_m, double y_m, MatPoint& highest) const;

  std::uint64_t edge_seed_, loose_seed_, detached_seed_;
  double per_edge_cell_, per_loose_cell_;
  double height_m_, reach_m_, edge_height_m_;
  double detached_share_;
};

}  // namespace rangegrasp::stitching::internal
