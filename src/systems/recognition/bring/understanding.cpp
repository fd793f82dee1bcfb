#include "recognition/bring/understanding.h"

#include <algorithm>
#include <set>
#include <utility>

#include "geometry/mesh.h"
#include "grasp/surface.h"

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;
using perception::PerceivedObject;
using perception::Scene;

/// Number of points on a model's surface, as in completion: about 2 mm apart on a cup.
constexpr std::size_t kSurfacePoints = 10000;

/// Replaces a perceived object's surface, and the quantities measured on it, by the model's.
void Complete(const geometry::TriangleMesh& surface_C, const Scene& scene,
              PerceivedObject& object) {
  const geometry::Plane& table = scene.table.plane;
  object.surface_C = surface_C;
  object.completed_C = grasp::SampleSurface(surface_C, kSurfacePoints).points;
  const auto above = [&](const Vector3d& p) { return table.Distance(p); };
  const auto [low, high] = std::ranges::minmax_element(surface_C.vertices, {}, above);
  object.base_m = std::max(0.0, above(*low));
  object.height_m = above(*high);
  object.center_C = geometry::BoundsOf(surface_C.vertices).center();
}

constexpr double kCell_m = 0.010;
constexpr double kLow_m = 0.010;
constexpr double kHigh_m = 0.040;

}  // namespace

void PutKnown(const recognition::FoundObject& found, const geometry::TriangleMesh& mesh_B,
              Understanding& understanding) {
  Scene& scene = understanding.scene;
  const std::set<geometry::SampleId> samples(found.samples.begin(), found.samples.end());
  std::vector<bool> own;  // of the cloud's points
  for (std::uint32_t i = 0; i < scene.cloud.size(); ++i) {
    own.push_back(samples.contains(scene.SampleOf(i)));
  }
  std::vector<std::size_t> shared;
  for (const PerceivedObject& object : scene.objects) {
    const auto count =
        std::ranges::count_if(object.points, [&](std::uint32_t point) { return own[point]; });
    shared.push_back(static_cast<std::size_t>(count));
  }
  const auto most = std::ranges::max_element(shared);
  const bool perceived = most != shared.end() && *most > 0;
  auto place = perceived ? static_cast<std::size_t>(most - shared.begin()) : shared.size();
  PerceivedObject known;
  known.axis_C = scene.table.plane.normal.unitOrthogonal();
  if (perceived) known = scene.objects[place];
  known.points = geometry::PositionsOf(own);
  Complete(geometry::Transformed(mesh_B, found.X_CB), scene, known);
  for (std::size_t i = shared.size(); i-- > 0;) {
    if (2 * shared[i] <= scene.objects[i].points.size()) {
      std::erase_if(scene.objects[i].points, [&](std::uint32_t point) { return own[point]; });
      continue;
    }
    scene.objects.erase(scene.objects.begin() + static_cast<std::ptrdiff_t>(i));
    understanding.found.erase(understanding.found.begin() + static_cast<std::ptrdiff_t>(i));
    if (i < place) --place;
  }
  const auto at = static_cast<std::ptrdiff_t>(std::min(place, scene.objects.size()));
  scene.objects.insert(scene.objects.begin() + at, std::move(known));
  understanding.found.insert(understanding.found.begin() + at, found);
}

std::optional<std::size_t> Understanding::Find(const std::string& object) const {
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] && found[i]->object == object) return i;
  }
  return std::nullopt;
}

Understanding Understand(Scene scene, const std::vector<recognition::FoundObject>& found,
                         const recognition::Library& library) {
  Understanding understanding;
  understanding.scene = std::move(scene);
  understanding.found.resize(understanding.scene.objects.size());
  for (const auto& one : found) PutKnown(one, library.Find(one.object).mesh_B, understanding);
  return understanding;
}

double HidingArea(const geometry::Observation& observation, const Understanding& understanding,
                  const recognition::Library& library, const Vector3d& middle_C, double radius_m) {
  const geometry::SeenSpace space({middle_C + Vector3d(-radius_m, -radius_m, kLow_m),
                                   middle_C + Vector3d(radius_m, radius_m, kHigh_m)},
                                  kCell_m, observation);
  struct Known {
    base::Pose X_BC;
    Eigen::AlignedBox3d box_B;  // grown by half a cell
  };
  std::vector<Known> known;
  const Vector3d grown = Vector3d::Constant(0.5 * kCell_m);
  for (const auto& found : understanding.found) {
    if (!found) continue;
    const auto box_B = geometry::BoundsOf(library.Find(found->object).mesh_B.vertices);
    known.push_back({found->X_CB.inverse(), {box_B.min() - grown, box_B.max() + grown}});
  }
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
    for (int x = 0; x < space.Size().x(); ++x) cells += hides(x, y);
  }
  return cells * kCell_m * kCell_m;
}

double SmallestFootprint(const recognition::KnownObject& object) {
  const Vector3d size = geometry::BoundsOf(object.mesh_B.vertices).sizes();
  return size.prod() / size.maxCoeff();
}

}  // namespace rangegrasp::bring
