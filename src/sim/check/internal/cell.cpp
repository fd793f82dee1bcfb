#include "sim/check/internal/cell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/rng.h"
#include "base/words.h"
#include "robot/mjcf/hand.h"

// Checks of the engine's options, the table, and what the scanner sees of the arm at home.

namespace rangegrasp::check::internal {
namespace {

constexpr double kTable_m = 1e-3;  // distance of its top from z = 0
constexpr double kLook_m = 0.5;    // height above the table from which it is looked for
constexpr double kMinImpratio = 10.0;
constexpr int kMinNoslip = 10;

void CheckOptions(Model& model) {
  const mjOption& option = model.m().opt;
  std::vector<std::string> weak;
  Attributes cure;
  const auto check = [&](bool right, const std::string& what, const char* name, const char* value) {
    if (right) return;
    weak.push_back(what);
    cure.emplace_back(name, value);
  };
  check(option.integrator == mjINT_IMPLICITFAST, "an integrator other than implicitfast",
        "integrator", "implicitfast");
  check(option.cone == mjCONE_ELLIPTIC, "pyramidal friction cones", "cone", "elliptic");
  check(option.impratio >= kMinImpratio, fmt::format("impratio {:g}", option.impratio), "impratio",
        "10");
  check(option.noslip_iterations >= kMinNoslip,
        fmt::format("noslip_iterations {}", option.noslip_iterations), "noslip_iterations", "10");
  if (weak.empty()) return;
  const std::string file = model.file().string();
  model.Error(file, "<option>",
              "has " + base::Join(weak) + ": grasped objects creep out of the hand",
              Cure({base::Edit{.file = file, .element = "/*/option", .set = cure}}));
}

void CheckTable(Model& model, int workspace) {
  const mjModel& m = model.m();
  const mjtNum* place = model.d().site_xpos + 3 * workspace;
  const mjtNum from[3] = {place[0], place[1], place[2] + kLook_m};
  const mjtNum down[3] = {0.0, 0.0, -1.0};
  // An open box for objects stands on the table.
  const int container = model.Find(mjOBJ_SITE, "container");
  const int box = container < 0 ? -1 : m.site_bodyid[container];
  double nearest = -1.0;
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    if (!model.Collides(g) || m.body_weldid[body] != 0 || body == box) continue;
    const double distance =
        m.geom_type[g] == mjGEOM_MESH
            ? mj_rayMesh(&m, &model.d(), g, from, down, nullptr)
            : mju_rayGeom(model.d().geom_xpos + 3 * g, model.d().geom_xmat + 9 * g,
                          m.geom_size + 3 * g, from, down, m.geom_type[g], nullptr);
    if (distance >= 0.0 && (nearest < 0.0 || distance < nearest)) nearest = distance;
  }
  if (std::abs(place[2]) > kTable_m) {
    model.Error(mjOBJ_SITE, workspace,
                fmt::format("is at z = {:.4g} m; the table's top is the plane z = 0", place[2]),
                "raise or lower the scene so that the table's top is at z = 0");
  } else if (nearest < 0.0 || std::abs(nearest - kLook_m) > kTable_m) {
    model.Error(mjOBJ_SITE, workspace, "no table below it has its top at z = 0",
                "<geom type=\"plane\" size=\"0.45 0.62 0.1\" condim=\"6\" friction=\"0.1 0.001 "
                "0.0001\" group=\"3\"/> at z = 0");
  }
  if (m.site_size[3 * workspace] <= 0.0 || m.site_type[workspace] != mjGEOM_CYLINDER) {
    model.Error(mjOBJ_SITE, workspace,
                "is not a cylinder; its first size is the workspace's radius",
                model.Set(mjOBJ_SITE, workspace, {{"type", "cylinder"}, {"size", "0.13 0.0005"}}));
  }
}

// Objects further outside the workspace are not perceived (workspace_margin_mm of experiments).
constexpr double kPerceived_m = 0.15;
constexpr double kMaxHidden = 0.05;  // share of the workspace that the arm at home may hide
// Rays over and above the workspace: number per side, and heights.
constexpr int kRays = 15;
constexpr double kHeights_m[] = {0.0, 0.15, 0.3, 0.45, 0.6};
constexpr mjtByte kVisibleGroups[mjNGROUP] = {1, 1, 1, 0, 0, 0};

/// What the scanner sees of the arm at its present joint positions.
struct Seen {
  double hidden = 0.0;      ///< share of the workspace that the arm hides
  bool in_the_way = false;  ///< a part of the arm is where objects are looked for
  int body = -1;            ///< the body in the way, or that hides the workspace

