#include "robot/mjcf/hand_closing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"

namespace rangegrasp::mjcf {
namespace {

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

constexpr int kPoints = 97;           // 1 mm of gap each of a hand that opens 100 mm
constexpr int kFirstSteps = 600;      // 1.2 s: from where the model is drawn to the open hand
constexpr int kStepsAPoint = 15;      // 30 ms: servos come within a hundredth of the step
constexpr double kStep_s = 0.002;     // as in scenes
constexpr double kServo_1_s = 300.0;  // of drives: a third of what the step allows
constexpr double kDrag = 0.95;        // of speed kept from step to step: springs swing out
constexpr double kArmature = 1000.0;  // of all but the hand, which so stands still
constexpr double kFarApart_m = 1.0;

// The copy that is closed: its options, and drives that go where they are told.
class Rehearsal {
 public:
  Rehearsal(const mjModel* model, const std::vector<HandMotor>& motors)
      : motors_(motors),
        tips_(LastSegmentsOf(model)),
        joints_(HandJoints(model)),
        model_(mj_copyModel(nullptr, model)),
        data_(mj_makeData(model)) {
    mjModel* m = model_.get();
    m->opt.disableflags |= mjDSBL_CONTACT | mjDSBL_GRAVITY | mjDSBL_SENSOR;
    m->opt.enableflags &= ~mjENBL_SLEEP;
    m->opt.integrator = mjINT_IMPLICITFAST;
    m->opt.timestep = kStep_s;
    std::vector<char> of_hand(static_cast<std::size_t>(m->nv), 0);
    for (const int j : joints_) of_hand[static_cast<std::size_t>(m->jnt_dofadr[j])] = 1;
    for (int dof = 0; dof < m->nv; ++dof) {
      if (!of_hand[static_cast<std::size_t>(dof)]) m->dof_armature[dof] += kArmature;
    }
    data_.reset(mj_makeData(m));
    MakeServos();
  }

  HandClosing Close() {
    HandClosing closing;
    closing.joints = joints_;
    for (int i = 0; i < kPoints; ++i) {
      const double share = static_cast<double>(i) / (kPoints - 1);
      for (const HandMotor& motor : motors_) {
        data_->ctrl[model_->actuator_ctrladr[motor.actuator]] = motor.open + share * motor.Travel();
      }
      Step(i == 0 ? kFirstSteps : kStepsAPoint);
      closing.points.push_back({share, Gap(), Positions()});
      NoteEqualities(closing);
    }
    NoteDrives(closing);
    return closing;
  }

 private:
  // A servo of one frequency for every drive, by the inertia that it moves; all others idle.
  void MakeServos() {
    mjModel* m = model_.get();
    mj_forward(m, data_.get());
    for (int a = 0; a < m->nactuator; ++a) {
      m->actuator_biastype[a] = mjBIAS_NONE;
      m->actuator_gaintype[a] = mjGAIN_FIXED;
      m->actuator_gainprm[a * mjNGAIN] = 0.0;
    }
    for (const HandMotor& motor : motors_) {
      const int a = motor.actuator;
      const double inertia = InertiaAt(a);
      m->actuator_biastype[a] = mjBIAS_AFFINE;
      m->actuator_gainprm[a * mjNGAIN] = inertia * kServo_1_s * kServo_1_s;
      m->actuator_biasprm[a * mjNBIAS] = 0.0;
      m->actuator_biasprm[a * mjNBIAS + 1] = -inertia * kServo_1_s * kServo_1_s;
      m->actuator_biasprm[a * mjNBIAS + 2] = -2.0 * inertia * kServo_1_s;
      m->actuator_forcelimited[a] = 0;
      m->actuator_ctrllimited[m->actuator_ctrladr[a]] = 0;
    }
  }

  double InertiaAt(int actuator) const {
    const mjModel* m = model_.get();
    const mjData* d = data_.get();
    const int out = m->actuator_outadr[actuator];
    std::vector<mjtNum> arm(static_cast<std::size_t>(m->nv), 0.0);
    std::vector<mjtNum> response(arm.size());
    for (int k = 0; k < d->moment_rownnz[out]; ++k) {
      const int at = d->moment_rowadr[out] + k;
      arm[static_cast<std::size_t>(d->moment_colind[at])] = d->actuator_moment[at];
    }
    mj_solveM(m, data_.get(), response.data(), arm.data(), 1);
    const double mobility = mju_dot(arm.data(), response.data(), static_cast<int>(m->nv));
    if (mobility <= 0.0) {
      throw base::InputError(fmt::format("actuator \"{}\" of tuple \"hand_motors\" moves nothing",
                                         mj_id2name(m, mjOBJ_ACTUATOR, actuator)));
    }
    return 1.0 / mobility;
  }

