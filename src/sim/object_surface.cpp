#include "sim/object_surface.h"

#include <utility>

#include "sim/internal/kinematics.h"
#include "sim/internal/scene_builder.h"
#include "sim/internal/visual.h"

namespace rangegrasp::sim {

geometry::ColoredMesh ObjectSurface(const ObjectModel& object) {
  const internal::BuiltScene built = internal::BuildObject(object);
  const mjModel* model = built.model.get();
  const int root = built.objects.front().body;
  mjData* made = nullptr;
  internal::CallEngine(nullptr, [&] { made = mj_makeData(model); });
  const internal::DataPtr data(made);
  internal::CallEngine(nullptr, [&] { mj_kinematics(model, data.get()); });
  VisualMesh visual = internal::VisualOfTree(model, data.get(), root);
  return {geometry::Transformed(visual.mesh_W, internal::BodyPose(data.get(), root).inverse()),
          std::move(visual.colors)};
}

}  // namespace rangegrasp::sim
