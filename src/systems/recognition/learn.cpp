#include "recognition/learn.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "geometry/kd_tree.h"
#include "grasp/surface.h"
#include "mesh/solid.h"
#include "recognition/model_shape.h"

namespace rangegrasp::recognition {
namespace {

using geometry::PointCloud;

constexpr std::size_t kMinPoints = 200;  // fewer are noise, or the scan is too coarse to learn from
/// A place on the surface was seen if a measured point is within this many spacings.
constexpr double kSeen = 2.5;
constexpr double kMaxSize = 1000.0;  // in spacings; a distant outlier keeps the mesher from ending
/// Several perceived objects may be pieces of one, but no hand grasps one this wide. The mesher may
/// not end if they are that far apart.
constexpr double kMaxPieces_m = 0.5;
/// The lowest points of the sides are classified as table. The body is therefore assumed to stand
/// where it was seen below this height above the table.
constexpr double kFoot_m = 0.008;
constexpr double kFacesUp = 0.5;  // z of a normal; the foot's upper end is inside the object

/// All perceived objects in the table's frame: one object may be split into several segments.
PointCloud ThingOf(const perception::Scene& scene, const base::Pose& X_CT) {
  PointCloud thing;
  for (const auto& object : scene.objects) {
    for (const std::uint32_t i : object.points) {
      thing.points.push_back(X_CT.inverse() * scene.cloud.points[i]);
      thing.normals.push_back(X_CT.linear().transpose() * scene.cloud.normals[i]);
    }
  }
  return thing;
}

/// Per cell, the mean of the points with similar normals. Both sides of a thin wall are kept.
PointCloud MeanOfEachCell(const PointCloud& cloud, double cell_m) {
  struct Sum {
    Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    int count = 0;
  };
  std::map<std::pair<std::array<long, 3>, int>, Sum> cells;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d& n = cloud.normals[i];
    Eigen::Index axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const int side = 2 * static_cast<int>(axis) + (n[axis] > 0.0 ? 1 : 0);
    Sum& sum = cells[{grasp::GridCell(cloud.points[i], cell_m), side}];
    sum.point += cloud.points[i];
    sum.normal += n;
    ++sum.count;
  }
  PointCloud thinned;
  for (const auto& [at, sum] : cells) {
    thinned.points.push_back(sum.point / sum.count);
    thinned.normals.push_back(sum.normal.normalized());
  }
  return thinned;
}

/// Adds the side below the lowest seen points, and the bottom, both from the hull of the foot
/// points. An object that is hollow from below looks the same from above.
void AddFoot(double spacing_m, PointCloud& thing) {
  const double lowest_m = geometry::BoundsOf(thing.points).min().z();
  geometry::Points feet;
  for (const Eigen::Vector3d& p : thing.points) {
    if (p.z() > kFoot_m) continue;
    feet.emplace_back(p.x(), p.y(), 0.0);
    feet.emplace_back(p.x(), p.y(), lowest_m);
  }
  const PointCloud foot = SampledSurface(geometry::ConvexHull(feet), spacing_m);
  for (std::size_t i = 0; i < foot.size(); ++i) {
    if (foot.normals[i].z() > kFacesUp) continue;
    thing.points.push_back(foot.points[i]);
    thing.normals.push_back(foot.normals[i]);
  }
}

double ShareSeen(const geometry::TriangleMesh& mesh, const PointCloud& thing, double spacing_m) {
  const geometry::KdTree measured(thing.points);
  double seen_m2 = 0.0, all_m2 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& pa = mesh.vertices[a];
    const Eigen::Vector3d& pb = mesh.vertices[b];
    const Eigen::Vector3d& pc = mesh.vertices[c];
    const Eigen::Vector3d middle = (pa + pb + pc) / 3.0;
    const Eigen::Vector3d twice = (pb - pa).cross(pc - pa);
    if (middle.z() < kFoot_m) continue;  // no sensor can see it there
    all_m2 += 0.5 * twice.norm();
    if (measured.CountWithin(middle, kSeen * spacing_m, 1) > 0) seen_m2 += 0.5 * twice.norm();
  }
  return all_m2 > 0.0 ? seen_m2 / all_m2 : 0.0;
}

}  // namespace

LearntModel Learn(const perception::Scene& scene, double spacing_m) {
  const geometry::Plane& table = scene.table.plane;
  const auto R_CT = base::TurnOnto(Eigen::Vector3d::UnitZ(), table.normal).toRotationMatrix();
  const base::Pose X_CT = base::MakePose(R_CT, table.Project(Eigen::Vector3d::Zero()));
  const PointCloud thing = MeanOfEachCell(ThingOf(scene, X_CT), spacing_m);
  if (thing.size() < kMinPoints) {
    throw base::InputError(
        fmt::format("only {} points belong to an object on the table (one per cell of {:g} mm); at "
                    "least {} are needed",
                    thing.size(), spacing_m * 1e3, kMinPoints));
  }
  const double size_m = geometry::BoundsOf(thing.points).sizes().maxCoeff();
  if (size_m > kMaxSize * spacing_m) {
    throw base::InputError(
        fmt::format("the points above the table are {:g} m across, more than {:g} cells of {:g} "
                    "mm: is an outlier among them? --crop excludes it",
                    size_m, kMaxSize, spacing_m * 1e3));
  }
  const std::size_t pieces = scene.objects.size();
  if (pieces > 1 && size_m > kMaxPieces_m) {
    throw base::InputError(fmt::format(
        "{} objects, {:.1f} m wide together, would become one model: use --crop to exclude the "
        "others",
        pieces, size_m));
  }
  PointCloud closed = thing;
  AddFoot(spacing_m, closed);
  auto surface = geometry::PoissonSurface(closed, spacing_m);
  if (!surface) {
    throw base::InputError(fmt::format("no closed surface fits the points of {}{}",
                                       base::Counted(pieces, "object"),
                                       pieces > 1 ? ": --crop excludes others" : ""));
  }
  LearntModel model;
  model.share_seen = ShareSeen(*surface, thing, spacing_m);
  Eigen::Vector3d middle = geometry::BoundsOf(surface->vertices).center();
  middle.z() = 0.0;
  const base::Pose X_TB = base::MakePose(Eigen::Matrix3d::Identity(), middle);
  model.mesh_B = geometry::Transformed(*surface, X_TB.inverse());
  model.X_CB = X_CT * X_TB;
  return model;
}

}  // namespace rangegrasp::recognition
