#include "trial/tryout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <map>

#include "base/file.h"
#include "base/installation.h"
#include "base/process/program.h"
#include "base/words.h"
#include "experiment/runner.h"
#include "sim/check/fix.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

using base::Finding;
using base::kMmPerM;
using Eigen::VectorXd;

constexpr int kTrialsPerObject = 3;
constexpr double kLimit_s = 45.0;  // computing time
// Widths of the objects, as shares of the hand's opening or of kWidest_m, whichever is smaller.
constexpr std::array<double, 3> kWidths = {0.4, 0.6, 0.8};
constexpr double kWidest_m = 0.1;
constexpr double kHeight_m = 0.1;
constexpr double kDensity_kg_m3 = 600.0;  // of a full carton
constexpr double kFoot = 0.4;             // radius of a ball's foot / the ball's, against rolling
constexpr double kPasses = 0.9;           // delivered / all trials
// Less than the 5 mrad that count as contact in an approach (sim/execute.cpp).
constexpr double kLag_rad = 0.004;
constexpr double kSlower = 0.8;  // each round lowers the limits at least by this factor
constexpr int kRounds = 6;
// Limits below this share of the file's are no fix: the drives are too weak.
constexpr double kUsable = 0.1;
constexpr double kPressed = 0.6;  // minimum measured / commanded grip force
constexpr double kSlid_m = 0.01;
constexpr int kMoreNoslip = 30;  // iterations against creep, in place of bench.xml's 10
constexpr std::uint64_t kSeed = 101;

// CPU time of this process, so that other processes do not influence the findings.
double Computed_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void WriteObject(const std::filesystem::path& folder, const std::string& name,
                 const std::vector<std::string>& geoms) {
  std::string elements;
  for (const std::string& geom : geoms) {
    elements += fmt::format(
        "<geom group=\"2\" contype=\"0\" conaffinity=\"0\" mass=\"0\" {0}/>"
        "<geom group=\"3\" condim=\"6\" friction=\"0.25 0.003 0.0005\" solref=\"0.005 1\" "
        "solimp=\"0.95 0.99 0.001 0.5 2\" density=\"{1:g}\" {0}/>",
        geom, kDensity_kg_m3);
  }
  base::WriteFile(folder / name / (name + ".xml"),
                  fmt::format("<mujoco model=\"{0}\"><custom><text name=\"surface\" "
                              "data=\"cardboard\"/></custom><worldbody><body name=\"{0}\">"
                              "<freejoint/>{1}</body></worldbody></mujoco>",
                              name, elements));
}

// Options for the generated objects alone on the table, with the method of chapter 5.
Options Generated(Options options, const std::filesystem::path& folder) {
  const double opening_m = robot::Robot::Load(options.scene).hand().MaxGap();
  options.object_folders = {folder};
  options.objects.clear();
  for (const double share : kWidths) {
    const double w = share * std::min(opening_m, kWidest_m);
    const double r = 0.5 * w;
    const double half_m = 0.5 * kHeight_m;
    const auto add = [&](const char* shape, const std::vector<std::string>& geoms) {
      options.objects.push_back(fmt::format("{}_{}_mm", shape, std::lround(w * kMmPerM)));
      WriteObject(folder, options.objects.back(), geoms);
    };
    add("box", {fmt::format("type=\"box\" size=\"{:.5f} {:.5f} {:.5f}\"", r, 0.6 * w, half_m)});
    add("cylinder", {fmt::format("type=\"cylinder\" size=\"{:.5f} {:.5f}\"", r, half_m)});
    add("ball", {fmt::format("type=\"sphere\" size=\"{:.5f}\"", r),
                 fmt::format("type=\"cylinder\" size=\"{:.5f} 0.001\" pos=\"0 0 {:.5f}\"",
                             kFoot * r, 0.001 - r)});
  }
  options.arranger = kSingle;
  options.detector = kDissertation;
  options.take = grasp::kAnywhere;
  options.clutter.always.clear();
  options.clutter.others.clear();
  options.trials_per_object = kTrialsPerObject;
  return options;
}

