#pragma once

#include <optional>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Lengths are fractions of the square root of the surface area, areas are fractions of the surface
/// area. Values were chosen on the first four models of each class of experiments/parts_psb.yaml
/// (docs/parts.md).
struct HierarchyOptions {
  int cells = 1000;           ///< >= 2; cells of faces, the resolution of cuts except in step 6
  double flat_side = 0.03;    ///< > 0; flat pieces are cut along grid cubes of this side
  int centers = 20;           ///< >= 4; for the whole; times sqrt(area share) for a part, >= 4
  int levels = 6;             ///< >= 1; core sizes per center
  double fine = 0.02;         ///< > 0; radius for measuring the surface's bending at creases
  double coarse = 0.04;       ///< > 0; the same at necks; the more concave of both counts
  double concavity = 2.5;     ///< >= 0; a cut through a bend of b rad costs exp(-concavity * b)
  double crease = 4.0;        ///< >= 0; a path over a bend of b rad counts 1 + crease * b times
  double cut_quality = 0.38;  ///< > 0; cuts with a larger quality value are not made
  /// >= 1; number of parts, best cuts first, whatever their quality; absent: cut_quality decides.
  std::optional<int> parts = {};
  double min_area = 0.005;    ///< > 0; minimum area of a part
  double solidity = 0.02;     ///< minimum of a part (ball: 0.28); excludes wall patches and dents
  double max_flatness = 0.9;  ///< maximum of a cut: cost / length * fraction seen across
  double sight = 0.4;         ///< >= 0; reach of SeenAcross / sqrt(side's area); 0: creases only
  double border_reach = 0.7;  ///< >= 0; how far borders move in step 6, in cell widths
};

/// A hierarchical variant of mirroring. It is our own, not the chapter's, and it has thresholds.
///
/// 1. The mesh becomes canonical and its flat pieces become facets, so that the parts do not depend
///    on its pose, on its storage order and on how it is cut into faces.
/// 2. Cells: facets are grouped into about `cells` patches that end at concave creases. A border
///    costs its length, less where the surface bends inwards across it (the minima rule, Hoffman
///    and Richards 1984; curvature tensor of Cohen-Steiner and Morvan 2003, at two scales).
/// 3. Mirroring (eq. 6.2-6.3) about many centers of inscribed balls: what a center sees is near the
///    mirrored hull (Katz, Tal and Basri 2007). A core grows around each center, best seen cells
///    first. Minimum cuts separate cores of several sizes at the cheapest place (as in Katz and Tal
///    2003). Cups and rings need no exception.
/// 4. The best cut is made if its quality is at most `cut_quality`. Quality is the cost over the
///    circumference of a disc as large as the smaller side (part salience, Hoffman and Singh 1997),
///    times how much the cells near the cut see of each other across it through the inside,
///    relative to what is seen at the same distance on one side (weak convexity, Asafi et al. 2013,
///    van Kaick et al. 2014). A cut needs a crease or a narrow view, and a side that is solid
///    (encloses volume outwards). A handle counts with the mean of its two ends.
/// 5. Steps 3 and 4 are repeated for each part.
/// 6. Minimum cuts move borders to the cheapest place nearby, facet by facet.
///
/// The largest part is the core, label 0; the others follow by decreasing area. Meshes may be open
/// and non-manifold. For a cloud MeshOfCloud is segmented, and points get the labels of the nearest
/// faces; for a body of revolution seen from one side (seen_side.h) smaller parts are joined. The
/// result is independent of vertex and face order, rotation, translation and scale, except where
/// rounding decides between parts of a symmetric shape. About O(n log n + parts * centers *
/// cells^1.5).
Segmentation SegmentHierarchy(const Shape& shape, const HierarchyOptions& options);

}  // namespace rangegrasp::parts
