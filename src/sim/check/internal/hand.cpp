#include "sim/check/internal/hand.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "robot/mjcf/hand.h"
#include "sim/check/internal/finger_poses.h"
#include "sim/internal/engine.h"

namespace rangegrasp::check::internal {
namespace {

using Eigen::Vector3d;
using sim::internal::DataPtr;
using sim::internal::Vec3;

// A fingertip that moves less than this between the open and the closed hand is not driven.
constexpr double kMoved_m = 0.002;
// Pads that stay further apart cannot hold thin objects; a hand that opens less holds hardly any.
constexpr double kMeet_m = 0.003;
constexpr double kOpens_m = 0.020;
constexpr double kEquality = 5e-4;  // more fails the audit (AuditBounds::equality_share)
constexpr double kBehind = 0.02;    // share of its travel by which a drive may stop short
// Tolerances of the site "tcp": distance from the middle of the open hand's pads, and tilt.
constexpr double kOff_m = 0.03;
const double kLean = std::cos(25.0 * mjPI / 180.0);
// Softer contacts sink in too deep; with fewer dimensions, objects spin in the hand.
constexpr double kSoft_s = 0.01;
constexpr int kSpinning = 4;
// An equality is firm with these values of solref and solimp, as in parallel_jaw.xml.
constexpr double kFirm_s = 0.005, kFirmMin = 0.999, kFirmMax = 0.9999;
constexpr double kGripped = 0.5;  // share of the closing at which forces are evaluated

/// The hand at a share of its closing.
DataPtr At(const Model& model, const mjcf::HandClosing& closing, double share) {
  DataPtr data(mj_makeData(&model.m()));
  closing.Pose(&model.m(), data.get(), share);
  mj_forward(&model.m(), data.get());
  return data;
}

Vector3d MiddleOf(const mjData* data, const std::vector<int>& geoms) {
  Vector3d sum = Vector3d::Zero();
  for (const int geom : geoms) sum += Vec3(data->geom_xpos + 3 * geom);
  return sum / std::max(1.0, static_cast<double>(geoms.size()));
}

/// Tool frame between the pads of the present hand: x across them, z away from its fixed parts.
struct Tool {
  Vector3d position_W, x_W, z_W;
};
Tool ToolOf(const Model& model, const mjData* data) {
  const mjModel& m = model.m();
  const mjcf::LastSegments tips = mjcf::LastSegmentsOf(&m);
  std::vector<int> palm;
  for (int g = 0; g < m.ngeom; ++g) {
    const bool fixed = m.body_weldid[m.geom_bodyid[g]] == m.body_weldid[model.hand];
    if (model.Collides(g) && fixed && model.InSubtree(m.geom_bodyid[g], model.hand)) {
      palm.push_back(g);
    }
  }
  Tool tool;
  const Vector3d thumb = MiddleOf(data, tips.thumb);
  const Vector3d fingers = MiddleOf(data, tips.fingers);
  tool.position_W = 0.5 * (thumb + fingers);
  tool.x_W = (thumb - fingers).normalized();
  const Vector3d root = palm.empty() ? Vec3(data->xpos + 3 * model.hand) : MiddleOf(data, palm);
  const Vector3d out = tool.position_W - root;
  tool.z_W = (out - tool.x_W.dot(out) * tool.x_W).normalized();
  return tool;
}

// Rounds to what a person would type, without -0.
double Rounded(double v, double steps = 1e4) { return std::round(steps * v) / steps + 0.0; }

std::string SiteText(const Model& model, const mjData* data, const Tool& tool) {
  const auto R = mjcf::Mat3(data->xmat + 9 * model.hand);
  const Vector3d p = R.transpose() * (tool.position_W - Vec3(data->xpos + 3 * model.hand));
  const Vector3d x = R.transpose() * tool.x_W;
  const Vector3d y = R.transpose() * tool.z_W.cross(tool.x_W);
  std::vector<double> axes;
  for (const Vector3d& axis : {x, y}) {
    for (const double v : axis) axes.push_back(Rounded(v, 1e3));
  }
  return fmt::format(
      "<site name=\"tcp\" pos=\"{:g} {:g} {:g}\" xyaxes=\"{:g}\" group=\"4\" "
      "size=\"0.004\"/>",
      Rounded(p.x()), Rounded(p.y()), Rounded(p.z()), fmt::join(axes, " "));
}

// @return false: reported that it does not
bool CheckCollides(Model& model, int fingertip) {
  if (model.Collides(fingertip)) return true;
  model.Error(mjOBJ_GEOM, fingertip, "is a fingertip, but not a collision geom",
              model.Set(mjOBJ_GEOM, fingertip, {{"contype", "1"}, {"conaffinity", "1"}}));
  return false;
}

// The attributes that make a fingertip's contacts firm; empty if they are.
Attributes FirmerTip(const mjModel& m, int geom) {
  Attributes firmer;
  if (m.geom_priority[geom] < 1) firmer.emplace_back("priority", "1");
  if (m.geom_condim[geom] < kSpinning) firmer.emplace_back("condim", "4");
  if (m.geom_solref[2 * geom] > kSoft_s) {
    firmer.emplace_back("solref", "0.005 1");
    firmer.emplace_back("solimp", "0.95 0.99 0.001 0.5 2");
  }
  return firmer;
}

void CheckTips(Model& model, const mjcf::HandClosing& closing) {
  const mjModel& m = model.m();
  const DataPtr open = At(model, closing, 0.0);
  const DataPtr closed = At(model, closing, closing.Touching());
  for (const int geom : model.Tuple("fingertips", mjOBJ_GEOM)) {
    const Vector3d way = Vec3(closed->geom_xpos + 3 * geom) - Vec3(open->geom_xpos + 3 * geom);
    if (!CheckCollides(model, geom)) continue;
    if (way.norm() < kMoved_m) {
      model.Error(mjOBJ_GEOM, geom,
                  fmt::format("is a fingertip that moves by {:.1f} mm while the hand closes: no "
                              "drive of \"hand_motors\" moves body \"{}\"",
                              1e3 * way.norm(), model.BodyName(m.geom_bodyid[geom])),
                  "list the drive that moves it in \"hand_motors\", or remove the geom from "
                  "\"fingertips\"");
      continue;
    }
    const Attributes firmer = FirmerTip(m, geom);
    if (firmer.empty()) continue;
    model.Warn(mjOBJ_GEOM, geom,
               "is a fingertip whose contacts are soft, lack torsional friction, or use the "
               "touched object's parameters",
               model.Set(mjOBJ_GEOM, geom, firmer));
  }
}

std::string Values(const std::vector<mjcf::HandMotor>& motors, bool open) {
  std::vector<double> values;
  for (const auto& motor : motors) values.push_back(Rounded(open ? motor.open : motor.closed));
  return fmt::format("{:g}", fmt::join(values, " "));
}

void CheckGap(Model& model, const mjcf::HandClosing& closing,
              const std::vector<mjcf::HandMotor>& motors) {
  const double open_m = closing.points.front().gap_m;
  const double least_m =
      std::ranges::min_element(closing.points, {}, &mjcf::HandClosing::Point::gap_m)->gap_m;
  if (closing.points.back().gap_m > open_m) {
    model.Error(mjOBJ_NUMERIC, "hand_closed",
                fmt::format("the pads move apart while the hand closes, from {:.1f} to {:.1f} mm",
                            1e3 * open_m, 1e3 * closing.points.back().gap_m),
                model.SetNumeric("hand_open", Values(motors, false), "") +
                    model.SetNumeric("hand_closed", Values(motors, true), ""));
  } else if (least_m > kMeet_m) {
    model.Warn(mjOBJ_NUMERIC, "hand_closed",
               fmt::format("the pads never meet: they open {:.1f} mm and stay {:.1f} mm apart",
                           1e3 * open_m, 1e3 * least_m),
               "set values that close the hand further, or widen the range of the joints; "
               "otherwise thinner objects cannot be grasped");
  } else if (open_m < kOpens_m) {
    model.Error(model.Where(mjOBJ_NUMERIC, model.Find(mjOBJ_NUMERIC, "hand_closed")),
                "numeric \"hand_open\"",
                fmt::format("the pads are {:.1f} mm apart in the open hand", 1e3 * open_m),
                "set values nearer to the open end");
  }
}

/// Joints of the closed hand that are stopped by their range.
std::vector<int> AtRangeEnds(const Model& model, const mjcf::HandClosing& closing) {
  constexpr double kEnd = 0.01;  // of the range: limits are soft
  const mjModel& m = model.m();
  std::vector<int> ended;
  for (std::size_t i = 0; i < closing.joints.size(); ++i) {
    const int joint = closing.joints[i];
    const auto [low, high] = model.RangeOf(joint, mjMAXVAL);
    const double left = kEnd * (high - low);
    const double before = closing.points.front().positions[i];
    const double q = closing.points.back().positions[i];
    // A joint that started at an end and stays there does not stop the hand.
    const bool moved = std::abs(q - before) > left;
    if (m.jnt_limited[joint] && moved && (q < low + left || q > high - left)) {
      ended.push_back(joint);
    }
  }
  return ended;
}

void CheckModelFollows(Model& model, const mjcf::HandClosing& closing,
                       std::vector<mjcf::HandMotor> motors) {
  if (closing.equality_m > kEquality) {
    const std::string name = model.Name(mjOBJ_EQUALITY, closing.equality);
    const Attributes firmer = FirmerEqualities(model.m());
    const Cure firm =
        Cure({base::Edit{.file = model.HandFile(), .element = "/*/equality/*", .set = firmer}}) +
        "; if that does not help, ";
    model.Error(
        model.HandFile(),
        fmt::format("equality {}{}", closing.equality,
                    name.empty() ? "" : fmt::format(" \"{}\"", name)),
        fmt::format("does not hold while the empty hand closes: its error is {:.3g} rad or m",
                    closing.equality_m),
        (firmer.empty() ? Cure() : firm) +
            "the joints' ranges or \"hand_open\" and \"hand_closed\" block the linkage");
  }
  if (closing.behind > kBehind) {
    const std::vector<int> ended = AtRangeEnds(model, closing);
    const bool joint = !ended.empty();
    const DataPtr reached = At(model, closing, 1.0);
    for (auto& motor : motors) {
      motor.closed = mjcf::DriveLength(&model.m(), reached.get(), motor.actuator);
    }
    model.Error(
        mjOBJ_ACTUATOR, closing.behind_actuator,
        fmt::format(
            "stops {:.0f} % of its way short of \"hand_closed\": {}", 100.0 * closing.behind,
            joint ? "stopped by the end of the range of joint " + model.NamesOf(mjOBJ_JOINT, ended)
                  : "no joint is at the end of its range, so an equality or a "
                    "spring holds it back"),
        model.SetNumeric("hand_closed", Values(motors, false), "") +
            (joint ? ", which is within the joints' ranges"
                   : ", which it reaches; or a softer spring, or another equality"));
  }
}

void CheckTool(Model& model, const mjcf::HandClosing& closing) {
  const int site = model.Find(mjOBJ_SITE, "tcp");
  if (site < 0) return;
  const DataPtr open = At(model, closing, 0.0);
  const Tool tool = ToolOf(model, open.get());
  const Vector3d off = Vec3(open->site_xpos + 3 * site) - tool.position_W;
  const Eigen::Matrix3d R = mjcf::Mat3(open->site_xmat + 9 * site);
  const double x = tool.x_W.dot(R.col(0));
  const double z = tool.z_W.dot(R.col(2));
  const double across_m = std::hypot(off.dot(tool.x_W), off.dot(tool.z_W.cross(tool.x_W)));
  if (x > kLean && z > 0.0 && across_m < kOff_m) return;
  model.Error(mjOBJ_SITE, site,
              x < 0.0 ? "its x points from the thumb's pads to the fingers'"
              : z < 0.0
                  ? "its z points into the palm, not away from it"
                  : fmt::format("is {:.0f} mm from the middle of the open hand's pads, or its x "
                                "differs by {:.0f} deg from the line across them",
                                1e3 * across_m, std::acos(std::clamp(x, -1.0, 1.0)) * 180.0 / mjPI),
              model.Replace(mjOBJ_SITE, site, SiteText(model, open.get(), tool)));
}

/// Largest force of a drive in the closing direction, at the half closed hand.
double StrengthOf(const Model& model, const mjData* data, const mjcf::HandMotor& motor,
                  double sign) {
  const mjModel& m = model.m();
  const mjcf::AffineDrive drive = mjcf::AffineOf(&m, motor.actuator);
  double strength = sign > 0.0 ? drive.strongest : -drive.weakest;
  const int control = m.actuator_ctrladr[motor.actuator];
  if (m.actuator_ctrllimited[control]) {
    const double at = drive.bias[0] + drive.bias[1] * mjcf::DriveLength(&m, data, motor.actuator);
    const double a = sign * (at + drive.gain * m.actuator_ctrlrange[2 * control]);
    const double b = sign * (at + drive.gain * m.actuator_ctrlrange[2 * control + 1]);
    strength = std::min(strength, std::max(a, b));
  }
  return strength;
}

void CheckGripStrength(Model& model, const mjcf::HandClosing& closing,
                       const std::vector<mjcf::HandMotor>& motors) {
  const auto wanted = model.Numeric("grip_force");
  const int site = model.Find(mjOBJ_SITE, "tcp");
  if (wanted.size() != 2 || site < 0) return;
  const double share = kGripped * closing.Touching();
  const DataPtr half = At(model, closing, share);
  const auto per_newton = mjcf::GripForces(&model.m(), half.get(), motors, closing, share,
                                           mjcf::Mat3(half->site_xmat + 9 * site).col(0));
  constexpr double kRounding = 1e-3;  // a drive of 70 N comes out as 69.99
  double force_N = mjMAXVAL;
  int weakest = -1;
  Cure stiffer;  // of servos that do not use the force range of their file
  for (std::size_t k = 0; k < motors.size(); ++k) {
    if (!motors[k].Moves() || std::abs(per_newton[k]) < mjMINVAL) continue;
    const double sign = per_newton[k] > 0.0 ? 1.0 : -1.0;
    const double strength = StrengthOf(model, half.get(), motors[k], sign);
    const double gives = strength / std::abs(per_newton[k]);
    const mjcf::AffineDrive drive = mjcf::AffineOf(&model.m(), motors[k].actuator);
    const double strongest = sign > 0.0 ? drive.strongest : -drive.weakest;
    if (gives < (1.0 - kRounding) * wanted[1] && std::isfinite(strongest) && drive.bias[1] < 0.0 &&
        strength > 0.0 && strength < (1.0 - kRounding) * strongest) {
      stiffer += model.Stiffer(motors[k].actuator, std::ceil(strongest / strength));
    }
    if (gives >= force_N) continue;
    force_N = gives;
    weakest = motors[k].actuator;
  }
  if (weakest < 0 || force_N >= (1.0 - kRounding) * wanted[1]) return;
  const double most = std::floor(std::max(1.0, force_N));
  const Cure softer =
      model.SetNumeric("grip_force", fmt::format("{:g} {:g}", std::min(wanted[0], most), most), "");
  model.Error(mjOBJ_ACTUATOR, weakest,
              fmt::format("gives {:.3g} N between the pads of the half closed hand; \"grip_force\" "
                          "needs {:g} N, at most {:g} N",
                          force_N, wanted[0], wanted[1]),
              stiffer.edits.empty() ? softer +
                                          ", or the forcerange of the hand's data sheet (for a "
                                          "servo, also a higher kp or a wider ctrlrange)"
                                    : stiffer + ": up to the forcerange");
}

/// Stiffness of a servo on a joint, at the joint; 0 for any other drive.
double StiffnessAtJoint(const Model& model, int actuator) {
  const mjModel& m = model.m();
  if (m.actuator_trntype[actuator] != mjTRN_JOINT) return 0.0;
  return -mjcf::AffineOf(&m, actuator).bias[1] * std::pow(m.actuator_gear[6 * actuator], 2);
}

// A finger that is pushed at its tip with F, at a lever L from a joint, gives way to the side if
// the joint's stiffness is less than F L. With less than kFirm times that, it turns the grasped
// object.
constexpr double kFirm = 5.0;

void CheckStiffness(Model& model, const mjcf::HandClosing& closing,
                    const std::vector<mjcf::HandMotor>& motors) {
  const mjModel& m = model.m();
  const auto force = model.Numeric("grip_force");
  if (force.size() != 2) return;
  const DataPtr half = At(model, closing, kGripped * closing.Touching());
  const auto tips = model.Tuple("fingertips", mjOBJ_GEOM);
  double times = 1.0;
  std::vector<int> soft;
  for (const auto& motor : motors) {
    const double stiffness = StiffnessAtJoint(model, motor.actuator);
    if (stiffness <= 0.0) continue;
    const int joint = m.actuator_trnid[2 * motor.actuator];
    if (m.jnt_type[joint] != mjJNT_HINGE) continue;
    double lever_m = 0.0;
    for (const int tip : tips) {
      if (model.Finger(m.geom_bodyid[tip]) != model.Finger(m.jnt_bodyid[joint])) continue;
      const Vector3d arm = Vec3(half->geom_xpos + 3 * tip) - Vec3(half->xanchor + 3 * joint);
      lever_m = std::max(lever_m, arm.norm());
    }
    const double needed = kFirm * force[0] * lever_m / stiffness;
    if (needed <= 1.0) continue;
    soft.push_back(motor.actuator);
    times = std::max(times, std::ceil(2.0 * needed) / 2.0);
  }
  if (soft.empty()) return;
  Cure cure;
  for (const int actuator : soft) cure += model.Stiffer(actuator, times);
  model.Warn(mjOBJ_ACTUATOR, soft,
             fmt::format("are so soft that fingers give way at a grip of {:g} N", force[0]), cure);
}

// A servo and its load oscillate with k / I = omega^2. The solver cannot follow more than
// kFastest_rad in a step, and fingers that keep swinging never rest on an object.
constexpr double kFastest_rad = 1.0;
constexpr double kCalm_rad = 0.2;
constexpr double kDampingRatio = 0.1, kGoodRatio = 0.7;

/// The inertia that a joint feels if all others are free.
double FeltInertia(const Model& model, mjData* data, int joint) {
  const int dof = model.m().jnt_dofadr[joint];
  std::vector<mjtNum> unit(model.m().nv), moved(unit);
  unit[dof] = 1.0;
  mj_solveM(&model.m(), data, moved.data(), unit.data(), 1);
  return 1.0 / moved[dof];
}

void CheckFingersSettle(Model& model, const mjcf::HandClosing& closing,
                        const std::vector<mjcf::HandMotor>& motors) {
  const mjModel& m = model.m();
  const double step_s = m.opt.timestep;
  const DataPtr open = At(model, closing, 0.0);
  std::vector<int> joints;
  Cure cure;
  for (const auto& motor : motors) {
    const double stiffness = StiffnessAtJoint(model, motor.actuator);
    if (stiffness <= 0.0) continue;
    const int joint = m.actuator_trnid[2 * motor.actuator];
    const int dof = m.jnt_dofadr[joint];
    double inertia = FeltInertia(model, open.get(), joint);
    Attributes changed;
    if (std::sqrt(stiffness / inertia) * step_s > kFastest_rad) {
      inertia = stiffness * std::pow(step_s / kCalm_rad, 2);
      changed.emplace_back("armature", fmt::format("{:.2g}", inertia));
    }
    const double critical = 2.0 * std::sqrt(stiffness * inertia);
    const double damping = m.dof_damping[dof] - mjcf::AffineOf(&m, motor.actuator).bias[2];
    if (damping < kDampingRatio * critical && m.dof_frictionloss[dof] == 0.0) {
      changed.emplace_back("damping", fmt::format("{:.2g}", kGoodRatio * critical));
    }
    if (changed.empty()) continue;
    joints.push_back(joint);
    cure += model.Set(mjOBJ_JOINT, joint, changed);
  }
  if (joints.empty()) return;
  model.Error(
      mjOBJ_JOINT, joints,
      fmt::format("swing too fast for the time step of {:g} ms, or without end: they have too "
                  "little armature (the inertia of motor and gear) or damping for the "
                  "stiffness of their drives",
                  1e3 * step_s),
      cure);
}

/// Finds links of the hand that overlap in all its poses, because of the modelling. Contacts
/// between them push the fingers away from where their drives hold them.
void CheckOwnContacts(Model& model, const mjcf::HandClosing& closing) {
  constexpr int kStands = 5;
  constexpr double kOverlap_m = 0.0005;
  const mjModel& m = model.m();
  const auto moving = [&](int geom) { return m.body_weldid[m.geom_bodyid[geom]]; };
  const auto parent = [&](int body) { return m.body_weldid[m.body_parentid[body]]; };
  std::map<std::pair<int, int>, std::set<int>> poses;
  for (int i = 0; i < kStands; ++i) {
    const DataPtr data = At(model, closing, closing.Touching() * i / (kStands - 1));
    for (int k = 0; k < data->ncon; ++k) {
      const mjContact& contact = data->contact[k];
      if (contact.geom[0] < 0 || contact.geom[1] < 0 || contact.dist > -kOverlap_m) continue;
      // The engine ignores contacts of a link with its parent, but not with a fixed one, as here.
      const int a = moving(contact.geom[0]), b = moving(contact.geom[1]);
      if (parent(a) == b || parent(b) == a) continue;
      const auto [low, high] =
          std::minmax(m.geom_bodyid[contact.geom[0]], m.geom_bodyid[contact.geom[1]]);
      if (model.InSubtree(low, model.hand) && model.InSubtree(high, model.hand)) {
        poses[{low, high}].insert(i);
      }
    }
  }
  for (const auto& [pair, in] : poses) {
    if (in.size() < kStands) continue;
    model.Error(
        model.Where(mjOBJ_BODY, pair.second), model.BothNames(pair.first, pair.second),
        "overlap in all positions of the hand, so that contacts between them block the fingers",
        model.Exclude(pair.first, pair.second));
  }
}

std::vector<mjcf::HandMotor> AtTheirRanges(const Model& model, const std::vector<int>& actuators) {
  const mjModel& m = model.m();
  std::vector<mjcf::HandMotor> motors;
  const DataPtr low(mj_makeData(&m));
  const DataPtr high(mj_makeData(&m));
  for (int j = 0; j < m.njnt; ++j) {
    if (!m.jnt_limited[j]) continue;
    low->qpos[m.jnt_qposadr[j]] = m.jnt_range[2 * j];
    high->qpos[m.jnt_qposadr[j]] = m.jnt_range[2 * j + 1];
  }
  for (const int a : actuators) {
    motors.push_back(
        {a, mjcf::DriveLength(&m, low.get(), a), mjcf::DriveLength(&m, high.get(), a)});
  }
  return motors;
}

// Whether the sides are further apart at the upper ends of the drives than at the lower ones.
bool OpensWithLength(const Model& model, const std::vector<mjcf::HandMotor>& motors,
                     const std::vector<int>& tips) {
  if (motors.empty() || tips.empty()) return false;
  const mjModel& m = model.m();
  const int thumb = model.Finger(m.geom_bodyid[tips.front()]);
  try {
    const auto closing =
        mjcf::CloseOnNothing(&m, motors, mjcf::LastSegmentsOf(&m, tips, thumb), model.hand);
    return closing.points.back().gap_m > closing.points.front().gap_m;
  } catch (const base::InputError&) {  // reported by CheckClosing
    return false;
  }
}

bool MovesHand(const Model& model, int actuator) {
  const mjModel& m = model.m();
  const int id = m.actuator_trnid[2 * actuator];
  const auto of_hand = [&](int joint) { return model.InSubtree(m.jnt_bodyid[joint], model.hand); };
  if (m.actuator_trntype[actuator] == mjTRN_JOINT) return of_hand(id);
  if (m.actuator_trntype[actuator] != mjTRN_TENDON) return false;
  const int first = m.tendon_adr[id];
  return m.wrap_type[first] == mjWRAP_JOINT && of_hand(m.wrap_objid[first]);
}

bool IsOutermost(const mjModel& m, int body) {
  for (int g = 0; g < m.ngeom; ++g) {
    const int b = m.geom_bodyid[g];
    if (b != body && mjcf::Collides(&m, g) && mjcf::InSubtree(&m, b, body)) return false;
  }
  return true;
}

// Whether a body closes a linkage, as the coupler of a four-bar does.
bool IsLink(const mjModel& m, int body) {
  for (int e = 0; e < m.neq; ++e) {
    const bool joined = m.eq_type[e] == mjEQ_CONNECT || m.eq_type[e] == mjEQ_WELD;
    if (joined && m.eq_objtype[e] == mjOBJ_BODY &&
        (m.eq_obj1id[e] == body || m.eq_obj2id[e] == body))
      return true;
  }
  return false;
}

// The thumb's tip is the one furthest from all others.
void PutThumbFirst(const Model& model, std::vector<int>& tips) {
  const auto finger = [&](int geom) { return model.Finger(model.m().geom_bodyid[geom]); };
  const auto place = [&](int geom) { return Vec3(model.d().geom_xpos + 3 * geom); };
  const auto apart_m = [&](int geom) {
    double sum_m = 0.0;
    for (const int other : tips) sum_m += (place(geom) - place(other)).norm();
    return sum_m;
  };
  if (tips.empty()) return;
  const int thumb = finger(*std::ranges::max_element(tips, {}, apart_m));
  std::ranges::stable_partition(tips, [&](int geom) { return finger(geom) == thumb; });
}

// Checks a hand of "hand_motors" by closing it.
void CheckClosing(Model& model) {
  if (model.HasErrors() || model.Tuple("fingertips", mjOBJ_GEOM).empty()) return;
  const mjcf::LastSegments tips = mjcf::LastSegmentsOf(&model.m());
  if (tips.thumb.empty() || tips.fingers.empty()) {
    model.Error(mjOBJ_TUPLE, "fingertips",
                "its geoms belong to one finger: a grasp needs two sides",
                "list the thumb's geoms first, then those of the fingers that face it");
    return;
  }
  try {
    const auto motors = mjcf::HandMotors(&model.m());
    const mjcf::HandClosing closing = mjcf::CloseOnNothing(&model.m(), motors);
    CheckTips(model, closing);
    CheckGap(model, closing, motors);
    CheckModelFollows(model, closing, motors);
    CheckFingersSettle(model, closing, motors);
    CheckOwnContacts(model, closing);
    if (model.HasErrors()) return;
    CheckTool(model, closing);
    CheckGripStrength(model, closing, motors);
    CheckStiffness(model, closing, motors);
  } catch (const base::InputError& error) {
    model.Error(model.HandFile(), "the hand", error.what(), "");
  }
  if (!model.Numeric("gear_backlash").empty()) {
    model.Warn(mjOBJ_NUMERIC, "gear_backlash",
               "has no effect: drives of \"hand_motors\" are not self-locking", "remove it");
  }
}

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
      if (driven(a) == driven(b)) continue;
      grown = roots.insert(model.Finger(driven(a) ? b : a)).second || grown;
    }
  }
  return roots;
}