// Why trials fail, and how to fix it.
struct Cause {
  std::string element, what, cure;
  std::vector<base::Edit> edits = {};
};

constexpr const char* kCreep = "creep";

// The fix for a failed audit, by the name of its value (sim/internal/audit.cpp).
std::string CureOf(const std::string& failed, const std::filesystem::path& scene) {
  const auto fails = [&](const char* name) { return failed.find(name) != std::string::npos; };
  const auto firmer = [](const std::string& attributes, const char* where) {
    return attributes.empty() ? "" : attributes + where + ", or ";
  };
  const std::string gentler = "a lower \"grip_force\"";
  if (fails("equality")) {
    return firmer(check::FirmerEqualities(scene), " on the hand's <equality>") + gentler;
  }
  if (fails("penetration")) {
    return firmer(check::FirmerTips(scene), " on the fingertips") + gentler;
  }
  const std::array<std::pair<const char*, const char*>, 6> cures = {{
      {kCreep,
       "condim=\"4\" priority=\"1\" on the fingertips, impratio=\"10\" cone=\"elliptic\" in "
       "<option>"},
      {"unrest", "a higher first \"grip_force\""},
      {"drive_limit", "a wider forcerange of the arm's drives, or a lower \"joint_acceleration\""},
      {"tracking", "a lower \"joint_acceleration\", or stiffer drives"},
      {"grip", "a lower \"grip_force\", or a narrower forcerange of the hand's drives"},
      {"", "a smaller timestep, and armature and damping in the joints of hand and arm"},
  }};
  return std::ranges::find_if(cures, [&](const auto& cure) { return fails(cure.first); })->second;
}

const char* const kStronger =
    "a lower \"grip_force\", less damping of the hand's joints, or, as far as its data sheet "
    "allows, a higher kp or a wider forcerange of the drives that close it";

bool PressesLess(const sim::ExecutionLog& log) {
  return log.felt_force_N > 0.0 && log.felt_force_N < kPressed * log.grip_force_N;
}

Cause OfTheGrip(const Attempt& attempt) {
  const sim::ExecutionLog& log = *attempt.log;
  if (!log.stopped_by_contact.empty() && !log.held_after_carry) {
    return {
        "the arm",
        fmt::format(
            "is stopped in {}: a joint lags {:.1f} mrad behind there, and 5 mrad count as contact",
            log.stopped_by_contact.front(), 1e3 * log.audit.tracking_error_rad),
        "lower \"joint_acceleration\", use stiffer drives, or clear the space around the arm"};
  }
  if (PressesLess(log)) {
    return {"the hand",
            fmt::format("presses with {:.0f} N where \"grip_force\" asks for {:.0f} N",
                        log.felt_force_N, log.grip_force_N),
            kStronger};
  }
  if (log.felt_force_N <= 0.0 && log.grip_force_N > 0.0 && log.lift_height_m < kSlid_m) {
    return {"the hand", "closes without any pressure on the object",
            "a wider forcerange or a higher kp of the drives of \"hand_motors\", \"hand_closed\" "
            "further closed, a site \"tcp\" between the pads"};
  }
  return {"the hand",
          fmt::format("loses the object: it slides by {:.0f} mm and turns by {:.0f} deg in the "
                      "hand, at a grip of {:.0f} N",
                      log.slip_in_hand_m * kMmPerM, base::ToDeg(log.tilt_in_hand_rad),
                      log.grip_force_N),
          "a higher \"grip_force\" (with drives that can give it), \"grip_sensors\" so that slips "
          "are felt, condim=\"4\" and priority=\"1\" on the fingertips"};
}

std::string FirstSeen(const Attempt& attempt) {
  const auto& objects = attempt.detected.detection.objects;
  if (objects.empty() || objects.front().surface_C.vertices.empty()) return "something else";
  const auto box = geometry::BoundsOf(objects.front().surface_C.vertices);
  return fmt::format("the part at x {:.0f} to {:.0f}, y {:.0f} to {:.0f}, z up to {:.0f} mm",
                     box.min().x() * kMmPerM, box.max().x() * kMmPerM, box.min().y() * kMmPerM,
                     box.max().y() * kMmPerM, box.max().z() * kMmPerM);
}

