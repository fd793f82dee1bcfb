#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/observation.h"

namespace rangegrasp::geometry {

/// What a sensor sees of its surroundings: a pyramid along z of its frame S (x right, y down).
struct Field {
  double half_right_rad = 0.3;  ///< from z to the sides, about S's y axis
  double half_down_rad = 0.3;   ///< about S's x axis
  double near_m = 0.1;          ///< it measures nothing nearer ...
  double far_m = 1.0;           ///< ... nor further away
};

/// What views have told of a box of space, cell by cell: seen through, a surface, or unseen.
/// O(samples * cells along a ray) a view.
class SeenSpace {
 public:
  enum class Cell : std::uint8_t { kUnseen, kFree, kSurface };

  /// @param box_C   its faces along C's axes; the cells that fit into it begin at its lowest corner
  /// @param cell_m  > 0, edge of a cell
  /// @throws std::invalid_argument if the box is empty, not finite or of more than 1e8 cells
  SeenSpace(const Eigen::AlignedBox3d& box_C, double cell_m);

  /// The ray of each measured sample is free up to a cell before its point; the point's cell is a
  /// surface, and stays one. What was not measured tells nothing.
  void Add(const geometry::View& view);

  Cell At(const Eigen::Vector3i& cell) const { return cells_[Index(cell)]; }
  const Eigen::Vector3i& Size() const { return size_; }
  Eigen::Vector3d MiddleOf(const Eigen::Vector3i& cell) const;
  double UnseenVolume() const;  ///< [m^3]

  /// The unseen volume [m^3] that a sensor at X_CS would see, as far as one can tell: over the
  /// cells of `region_C` that were not seen, the largest of its rays' chances to come so far. A ray
  /// ends at a known surface. In unseen space it comes on with exp(-way / depth_m): something may
  /// be there, and most of an object's inside will never be seen.
  double GainFrom(const base::Pose& X_CS, const Field& field, const Eigen::AlignedBox3d& region_C,
                  double depth_m) const;

  /// A surface over what was seen to be there and what may be: over each column of cells the top of
  /// the last that is not free, counted from below, margin_m above it. Nothing where a column is
  /// free. One mesh of level tops and upright walls, open below.
  geometry::TriangleMesh Ceiling(double margin_m) const;

 private:
  std::size_t Index(const Eigen::Vector3i& cell) const {
    return static_cast<std::size_t>((cell.z() * size_.y() + cell.y()) * size_.x() + cell.x());
  }
  template <typename Visit>
  void Walk(const Eigen::Vector3d& from_C, const Eigen::Vector3d& to_C, const Visit& visit) const;
  int TopOf(int x, int y) const;

  Eigen::Vector3d low_C_;
  double cell_m_;
  Eigen::Vector3i size_;
  std::vector<Cell> cells_;
};

}  // namespace rangegrasp::geometry