// Checks a hand with one geared motor on its hinges ("hand_joints"): ranges, and what they move.
void CheckGearedHand(Model& model) {
  const auto joints = model.Tuple("hand_joints", mjOBJ_JOINT);
  const auto tips = model.Tuple("fingertips", mjOBJ_GEOM);
  if (joints.empty() || tips.empty()) return;
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

}  // namespace

Attributes FirmerEqualities(const mjModel& m) {
  for (int e = 0; e < m.neq; ++e) {
    const mjtNum* solref = m.eq_solref + mjNREF * e;
    const mjtNum* solimp = m.eq_solimp + mjNIMP * e;
    if (solref[0] <= kFirm_s && solimp[0] >= kFirmMin && solimp[1] >= kFirmMax) continue;
    return {{"solref", fmt::format("{:g} 1", kFirm_s)},
            {"solimp", fmt::format("{:g} {:g} 0.001", kFirmMin, kFirmMax)}};
  }
  return {};
}

Attributes FirmerTips(const Model& model) {
  for (const int geom : model.Tuple("fingertips", mjOBJ_GEOM)) {
    if (const Attributes firmer = FirmerTip(model.m(), geom); !firmer.empty()) return firmer;
  }
  return {};
}

void CheckHand(Model& model) {
  if (model.hand < 0) return;
  model.Find(mjOBJ_TUPLE, "hand_motors") >= 0 ? CheckClosing(model) : CheckGearedHand(model);
}