Cause CauseOf(const Attempt& attempt, const std::filesystem::path& scene) {
  switch (attempt.outcome) {
    case Outcome::kWrongTarget:
      return {"the scene", "is mistaken for an object: " + FirstSeen(attempt),
              "add a collision geom (group=\"3\") of its shape, so that it is known; or move it; "
              "or lower `workspace_margin_mm` in the experiment"};
    case Outcome::kNotSegmented:
      return {"the sensor", "does not show the object as a single object: " + attempt.detail,
              "move the sensor nearer to the workspace, or clear its line of sight"};
    case Outcome::kNoGrasp:
      return {"the hand", "finds no grasp that is free of collisions: " + attempt.detail,
              "a hand that opens wider (\"hand_open\"), a site \"tcp\" between the pads"};
    case Outcome::kNoPath:
      return {"the arm", "finds no motion: " + attempt.detail,
              "mount the hand or the arm differently, or clear the space there"};
    case Outcome::kInvalidPhysics:
      return {"the physics", "is not valid: " + attempt.detail, CureOf(attempt.detail, scene)};
    case Outcome::kNotLifted:
    case Outcome::kDropped:
      return OfTheGrip(attempt);
    case Outcome::kMisplaced:
      return {"the release", attempt.detail, "a hand that opens wider (\"hand_open\")"};
    default:
      return {"a trial", attempt.detail, ""};
  }
}

// Runs the trials of one cell in sequence.
class Trying {
 public:
  Trying(Cell& cell, const std::function<void(const std::string&)>& say) : cell_(cell), say_(say) {}

  Tryout Run() {
    const auto cases = experiment::InTurn(TrialsOf(cell_.options, kSeed));
    if (say_) {
      say_(fmt::format("tries {} trials: reach, grasp, lift, carry and release of {}", cases.size(),
                       base::Join(cell_.options.objects)));
    }
    for (const experiment::Case& which : cases) {
      if (Computed_s() - start_s_ > kLimit_s) break;
      Try(SpecOf(which));
    }
    const bool error = tried_.delivered < kPasses * tried_.trials;
    CheckCreep(cases);
    CheckLag();
    CheckGrip();
    for (const auto& [key, group] : groups_) Report(error, group);
    std::ranges::stable_partition(tried_.findings, &Finding::error);
    return std::move(tried_);
  }

 private:
  struct Group {
    Cause first;
    std::map<std::string, int> outcomes;
    std::vector<std::string> objects;
    int count = 0;
  };

  Attempt AttemptAt(const TrialSpec& spec) const {
    Attempt attempt;
    RunTrial(cell_, spec, nullptr, {}, &attempt);
    return attempt;
  }

  void Try(const TrialSpec& spec) {
    const Attempt attempt = AttemptAt(spec);
    if (attempt.stage == "arrange") return;  // a fault of the objects, not of the cell
    ++tried_.trials;
    tried_.detected += attempt.accepted ? 1 : 0;
    tried_.delivered += attempt.outcome == Outcome::kDelivered ? 1 : 0;
    if (attempt.log && attempt.log->lags_rad.size() > 0) {
      const VectorXd& lags_rad = attempt.log->lags_rad;
      if (lags_rad_.size() == 0) lags_rad_ = VectorXd::Zero(lags_rad.size());
      if (lags_rad.maxCoeff() > lags_rad_.maxCoeff()) worst_ = spec;
      lags_rad_ = lags_rad_.cwiseMax(lags_rad);
    }
    if (attempt.log && PressesLess(*attempt.log)) ++weak_;
    if (attempt.outcome == Outcome::kDelivered) return;
    if (attempt.outcome == Outcome::kInvalidPhysics) ++invalid_;
    const Cause cause = CauseOf(attempt, cell_.options.scene);
    Group& group = groups_[cause.element + cause.cure];
    if (group.count++ == 0) group.first = cause;
    ++group.outcomes[std::string(base::Word(attempt.outcome))];
    AddOnce({spec.object}, group.objects);
  }

