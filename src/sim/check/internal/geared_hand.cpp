#include "sim/check/internal/geared_hand.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "robot/mjcf/hand.h"
#include "sim/check/internal/hand.h"

namespace rangegrasp::check::internal {
namespace {

bool BelowAny(const Model& model, int body, const std::set<int>& roots) {
  return std::ranges::any_of(roots, [&](int root) { return model.InSubtree(body, root); });
}

// Bodies that move with the driven joints: by a joint itself, or by an equality with a moving body.
std::set<int> DrivenBodies(const Model& model, const std::vector<int>& joints) {
  const mjModel& m = model.m();
  std::set<int> roots;
  for (const int joint : joints) roots.insert(m.jnt_bodyid[joint]);
  const auto driven = [&](int body) { return BelowAny(model, body, roots); };
  for (bool grown = true; grown;) {
    grown = false;
    for (int e = 0; e < m.neq; ++e) {
      int a = m.eq_obj1id[e];
      int b = m.eq_obj2id[e];
      if (a < 0 || b < 0) continue;
      if (m.eq_type[e] == mjEQ_JOINT) {
        a = m.jnt_bodyid[a];
        b = m.jnt_bodyid[b];
      } else if ((m.eq_type[e] != mjEQ_CONNECT && m.eq_type[e] != mjEQ_WELD) ||
                 m.eq_objtype[e] != mjOBJ_BODY) {
        continue;
      }
      // A linkage moves all bodies from its ground on.
      const auto top = [&](int body) { return mjcf::HandBranch(&m, body, model.hand); };
      if (driven(a) != driven(b)) grown = roots.insert(driven(a) ? top(b) : top(a)).second || grown;
    }
  }
  return roots;
}

}  // namespace

void CheckGearedHand(Model& model) {
  const auto joints = model.Tuple("hand_joints", mjOBJ_JOINT);
  const auto tips = model.Tuple("fingertips", mjOBJ_GEOM);
  if (model.hand < 0 || joints.empty() || tips.empty()) return;
  const mjModel& m = model.m();
  const std::set<int> roots = DrivenBodies(model, joints);
  for (const int joint : joints) {
    if (m.jnt_limited[joint]) continue;
    model.Error(mjOBJ_JOINT, joint,
                "has no range, so that the open and the closed position are unknown",
                "range=\"OPEN CLOSED\"");
  }
  for (const int geom : tips) {
    const int body = m.geom_bodyid[geom];
    CheckCollides(model, geom);
    if (BelowAny(model, body, roots)) continue;
    model.Error(
        mjOBJ_GEOM, geom,
        fmt::format("is a fingertip on body \"{}\", which no joint of \"hand_joints\" moves",
                    model.BodyName(body)),
        "list the joint that moves it in \"hand_joints\", or remove the geom from \"fingertips\"");
  }
}

}  // namespace rangegrasp::check::internal
