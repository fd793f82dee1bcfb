#include "sim/bodies.h"

#include <algorithm>
#include <set>
#include <utility>

#include "sim/internal/engine.h"
#include "sim/internal/scene_builder.h"

namespace rangegrasp::sim {
namespace {

constexpr int kCapsuleSegments = 20;  // for round primitives: pages are for viewing, not measuring

// From the model, so that the bytes do not depend on the body's pose.
base::Pose InBody(const mjModel* model, int geom) {
  const mjtNum* q = model->geom_quat + 4 * geom;
  return base::MakePose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
                        internal::Vec3(model->geom_pos + 3 * geom));
}

bool HasEnd(const mjModel* model, int geom) {
  const mjtNum* size = model->geom_size + 3 * geom;
  return model->geom_type[geom] != mjGEOM_PLANE || (size[0] > 0 && size[1] > 0);
}

}  // namespace

std::vector<VisualBody> VisualBodies(const World& world) {
  const mjModel* model = world.model();
  std::set<int> objects, parked;  // root bodies
  for (int object = 0; object < world.objects(); ++object) {
    (world.parked(object) ? parked : objects).insert(world.object_body(object));
  }
  internal::ColorsOfGeoms colors(model);
  std::vector<VisualBody> bodies;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    const int body = model->geom_bodyid[geom];
    const int root = model->body_rootid[body];
    if (parked.contains(root) || !internal::Visible(model, geom) || !HasEnd(model, geom)) continue;
    const Eigen::Vector4f color = colors.Of(geom);
    auto drawn = std::ranges::find_if(
        bodies, [&](const VisualBody& one) { return one.body == body && one.color == color; });
    if (drawn == bodies.end()) {
      drawn = bodies.insert(drawn, {body,
                                    std::string(mjcf::NameOf(model, mjOBJ_BODY, body)),
                                    {},
                                    color,
                                    objects.contains(root)});
    }
    geometry::Append(geometry::Transformed(internal::GeomSurface(model, geom, kCapsuleSegments),
                                           InBody(model, geom)),
                     drawn->mesh_B);
  }
  return bodies;
}

base::Pose BodyPose(const World& world, int body) { return internal::BodyPose(world.data(), body); }

std::vector<ContactForce> HandForces(const World& world, double min_N) {
  const mjModel* model = world.model();
  const mjData* data = world.data();
  const int hand = internal::Find(model, mjOBJ_BODY, "hand");
  const auto of_hand = [&](int geom) {
    return geom >= 0 && internal::InSubtree(model, model->geom_bodyid[geom], hand);
  };
  std::vector<ContactForce> forces;
  for (int i = 0; i < data->ncon; ++i) {
    const mjContact& contact = data->contact[i];
    const bool first = of_hand(contact.geom[0]);
    if (first == of_hand(contact.geom[1])) continue;
    mjtNum force_K[6] = {0};  // in the contact's frame, whose axes are the rows of `frame`
    mj_contactForce(model, data, i, force_K);
    // The engine gives the force of the first geom on the second.
    const Eigen::Vector3d force_W =
        (first ? 1.0 : -1.0) * (mjcf::Mat3(contact.frame).transpose() * internal::Vec3(force_K));
    if (force_W.norm() > min_N) forces.push_back({internal::Vec3(contact.pos), force_W});
  }
  return forces;
}

geometry::ColoredMesh ObjectSurface(const ObjectModel& object) {
  const internal::BuiltScene built = internal::BuildObject(object);
  const mjModel* model = built.model.get();
  const int root = built.objects.front().body;
  const internal::DataPtr data = internal::DataAtZero(model);
  internal::ColorsOfGeoms colors(model);
  VisualMesh visual = internal::VisualOfTree(model, data.get(), root, colors);
  return {geometry::Transformed(visual.mesh_W, internal::BodyPose(data.get(), root).inverse()),
          std::move(visual.colors)};
}

}  // namespace rangegrasp::sim
