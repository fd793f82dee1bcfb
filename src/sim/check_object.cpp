#include "sim/check_object.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "geometry/hull.h"
#include "geometry/mass_properties.h"
#include "sim/internal/kinematics.h"
#include "sim/internal/scene_builder.h"
#include "sim/internal/visual.h"
#include "sim/resting_poses.h"

namespace rangegrasp::sim {
namespace {

using base::Finding;
using Eigen::Vector3d;

constexpr int kSegments = 32;  // of round primitives

std::string Mm(double length_m) { return fmt::format("{:.4g} mm", length_m * base::kMmPerM); }

double LongestEdge(const geometry::Points& points) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  return points.empty() ? 0.0 : box.sizes().maxCoeff();
}

// A compiled object at its zero pose, and what is wrong with it.
class Checked {
 public:
  Checked(const ObjectModel& object, const ObjectBounds& bounds)
      : object_(object), bounds_(bounds), built_(internal::BuildObject(object)) {
    mjData* data = nullptr;
    internal::CallEngine(nullptr, [&] { data = mj_makeData(model()); });
    data_.reset(data);
    internal::CallEngine(nullptr, [&] {
      mj_kinematics(model(), data);
      mj_comPos(model(), data);
    });
    seen_ = internal::VisualOfTree(model(), data_.get(), root()).mesh_W.vertices;
    for (int geom = 0; geom < model()->ngeom; ++geom) {
      if (!internal::Collides(model(), geom)) continue;
      const auto surface = internal::GeomSurface(model(), geom, kSegments);
      for (const Vector3d& v : surface.vertices) {
        solid_.push_back(internal::GeomPose(data_.get(), geom) * v);
      }
    }
  }

