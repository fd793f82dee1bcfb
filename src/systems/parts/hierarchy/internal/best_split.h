#pragma once

#include <cstdint>
#include <vector>

#include "parts/hierarchy/internal/cells.h"

namespace rangegrasp::parts {

using CellSet = std::vector<std::uint32_t>;  ///< ascending

/// The connected sets of cells on the same side, by their first cells.
std::vector<CellSet> ConnectedSets(const Cells& cells, const std::vector<bool>& side);

/// How many closed borders a set of cells has with the rest of its part, if it can be taken off
/// without that the rest comes apart (a handle has two); else 1.
double HandleLoops(const Cells& part, const std::vector<bool>& off);

/// sum_c A_c n_c . (x_c - x_mean) / A^1.5 over the cells on a side: three times the volume between
/// them and their mean. A ball's is 0.28, a flat patch's 0, a dent's negative.
double Solidity(const Cells& part, const std::vector<bool>& in, bool side);

struct SplitOptions {
  double min_area;  ///< of both sides
  double solidity;  ///< of the smaller side
  /// Cost of the border over its length, at most: 1 is flat, below is concave. A rod is no two
  /// parts however long it is.
  double max_flatness = 1e9;
};
/// A connected set of cells to cut off.
struct Split {
  /// Cost / sqrt(4 pi area of the smaller side) / loops; infinite if there is none.
  double quality;
  CellSet off;
};
/// The best of all connected pieces into which a candidate cuts a part; ties: the first.
Split BestSplit(const Cells& part, const std::vector<std::vector<bool>>& candidates,
                const SplitOptions& options);

/// The connected sets that are left of a part without `off`, and `off`. Crumbs smaller than
/// min_area go with it, but for the largest.
std::vector<CellSet> Divide(const Cells& part, const CellSet& off, double min_area);

}  // namespace rangegrasp::parts