  void Report(bool error, const Group& group) {
    std::vector<std::string> outcomes;
    for (const auto& [word, count] : group.outcomes)
      outcomes.push_back(fmt::format("{} {}", word, count));
    tried_.findings.push_back(
        {error, cell_.options.scene.string(), group.first.element,
         fmt::format("{} ({} of {} trials, {}: {})", group.first.what, group.count, tried_.trials,
                     base::Join(outcomes), base::Join(group.objects)),
         group.first.cure, group.first.edits});
  }

  // Contacts may creep because the solver has too few iterations against it; with more, other hands
  // creep. So all trials are run again with more, which are proposed if fewer then fail.
  void CheckCreep(const std::vector<experiment::Case>& cases) {
    const std::string cure = CureOf(kCreep, cell_.options.scene);
    const auto creeps = [&](const auto& group) { return group.second.first.cure == cure; };
    const auto creeping = std::ranges::find_if(groups_, creeps);
    if (creeping == groups_.end()) return;
    int trials = 0, invalid = 0;
    cell_.options.physics.min_noslip = kMoreNoslip;
    for (const experiment::Case& which : cases) {
      if (trials == tried_.trials) break;
      const Attempt attempt = AttemptAt(SpecOf(which));
      trials += attempt.stage == "arrange" ? 0 : 1;
      invalid += attempt.outcome == Outcome::kInvalidPhysics ? 1 : 0;
    }
    cell_.options.physics.min_noslip = 0;
    if (invalid >= invalid_) return;
    Cause& cause = creeping->second.first;
    cause.edits = {{.file = cell_.options.scene.string(),
                    .element = "/*/option",
                    .set = {{"noslip_iterations", std::to_string(kMoreNoslip)}}}};
    cause.cure =
        fmt::format(" (tried: {} instead of {} trials are then invalid)\nor ", invalid, invalid_) +
        cause.cure;
  }

  // Drives that do not reach the grip force will not hold heavier objects than those tried.
  void CheckGrip() {
    if (2 * weak_ <= tried_.trials || tried_.delivered < kPasses * tried_.trials) return;
    tried_.findings.push_back(
        {false, cell_.options.scene.string(), "the hand",
         fmt::format("presses with less than {:.0f} % of the commanded grip in {} of {} trials",
                     100.0 * kPressed, weak_, tried_.trials),
         kStronger});
  }

  // A joint that lags behind can stop the arm as if it had hit something. This is an error even if
  // all trials succeeded.
  void CheckLag() {
    std::vector<int> slow;
    std::vector<std::string> names;
    for (int i = 0; i < lags_rad_.size(); ++i) {
      if (lags_rad_[i] <= kLag_rad) continue;
      slow.push_back(i);
      names.push_back(std::to_string(i + 1));
    }
    if (slow.empty()) return;
    Finding behind{
        true, cell_.options.scene.string(), "joints " + base::Join(names) + " of the arm",
        fmt::format("lag up to {:.1f} mrad behind in the motions of a trial; a lag of more than 5 "
                    "mrad counts as contact, more than 8 mrad ends the grasp",
                    1e3 * lags_rad_.maxCoeff()),
        ""};
    SlowEnough(slow, behind);
    tried_.findings.push_back(behind);
  }

