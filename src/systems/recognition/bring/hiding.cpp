#include "recognition/bring/hiding.h"

#include <algorithm>
#include <vector>

#include "geometry/bounds.h"
#include "geometry/seen_space.h"

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;

constexpr double kCell_m = 0.010;
constexpr double kLow_m = 0.010;
constexpr double kHigh_m = 0.040;

/// A known object's box, in its own frame, grown by half a cell.
struct Known {
  base::Pose X_BC;
  Eigen::AlignedBox3d box_B;
};

std::vector<Known> KnownOf(const Understanding& understanding,
                           const recognition::Library& library) {
  std::vector<Known> known;
  const Vector3d grown = Vector3d::Constant(0.5 * kCell_m);
  for (const auto& found : understanding.found) {
    if (!found) continue;
    const Eigen::AlignedBox3d box_B =
        geometry::BoundsOf(library.Find(found->object).mesh_B.vertices);
    known.push_back({found->X_CB.inverse(), {box_B.min() - grown, box_B.max() + grown}});
  }
  return known;
}

}  // namespace

double HidingArea(const geometry::Observation& observation, const Understanding& understanding,
                  const recognition::Library& library, const Vector3d& middle_C, double radius_m) {
  geometry::SeenSpace space({middle_C + Vector3d(-radius_m, -radius_m, kLow_m),
                             middle_C + Vector3d(radius_m, radius_m, kHigh_m)},
                            kCell_m);
  for (const geometry::View& view : observation.views) space.Add(view);
  const std::vector<Known> known = KnownOf(understanding, library);
  const auto hides = [&](int x, int y) {
    for (int z = 0; z < space.Size().z(); ++z) {
      const Eigen::Vector3i cell(x, y, z);
      const Vector3d p_C = space.MiddleOf(cell);
      if (space.At(cell) != geometry::SeenSpace::Cell::kUnseen) return false;
      if ((p_C - middle_C).head<2>().norm() > radius_m) return false;
      if (std::ranges::any_of(known,
                              [&](const Known& k) { return k.box_B.contains(k.X_BC * p_C); })) {
        return false;
      }
    }
    return true;
  };
  int cells = 0;
  for (int y = 0; y < space.Size().y(); ++y) {
    for (int x = 0; x < space.Size().x(); ++x) cells += hides(x, y) ? 1 : 0;
  }
  return cells * kCell_m * kCell_m;
}

double SmallestFootprint(const recognition::KnownObject& object) {
  const Vector3d size = geometry::BoundsOf(object.mesh_B.vertices).sizes();
  return size.prod() / size.maxCoeff();
}

}  // namespace rangegrasp::bring
