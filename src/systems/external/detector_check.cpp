#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "base/process/program.h"
#include "base/units.h"
#include "base/words.h"
#include "external/outside_detector.h"
#include "grasp/detector.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::external {
namespace {

using grasp::Detected;
using grasp::Detector;
using grasp::DetectorFailed;
using trial::Cell;

constexpr const char* kExternal = "external";  // name of the options in trial::Options
constexpr std::size_t kScenes = 3;
// The reported tables use other seeds.
constexpr std::uint64_t kSeed = 11;

struct CheckScene {
  std::string object;
  std::uint64_t seed = 0;
  trial::Sensed sensed;
  int target = 0;
};

std::vector<CheckScene> ScenesOf(const Cell& cell) {
  std::vector<CheckScene> scenes;
  // Spread over the list, whose neighbors are often alike.
  const auto& objects = cell.options.objects;
  const std::size_t step = std::max<std::size_t>(1, objects.size() / kScenes);
  for (std::size_t i = 0; i < objects.size(); i += step) {
    const std::string& object = objects[i];
    const std::uint64_t seed = trial::TrialSeed(kSeed, object, 0);
    auto arranged = ArrangeTrial(cell, {object, 0, seed});
    if (!arranged) continue;
    scenes.push_back({object, seed, Look(cell, arranged->world, seed), arranged->target});
    if (scenes.size() == kScenes) break;
  }
  return scenes;
}

Detected Ask(const Detector& detector, const CheckScene& scene) {
  base::Rng rng = trial::StageStream(scene.seed, "perceive");
  return detector.Detect(scene.sensed.observation, rng);
}

double SecondsOf(const Detected& detected) {
  for (const auto& [stage, seconds] : detected.seconds) {
    if (stage == "detector") return seconds;
  }
  return 0.0;
}

std::string TargetText(const Cell& cell, const CheckScene& scene,
                       const grasp::Detection& detection) {
  if (detection.objects.empty()) return "no object";
  const auto verdict =
      trial::JudgeDetection(detection, scene.sensed,
                            {static_cast<std::uint32_t>(scene.target) + 1, cell.TablePlane(),
                             cell.options.perception.preprocess.table_clearance_m});
  if (!verdict.right_target) return "the first object is not the target";
  return verdict.segmented ? "the first object is the target"
                           : "the first object is a part of the target";
}

std::ptrdiff_t Free(const grasp::Detection& detection) {
  return std::ranges::count_if(detection.grasps, [](const auto& g) { return !g.collides; });
}

std::string Describe(const Cell& cell, const CheckScene& scene, const Detected& detected) {
  const grasp::Detection& detection = detected.detection;
  const auto workspace = grasp::WorkspaceOf(cell.robot, cell.options.workspace_margin_m);
  const auto& grasps = detection.grasps;
  const auto inside = std::ranges::count_if(grasps, [&](const auto& g) {
    return workspace.Contains((g.X_CH * cell.robot.hand().X_HG_tip).translation());
  });
  return fmt::format(
      "{}: {} in the answer; {}{}; {} of the first, {} in the workspace, {} free of collisions; "
      "{}; {:.2f} s\n",
      scene.object, base::Counted(detected.answered, "grasp"),
      base::Counted(detection.objects.size(), "object"),
      detection.objects.empty() || detection.objects.front().whole
          ? ""
          : " (none in the answer: the points between the fingers of the best grasp)",
      base::Counted(grasps.size(), "grasp"), inside, Free(detection),
      TargetText(cell, scene, detection), SecondsOf(detected));
}

// A warning of the first grasp whose approach points against its hand; empty if there is none.
std::string WrongWay(const Cell& cell, const grasp::Detection& detection) {
  for (const grasp::DetectedGrasp& grasp : detection.grasps) {
    const Eigen::Vector3d z_G = (grasp.X_CH * cell.robot.hand().X_HG_tip).linear().col(2);
    const double cosine = std::clamp(z_G.dot(grasp.approach_C), -1.0, 1.0);
    if (cosine >= 0.0) continue;
    return fmt::format(
        "`approach` of a grasp points against z of its `rotation` ({:.0f} deg): it is the "
        "direction in which the hand moves to the object, [0, 0, -1] from above",
        base::ToDeg(std::acos(cosine)));
  }
  return "";
}

bool IsSame(const grasp::Detection& a, const grasp::Detection& b) {
  const auto same_object = [](const auto& p, const auto& q) { return p.samples == q.samples; };
  const auto same_grasp = [](const auto& p, const auto& q) {
    return p.X_CH.matrix() == q.X_CH.matrix() && p.score == q.score;
  };
  return std::ranges::equal(a.objects, b.objects, same_object) &&
         std::ranges::equal(a.grasps, b.grasps, same_grasp);
}

std::string DescribeSandbox(const Cell& cell, const CheckScene& scene, const Detected& before,
                            bool& failed) {
  if (const auto why = process::WhyNoSandbox()) {
    return "sandbox: does not work on this machine: " + *why + "\n";
  }
  auto boxed = trial::Of<OutsideOptions>(cell.options, kExternal);
  const bool wanted = boxed.sandbox;
  boxed.sandbox = true;
  try {
    const Detected again = Ask(*MakeOutsideDetector(boxed, cell.options, cell.robot), scene);
    return std::string(
               "sandbox: works on this machine, and the detector works in it; a repeated question "
               "gave ") +
           (IsSame(before.detection, again.detection)
                ? "the same answer\n"
                : "another answer: use the seed of the question for random numbers\n");
  } catch (const DetectorFailed& e) {
    failed = failed || wanted;
    return fmt::format(
        "sandbox: works on this machine, but the detector does not work in it (no network, one "
        "writable folder): {}\n",
        e.what());
  }
}

/// Queries the cell's external detector on the first arrangement of up to three objects. Describes
/// its answers and the first error with its fix. Then reports whether a sandbox can be made on this
/// machine, whether the detector works in it, and whether it gives the same answer to the same
/// question.
/// @param text  receives the report; ends with a newline
/// @return whether the detector can be used
bool CheckAnswers(const Cell& cell, std::string& text) {
  bool failed = false;
  std::size_t in_air = 0;
  std::ptrdiff_t free = 0;
  std::size_t answered = 0;
  const auto scenes = ScenesOf(cell);
  for (const CheckScene& scene : scenes) {
    try {
      const Detected detected = Ask(*cell.detector, scene);
      text += Describe(cell, scene, detected);
      free += Free(detected.detection);
      answered += detected.answered;
      if (Free(detected.detection) == 0) {
        text += fmt::format("{}: warning: no grasp is free of collisions\n", scene.object);
      }
      if (const auto wrong = WrongWay(cell, detected.detection); !wrong.empty()) {
        text += fmt::format("{}: warning: {}\n", scene.object, wrong);
      }
      if (!detected.why_none.empty()) {
        ++in_air;
        text += fmt::format("{}: {}\n", scene.object, detected.why_none);
      }
      if (&scene == &scenes.back()) text += DescribeSandbox(cell, scene, detected, failed);
    } catch (const DetectorFailed& e) {
      text += fmt::format("{}: detector_failed: {}\n", scene.object, e.what());
      return false;
    }
  }
  if (scenes.empty()) return !failed;
  if (in_air == scenes.size()) return false;
  if (free == 0) {
    text +=
        answered == 0
            ? "no answer has a grasp\n"
            : "no grasp of any scan is free of collisions: is z of `rotation` (its third column) "
              "from the palm to the object, and do `samples` count all samples of the scan, "
              "also those without a point?\n";
    return false;
  }
  return !failed;
}

using trial::Options;

void Read(base::YamlMap keys, Options& options) {
  ReadOutside(std::move(keys), trial::Of<OutsideOptions>(options, kExternal));
}

// Checks that a required sandbox can be made on this machine, and that the detector's time limit is
// less than that of the trial.
void Check(const base::YamlMap& map, const Options& all, double case_limit_s) {
  const auto options = trial::Of<OutsideOptions>(all, kExternal);
  if (options.command.empty()) map.Fail("detector", "key 'command': is missing and has no default");
  if (options.limit_s >= case_limit_s) {
    map.Fail("detector", fmt::format("time_limit_s is {:g} s: it must be less than trial_limit_s "
                                     "({:g} s), the limit of the whole trial",
                                     options.limit_s, case_limit_s));
  }
  if (!options.sandbox) return;
  if (const auto why = process::WhyNoSandbox()) {
    map.Fail("detector", "the sandbox cannot be created: " + *why +
                             "; `sandbox: false` (--set detector.sandbox=false) runs the detector "
                             "without one, if you trust it");
  }
}

// Adds a hash of the files in the command.
void AddTo(const Options& all, experiment::Stamp& stamp) {
  const auto options = trial::Of<OutsideOptions>(all, kExternal);
  std::uint64_t hash = base::Fnv1a(options.sandbox ? "sandbox" : "");
  for (const auto& file : options.files) {
    if (std::filesystem::is_regular_file(file)) {
      hash = base::Fnv1a(file.filename().string() + base::ReadFile(file), hash);
    }
  }
  stamp.identity["detector_hash"] = base::Hex(hash);
}

}  // namespace
}  // namespace rangegrasp::external

namespace rangegrasp {

void RegisterExternal() {
  using namespace external;
  trial::AddDetector({.word = trial::kDetectorWithKeys,
                      .make =
                          [](const trial::Options& options, const robot::Robot& robot,
                             grasp::SceneObserver observer) {
                            return MakeOutsideDetector(
                                trial::Of<OutsideOptions>(options, kExternal), options, robot,
                                std::move(observer));
                          },
                      .read = Read,
                      .check = Check,
                      .add_to = AddTo,
                      .hide =
                          [](const std::filesystem::path& folder, trial::Options& options) {
                            trial::Of<OutsideOptions>(options, kExternal).hidden.push_back(folder);
                          },
                      .check_answers = CheckAnswers});
}

}  // namespace rangegrasp