  void Step(int steps) {
    for (int i = 0; i < steps; ++i) {
      mj_step(model_.get(), data_.get());
      mju_scl(data_->qvel, data_->qvel, kDrag, static_cast<int>(model_->nv));
    }
    mj_forward(model_.get(), data_.get());
    if (data_->warning[mjWARN_BADQACC].number > 0 || data_->warning[mjWARN_BADQPOS].number > 0) {
      throw base::InputError(
          "the hand does not stay finite while its drives close it on nothing: its equalities, "
          "masses or \"hand_open\" and \"hand_closed\" contradict each other");
    }
  }

  double Gap() {
    double gap_m = kFarApart_m;
    for (const int a : tips_.thumb) {
      for (const int b : tips_.fingers) {
        gap_m =
            std::min(gap_m, mj_geomDistance(model_.get(), data_.get(), a, b, kFarApart_m, nullptr));
      }
    }
    return gap_m;
  }

  std::vector<double> Positions() const {
    std::vector<double> positions;
    for (const int j : joints_) positions.push_back(data_->qpos[model_->jnt_qposadr[j]]);
    return positions;
  }

  void NoteEqualities(HandClosing& closing) const {
    for (int row = 0; row < data_->ne; ++row) {
      const double error = std::abs(data_->efc_pos[row]);
      if (error <= closing.equality_m) continue;
      closing.equality_m = error;
      closing.equality = data_->efc_id[row];
    }
  }

  void NoteDrives(HandClosing& closing) const {
    for (const HandMotor& motor : motors_) {
      if (!motor.Moves()) continue;
      const double at = DriveLength(model_.get(), data_.get(), motor.actuator);
      const double behind = std::abs((motor.closed - at) / motor.Travel());
      if (behind <= closing.behind) continue;
      closing.behind = behind;
      closing.behind_actuator = motor.actuator;
    }
  }

  std::vector<HandMotor> motors_;
  LastSegments tips_;
  std::vector<int> joints_;
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
};

// Where a share lies: the point below it, and how far on to the next.
std::pair<std::size_t, double> Place(const std::vector<HandClosing::Point>& points, double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(points.size() - 1);
  const auto from = std::min(static_cast<std::size_t>(at), points.size() - 2);
  return {from, at - static_cast<double>(from)};
}

}  // namespace

double HandClosing::GapAt(double share) const {
  const auto [i, u] = Place(points, share);
  return (1.0 - u) * points[i].gap_m + u * points[i + 1].gap_m;
}

double HandClosing::NarrowingAt(double share) const {
  const auto [i, u] = Place(points, share);
  return (points[i].gap_m - points[i + 1].gap_m) * static_cast<double>(points.size() - 1);
}

double HandClosing::ShareAtGap(double gap_m) const {
  std::size_t i = 0;
  while (i < points.size() && points[i].gap_m >= gap_m) ++i;
  if (i == 0) return 0.0;
  if (i == points.size()) return 1.0;
  const double u = (points[i - 1].gap_m - gap_m) / (points[i - 1].gap_m - points[i].gap_m);
  return points[i - 1].share + u * (points[i].share - points[i - 1].share);
}

double HandClosing::Touching() const { return ShareAtGap(0.0); }

void HandClosing::Pose(const mjModel* model, mjData* data, double share) const {
  const auto [i, u] = Place(points, share);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    data->qpos[model->jnt_qposadr[joints[k]]] =
        (1.0 - u) * points[i].positions[k] + u * points[i + 1].positions[k];
  }
}

HandClosing CloseOnNothing(const mjModel* model) {
  return CloseOnNothing(model, HandMotors(model));
}

HandClosing CloseOnNothing(const mjModel* model, const std::vector<HandMotor>& motors) {
  return Rehearsal(model, motors).Close();
}

}  // namespace rangegrasp::mjcf
