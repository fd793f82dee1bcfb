// How often objects are taken as rotational: arranges, scans, perceives and plans grasps, without
// moving the arm. One line a scan as CSV; then, to stderr, one for each object and pose.
//
//   rangegrasp_rotational_survey EXPERIMENT.yaml --seed N --scans N [--objects a,b] [--set K=V ...]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/units.h"
#include "base/words.h"
#include "experiment/experiment.h"
#include "register_all.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp {
namespace {

using Eigen::Vector3d;

/// Bodies of revolution about their model's z axis, but for a handle.
constexpr std::array<std::string_view, 5> kRound{"salt_cylinder", "sweets_cylinder", "spread",
                                                 "coffee_cup", "bowl"};
/// Neither round nor without a round side: counted apart.
constexpr std::array<std::string_view, 3> kBetween{"sweets_half_cylinder", "shower_gel", "cleaner"};
/// An axis within this of the vertical stands, one within this of the horizontal lies.
constexpr double kStanding_rad = base::Deg(20.0);
/// A perceived axis within this of the model's is the right one.
constexpr double kSameAxis_rad = base::Deg(10.0);

std::string ShapeOf(std::string_view object) {
  const auto in = [&](const auto& names) {
    return std::find(names.begin(), names.end(), object) != names.end();
  };
  return in(kRound) ? "round" : in(kBetween) ? "between" : "box";
}

std::string PoseOf(const Vector3d& axis_W) {
  const double tilt = std::acos(std::min(1.0, std::abs(axis_W.z())));
  if (tilt < kStanding_rad) return "upright";
  return tilt > 0.5 * base::kPi - kStanding_rad ? "lying" : "leaning";
}

/// What the detector made of a scan's first object.
struct Seen {
  std::optional<perception::PerceivedObject> object;
  std::array<int, 3> free{};  ///< grasps by type
};

Seen See(const trial::Cell& cell, const trial::Arrangement& arranged,
         const trial::TrialSpec& spec) {
  Seen seen;
  const auto look = [&](const perception::Scene& scene, const std::vector<grasp::Grasp>& grasps,
                        const geometry::Observation&) {
    if (!scene.objects.empty()) seen.object = scene.objects.front();
    for (const auto& g : grasps) seen.free[static_cast<std::size_t>(g.type)] += g.collides ? 0 : 1;
  };
  const auto sensed = Look(cell, arranged.world, spec.seed);
  base::Rng rng(base::DeriveSeed(spec.seed, "perceive"));
  MakeDetector(cell.options, cell.robot, look)->Detect(sensed.observation, rng);
  return seen;
}

struct Count {
  int scans = 0;
  int rotational = 0;
  int right_axis = 0;
};

void Print(const std::map<std::string, Count>& counts) {
  for (const auto& [what, count] : counts) {
    fmt::print(stderr, "{:32} {:4} scans, rotational {:4} ({:5.1f} %), about its axis {:4}\n", what,
               count.scans, count.rotational, 100.0 * count.rotational / count.scans,
               count.right_axis);
  }
}

void Survey(const trial::Cell& cell, const std::vector<std::string>& objects, std::uint64_t seed,
            int scans) {
  std::map<std::string, Count> counts;
  fmt::print(
      "object,index,shape,pose,kind,open,axis_error_deg,center_error_mm,radius_mm,rim_fraction,"
      "body_fraction,cylindrical,rim,power\n");
  for (const auto& object : objects.empty() ? cell.options.objects : objects) {
    for (int i = 0; i < scans; ++i) {
      const trial::TrialSpec spec{object, i, trial::TrialSeed(seed, object, i)};
      const auto arranged = ArrangeTrial(cell, spec);
      if (!arranged) continue;
      const auto X_WO = arranged->world.ObjectPose(arranged->target);
      const Vector3d axis_W = X_WO.linear().col(2);
      const Seen seen = See(cell, *arranged, spec);
      const bool rotational =
          seen.object && seen.object->kind == perception::ObjectKind::kRotational;
      perception::RotationAxis axis{Vector3d::Zero(), Vector3d::UnitZ()};
      if (rotational) axis = *seen.object->axis;
      const double error = std::acos(std::min(1.0, std::abs(axis.direction_C.dot(axis_W))));
      const double off = (axis.center_C - X_WO.translation()).cross(axis_W).norm();
      fmt::print("{},{},{},{},{},{},{:.1f},{:.1f},{:.1f},{:.2f},{:.2f},{},{},{}\n", object, i,
                 ShapeOf(object), PoseOf(axis_W),
                 seen.object ? base::Word(seen.object->kind) : "nothing",
                 seen.object && seen.object->open ? 1 : 0, base::ToDeg(error), off / base::kMm,
                 axis.radius_m / base::kMm, axis.rim_fraction, axis.body_fraction, seen.free[0],
                 seen.free[1], seen.free[2]);
      for (const std::string& what :
           {"all " + ShapeOf(object) + " " + PoseOf(axis_W), object + " " + PoseOf(axis_W)}) {
        Count& count = counts[what];
        ++count.scans;
        count.rotational += rotational ? 1 : 0;
        count.right_axis += rotational && error < kSameAxis_rad ? 1 : 0;
      }
    }
  }
  Print(counts);
}

}  // namespace
}  // namespace rangegrasp

int main(int argc, char** argv) {
  rangegrasp::RegisterAll();
  std::string file;
  std::uint64_t seed = 0;
  int scans = 10;
  rangegrasp::experiment::Changes changes;
  CLI::App app{"How often objects are taken as rotational, without moving the arm."};
  app.add_option("experiment", file, "experiment file (YAML)")->required();
  app.add_option("--seed", seed, "of the experiment")->required();
  app.add_option("--scans", scans, "of each object");
  app.add_option("--objects", changes.groups, "only these")->delimiter(',');
  app.add_option("--set", changes.set, "KEY=VALUE")->take_all();
  CLI11_PARSE(app, argc, argv);
  const auto experiment =
      rangegrasp::experiment::OpenExperiment(file, rangegrasp::experiment::AllKinds(), changes);
  rangegrasp::Survey(rangegrasp::trial::CellOf(*experiment.task), changes.groups, seed, scans);
  return 0;
}
