#include "robot/mjcf/hand_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "robot/mjcf/names.h"

namespace rangegrasp::mjcf {
namespace {

/// The topmost body with a joint on the way from a body up to the hand's root.
int HandBranch(const mjModel* model, int body, int hand) {
  int branch = body;
  for (int b = body; b > hand; b = model->body_parentid[b]) {
    if (model->body_jntnum[b] > 0) branch = b;
  }
  return branch;
}

std::vector<double> OneADrive(const mjModel* model, const char* name, std::size_t drives) {
  std::vector<double> values = NumericOf(model, name);
  if (values.size() != drives) {
    throw base::InputError(fmt::format(
        "numeric \"{}\" must hold one value for each of the {} drives of tuple \"hand_motors\"; it "
        "holds {}",
        name, drives, values.size()));
  }
  return values;
}

void RequireAffine(const mjModel* model, int actuator) {
  const bool gain = model->actuator_gaintype[actuator] == mjGAIN_FIXED;
  const bool bias = model->actuator_biastype[actuator] == mjBIAS_NONE ||
                    model->actuator_biastype[actuator] == mjBIAS_AFFINE;
  const bool at_once = model->actuator_dyntype[actuator] == mjDYN_NONE;
  if (gain && bias && at_once && model->actuator_gainprm[actuator * mjNGAIN] != 0.0) return;
  throw base::InputError(fmt::format(
      "actuator \"{}\" of tuple \"hand_motors\" is neither a <position> servo nor a <motor> nor a "
      "<general> whose force is linear in its command, its length and its speed",
      mj_id2name(model, mjOBJ_ACTUATOR, actuator)));
}

template <class OfJoint>
double Along(const mjModel* model, int actuator, double otherwise, const OfJoint& of_joint) {
  const double gear = model->actuator_gear[6 * model->actuator_outadr[actuator]];
  const int id = model->actuator_trnid[2 * actuator];
  if (model->actuator_trntype[actuator] == mjTRN_JOINT) return gear * of_joint(id);
  if (model->actuator_trntype[actuator] != mjTRN_TENDON) return otherwise;
  double sum = 0.0;
  for (int i = model->tendon_adr[id]; i < model->tendon_adr[id] + model->tendon_num[id]; ++i) {
    if (model->wrap_type[i] != mjWRAP_JOINT) return otherwise;
    sum += model->wrap_prm[i] * of_joint(model->wrap_objid[i]);
  }
  return gear * sum;
}

}  // namespace

bool HasMotors(const mjModel* model) { return TryFind(model, mjOBJ_TUPLE, "hand_motors") >= 0; }

std::vector<HandMotor> HandMotors(const mjModel* model) {
  const std::vector<int> actuators = TupleOf(model, mjOBJ_ACTUATOR, "hand_motors");
  const std::vector<double> open = OneADrive(model, "hand_open", actuators.size());
  const std::vector<double> closed = OneADrive(model, "hand_closed", actuators.size());
  std::vector<HandMotor> motors;
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    RequireAffine(model, actuators[i]);
    motors.push_back({actuators[i], open[i], closed[i]});
  }
  if (std::none_of(motors.begin(), motors.end(), [](const HandMotor& m) { return m.Moves(); })) {
    throw base::InputError(
        "numerics \"hand_open\" and \"hand_closed\" are the same: nothing closes");
  }
  return motors;
}

int ThumbRoot(const mjModel* model) {
  if (!HasMotors(model)) {
    return model->jnt_bodyid[TupleOf(model, mjOBJ_JOINT, "hand_joints").at(0)];
  }
  const int tip = TupleOf(model, mjOBJ_GEOM, "fingertips").at(0);
  return HandBranch(model, model->geom_bodyid[tip], Find(model, mjOBJ_BODY, "hand"));
}

LastSegments LastSegmentsOf(const mjModel* model) {
  const std::vector<int> tips = TupleOf(model, mjOBJ_GEOM, "fingertips");
  const int thumb = ThumbRoot(model);
  LastSegments last;
  for (const int geom : tips) {
    const int body = model->geom_bodyid[geom];
    const bool inner = std::any_of(tips.begin(), tips.end(), [&](int other) {
      const int further = model->geom_bodyid[other];
      return further != body && InSubtree(model, further, body);
    });
    if (!inner) (InSubtree(model, body, thumb) ? last.thumb : last.fingers).push_back(geom);
  }
  return last;
}

int ToolSite(const mjModel* model, std::string_view name) {
  const int site = TryFind(model, mjOBJ_SITE, name);
  return site >= 0 ? site : TryFind(model, mjOBJ_SITE, "tcp");
}

double DriveLength(const mjModel* model, const mjData* data, int actuator) {
  return Along(model, actuator, data->actuator_length[model->actuator_outadr[actuator]],
               [&](int joint) { return data->qpos[model->jnt_qposadr[joint]]; });
}

double DriveSpeed(const mjModel* model, const mjData* data, int actuator) {
  return Along(model, actuator, data->actuator_velocity[model->actuator_outadr[actuator]],
               [&](int joint) { return data->qvel[model->jnt_dofadr[joint]]; });
}

std::vector<int> HandJoints(const mjModel* model) {
  const int hand = Find(model, mjOBJ_BODY, "hand");
  std::vector<int> joints;
  for (int j = 0; j < model->njnt; ++j) {
    if (!InSubtree(model, model->jnt_bodyid[j], hand)) continue;
    if (model->jnt_type[j] != mjJNT_HINGE && model->jnt_type[j] != mjJNT_SLIDE) {
      throw base::InputError("a joint of the hand is neither a hinge nor a slide");
    }
    joints.push_back(j);
  }
  return joints;
}

AffineDrive AffineOf(const mjModel* model, int actuator) {
  AffineDrive drive;
  drive.gain = model->actuator_gainprm[actuator * mjNGAIN];
  if (model->actuator_biastype[actuator] == mjBIAS_AFFINE) {
    std::copy_n(model->actuator_biasprm + actuator * mjNBIAS, 3, drive.bias);
  }
  drive.weakest = -std::numeric_limits<double>::infinity();
  drive.strongest = std::numeric_limits<double>::infinity();
  if (model->actuator_forcelimited[actuator]) {
    drive.weakest = model->actuator_forcerange[2 * actuator];
    drive.strongest = model->actuator_forcerange[2 * actuator + 1];
  }
  const int control = model->actuator_ctrladr[actuator];
  if (drive.bias[1] == 0.0 && model->actuator_ctrllimited[control]) {
    // Of a motor the command's range is the force's.
    const double a = drive.bias[0] + drive.gain * model->actuator_ctrlrange[2 * control];
    const double b = drive.bias[0] + drive.gain * model->actuator_ctrlrange[2 * control + 1];
    drive.weakest = std::max(drive.weakest, std::min(a, b));
    drive.strongest = std::min(drive.strongest, std::max(a, b));
  }
  return drive;
}

}  // namespace rangegrasp::mjcf
