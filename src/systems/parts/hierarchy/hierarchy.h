#pragma once

#include <optional>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// Lengths are shares of the root of the surface area, areas of the surface area. Values were
/// chosen on the first four models of each class of experiments/parts_psb.yaml (docs/parts.md).
struct HierarchyOptions {
  int cells = 1000;           ///< >= 2; of faces, the resolution of cuts until their last step
  double flat_side = 0.03;    ///< > 0; flat pieces are cut along cubes of this side
  int centers = 20;           ///< >= 4; of the whole; a part has the root of its share, at least 4
  int levels = 6;             ///< >= 1; sizes of core about each center
  double fine = 0.02;         ///< > 0; radius in which the surface's bend is measured: creases
  double coarse = 0.04;       ///< > 0; the same: necks; the more concave of both counts
  double concavity = 2.5;     ///< >= 0; a cut through a bend of b rad costs exp(-concavity * b)
  double crease = 4.0;        ///< >= 0; the way across a bend of b rad is 1 + crease * b as long
  double cut_quality = 0.38;  ///< > 0; a cut worse than this is not made
  /// >= 1; so many parts, best cuts first, whatever their quality; absent: cut_quality decides.
  std::optional<int> parts = {};
  double min_area = 0.005;    ///< > 0; of a part
  double solidity = 0.02;     ///< of a part, a ball's is 0.28; patches of a wall and dents are none
  double max_flatness = 0.9;  ///< of a cut: cost over length, times what is seen across, at most
  double sight = 0.4;  ///< >= 0; reach of SeenAcross, of the root of the side; 0: creases alone
  double border_reach = 0.7;  ///< >= 0; how far borders move at last, in widths of a cell
};

/// A hierarchical variant of mirroring; our own, not the chapter's, and it has thresholds.
///
/// 1. The mesh becomes canonical and its flat pieces become facets, so that parts do not depend on
///    how it lies, is written down and cut into faces.
/// 2. Cells: the facets in about `cells` patches that end at concave creases; a border between two
///    costs its length, less where the surface bends inwards across it (the minima rule, Hoffman
///    and Richards 1984; curvature tensor of Cohen-Steiner and Morvan 2003, at two scales).
/// 3. Mirroring (eq. 6.2-6.3) about many centers, those of inscribed balls: what is seen of the
///    shape from a center is near the mirrored hull (Katz, Tal and Basri 2007). A core grows about
///    each, what is seen best first, and minimum cuts take cores of several sizes off where that is
///    cheapest (as in Katz and Tal 2003). Cups and rings need no exception.
/// 4. The best cut is made if its quality is at most `cut_quality`: cost over the girth of a disc
///    as large as the smaller side (part salience, Hoffman and Singh 1997), times what cells next
///    to it see of each other across it through the inside, as a share of what is seen as far on
///    one side (weak convexity, Asafi et al. 2013, van Kaick et al. 2014). It needs a crease or a
///    narrow view, and a side that is solid (encloses volume outwards). A handle counts the mean of
///    its two ends.
/// 5. The same (3, 4) with each of the parts: a tree, whose upper levels are coarser parts.
/// 6. Borders move to the cheapest place nearby, facet by facet, by minimum cuts.
///
/// The largest part is the core, label 0; the others follow by falling area. Open and non-manifold
/// meshes too. Of a cloud MeshOfCloud is segmented, each point has the label of the nearest face;
/// of a body of revolution seen from one side (seen_side.h) smaller parts are joined. The same for
/// any order of vertices and faces, and for any turn, shift and scale but where rounding decides
/// between parts of a symmetric shape. About O(n log n + parts * centers * cells^1.5).
/// @throws std::invalid_argument if an option is out of range.
Segmentation SegmentHierarchy(const Shape& shape, const HierarchyOptions& options);

}  // namespace rangegrasp::parts
