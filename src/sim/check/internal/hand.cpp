// What the hand's drives move.

#include "sim/check/internal/hand.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace rangegrasp::check::internal {
namespace {

// Bodies that move with the driven joints: by a joint itself, or by an equality with one that does.
std::set<int> DrivenBodies(const Model& model, const std::vector<int>& joints) {
  const mjModel& m = model.m();
  std::set<int> roots;
  for (const int joint : joints) roots.insert(m.jnt_bodyid[joint]);
  const auto driven = [&](int body) {
    return std::any_of(roots.begin(), roots.end(),
                       [&](int root) { return model.InSubtree(body, root); });
  };
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
      // A linkage moves all from its ground on: the topmost jointed body below the hand.
      const auto top = [&](int body) {
        int jointed = body;
        for (int p = body; p > model.hand; p = m.body_parentid[p]) {
          if (m.body_jntnum[p] > 0) jointed = p;
        }
        return jointed;
      };
      if (driven(a) != driven(b)) grown = roots.insert(driven(a) ? top(b) : top(a)).second || grown;
    }
  }
  return roots;
}

void CheckGearedHand(Model& model) {
  const auto joints = model.Tuple("hand_joints", mjOBJ_JOINT);
  const auto tips = model.Tuple("fingertips", mjOBJ_GEOM);
  if (model.hand < 0 || joints.empty() || tips.empty()) return;
  const mjModel& m = model.m();
  const std::set<int> roots = DrivenBodies(model, joints);
  for (const int joint : joints) {
    if (m.jnt_limited[joint]) continue;
    model.Error(model.Where(mjOBJ_JOINT, joint), model.Element(mjOBJ_JOINT, joint),
                "has no range, so that nothing says where the hand is open and where closed",
                "range=\"OPEN CLOSED\"");
  }
  for (const int geom : tips) {
    const int body = m.geom_bodyid[geom];
    if (!model.Collides(geom)) {
      model.Error(model.Where(mjOBJ_GEOM, geom), model.Element(mjOBJ_GEOM, geom),
                  "is a fingertip that collides with nothing",
                  "remove contype=\"0\" and conaffinity=\"0\"");
    }
    if (std::any_of(roots.begin(), roots.end(),
                    [&](int root) { return model.InSubtree(body, root); })) {
      continue;
    }
    model.Error(model.Where(mjOBJ_GEOM, geom), model.Element(mjOBJ_GEOM, geom),
                fmt::format("is a fingertip on body \"{}\", which none of \"hand_joints\" moves",
                            model.BodyName(body)),
                "list the joint that moves it in \"hand_joints\", or take the geom out of "
                "\"fingertips\"");
  }
}

}  // namespace

void CheckHand(Model& model) {
  if (model.hand < 0) return;
  model.Find(mjOBJ_TUPLE, "hand_motors") >= 0 ? CheckClosing(model) : CheckGearedHand(model);
}

}  // namespace rangegrasp::check::internal
