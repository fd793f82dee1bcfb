#include "robot/internal/mjcf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.h"
#include "base/process/program.h"
#include "base/words.h"
#include "robot/mjcf/files.h"

namespace rangegrasp::robot::internal {
namespace {

using Eigen::Vector3d;

// While it exists, the engine neither prints nor logs warnings: the simulation reports them.
class QuietEngine {
 public:
  QuietEngine() : before_(mju_setLogHandler([](const mjLogMessage*) {})) {}
  ~QuietEngine() { mju_setLogHandler(before_); }
  QuietEngine(const QuietEngine&) = delete;
  QuietEngine& operator=(const QuietEngine&) = delete;

 private:
  mjfLogHandler before_;
};

/// Number of states from open to closed: the gap of a hand that opens 100 mm changes by 4 to 5 mm
/// per state. With more, grasps are checked at more openings, and height fields take more time.
constexpr int kStates = 24;
/// Bisections for the share of the range at which the pads touch, to 2^-30.
constexpr int kBisections = 30;
/// Step of the finite difference for a spring's stiffness; springs are linear.
constexpr double kProbe_rad = 1e-3;
constexpr double kMinStiffness = 1e-9;  ///< [N m / rad] less is no spring

/// Roles of the hand's geoms and joints.
struct Parts {
  int body = -1;
  std::vector<int> driven, passive;          // joints
  std::vector<int> geoms;                    // that collide
  std::vector<int> fingertips;               // geoms that may hold an object
  mjcf::LastSegments tips;                   // among them
  int thumb_root = -1;                       // body
  std::optional<mjcf::HandClosing> closing;  // of a hand that states how it closes
  /// Sites at the tips with a tool centre between them, the thumb's first; may be empty.
  std::vector<int> tip_sites, power_sites;
};

bool Holds(const std::vector<int>& ids, int id) { return std::ranges::find(ids, id) != ids.end(); }

Parts FindParts(const Mjcf& mjcf, int hand_body) {
  const mjModel& m = mjcf.model();
  Parts parts;
  parts.body = hand_body;
  parts.fingertips = mjcf.Tuple("fingertips", mjOBJ_GEOM);
  if (mjcf::HasMotors(&m)) {
    parts.closing = mjcf::CloseOnNothing(&m);
  } else {
    parts.driven = mjcf.Tuple("hand_joints", mjOBJ_JOINT);
  }
  parts.thumb_root = mjcf::ThumbRoot(&m);
  parts.tip_sites = mjcf.TupleIfAny("tip_grasp_tips", mjOBJ_SITE);
  parts.power_sites = mjcf.TupleIfAny("power_grasp_tips", mjOBJ_SITE);
  for (int j = 0; j < m.njnt; ++j) {
    if (!Holds(parts.driven, j) && mjcf.InSubtree(m.jnt_bodyid[j], hand_body)) {
      parts.passive.push_back(j);
    }
  }
  for (int g = 0; g < m.ngeom; ++g) {
    if (mjcf.Collides(g) && mjcf.InSubtree(m.geom_bodyid[g], hand_body)) parts.geoms.push_back(g);
  }
  parts.tips = mjcf::LastSegmentsOf(&m);
  if (parts.tips.thumb.empty() || parts.tips.fingers.empty()) {
    mjcf.Fail(parts.closing ? "tuple \"fingertips\" needs geoms of two fingers, the thumb's first"
                            : "tuple \"fingertips\" needs the last segments of the thumb (the "
                              "first of \"hand_joints\") and of a finger");
  }
  return parts;
}

/// q1 = q1_0 + polynomial(q2 - q2_0) for each joint equality.
void ApplyEqualities(const mjModel& m, mjData& d) {
  for (int e = 0; e < m.neq; ++e) {
    if (m.eq_type[e] != mjEQ_JOINT || m.eq_obj2id[e] < 0) continue;
    const int a = m.jnt_qposadr[m.eq_obj1id[e]];
    const int b = m.jnt_qposadr[m.eq_obj2id[e]];
    const double x = d.qpos[b] - m.qpos0[b];
    const mjtNum* c = m.eq_data + e * mjNEQDATA;
    d.qpos[a] = m.qpos0[a] + c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])));
  }
}

