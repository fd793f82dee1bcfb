// The engine's options, the table, and what the scanner sees of the arm at home.

#include <fmt/format.h>

#include <cmath>

#include "check/internal/model.h"

namespace rangegrasp::check::internal {
namespace {

constexpr double kTable_m = 1e-3;  // of its top from z = 0
constexpr double kLook_m = 0.5;    // from above the table down to it
constexpr double kMinImpratio = 10.0;
constexpr int kMinNoslip = 10;
// What lies further outside the workspace is not perceived (workspace_margin_mm of experiments).
constexpr double kMargin_m = 0.15;
// Looks over the workspace and above it.
constexpr int kRays = 15;
constexpr double kHeights_m[] = {0.0, 0.15, 0.3, 0.45, 0.6};
constexpr double kMaxHidden = 0.05;  // of the workspace, by the arm at home
constexpr mjtByte kVisibleGroups[mjNGROUP] = {1, 1, 1, 0, 0, 0};

void CheckOptions(Model& model) {
  const mjOption& option = model.m().opt;
  std::string weak;
  const auto add = [&](const std::string& what) { weak += (weak.empty() ? "" : ", ") + what; };
  if (option.cone != mjCONE_ELLIPTIC) add("pyramidal friction cones");
  if (option.impratio < kMinImpratio) add(fmt::format("impratio {:g}", option.impratio));
  if (option.noslip_iterations < kMinNoslip) {
    add(fmt::format("noslip_iterations {}", option.noslip_iterations));
  }
  if (option.integrator != mjINT_IMPLICITFAST) add("an integrator other than implicitfast");
  if (weak.empty()) return;
  model.Error(model.file().string(), "<option>", "has " + weak + ": what the hand holds creeps out",
              "<option timestep=\"0.002\" integrator=\"implicitfast\" solver=\"Newton\" "
              "cone=\"elliptic\" impratio=\"10\" noslip_iterations=\"10\"/>");
}

void CheckTable(Model& model, int workspace) {
  const mjModel& m = model.m();
  const mjtNum* place = model.d().site_xpos + 3 * workspace;
  const mjtNum from[3] = {place[0], place[1], place[2] + kLook_m};
  const mjtNum down[3] = {0.0, 0.0, -1.0};
  double nearest = -1.0;
  for (int g = 0; g < m.ngeom; ++g) {
    if (!model.Collides(g) || m.body_weldid[m.geom_bodyid[g]] != 0) continue;
    const double distance =
        m.geom_type[g] == mjGEOM_MESH
            ? mj_rayMesh(&m, &model.d(), g, from, down, nullptr)
            : mju_rayGeom(model.d().geom_xpos + 3 * g, model.d().geom_xmat + 9 * g,
                          m.geom_size + 3 * g, from, down, m.geom_type[g], nullptr);
    if (distance >= 0.0 && (nearest < 0.0 || distance < nearest)) nearest = distance;
  }
  const std::string where = model.Where(mjOBJ_SITE, workspace);
  const std::string element = model.Element(mjOBJ_SITE, workspace);
  if (std::abs(place[2]) > kTable_m) {
    model.Error(where, element,
                fmt::format("lies at z = {:.4g} m; the table's top is the plane z = 0", place[2]),
                "raise or lower the scene so that the table's top is at z = 0");
  } else if (nearest < 0.0 || std::abs(nearest - kLook_m) > kTable_m) {
    model.Error(where, element, "there is no table below it whose top is at z = 0",
                "<geom type=\"plane\" size=\"0.45 0.62 0.1\" condim=\"6\" friction=\"0.1 0.001 "
                "0.0001\" group=\"3\"/> at z = 0");
  }
  if (m.site_size[3 * workspace] <= 0.0 || m.site_type[workspace] != mjGEOM_CYLINDER) {
    model.Error(where, element, "is no cylinder, whose first size is the workspace's radius",
                "type=\"cylinder\" size=\"0.13 0.0005\"");
  }
}

struct Seen {
  int rays = 0, hidden = 0;  // of those that go to the workspace
  int body = -1;             // that hides it
  int inside = -1;           // a body that stands where objects are looked for
};

Seen LookFrom(Model& model, const mjtNum* eye, const mjtNum* middle, double radius_m) {
  const mjModel& m = model.m();
  Seen seen;
  const double reach_m = radius_m + kMargin_m;
  for (const double height_m : kHeights_m) {
    for (int i = 0; i < kRays * kRays; ++i) {
      const double x = reach_m * (2.0 * (i % kRays) / (kRays - 1) - 1.0);
      const double y = reach_m * (2.0 * (i / kRays) / (kRays - 1) - 1.0);
      if (std::hypot(x, y) > reach_m) continue;
      mjtNum ray[3] = {middle[0] + x - eye[0], middle[1] + y - eye[1],
                       middle[2] + height_m - eye[2]};
      const double length = mju_normalize3(ray);
      int geom = -1;
      const double distance =
          mj_ray(&m, &model.d(), eye, ray, kVisibleGroups, 1, -1, &geom, nullptr);
      const bool robot = geom >= 0 && model.IsRobot(m.geom_bodyid[geom]);
      const bool to_workspace = height_m == 0.0 && std::hypot(x, y) <= radius_m;
      if (to_workspace) ++seen.rays;
      if (!robot) continue;
      if (to_workspace && distance < length) {
        ++seen.hidden;
        seen.body = m.geom_bodyid[geom];
      }
      const double px = eye[0] + distance * ray[0] - middle[0];
      const double py = eye[1] + distance * ray[1] - middle[1];
      if (std::hypot(px, py) < reach_m) seen.inside = m.geom_bodyid[geom];
    }
  }
  return seen;
}

void CheckView(Model& model, int workspace, int scanner) {
  const Seen seen =
      LookFrom(model, model.d().site_xpos + 3 * scanner, model.d().site_xpos + 3 * workspace,
               model.m().site_size[3 * workspace]);
  const std::string where = model.Where(mjOBJ_NUMERIC, model.Find(mjOBJ_NUMERIC, "home"));
  if (seen.inside >= 0) {
    model.Error(where, "numeric \"home\"",
                fmt::format("body \"{}\" is then within {:.0f} mm of the workspace, where the "
                            "scanner takes it for an object",
                            model.BodyName(seen.inside), 1e3 * kMargin_m),
                "a home further back");
  } else if (seen.hidden > kMaxHidden * seen.rays) {
    model.Error(where, "numeric \"home\"",
                fmt::format("body \"{}\" then hides {:.0f} % of the workspace from the scanner",
                            model.BodyName(seen.body), 100.0 * seen.hidden / seen.rays),
                "a home further back");
  }
}

}  // namespace

void CheckCell(Model& model) {
  if (model.kind() != Kind::kScene) return;
  CheckOptions(model);
  const int workspace = model.Find(mjOBJ_SITE, "workspace");
  const int scanner = model.Find(mjOBJ_SITE, "scanner");
  if (workspace < 0) return;
  model.SetHome();
  CheckTable(model, workspace);
  if (scanner >= 0 && !model.home.empty()) CheckView(model, workspace, scanner);
}

}  // namespace rangegrasp::check::internal