  bool IsFree() const { return !in_the_way && hidden <= kMaxHidden; }
};

// Sees nothing without the sites "workspace" and "scanner".
Seen LookAtWorkspace(Model& model) {
  Seen seen;
  const int workspace = model.Find(mjOBJ_SITE, "workspace");
  const int scanner = model.Find(mjOBJ_SITE, "scanner");
  if (workspace < 0 || scanner < 0) return seen;
  const mjtNum* eye = model.d().site_xpos + 3 * scanner;
  const mjtNum* middle = model.d().site_xpos + 3 * workspace;
  const double radius_m = model.m().site_size[3 * workspace];
  const double reach_m = radius_m + kPerceived_m;
  const mjModel& m = model.m();
  int rays = 0;
  int hidden = 0;
  for (const double height_m : kHeights_m) {
    for (int i = 0; i < kRays * kRays; ++i) {
      const double x = reach_m * (2.0 * (i % kRays) / (kRays - 1) - 1.0);
      const double y = reach_m * (2.0 * (i / kRays) / (kRays - 1) - 1.0);
      if (std::hypot(x, y) > reach_m) continue;
      const bool to_workspace = height_m == 0.0 && std::hypot(x, y) <= radius_m;
      mjtNum ray[3] = {middle[0] + x - eye[0], middle[1] + y - eye[1],
                       middle[2] + height_m - eye[2]};
      const double length = mju_normalize3(ray);
      int geom = -1;
      const double distance =
          mj_ray(&m, &model.d(), eye, ray, kVisibleGroups, 1, -1, &geom, nullptr);
      rays += to_workspace;
      if (geom < 0 || !model.IsRobot(m.geom_bodyid[geom])) continue;
      if (to_workspace && distance < length) {
        ++hidden;
        if (!seen.in_the_way) seen.body = m.geom_bodyid[geom];
      }
      const double hit_x = eye[0] + distance * ray[0] - middle[0];
      const double hit_y = eye[1] + distance * ray[1] - middle[1];
      if (std::hypot(hit_x, hit_y) >= reach_m) continue;
      seen.in_the_way = true;
      seen.body = m.geom_bodyid[geom];
    }
  }
  if (rays > 0) seen.hidden = static_cast<double>(hidden) / rays;
  return seen;
}

void CheckView(Model& model) {
  const Seen seen = LookAtWorkspace(model);
  if (seen.IsFree()) return;
  const std::string what =
      seen.in_the_way
          ? fmt::format(
                "at home is within {:.0f} mm of the workspace, where it is perceived as an object",
                1e3 * kPerceived_m)
          : fmt::format("at home hides {:.0f} % of the workspace from the scanner",
                        100.0 * seen.hidden);
  const Cure home = SuggestHome(model);
  model.Error(mjOBJ_NUMERIC, "home", fmt::format("body \"{}\" {}", model.BodyName(seen.body), what),
              home.empty() ? Cure("a home position further back") : home);
}

// No link of an arm at a table reaches further from its joint.
constexpr double kMaxLink_m = 3.0;
constexpr double kMillimetres = 0.001;
// Arms of 6 or 7 joints on the market weigh 4 to 300 kg.
constexpr double kMinArm_kg = 0.5;
constexpr double kMaxArm_kg = 1000.0;
// The radius of gyration of a body as a share of its geoms' reach: 0.58 for a thin rod from its
// end, 0.63 for a ball. Inertia that reaches beyond all geoms does not belong to them.
constexpr double kMaxGyration = 2.0;
constexpr double kMinGyration = 0.02;
constexpr double kSmallBody_m = 0.005;  // for which the shares mean nothing
constexpr int kMaxVisibleGroup = 2;     // MuJoCo's viewers and the sensors see groups 0 to 2

std::vector<int> GeomsOf(const mjModel& m, int body) {
  std::vector<int> geoms;
  for (int g = 0; g < m.body_geomnum[body]; ++g) geoms.push_back(m.body_geomadr[body] + g);
  return geoms;
}

// @return whether meshes are of a size that a robot may have
bool CheckSizes(Model& model, const std::vector<int>& bodies) {
  const mjModel& m = model.m();
  std::set<int> reported;
  bool right = true;
  for (const int body : bodies) {
    for (const int geom : GeomsOf(m, body)) {
      if (m.geom_rbound[geom] <= kMaxLink_m) continue;
      right = false;
      const int mesh = m.geom_dataid[geom];
      const bool is_mesh = m.geom_type[geom] == mjGEOM_MESH && mesh >= 0;
      if (is_mesh && !reported.insert(mesh).second) continue;
      const std::string what = fmt::format(
          "reaches {:.0f} m from its middle: is it in millimetres?", m.geom_rbound[geom]);
      if (is_mesh) {
        const Eigen::Vector3d scale = kMillimetres * mjcf::Vec3(m.mesh_scale + 3 * mesh);
        model.Error(
            mjOBJ_MESH, mesh, what,
            model.Set(mjOBJ_MESH, mesh,
                      {{"scale", fmt::format("{:g} {:g} {:g}", scale[0], scale[1], scale[2])}}) +
                " (or in <default> <mesh .../> for all)");
      } else {
        model.Error(mjOBJ_GEOM, geom, what, "give the sizes in metres");
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
    for (const int geom : GeomsOf(m, body)) {
      reach_m = std::max(reach_m, mju_norm3(m.geom_pos + 3 * geom) + m.geom_rbound[geom]);
    }
    const double most = mjcf::Vec3(m.body_inertia + 3 * body).maxCoeff();
    if (m.body_mass[body] <= 0.0 || reach_m < kSmallBody_m) continue;
    const double gyration = std::sqrt(most / m.body_mass[body]) / reach_m;
    if (gyration <= kMaxGyration && gyration >= kMinGyration) continue;
    model.Report(gyration > kMaxGyration, mjOBJ_BODY, body,
                 fmt::format("has the inertia of {:.3g} kg at {:.3g} m from the center, but its "
                             "geoms reach {:.3g} m",
                             m.body_mass[body], gyration * reach_m, reach_m),
                 fmt::format("diaginertia=\"{0:.2g} {0:.2g} {0:.2g}\" in its <inertial>",
                             m.body_mass[body] * 0.16 * reach_m * reach_m));
  }
  if (!model.HasArm() || (total_kg >= kMinArm_kg && total_kg <= kMaxArm_kg)) return;
  model.Error(model.ArmFile(), "the arm",
              fmt::format("has an implausible mass of {:.3g} kg, including its hand", total_kg),
              "<inertial mass= pos= diaginertia=/> in each body, in kg and kg m^2, or density= of "
              "its geoms in kg/m^3");
}

void CheckGeoms(Model& model, const std::vector<int>& bodies) {
  const mjModel& m = model.m();
  std::vector<int> bare;
  bool seen = false, collides = false;
  for (const int body : bodies) {
    const auto geoms = GeomsOf(m, body);
    seen = seen || std::ranges::any_of(geoms, [&](int g) {
             return m.geom_group[g] <= kMaxVisibleGroup && m.geom_rgba[4 * g + 3] > 0.0F;
           });
    const bool solid = std::ranges::any_of(geoms, [&](int g) { return model.Collides(g); });
    collides = collides || solid;
    if (!geoms.empty() && !solid) bare.push_back(body);
  }
  const std::string name = model.HasArm() ? "the arm" : "the hand";
  if (!seen) {
    model.Error(model.file().string(), name,
                "has no visible geom (groups 0 to 2): sensors and pictures do not show it",
                "group=\"2\" for the visible geoms");
  }
  if (!collides) {
    model.Error(model.file().string(), name, "has no collision geom: it passes through everything",
                "geoms with group=\"3\" and without contype=\"0\" conaffinity=\"0\"");
  } else if (!bare.empty()) {
    model.Warn(mjOBJ_BODY, bare, "have no collision geoms: they pass through everything",
               "a capsule or a box with group=\"3\" in each, or contype=\"1\" on one of its geoms");
  }
}

// A pair that touches in nearly all of these random poses does so because of the modelling. A pair
// that touches in nine of ten poses would do so in 95 of 100 for one of 60 arms.
constexpr int kPoses = 100;
constexpr double kAlways = 0.95;
// The planner grows arm and hand by this margin (PlanOptions::collision_margin_m).
constexpr double kMargin_m = 0.003;

using Pair = std::pair<int, int>;  // bodies, the lower first

// Pairs of bodies closer than the margin, at least one of them of the robot, with their distance.
// Pairs within the hand do not count: its fingers rest on each other.
std::map<Pair, double> Touching(Model& model, double margin_m) {
  const mjModel& m = model.m();
  std::map<Pair, double> pairs;
  mj_collision(&model.m(), &model.d());
  for (int i = 0; i < model.d().ncon; ++i) {
    const mjContact& contact = model.d().contact[i];
    if (contact.geom[0] < 0 || contact.geom[1] < 0 || contact.dist > margin_m) continue;
    const int a = m.geom_bodyid[contact.geom[0]];
    const int b = m.geom_bodyid[contact.geom[1]];
    const bool in_hand =
        model.hand > 0 && model.InSubtree(a, model.hand) && model.InSubtree(b, model.hand);
    if (in_hand || (!model.IsRobot(a) && !model.IsRobot(b))) continue;
    auto [pair, is_new] = pairs.try_emplace(Pair(std::min(a, b), std::max(a, b)), contact.dist);
    if (!is_new) pair->second = std::min(pair->second, contact.dist);
  }
  return pairs;
}

// Search for a home pose: number of random poses, and of those that are checked closely.
constexpr int kDraws = 40000;
constexpr int kClosely = 400;
constexpr double kDown = 0.5;                  // cosine of the approach's angle from straight down
constexpr double kLow_m = 0.2, kHigh_m = 0.6;  // of the tool's centre above the table
constexpr double kFromLimit_rad = 0.15;        // distance of joints from their ranges' ends
// A joint at an end of its range costs as much as this distance of the hand from the workspace.
constexpr double kBentJoint_m = 0.2;
constexpr double kHandsWidth_m = 0.12;  // that the hand reaches beyond its tool's centre

struct Draw {
  double cost;
  std::vector<double> q;
};

void DrawAnyPose(Model& model, base::Rng& rng) {
  std::vector<double> q;
  for (const int joint : model.arm_joints) {
    const auto [low, high] = model.RangeOf(joint, mjPI);
    q.push_back(rng.Uniform(low, high));
  }
  model.SetArm(q.data());
}

// Cost of a pose: the hand's distance and the joints' bends; negative if it is not allowed.
double CostOf(Model& model, const std::vector<double>& q, int tool, int workspace) {
  const mjModel& m = model.m();
  const mjtNum* at = model.d().site_xpos + 3 * tool;
  const mjtNum* middle = model.d().site_xpos + 3 * workspace;
  const double down = -model.d().site_xmat[9 * tool + 8];
  const double away_m = std::hypot(at[0] - middle[0], at[1] - middle[1]);
  const double outside_m = m.site_size[3 * workspace] + kPerceived_m + kHandsWidth_m;
  if (down < kDown || at[2] < kLow_m || at[2] > kHigh_m || away_m < outside_m) return -1.0;
  double bent = 0.0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const auto [low, high] = model.RangeOf(model.arm_joints[i], mjPI);
    bent += std::pow((q[i] - 0.5 * (low + high)) / std::min(0.5 * (high - low), mjPI), 2);
  }
  return away_m - outside_m + kBentJoint_m * bent;
}

std::vector<double> DrawPose(const Model& model, base::Rng& rng) {
  std::vector<double> q;
  for (const int joint : model.arm_joints) {
    // At most half a turn to either side of zero.
    const auto [first, last] = model.RangeOf(joint, 2.0 * mjPI);
    const double low = std::max(first + kFromLimit_rad, -mjPI);
    const double high = std::min(last - kFromLimit_rad, mjPI);
    q.push_back(low < high ? rng.Uniform(low, high) : 0.5 * (first + last));
  }
  return q;
}

}  // namespace

void CheckCell(Model& model) {
  if (model.kind() != Kind::kScene) return;
  CheckOptions(model);
  const int workspace = model.Find(mjOBJ_SITE, "workspace");
  if (workspace < 0) return;
  model.SetHome();
  CheckTable(model, workspace);
  if (!model.home.empty()) CheckView(model);
}

void CheckBodies(Model& model) {
  const auto bodies = model.RobotBodies();
  if (bodies.empty()) return;
  if (CheckSizes(model, bodies)) CheckMasses(model, bodies);
  CheckGeoms(model, bodies);
}

void CheckContacts(Model& model) {
  if (model.arm_joints.empty()) return;
  mjModel& m = model.m();
  const std::vector<mjtNum> margins(m.geom_margin, m.geom_margin + m.ngeom);
  for (int g = 0; g < m.ngeom; ++g) {
    if (model.IsRobot(m.geom_bodyid[g])) m.geom_margin[g] = std::max(m.geom_margin[g], kMargin_m);
  }
  std::map<Pair, int> counts;
  base::Rng rng(1);
  for (int i = 0; i < kPoses; ++i) {
    DrawAnyPose(model, rng);
    for (const auto& [pair, distance_m] : Touching(model, kMargin_m)) ++counts[pair];
  }
  std::ranges::copy(margins, m.geom_margin);
  for (const auto& [pair, count] : counts) {
    if (count < kAlways * kPoses) continue;
    model.Error(
        model.Where(mjOBJ_BODY, pair.second), model.BothNames(pair.first, pair.second),
        fmt::format("touch, or come nearer than the planner's {:g} mm, in {} of {} poses of "
                    "the arm",
                    1e3 * kMargin_m, count, kPoses),
        model.Exclude(pair.first, pair.second));
  }
  model.SetHome();
  if (model.home.empty()) return;
  const auto at_home = Touching(model, 0.0);
  const Cure home = at_home.empty() ? Cure() : SuggestHome(model);
  for (const auto& [pair, distance_m] : at_home) {
    if (counts[pair] >= kAlways * kPoses) continue;
    model.Error(mjOBJ_NUMERIC, "home",
                fmt::format("{} overlap by {:.1f} mm there",
                            model.BothNames(pair.first, pair.second), -1e3 * distance_m),
                (home.empty() ? Cure("another home position") : home) +
                    "; or, if they never meet in reality, " +
                    model.Exclude(pair.first, pair.second).edits.front().block);
  }
}

Cure SuggestHome(Model& model) {
  const int workspace = model.Find(mjOBJ_SITE, "workspace");
  const int tool = model.Find(mjOBJ_SITE, "tcp");
  if (workspace < 0 || tool < 0 || model.hand < 0 || model.arm_joints.empty()) return "";
  base::Rng rng(1);
  std::vector<Draw> draws;
  for (int i = 0; i < kDraws; ++i) {
    const auto q = DrawPose(model, rng);
    model.SetArm(q.data());
    const double cost = CostOf(model, q, tool, workspace);
    if (cost >= 0.0) draws.push_back({cost, q});
  }
  std::ranges::stable_sort(draws, {}, &Draw::cost);
  Cure found;
  for (std::size_t i = 0; found.empty() && i < draws.size() && i < kClosely; ++i) {
    // Checks the rounded values that are printed.
    for (double& q : draws[i].q) q = std::round(100.0 * q) / 100.0;
    model.SetArm(draws[i].q.data());
    if (Touching(model, mjMAXVAL).empty() && LookAtWorkspace(model).IsFree()) {
      found = model.SetNumeric("home", fmt::format("{:g}", fmt::join(draws[i].q, " ")),
                               model.file().string());
    }
  }
  model.SetHome();
  return found;
}

}  // namespace rangegrasp::check::internal