double SpringForce(const mjModel& m, mjData& d, int joint) {
  mj_fwdPosition(&m, &d);
  mj_fwdVelocity(&m, &d);
  return d.qfrc_spring[m.jnt_dofadr[joint]];
}

/// Moves a passive joint to where its linear springs' force is zero (one Newton step), within its
/// range; without a spring, to the same share of its range.
void RelaxPassive(const mjModel& m, mjData& d, int joint, double fraction) {
  mjtNum& q = d.qpos[m.jnt_qposadr[joint]];
  const double lower = m.jnt_range[2 * joint];
  const double upper = m.jnt_range[2 * joint + 1];
  q = lower;
  const double force = SpringForce(m, d, joint);
  q = lower + kProbe_rad;
  const double stiffness = (force - SpringForce(m, d, joint)) / kProbe_rad;
  q = stiffness > kMinStiffness ? std::clamp(lower + force / stiffness, lower, upper)
                                : lower + fraction * (upper - lower);
}

void SetClosing(const Mjcf& mjcf, const Parts& parts, double fraction) {
  const mjModel& m = mjcf.model();
  mjData& d = mjcf.data();
  if (parts.closing) {
    parts.closing->Pose(&m, &d, fraction);
  } else {
    for (int j : parts.driven) {
      d.qpos[m.jnt_qposadr[j]] =
          m.jnt_range[2 * j] + fraction * (m.jnt_range[2 * j + 1] - m.jnt_range[2 * j]);
    }
    ApplyEqualities(m, d);
    for (int j : parts.passive) RelaxPassive(m, d, j, fraction);
  }
  mj_kinematics(&m, &d);
}

double Gap(const Mjcf& mjcf, const Parts& parts) {
  return mjcf::GapOf(&mjcf.model(), &mjcf.data(), parts.tips);
}

/// Points on the hand's surface that move with their geoms: geom, point in its frame.
using PadPoints = std::vector<std::pair<int, Vector3d>>;
struct Pads {
  PadPoints thumb, fingers;
};

Vector3d Mean_W(const Mjcf& mjcf, const PadPoints& points) {
  Vector3d sum_W = Vector3d::Zero();
  for (const auto& [geom, p_S] : points) sum_W += mjcf.GeomPose(geom) * p_S;
  return sum_W / static_cast<double>(points.size());
}

/// How far a geom reaches along the unit vector n_W.
double Reach(const Mjcf& mjcf, int geom, const Vector3d& n_W) {
  return geometry::Support(mjcf.ShapeOf(geom, mjcf.GeomPose(geom)), base::Pose::Identity(), n_W);
}

/// The middle of a geom's side in a direction: for two flat pads, the engine gives arbitrary
/// nearest points.
Vector3d MiddleOfSide_S(const Mjcf& mjcf, int geom, const Vector3d& direction_W) {
  const base::Pose X_WS = mjcf.GeomPose(geom);
  const double half_m = Reach(mjcf, geom, direction_W) - direction_W.dot(X_WS.translation());
  return X_WS.linear().transpose() * (half_m * direction_W);
}

/// Where the last segments are nearest to each other at the present closing; for a hand that states
/// how it closes, the middles of the sides that face each other.
Pads FacingPoints(const Mjcf& mjcf, const Parts& parts, const Vector3d& x_W) {
  Pads pads;
  if (parts.closing) {
    for (const int g : parts.tips.thumb) pads.thumb.emplace_back(g, MiddleOfSide_S(mjcf, g, -x_W));
    for (const int g : parts.tips.fingers) {
      pads.fingers.emplace_back(g, MiddleOfSide_S(mjcf, g, x_W));
    }
    return pads;
  }
  for (int finger : parts.tips.fingers) {
    for (int thumb : parts.tips.thumb) {
      mjtNum line[6];
      mj_geomDistance(&mjcf.model(), &mjcf.data(), thumb, finger, mjcf::kFarApart_m, line);
      pads.thumb.emplace_back(thumb, mjcf.GeomPose(thumb).inverse() * mjcf::Vec3(line));
      pads.fingers.emplace_back(finger, mjcf.GeomPose(finger).inverse() * mjcf::Vec3(line + 3));
    }
  }
  return pads;
}

