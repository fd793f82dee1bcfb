#pragma once

#include <vector>

#include "geometry/mesh.h"
#include "mesh/repair.h"

namespace rangegrasp::objects {

/// How a solid is cut into convex parts.
struct CutOptions {
  /// How far a part's hull may stand off from the solid, as a share of half its longest edge: 2.5
  /// mm of 100 mm. Smaller: more parts, slower to cut and to simulate.
  double concavity = 0.05;
  /// The search for good cuts: nodes and rounds of its tree, samples of a surface. A third of
  /// CoACD's own defaults, and a tenth of their time; six household shapes come out as well within
  /// 1 % of their volumes.
  int nodes = 10;
  int rounds = 40;
  int samples = 1000;
  /// Triangles that are cut: more are simplified before. Time grows with them, the parts do not.
  std::size_t max_triangles = 2000;
  /// A part below this share of the solid's volume is a splinter; the engine refuses such hulls.
  double min_part = 1e-5;
};

/// Approximate convex decomposition (CoACD; Wei et al. 2022): closed hulls, faces outward, in the
/// solid's frame and unit. The same solid gives the same bytes, on any number of cores.
/// @param solid  as geometry::RepairMesh makes it.
/// @throws base::RunError saying how to install CoACD's library where there is none.
std::vector<geometry::TriangleMesh> ConvexParts(const geometry::TriangleMesh& solid,
                                                const CutOptions& options = {});

/// The parts of the coarsest cut that is good enough, with how well they stand for the solid.
struct Cut {
  std::vector<geometry::TriangleMesh> parts;
  geometry::Overlap overlap;
};
/// As ConvexParts; where parts stand out by more than max_beyond of the solid's volume (thin walls)
/// once more, half as coarsely.
/// @throws as ConvexParts.
Cut CutFinely(const geometry::TriangleMesh& solid, double max_beyond,
              const CutOptions& options = {});

/// Whether CoACD's library is there.
bool CanCut();

}  // namespace rangegrasp::objects
