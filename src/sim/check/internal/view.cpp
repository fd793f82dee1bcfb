#include "sim/check/internal/view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "robot/mjcf/hand_file.h"

namespace rangegrasp::check::internal {
namespace {

// Looks over the workspace and above it, so many a side.
constexpr int kRays = 15;
constexpr double kHeights_m[] = {0.0, 0.15, 0.3, 0.45, 0.6};
constexpr mjtByte kVisibleGroups[mjNGROUP] = {1, 1, 1, 0, 0, 0};

// Of a home pose that is drawn: poses tried, and of these the ones that are looked at closely.
constexpr int kDraws = 40000;
constexpr int kClosely = 400;
constexpr double kDown = 0.5;                  // cosine of the approach's angle from straight down
constexpr double kLow_m = 0.2, kHigh_m = 0.6;  // of the tool's centre above the table
constexpr double kFromLimit_rad = 0.15;        // of joints, from their ranges' ends
// A joint at the end of its range is worth so much way of the hand from the workspace.
constexpr double kBentJoint_m = 0.2;
constexpr double kHandsWidth_m = 0.12;  // that the hand reaches beyond its tool's centre

void Look(Model& model, const mjtNum* eye, const mjtNum* target, bool to_workspace, double reach_m,
          const mjtNum* middle, Seen& seen, int& rays, int& hidden) {
  const mjModel& m = model.m();
  mjtNum ray[3] = {target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]};
  const double length = mju_normalize3(ray);
  int geom = -1;
  const double distance = mj_ray(&m, &model.d(), eye, ray, kVisibleGroups, 1, -1, &geom, nullptr);
  if (to_workspace) ++rays;
  if (geom < 0 || !model.IsRobot(m.geom_bodyid[geom])) return;
  if (to_workspace && distance < length) {
    ++hidden;
    if (!seen.in_the_way) seen.body = m.geom_bodyid[geom];
  }
  const double x = eye[0] + distance * ray[0] - middle[0];
  const double y = eye[1] + distance * ray[1] - middle[1];
  if (std::hypot(x, y) >= reach_m) return;
  seen.in_the_way = true;
  seen.body = m.geom_bodyid[geom];
}

struct Draw {
  double cost;
  std::vector<double> q;
};

void Pose(Model& model, const std::vector<double>& q) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    model.d().qpos[model.m().jnt_qposadr[model.arm_joints[i]]] = q[i];
  }
  mj_kinematics(&model.m(), &model.d());
}

// How far the hand is from where it belongs; negative where the pose is none.
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
    const mjtNum* range = m.jnt_range + 2 * model.arm_joints[i];
    const bool limited = m.jnt_limited[model.arm_joints[i]] != 0;
    const double half = limited ? std::min(0.5 * (range[1] - range[0]), mjPI) : mjPI;
    const double middle_rad = limited ? 0.5 * (range[0] + range[1]) : 0.0;
    bent += std::pow((q[i] - middle_rad) / half, 2);
  }
  return away_m - outside_m + kBentJoint_m * bent;
}

std::vector<double> DrawPose(const Model& model, base::Rng& rng) {
  std::vector<double> q;
  for (const int joint : model.arm_joints) {
    const mjtNum* range = model.m().jnt_range + 2 * joint;
    const bool limited = model.m().jnt_limited[joint] != 0;
    // Within half a turn to either side of zero where there is more.
    const double low = std::max(limited ? range[0] + kFromLimit_rad : -mjPI, -mjPI);
    const double high = std::min(limited ? range[1] - kFromLimit_rad : mjPI, mjPI);
    q.push_back(low < high ? rng.Uniform(low, high) : 0.5 * (range[0] + range[1]));
  }
  return q;
}

bool TouchesAnything(Model& model) {
  const mjModel& m = model.m();
  mj_collision(&m, &model.d());
  for (int i = 0; i < model.d().ncon; ++i) {
    const mjContact& contact = model.d().contact[i];
    if (contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const int a = m.geom_bodyid[contact.geom[0]];
    const int b = m.geom_bodyid[contact.geom[1]];
    const bool in_hand = model.InSubtree(a, model.hand) && model.InSubtree(b, model.hand);
    if (!in_hand && (model.IsRobot(a) || model.IsRobot(b))) return true;
  }
  return false;
}

}  // namespace

Seen LookAtWorkspace(Model& model) {
  Seen seen;
  const int workspace = model.Find(mjOBJ_SITE, "workspace");
  const int scanner = model.Find(mjOBJ_SITE, "scanner");
  if (workspace < 0 || scanner < 0) return seen;
  const mjtNum* eye = model.d().site_xpos + 3 * scanner;
  const mjtNum* middle = model.d().site_xpos + 3 * workspace;
  const double radius_m = model.m().site_size[3 * workspace];
  const double reach_m = radius_m + kPerceived_m;
  int rays = 0;
  int hidden = 0;
  for (const double height_m : kHeights_m) {
    for (int i = 0; i < kRays * kRays; ++i) {
      const double x = reach_m * (2.0 * (i % kRays) / (kRays - 1) - 1.0);
      const double y = reach_m * (2.0 * (i / kRays) / (kRays - 1) - 1.0);
      if (std::hypot(x, y) > reach_m) continue;
      const bool to_workspace = height_m == 0.0 && std::hypot(x, y) <= radius_m;
      const mjtNum target[3] = {middle[0] + x, middle[1] + y, middle[2] + height_m};
      Look(model, eye, target, to_workspace, reach_m, middle, seen, rays, hidden);
    }
  }
  if (rays > 0) seen.hidden = static_cast<double>(hidden) / rays;
  return seen;
}

std::string SuggestHome(Model& model) {
  const int workspace = model.Find(mjOBJ_SITE, "workspace");
  const int tool = mjcf::ToolSite(&model.m(), "tcp_tip");
  if (workspace < 0 || tool < 0 || model.hand < 0 || model.arm_joints.empty()) return "";
  base::Rng rng(1);
  std::vector<Draw> draws;
  for (int i = 0; i < kDraws; ++i) {
    const auto q = DrawPose(model, rng);
    Pose(model, q);
    const double cost = CostOf(model, q, tool, workspace);
    if (cost >= 0.0) draws.push_back({cost, q});
  }
  std::stable_sort(draws.begin(), draws.end(),
                   [](const Draw& a, const Draw& b) { return a.cost < b.cost; });
  std::string found;
  for (std::size_t i = 0; found.empty() && i < draws.size() && i < kClosely; ++i) {
    // What is printed is what is checked.
    std::string values;
    for (double& q : draws[i].q) {
      q = std::round(100.0 * q) / 100.0;
      values += fmt::format("{}{:g}", values.empty() ? "" : " ", q);
    }
    Pose(model, draws[i].q);
    if (TouchesAnything(model)) continue;
    const Seen seen = LookAtWorkspace(model);
    if (!seen.in_the_way && seen.hidden <= kMaxHidden) {
      found = fmt::format("<numeric name=\"home\" data=\"{}\"/>", values);
    }
  }
  model.SetHome();
  return found;
}

}  // namespace rangegrasp::check::internal
