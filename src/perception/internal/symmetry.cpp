#include "perception/internal/symmetry.h"

#include <cmath>

#include "perception/internal/planar.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Points;

/// What a part is symmetric about.
struct Symmetry {
  enum class Kind { kNone, kMirror, kHalfTurn } kind = Kind::kNone;
  Eigen::Vector3d through;  ///< a point of the mirror plane, or of the axis
  Eigen::Vector3d normal;   ///< of the mirror plane; unit
};

Symmetry FindSymmetry(const ObjectContext& context, const Part& part) {
  const CompletionOptions& options = context.options.completion;
  const Eigen::Vector3d& up = context.table.normal;
  const TopSurface& top = *part.top;
  const Eigen::Vector3d level = top.plane.normal.cross(up);
  const bool inclined = level.norm() > std::sin(options.min_inclination_rad);
  if (top.ridge || inclined) {
    const Eigen::Vector3d along = top.ridge ? top.major_C : level;
    const PlanarFrame frame = MakePlanarFrame(context.table, top.center_C, along);
    Eigen::Vector3d through = top.center_C;
    if (!top.ridge) {
      through +=
          HighestLine(frame, context.table, geometry::Select(context.cloud.points, top.points)) *
          frame.v;
    }
    return {Symmetry::Kind::kMirror, through, frame.v};
  }
  const PlanarFrame frame = MakePlanarFrame(context.table, top.center_C);
  const Rectangle body =
      MinAreaRectangle(Flatten(frame, geometry::Select(context.cloud.points, part.points)));
  if (top.major_m * top.minor_m < options.max_top_share * body.length_m * body.width_m) {
    return {Symmetry::Kind::kHalfTurn, top.center_C, up};
  }
  return {};
}

Eigen::Vector3d Image(const Symmetry& symmetry, const Eigen::Vector3d& p) {
  const Eigen::Vector3d d = p - symmetry.through;
  const Eigen::Vector3d along = d.dot(symmetry.normal) * symmetry.normal;
  return symmetry.kind == Symmetry::Kind::kMirror ? Eigen::Vector3d(p - 2.0 * along)
                                                  : Eigen::Vector3d(p - 2.0 * (d - along));
}

}  // namespace

Points SymmetricImage(const ObjectContext& context, const Part& part) {
  if (!context.options.complete_by_symmetry || !part.top) return {};
  const Symmetry symmetry = FindSymmetry(context, part);
  if (symmetry.kind == Symmetry::Kind::kNone) return {};
  Points image;
  image.reserve(part.points.size());
  for (const auto i : part.points) {
    const Eigen::Vector3d p = Image(symmetry, context.cloud.points[i]);
    if (!context.views.IsFree(p, context.options.completion.free_margin_m) &&
        context.table.Distance(p) >= 0.0) {
      image.push_back(p);
    }
  }
  const double share = static_cast<double>(image.size()) / static_cast<double>(part.points.size());
  if (share < context.options.completion.mirror_share) image.clear();
  return image;
}

}  // namespace rangegrasp::perception::internal
