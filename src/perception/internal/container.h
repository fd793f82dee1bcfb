#pragma once

#include "perception/internal/planar.h"

namespace rangegrasp::perception::internal {

/// An open box that things lie in. Its walls are obstacles for the hand and are not grasped.
struct Container {
  PlanarFrame frame;   ///< on the table
  Rectangle walls;     ///< in that frame: the border that the walls stand on
  double rim_m = 0.0;  ///< height over the table below which points at the border are a wall
};

/// A box is recognized by its geometry alone. Two upright sheets face each other, further apart
/// than a hand can grasp. A rectangle with them as sides is that wide in the other direction, too,
/// and most of its border is equally high, unlike things that stand about. There is no lid, and no
/// circle that fits the upright points better, as in a pot. A sheet, seen from above, is a straight
/// line with upright points along most of a side; points off it, single ones or a thing's, do not
/// move it. If only the rim of a wall is seen, the ends of the sheets show where it is. O(n).
/// @return nullopt if there is no box.
std::optional<Container> FindContainer(const PointCloud& cloud, const Plane& table,
                                       const ContainerOptions& options);

/// The points at the border, up to the rim: positions in the cloud, ascending.
Indices PointsOfWalls(const PointCloud& cloud, const Container& container,
                      const ContainerOptions& options);

/// Whether a segment is a piece of wall that the border has missed: nearly all of it lies close to
/// the border and below the rim.
bool IsPieceOfWall(const PointCloud& cloud, const Container& container,
                   const ContainerOptions& options, const Indices& segment);

}  // namespace rangegrasp::perception::internal
