#pragma once

#include <optional>

#include "parts/hierarchy/internal/cells.h"

namespace rangegrasp::parts {

/// Of each cell on which of two sides it is, 0 or 1.
using Sides = std::vector<std::uint8_t>;

/// The connected sets of cells on the same side, by their first cells.
std::vector<Indices> ConnectedSets(const Cells& cells, const Sides& side);

/// How many closed borders a set of cells has with the rest of its part, if it can be taken off
/// without that the rest comes apart (a handle has two); else 1.
double HandleLoops(const Cells& part, const Sides& off);

/// sum_c A_c n_c . (x_c - x_mean) / A^1.5 over the cells in a set: three times the volume between
/// them and their mean. A ball's is 0.28, a flat patch's 0, a dent's negative.
double Solidity(const Cells& part, const Sides& in);

/// Weak convexity (van Kaick et al. 2014): how many pairs of cells next to a border see each other
/// across it, as a share of what pairs as far apart on one side of it do; 0.1 to 1.
/// @param reach  of cells from the border, along the surface
/// @param limit  what is above it need not be known exactly
/// @return nullopt, sooner, for some of what is above the limit
std::optional<double> SeenAcross(const Cells& part, const Sides& off, double reach,
                                 double limit = 2.0);

struct SplitOptions {
  double min_area;  ///< of both sides
  double solidity;  ///< of the smaller side
  /// Cost of the border over its length, times SeenAcross, at most: 1 is neither concave nor hides
  /// anything. A rod is no two parts however long it is.
  double max_flatness = 1e9;
  double sight = 0.4;  ///< reach of SeenAcross, of the root of the smaller side's area
};
/// A connected set of cells to cut off.
struct CutOff {
  /// Cost / sqrt(4 pi area of the smaller side) / loops * SeenAcross; infinite if there is none.
  double quality;
  Indices off;
};
/// The best of all connected pieces into which a candidate cuts a part; ties: the first.
CutOff BestSplit(const Cells& part, const std::vector<Sides>& candidates,
                 const SplitOptions& options);

/// The connected sets that are left of a part without `off`, and `off`. Crumbs smaller than
/// min_area go with it, but for the largest.
std::vector<Indices> Divide(const Cells& part, const Indices& off, double min_area);

struct CandidateOptions {
  int centers = 60;          ///< interior centers to mirror about
  int levels = 8;            ///< cores of different size per center
  double min_share = 0.004;  ///< of the surface, of the first core: just below the smallest part
  double max_share = 0.7;    ///< of the last core; what is outside of it is to be a part
  /// The cut lies in a band between a core and one so many times as large: a wider band finds more
  /// distant necks and costs more time.
  double reach = 3.0;
};

/// The center of a ball inside of the shape that touches it in cell `c`: the smallest such ball
/// that no other cell's center is in.
Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c);

/// Sets of cells that may be parts. About each center the cells' centers are mirrored (eq. 6.2);
/// how deep an image lies below the hull (eq. 6.3) says how well it is seen. A core grows from the
/// cells next to the center, best seen first; another grows where the shape is thinnest first (the
/// radius of the inscribed ball), which follows a handle to its other end. Cores of several sizes
/// are cut off where it is cheapest between them and a core some times as large.
std::vector<Sides> MirrorCandidates(const Cells& cells, const CandidateOptions& options);

/// Moves the border of any two parts to the cheapest place (sum of `costs`, parallel to
/// FaceGraph::neighbor) within `width` of where it is: a minimum cut between their faces that are
/// farther. Pairs of parts one after the other, ascending. No part vanishes.
void MoveBorders(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                 double width, Labels& label);

}  // namespace rangegrasp::parts
