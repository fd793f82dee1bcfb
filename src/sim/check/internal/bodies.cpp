// Masses, inertias and geoms of the arm and the hand.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/check/internal/model.h"

namespace rangegrasp::check::internal {
namespace {

// No link of an arm that stands at a table reaches further from its joint.
constexpr double kMaxLink_m = 3.0;
constexpr double kMillimetres = 0.001;
// Arms of 6 or 7 joints on the market weigh 4 to 300 kg.
constexpr double kMinArm_kg = 0.5;
constexpr double kMaxArm_kg = 1000.0;
// The radius of gyration of a body as a share of how far its geoms reach: of a thin rod 0.58 from
// its end, of a ball 0.63 of its radius; inertia that reaches beyond all geoms is none of theirs.
constexpr double kMaxGyration = 2.0;
constexpr double kMinGyration = 0.02;
constexpr double kSmallBody_m = 0.005;  // of which the shares say nothing
constexpr int kMaxVisibleGroup = 2;     // MuJoCo's viewers and the sensors see groups 0 to 2

std::vector<int> RobotBodies(const Model& model) {
  std::vector<int> bodies;
  for (int body = 1; body < model.m().nbody; ++body) {
    if (model.IsRobot(body)) bodies.push_back(body);
  }
  return bodies;
}

std::vector<int> GeomsOf(const mjModel& m, int body) {
  std::vector<int> geoms;
  for (int g = 0; g < m.body_geomnum[body]; ++g) geoms.push_back(m.body_geomadr[body] + g);
  return geoms;
}

bool IsSeen(const mjModel& m, int geom) {
  return m.geom_group[geom] <= kMaxVisibleGroup && m.geom_rgba[4 * geom + 3] > 0.0F;
}

double Reach(const mjModel& m, int geom) {
  return mju_norm3(m.geom_pos + 3 * geom) + m.geom_rbound[geom];
}

// @return whether meshes are of a size that a robot may have
bool CheckSizes(Model& model, const std::vector<int>& bodies) {
  const mjModel& m = model.m();
  std::set<int> told;
  bool right = true;
  for (const int body : bodies) {
    for (const int geom : GeomsOf(m, body)) {
      if (m.geom_rbound[geom] <= kMaxLink_m) continue;
      right = false;
      const int mesh = m.geom_dataid[geom];
      const bool is_mesh = m.geom_type[geom] == mjGEOM_MESH && mesh >= 0;
      if (is_mesh && !told.insert(mesh).second) continue;
      const std::string what =
          fmt::format("reaches {:.0f} m from its middle: millimetres?", m.geom_rbound[geom]);
      if (is_mesh) {
        model.Error(model.WhereMesh(mesh), model.Element(mjOBJ_MESH, mesh), what,
                    fmt::format("<mesh ... scale=\"{0} {0} {0}\"/> (or in <default> <mesh "
                                "scale=\"{0} {0} {0}\"/> for all)",
                                kMillimetres));
      } else {
        model.Error(model.Where(mjOBJ_GEOM, geom), model.Element(mjOBJ_GEOM, geom), what,
                    "sizes in metres");
      }
    }
  }
  return right;
}

void CheckMasses(Model& model, const std::vector<int>& bodies) {
  const mjModel& m = model.m();
  double total_kg = 0.0;
  for (const int body : bodies) {
    total_kg += m.body_mass[body];
    double reach_m = 0.0;
    for (const int geom : GeomsOf(m, body)) reach_m = std::max(reach_m, Reach(m, geom));
    const mjtNum* inertia = m.body_inertia + 3 * body;
    const double most = std::max({inertia[0], inertia[1], inertia[2]});
    if (m.body_mass[body] <= 0.0 || reach_m < kSmallBody_m) continue;
    const double gyration = std::sqrt(most / m.body_mass[body]) / reach_m;
    if (gyration <= kMaxGyration && gyration >= kMinGyration) continue;
    const std::string what = fmt::format(
        "has an inertia as if its {:.3g} kg lay {:.3g} m from their middle, and its geoms reach "
        "{:.3g} "
        "m",
        m.body_mass[body], gyration * reach_m, reach_m);
    const std::string cure =
        fmt::format("diaginertia=\"{0:.2g} {0:.2g} {0:.2g}\" in its <inertial>",
                    m.body_mass[body] * 0.16 * reach_m * reach_m);
    gyration > kMaxGyration
        ? model.Error(model.Where(mjOBJ_BODY, body), model.Element(mjOBJ_BODY, body), what, cure)
        : model.Warn(model.Where(mjOBJ_BODY, body), model.Element(mjOBJ_BODY, body), what, cure);
  }
  if (!model.HasArm() || (total_kg >= kMinArm_kg && total_kg <= kMaxArm_kg)) return;
  model.Error(model.ArmFile(), "the arm", fmt::format("weighs {:.3g} kg with its hand", total_kg),
              "<inertial mass= pos= diaginertia=/> in each body, in kg and kg m^2, or density= of "
              "its geoms in kg/m^3");
}

void CheckGeoms(Model& model, const std::vector<int>& bodies) {
  const mjModel& m = model.m();
  std::vector<int> bare;
  bool seen = false;
  bool collides = false;
  for (const int body : bodies) {
    const auto geoms = GeomsOf(m, body);
    seen = seen || std::any_of(geoms.begin(), geoms.end(), [&](int g) { return IsSeen(m, g); });
    const bool solid =
        std::any_of(geoms.begin(), geoms.end(), [&](int g) { return model.Collides(g); });
    collides = collides || solid;
    if (!geoms.empty() && !solid) bare.push_back(body);
  }
  const std::string name = model.HasArm() ? "the arm" : "the hand";
  if (!seen) {
    model.Error(model.file().string(), name,
                "has no geom that is seen (groups 0 to 2): sensors and pictures pass it over",
                "group=\"2\" for the geoms that are to be seen");
  }
  if (!collides) {
    model.Error(model.file().string(), name,
                "has no geom that collides: it goes through everything",
                "geoms with group=\"3\" and without contype=\"0\" conaffinity=\"0\"");
  } else if (!bare.empty()) {
    model.Warn(model.Where(mjOBJ_BODY, bare.front()), "bodies " + model.NamesOf(mjOBJ_BODY, bare),
               "have geoms, none of which collides: they go through everything",
               "a capsule or a box with group=\"3\" in each, or contype=\"1\" on one of its geoms");
  }
}

}  // namespace

void CheckBodies(Model& model) {
  const auto bodies = RobotBodies(model);
  if (bodies.empty()) return;
  if (CheckSizes(model, bodies)) CheckMasses(model, bodies);
  CheckGeoms(model, bodies);
}

}  // namespace rangegrasp::check::internal
