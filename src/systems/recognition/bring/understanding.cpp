#include "recognition/bring/understanding.h"

#include <algorithm>
#include <set>
#include <utility>

#include "grasp/surface.h"

namespace rangegrasp::bring {
namespace {

using Eigen::Vector3d;
using perception::PerceivedObject;
using perception::Scene;

/// Of a model's surface, as completion leaves them: about 2 mm apart on a cup.
constexpr std::size_t kSurfacePoints = 10000;

/// Whether the points of the scene's cloud are of an object's samples, one a point.
std::vector<bool> IsOf(const std::vector<geometry::SampleId>& samples, const Scene& scene) {
  const std::set<geometry::SampleId> wanted(samples.begin(), samples.end());
  std::vector<bool> is_of(scene.cloud.size());
  for (std::uint32_t i = 0; i < is_of.size(); ++i) is_of[i] = wanted.contains(scene.SampleOf(i));
  return is_of;
}

/// What the model tells of a perceived object: its surface, and what is measured on it.
void Complete(const geometry::TriangleMesh& surface_C, const Scene& scene,
              PerceivedObject& object) {
  const geometry::Plane& table = scene.table.plane;
  object.surface_C = surface_C;
  object.completed_C = grasp::SampleSurface(surface_C, kSurfacePoints).points;
  Eigen::AlignedBox3d box_C;
  double low_m = table.Distance(surface_C.vertices.front());
  double high_m = low_m;
  for (const Vector3d& vertex : surface_C.vertices) {
    box_C.extend(vertex);
    low_m = std::min(low_m, table.Distance(vertex));
    high_m = std::max(high_m, table.Distance(vertex));
  }
  object.base_m = std::max(0.0, low_m);
  object.height_m = high_m;
  object.center_C = box_C.center();
}

}  // namespace

void PutKnown(const recognition::FoundObject& found, const geometry::TriangleMesh& mesh_B,
              Understanding& understanding) {
  Scene& scene = understanding.scene;
  const std::vector<bool> own = IsOf(found.samples, scene);
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
  known.points.clear();
  for (std::uint32_t i = 0; i < own.size(); ++i) {
    if (own[i]) known.points.push_back(i);
  }
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

}  // namespace rangegrasp::bring
