#pragma once

#include <optional>

#include "parts/hierarchy/hierarchy.h"
#include "parts/hierarchy/internal/cells.h"

namespace rangegrasp::parts {

/// For each cell the side it is on, 0 or 1.
using Sides = std::vector<std::uint8_t>;

/// Connected sets of cells on the same side, ordered by their first cells.
std::vector<Indices> ConnectedSets(const Cells& cells, const Sides& side);

/// Number of closed borders between a set of cells and the rest of its part (a handle has two). 1
/// if the set cannot be removed without disconnecting the rest.
double HandleLoops(const Cells& part, const Sides& off);

/// sum_c A_c n_c . (x_c - x_mean) / A^1.5 over the cells of a set: three times the volume between
/// them and their mean. It is 0.28 for a ball, 0 for a flat patch and negative for a dent.
double Solidity(const Cells& part, const Sides& in);

/// Weak convexity (van Kaick et al. 2014): fraction of the pairs of cells near a border that see
/// each other across it, relative to pairs at the same distance on one side of it; 0.1 to 1.
/// @param reach  maximum distance of cells from the border, along the surface
/// @param limit  values above it need not be exact
/// @return nullopt, after less work, for some of the values above the limit
std::optional<double> SeenAcross(const Cells& part, const Sides& off, double reach,
                                 double limit = 2.0);

/// A connected set of cells to cut off.
struct CutOff {
  /// Cost / sqrt(4 pi area of the smaller side) / loops * SeenAcross; infinite if there is no cut.
  double quality;
  Indices off;
};
/// The best of all connected pieces into which the candidates cut a part; on ties the first one.
/// @param min_area  minimum area of both sides
/// @param options  limits of a cut: solidity, max_flatness, sight
CutOff BestSplit(const Cells& part, const std::vector<Sides>& candidates, double min_area,
                 const HierarchyOptions& options);

/// Divides a part into `off` and the connected sets of the rest. Sets smaller than min_area join
/// `off`, except for the largest one.
std::vector<Indices> Divide(const Cells& part, const Indices& off, double min_area);

/// Center of a ball inside the shape that touches it in cell `c`: the smallest such ball that
/// touches another cell's center, so that no other center is inside.
Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c);

/// Sets of cells that may be parts. The cells' centers are mirrored about each center (eq. 6.2);
/// the depth of an image below the hull (eq. 6.3) shows how well a cell is seen. One core grows
/// from the cells next to the center, best seen cells first. Another one grows to the thinnest
/// places first (the radius of the inscribed ball), which follows a handle to its other end. Cores
/// of several sizes are cut off at the cheapest place between them and a core several times as
/// large.
/// @param centers  interior centers to mirror about
/// @param levels  core sizes per center
std::vector<Sides> MirrorCandidates(const Cells& cells, int centers, int levels);

/// Moves the border between any two parts to the cheapest place (sum of `costs`, parallel to
/// FaceGraph::neighbor) within `width` of its position, by a minimum cut between the faces farther
/// away. Pairs of parts are handled one after the other, in ascending order. No part vanishes.
void MoveBorders(const FaceGraph& faces, const FaceFrames& frames, const std::vector<double>& costs,
                 double width, Labels& label);

}  // namespace rangegrasp::parts
