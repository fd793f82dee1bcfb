#pragma once

#include "perception/internal/planar.h"

namespace rangegrasp::perception::internal {

/// An open box that things lie in. Its walls are in the hand's way, and nothing to grasp.
struct Container {
  PlanarFrame frame;   ///< on the table
  Rectangle walls;     ///< in that frame: the border that the walls stand on
  double rim_m = 0.0;  ///< height over the table below which what is at the border is a wall
};

/// A box is known by its geometry alone: two upright sheets face each other, further apart than a
/// hand can grasp; a rectangle of which they are sides is wider that way, too, and most of its
/// border is equally high, which things that stand about are not; and there is no lid. A sheet is a
/// straight line, seen from above, that upright points lie on for the most part of a side: what is
/// off it, singly or as a thing, does not move it. Where a wall is not seen but for its rim, the
/// ends of the sheets say where it is. O(n).
/// @return nullopt where there is no box.
std::optional<Container> FindContainer(const PointCloud& cloud, const Plane& table,
                                       const ContainerOptions& options);

/// The points at the border, up to the rim: positions in the cloud, ascending.
Indices PointsOfWalls(const PointCloud& cloud, const Container& container,
                      const ContainerOptions& options);

/// Whether a segment is a piece of wall that the border has missed: nearly all of it lies close to
/// it and below the rim.
bool IsPieceOfWall(const PointCloud& cloud, const Container& container,
                   const ContainerOptions& options, const Indices& segment);

}  // namespace rangegrasp::perception::internal