HandGuess GuessHand(Model& model) {
  HandGuess guess;
  if (model.hand < 0) return guess;
  const mjModel& m = model.m();
  for (int a = 0; a < m.nactuator; ++a) {
    if (MovesHand(model, a)) guess.motors.push_back(a);
  }
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    const bool moves = m.body_weldid[body] != m.body_weldid[model.hand];
    if (moves && model.Collides(g) && model.InSubtree(body, model.hand) && IsOutermost(m, body) &&
        !IsLink(m, body)) {
      guess.fingertips.push_back(g);
    }
  }
  PutThumbFirst(model, guess.fingertips);
  const auto named = model.Tuple("hand_motors", mjOBJ_ACTUATOR);
  const auto& drives = named.empty() ? guess.motors : named;
  const auto named_tips = model.Tuple("fingertips", mjOBJ_GEOM);
  const auto& tips = named_tips.empty() ? guess.fingertips : named_tips;
  const auto poses = FingerPoses(model, drives, tips);
  auto motors = poses ? *poses : AtTheirRanges(model, drives);
  if (!poses && OpensWithLength(model, motors, tips)) {
    for (auto& motor : motors) std::swap(motor.open, motor.closed);
  }
  guess.open = Values(motors, true);
  guess.closed = Values(motors, false);
  return guess;
}

Cure SuggestTool(Model& model) {
  const std::string in_words =
      "add a <site name=\"tcp\"> to the body \"hand\", between the pads of the open hand; once the "
      "hand has its tuples and numerics, this check prints one";
  try {
    if (model.Tuple("fingertips", mjOBJ_GEOM).empty()) return in_words;
    const mjcf::HandClosing closing = mjcf::CloseOnNothing(&model.m());
    const DataPtr open = At(model, closing, 0.0);
    const std::string site = SiteText(model, open.get(), ToolOf(model, open.get()));
    const auto body = model.lines().EditOf("body", model.Name(mjOBJ_BODY, model.hand));
    return body ? Cure::Insert(body->file, body->element, site)
                : Cure("in the body \"hand\": " + site);
  } catch (const base::InputError&) {
    return in_words;
  }
}

}  // namespace rangegrasp::check::internal