  // Adds a fix for the slow joints: limits with which the drives can follow in the worst trial.
  void SlowEnough(const std::vector<int>& slow, Finding& behind) {
    robot::Robot& robot = cell_.robot;
    const VectorXd velocity = robot.velocity, acceleration = robot.acceleration;
    VectorXd lags_rad = lags_rad_;
    for (int round = 0; round < kRounds && lags_rad.maxCoeff() > kLag_rad; ++round) {
      for (Eigen::Index i = 0; i < lags_rad.size(); ++i) {
        if (lags_rad[i] <= kLag_rad) continue;
        const double slower = std::min(kSlower, kLag_rad / lags_rad[i]);
        robot.acceleration[i] = Rounded(slower * robot.acceleration[i]);
        if (round > 0) robot.velocity[i] = Rounded(slower * robot.velocity[i]);
      }
      const Attempt attempt = AttemptAt(worst_);
      if (!attempt.log || attempt.log->lags_rad.size() == 0) break;
      lags_rad = attempt.log->lags_rad;
    }
    std::vector<base::Edit>& edits = behind.edits;
    const auto limit = [&](const char* name, const VectorXd& values) {
      const auto made =
          check::SetNumeric(cell_.options.scene, name,
                            fmt::format("{:g}", fmt::join(values.begin(), values.end(), " ")));
      edits.insert(edits.end(), made.begin(), made.end());
    };
    const double slowest = (robot.acceleration.array() / acceleration.array()).minCoeff();
    const bool held = lags_rad.maxCoeff() <= kLag_rad && slowest >= kUsable;
    const double stiffer = std::ceil(lags_rad_.maxCoeff() / (kSlower * kLag_rad));
    if (held) {
      limit("joint_acceleration", robot.acceleration);
      if (robot.velocity != velocity) limit("joint_velocity", robot.velocity);
      behind.cure = fmt::format(" (tried)\nor kp of their drives {:.0f} times as high", stiffer);
    } else {
      edits = check::StifferDrives(cell_.options.scene, slow, stiffer);
    }
    behind.cure += edits.empty() ? "a higher kp of their drives" : "";
    behind.cure += ", or less damping of the joints";
    robot.velocity = velocity;
    robot.acceleration = acceleration;
  }

  static double Rounded(double v) { return std::max(0.01, std::floor(100.0 * v) / 100.0); }

  Cell& cell_;
  const std::function<void(const std::string&)>& say_;
  double start_s_ = Computed_s();
  Tryout tried_;
  std::map<std::string, Group> groups_;
  VectorXd lags_rad_;  ///< largest lag of each joint
  TrialSpec worst_;    ///< the trial with the largest lag
  int weak_ = 0;       ///< number of trials with too little grip force at the pads
  int invalid_ = 0;    ///< number of trials whose physics is not valid
};

}  // namespace

std::string Tryout::Text() const {
  return fmt::format("{} tried: {} detected, {} delivered", base::Counted(trials, "trial"),
                     detected, delivered);
}

Options OptionsOf(const std::filesystem::path& scene) {
  Options options;
  options.scene = scene;
  options.sensor = base::DataFolder() / "models/sensors/line_scanner.yaml";
  options.sensor_type = kLineScanner;
  options.perception.stated_noise = FindSensor(kLineScanner)->states_noise;
  options.arranger = kSingle;
  options.detector = kDissertation;
  SetMethod(MethodKind::kImproved, options);
  return options;
}

std::vector<Finding> CheckSight(const Cell& cell) {
  if (cell.sensor->Rehearses()) return {};
  const robot::Robot& robot = cell.robot;
  const Sensed sensed = Look(cell, WorldOf(cell.options, {}), kSeed);
  const base::Pose X_PlaceW = robot.X_WWorkspace.inverse();
  std::size_t measured = 0;
  for (const geometry::View& view : sensed.observation.views) {
    for (const Eigen::Vector3d& p_W : view.image.points_C) {
      if (!p_W.allFinite()) continue;
      ++measured;
      if ((X_PlaceW * p_W).head<2>().norm() <= robot.workspace_radius_m) return {};
    }
  }
  const Eigen::Vector3d center_mm = robot.X_WWorkspace.translation() * kMmPerM;
  return {
      {true, cell.options.sensor.string(), "the sensor",
       fmt::format("measures no point of the workspace, which is {:.0f} mm about x {:.0f}, y "
                   "{:.0f} mm on the table ({} elsewhere)",
                   robot.workspace_radius_m * kMmPerM, center_mm.x(), center_mm.y(),
                   base::Counted(static_cast<std::int64_t>(measured), "point")),
       "turn it to the workspace: by the site \"scanner\" of the scene (x right, y down, z "
       "forward), or by `place` or `site` in a depth camera's file; and let the file's range of "
       "depths and field of view include the workspace"}};
}

Tryout TryCell(Options options, const std::function<void(const std::string&)>& say) {
  const process::OwnFolder folder;
  Cell cell(Generated(std::move(options), folder.path()));
  cell.sensor->Prepare();
  return Trying(cell, say).Run();
}

}  // namespace rangegrasp::trial