  std::vector<Finding> Findings() {
    CheckSize();
    if (found_.empty()) {
      CheckSeen();
      CheckMass();
      CheckResting();
    }
    CheckConvex();
    CheckSurface();
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Finding& a, const Finding& b) { return a.error && !b.error; });
    return std::move(found_);
  }

 private:
  const mjModel* model() const { return built_.model.get(); }
  int root() const { return built_.objects[0].body; }

  void Say(bool error, const std::string& element, const std::string& what,
           const std::string& cure) {
    found_.push_back({error, object_.mjcf.string(), element, what, cure});
  }
  std::string Body() const {
    return fmt::format("body \"{}\"", mj_id2name(model(), mjOBJ_BODY, root()));
  }

  void CheckSize() {
    const double size = LongestEdge(solid_);
    if (size > bounds_.max_size_m) {
      Say(true, Body(), fmt::format("what collides is {:.4g} m long: a mesh in millimetres?", size),
          "write scale=\"0.001 0.001 0.001\" in each <mesh>, and correct mass and inertia; "
          "`rangegrasp add-object` does all of it");
    } else if (size < bounds_.min_size_m) {
      Say(true, Body(), fmt::format("what collides is {} long: too small for a hand", Mm(size)),
          "write a scale in each <mesh>, e.g. scale=\"1000 1000 1000\"");
    }
  }

  void CheckSeen() {
    if (seen_.empty()) {
      Say(true, Body(), "no geom is seen: sensors see the groups 0 to 2",
          "add <geom group=\"2\" contype=\"0\" conaffinity=\"0\" mass=\"0\" .../> of its shape");
      return;
    }
    const double seen = LongestEdge(seen_), solid = LongestEdge(solid_);
    if (std::abs(seen - solid) <= bounds_.max_mismatch * std::max(seen, solid)) return;
    Say(true, Body(), fmt::format("what is seen is {} long, what collides {}", Mm(seen), Mm(solid)),
        "give both the same shape and, in <mesh>, the same scale");
  }

  void CheckMass() {
    const geometry::TriangleMesh hull = geometry::ConvexHull(solid_);
    const geometry::MassProperties filled = geometry::MassPropertiesOf(hull);
    if (!(filled.volume_m3 > 0.0)) {
      Say(true, Body(), "what collides has no volume", "give it a solid shape");
      return;
    }
    const double mass = model()->body_subtreemass[root()];
    const double density = mass / filled.volume_m3;
    if (density < bounds_.min_density_kg_m3 || density > bounds_.max_density_kg_m3) {
      Say(true, Body(),
          fmt::format("its mass of {:.4g} kg is out of all proportion: {:.3g} kg/m3 in its hull, "
                      "{:g} to {:g} are possible",
                      mass, density, bounds_.min_density_kg_m3, bounds_.max_density_kg_m3),
          "state the mass in kg in <inertial> or in a geom's mass=\"...\"");
      return;
    }
    CheckInertia(mass / filled.volume_m3 * filled.inertia_M, hull);
  }

  // Of one rigid body: others' inertia changes with their joints.
  void CheckInertia(const Eigen::Matrix3d& filled, const geometry::TriangleMesh& hull) {
    if (model()->nbody != root() + 1) return;
    Eigen::Vector3d own = internal::Vec3(model()->body_inertia + 3 * root());
    std::sort(own.data(), own.data() + 3);
    const Eigen::Vector3d even =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(filled).eigenvalues();
    for (int axis = 0; axis < 3; ++axis) {
      const double share = own[axis] / even[axis];
      if (share >= bounds_.min_inertia && share <= bounds_.max_inertia) continue;
      Say(true, Body(),
          fmt::format(
              "its inertia is out of all proportion: a principal moment of {:.3g} kg m2, "
              "{:.3g} of what its hull has where its mass fills it evenly ({:g} to {:g} are "
              "possible)",
              own[axis], share, bounds_.min_inertia, bounds_.max_inertia),
          fmt::format("its hull has diaginertia=\"{:.3g} {:.3g} {:.3g}\"; or leave <inertial> out "
                      "and give the geoms that collide their mass",
                      even[0], even[1], even[2]));
      return;
    }
    geometry::Points with_center = hull.vertices;
    with_center.push_back(internal::CenterOfMass(model(), data_.get(), root()));
    const double inside = geometry::Volume(hull);
    if (geometry::Volume(geometry::ConvexHull(with_center)) <= inside * (1.0 + 1e-6)) return;
    Say(true, Body(), "its center of mass lies outside of what collides",
        "correct pos=\"...\" of <inertial>");
  }

  void CheckResting() {
    if (!StableRestingPoses(object_, bounds_.min_tipping_rad).empty()) return;
    Say(true, Body(),
        fmt::format("it rests nowhere: every pose tips over at less than {:.0f} deg",
                    base::ToDeg(bounds_.min_tipping_rad)),
        "give it a flat side, or lower min_tipping_deg in the experiment");
  }

  void CheckConvex() {
    for (int geom = 0; geom < model()->ngeom; ++geom) {
      if (!internal::Collides(model(), geom) || model()->geom_type[geom] != mjGEOM_MESH) continue;
      const auto mesh = internal::GeomSurface(model(), geom, kSegments);
      const double hull = geometry::Volume(geometry::ConvexHull(mesh.vertices));
      const double share = std::abs(geometry::Volume(mesh)) / hull;
      if (!(share < bounds_.min_convexity)) continue;
      const char* name = mj_id2name(model(), mjOBJ_MESH, model()->geom_dataid[geom]);
      Say(false, fmt::format("mesh \"{}\"", name == nullptr ? "" : name),
          fmt::format("is not convex: it collides as its hull, of which it fills {:.0f} %",
                      100.0 * share),
          "cut it into convex parts: `rangegrasp add-object` does");
    }
  }

  void CheckSurface() {
    if (mj_name2id(model(), mjOBJ_TEXT, "surface") >= 0) return;
    Say(false, Body(), "names no surface: friction and reflection are those of cardboard",
        "write <text name=\"surface\" data=\"plastic\"/> in <custom>, or another of "
        "models/surfaces.yaml");
  }

  const ObjectModel& object_;
  const ObjectBounds& bounds_;
  internal::BuiltScene built_;
  internal::DataPtr data_;
  geometry::Points seen_, solid_;
  std::vector<Finding> found_;
};

}  // namespace

bool IsObjectFile(const std::filesystem::path& mjcf) { return internal::IsObject(mjcf); }

std::vector<Finding> CheckObject(const ObjectModel& object, const ObjectBounds& bounds) {
  try {
    return Checked(object, bounds).Findings();
  } catch (const base::InputError& error) {
    std::string what = error.what();
    const std::string file = object.mjcf.string() + ": ";
    if (what.starts_with(file)) what.erase(0, file.size());
    return {{true, object.mjcf.string(), "object", what,
             "docs/bring-your-own.md shows what an object's file holds"}};
  }
}

}  // namespace rangegrasp::sim
