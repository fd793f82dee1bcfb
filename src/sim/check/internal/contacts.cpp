// What touches at home, and what touches wherever the arm goes.

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/rng.h"
#include "sim/check/internal/model.h"
#include "sim/check/internal/view.h"

namespace rangegrasp::check::internal {
namespace {

// Poses of the arm that are looked at, drawn from its ranges: what touches in nearly all of them
// does so by the way it is drawn. A pair that touches in nine of ten poses by chance of the draw
// would do so in 95 of 100 once in 60 arms.
constexpr int kPoses = 100;
constexpr double kAlways = 0.95;
// The planner grows arm and hand by this (PlanOptions::collision_margin_m).
constexpr double kMargin_m = 0.003;
constexpr double kTurn_rad = mjPI;  // a continuous joint, to either side

using Pair = std::pair<int, int>;  // bodies, the lower first

// Pairs of bodies, one of them the arm's or the hand's, that are nearer to each other than margin;
// the least distance of each. Not of the hand with itself: its fingers rest on each other.
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

void Pose(Model& model, base::Rng& rng) {
  const mjModel& m = model.m();
  for (const int joint : model.arm_joints) {
    const mjtNum* range = m.jnt_range + 2 * joint;
    const double low = m.jnt_limited[joint] ? range[0] : -kTurn_rad;
    const double high = m.jnt_limited[joint] ? range[1] : kTurn_rad;
    model.d().qpos[m.jnt_qposadr[joint]] = rng.Uniform(low, high);
  }
  mj_kinematics(&model.m(), &model.d());
}

std::string Exclusion(const Model& model, const Pair& pair) {
  const auto name = [&](int body) { return body == 0 ? "world" : model.BodyName(body); };
  return fmt::format("in <contact> of {}: <exclude body1=\"{}\" body2=\"{}\"/>",
                     model.file().string(), name(pair.first), name(pair.second));
}

std::string Both(const Model& model, const Pair& pair) {
  const auto name = [&](int body) { return body == 0 ? "world" : model.BodyName(body); };
  return fmt::format("bodies \"{}\" and \"{}\"", name(pair.first), name(pair.second));
}

}  // namespace

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
    Pose(model, rng);
    for (const auto& [pair, distance_m] : Touching(model, kMargin_m)) ++counts[pair];
  }
  std::copy(margins.begin(), margins.end(), m.geom_margin);
  for (const auto& [pair, count] : counts) {
    if (count < kAlways * kPoses) continue;
    const int body = std::max(pair.first, pair.second);
    model.Error(
        model.Where(mjOBJ_BODY, body), Both(model, pair),
        fmt::format("touch, or come nearer than the planner's {:g} mm, in {} of {} poses of "
                    "the arm",
                    1e3 * kMargin_m, count, kPoses),
        Exclusion(model, pair));
  }
  model.SetHome();
  if (model.home.empty()) return;
  const auto at_home = Touching(model, 0.0);
  const std::string home = at_home.empty() ? "" : SuggestHome(model);
  for (const auto& [pair, distance_m] : at_home) {
    if (counts[pair] >= kAlways * kPoses) continue;
    model.Error(model.Where(mjOBJ_NUMERIC, model.Find(mjOBJ_NUMERIC, "home")), "numeric \"home\"",
                fmt::format("{} are {:.1f} mm inside each other there", Both(model, pair),
                            -1e3 * distance_m),
                (home.empty() ? "another home" : home) + "; or, if they never meet in reality, " +
                    Exclusion(model, pair));
  }
}

}  // namespace rangegrasp::check::internal
