#pragma once

#include <cstdint>
#include <vector>

namespace rangegrasp::parts {

/// What stands out of a core, element by element (faces of a mesh, points of a cloud).
struct StandingOut {
  std::vector<double> growth;  ///< the core's hull holds it from this factor on; <= 1: of the core
  std::vector<double> weight;  ///< area, or 1
  std::vector<double> remoteness;  ///< mean geodesic distance to all of the shape
  /// Neighbors of element i are neighbor[begin[i] .. begin[i + 1]).
  std::vector<std::uint32_t> begin, neighbor;
};

struct LimbOptions {
  double min_weight = 0.01;  ///< share of all weight from which a piece is a limb, not a crumb
  /// A limb lasts while the core grows by this share of itself: less is a bump.
  double min_prominence = 0.1;
  /// Its tip is so many times as remote as its root. Of limbs, tails and ears of four models that
  /// it was chosen on 1.26 and more, of bellies, udders and bent hips 1.14 and less.
  double min_reach = 1.2;
};

/// Cuts what stands out into limbs.
///
/// As the core grows, the pieces outside of it get smaller, fall apart and vanish: a tree (the join
/// tree of `growth`). A piece that falls apart into limbs is told as one limb or as those,
/// whichever last for a longer growth of the core, those in the mean: a chest with arms and head
/// falls apart, an arm with fingers stays whole. So each limb is cut where it joins others, and no
/// growth is fixed for all of them. A limb leads away from the rest (the feature points of Katz et
/// al. 2005): what does not is the core's, and a piece falls apart only if two of its limbs do: a
/// head with short ears stays whole. O(n log n).
/// @return a label an element: 0 the core, from 1 the limbs by falling weight.
std::vector<std::int32_t> LabelLimbs(const StandingOut& elements, const LimbOptions& options);

}  // namespace rangegrasp::parts