/// The share of the joints' range at which the pads touch; 1 if they never do.
double TouchingFraction(const Mjcf& mjcf, const Parts& parts) {
  const auto open = [&](double fraction) {
    SetClosing(mjcf, parts, fraction);
    return Gap(mjcf, parts) > 0.0;
  };
  if (open(1.0)) return 1.0;
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (open(middle) ? low : high) = middle;
  }
  return low;
}

/// Midway between the thumb's tip and the middle of the others. Section 5.3 names the center of
/// gravity of three tips, but a hand that is centered there comes down on boxes wider than 55 mm,
/// which the dissertation's hand delivered.
Vector3d TipCenter_W(const Mjcf& mjcf, const std::vector<int>& sites) {
  const auto at = [&](int site) { return mjcf::Vec3(mjcf.data().site_xpos + 3 * site); };
  Vector3d fingers = Vector3d::Zero();
  for (std::size_t i = 1; i < sites.size(); ++i) fingers += at(sites[i]);
  return 0.5 * (at(sites.front()) + fingers / static_cast<double>(sites.size() - 1));
}

HandModel::State StateNow(const Mjcf& mjcf, const Parts& parts, const Pads& pads) {
  const mjModel& m = mjcf.model();
  const base::Pose X_HW = mjcf.BodyPose(parts.body).inverse();
  HandModel::State state;
  for (int g : parts.geoms) {
    state.shapes.push_back(mjcf.ShapeOf(g, X_HW * mjcf.GeomPose(g)));
    state.is_finger.push_back(Holds(parts.fingertips, g));
    state.is_thumb.push_back(mjcf.InSubtree(m.geom_bodyid[g], parts.thumb_root));
  }
  state.gap_m = std::max(0.0, Gap(mjcf, parts));
  state.thumb_pad_H = X_HW * Mean_W(mjcf, pads.thumb);
  state.finger_pad_H = X_HW * Mean_W(mjcf, pads.fingers);
  // Without sites at its tips, a hand's tool centres move like the middle of its pads.
  state.tip_center_H = state.power_center_H = 0.5 * (state.thumb_pad_H + state.finger_pad_H);
  if (parts.tip_sites.size() > 1) state.tip_center_H = X_HW * TipCenter_W(mjcf, parts.tip_sites);
  if (parts.power_sites.size() > 1) {
    state.power_center_H = X_HW * TipCenter_W(mjcf, parts.power_sites);
  }
  return state;
}

/// Distance from the front of the hand's fixed parts to the tool centre, along the approach.
double PalmDepth(const Mjcf& mjcf, const Parts& parts, const base::Pose& X_WG) {
  const Vector3d approach_W = X_WG.linear().col(2);
  double front = -std::numeric_limits<double>::infinity();
  for (int g : parts.geoms) {
    const mjModel& m = mjcf.model();
    if (m.body_weldid[m.geom_bodyid[g]] == m.body_weldid[parts.body]) {
      front = std::max(front, Reach(mjcf, g, approach_W));
    }
  }
  return std::isfinite(front) ? approach_W.dot(X_WG.translation()) - front : 0.0;
}

}  // namespace

Mjcf::Mjcf(const std::filesystem::path& file) : file_(file) {
  char text[1000] = "";
  // With a relative path, the engine loses the files that an included file refers to.
  const std::string path = std::filesystem::absolute(file).string();
  mjcf::CheckFiles(file);
  {
    const QuietEngine quiet;
    process::NeedMemory(mjcf::kEngine_bytes);
    model_.reset(mj_loadXML(path.c_str(), nullptr, text, sizeof(text)));
  }
  if (!model_) throw base::InputError(mjcf::EngineMessage(file, text));
  if (const std::string far = mjcf::FarAway(*model_); !far.empty()) {
    Fail(far + ": is more than 10 km away");
  }
  data_.reset(mj_makeData(model_.get()));
  mj_kinematics(model_.get(), data_.get());
}

void Mjcf::Fail(const std::string& what) const {
  throw base::InputError(file_.string() + ": " + what);
}

