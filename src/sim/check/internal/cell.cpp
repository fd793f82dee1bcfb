// The engine's options, the table, and what the scanner sees of the arm at home.

#include <fmt/format.h>

#include <cmath>

#include "sim/check/internal/model.h"
#include "sim/check/internal/view.h"

namespace rangegrasp::check::internal {
namespace {

constexpr double kTable_m = 1e-3;  // of its top from z = 0
constexpr double kLook_m = 0.5;    // from above the table down to it
constexpr double kMinImpratio = 10.0;
constexpr int kMinNoslip = 10;
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

void CheckView(Model& model) {
  const Seen seen = LookAtWorkspace(model);
  if (!seen.in_the_way && seen.hidden <= kMaxHidden) return;
  const std::string what =
      seen.in_the_way
          ? fmt::format(
                "is then within {:.0f} mm of the workspace, where the scanner takes it for an "
                "object",
                1e3 * kPerceived_m)
          : fmt::format("then hides {:.0f} % of the workspace from the scanner",
                        100.0 * seen.hidden);
  const auto home = SuggestHome(model);
  model.Error(model.Where(mjOBJ_NUMERIC, model.Find(mjOBJ_NUMERIC, "home")), "numeric \"home\"",
              fmt::format("body \"{}\" {}", model.BodyName(seen.body), what),
              home.empty() ? "a home further back" : home);
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

}  // namespace rangegrasp::check::internal