std::string Mjcf::GeomTitle(int geom) const {
  const std::string name = Name(mjOBJ_GEOM, geom);
  if (!name.empty()) return name;
  const std::string body = Name(mjOBJ_BODY, model_->geom_bodyid[geom]);
  return "a geom of " + (body.empty() ? "a body without a name" : body);
}

int Mjcf::Require(mjtObj type, std::string_view name) const {
  int found = -1;
  const std::string what = fmt::format("{} \"{}\"", mju_type2Str(type), name);
  for (int id = 0; id < mjcf::CountOf(model_.get(), type); ++id) {
    if (mjcf::Suffix(Name(type, id)) != name) continue;
    if (found >= 0) {
      Fail(fmt::format("{} exists twice: {} and {}", what, Name(type, found), Name(type, id)));
    }
    found = id;
  }
  if (found < 0) Fail(fmt::format("there is no {} (with any prefix)", what));
  return found;
}

std::vector<int> Mjcf::TupleIfAny(std::string_view name, mjtObj type) const {
  return FindIfAny(mjOBJ_TUPLE, name) >= 0 ? Tuple(name, type) : std::vector<int>();
}

std::vector<int> Mjcf::Tuple(std::string_view name, mjtObj type) const {
  const int id = Require(mjOBJ_TUPLE, name);
  const int* types = model_->tuple_objtype + model_->tuple_adr[id];
  const int* ids = model_->tuple_objid + model_->tuple_adr[id];
  const int size = model_->tuple_size[id];
  if (size == 0 || !std::all_of(types, types + size, [&](int t) { return t == type; })) {
    Fail(fmt::format("tuple \"{}\" must have elements of type {}", name, mju_type2Str(type)));
  }
  return {ids, ids + size};
}

Eigen::VectorXd Mjcf::Numeric(std::string_view name, int size) const {
  const int id = Require(mjOBJ_NUMERIC, name);
  if (model_->numeric_size[id] != size) {
    Fail(fmt::format("numeric \"{}\" must have {}", name, base::Counted(size, "value")));
  }
  return Eigen::Map<const Eigen::VectorXd>(model_->numeric_data + model_->numeric_adr[id], size);
}

geometry::Shape Mjcf::ShapeOf(int geom, const base::Pose& X_BS) const {
  const mjModel& m = *model_;
  geometry::Shape shape;
  shape.kind = mjcf::KindOf(m.geom_type[geom]).value_or(geometry::Shape::Kind::kConvex);
  shape.X_BS = X_BS;
  shape.size = mjcf::Vec3(m.geom_size + 3 * geom);
  shape.name = Name(mjOBJ_GEOM, geom);
  if (shape.kind == geometry::Shape::Kind::kConvex) {
    if (m.geom_type[geom] != mjGEOM_MESH)
      Fail(fmt::format("geom \"{}\": unsupported type", shape.name));
    shape.mesh = mjcf::HullOf(&m, m.geom_dataid[geom]);
  }
  return shape;
}

HandModel SampleHand(const Mjcf& mjcf, int hand_body) {
  const Parts parts = FindParts(mjcf, hand_body);
  const int tip_site = mjcf.Require(mjOBJ_SITE, "tcp");
  const double closed = TouchingFraction(mjcf, parts);
  SetClosing(mjcf, parts, closed);
  const Pads pads = FacingPoints(mjcf, parts, mjcf.SitePose(tip_site).linear().col(0));
  HandModel hand;
  for (int i = 0; i < kStates; ++i) {
    SetClosing(mjcf, parts, static_cast<double>(i) / (kStates - 1) * closed);
    hand.states.push_back(StateNow(mjcf, parts, pads));
  }
  SetClosing(mjcf, parts, 0.0);
  const base::Pose X_HW = mjcf.BodyPose(hand_body).inverse();
  const base::Pose X_WG = mjcf.SitePose(tip_site);
  hand.X_HG_tip = X_HW * X_WG;
  hand.level = parts.closing.has_value();
  hand.depth_m = PalmDepth(mjcf, parts, X_WG);
  return hand;
}

}  // namespace rangegrasp::robot::internal
