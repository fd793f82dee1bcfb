#include "grasp/detector.h"

#include <deque>
#include <optional>

#include "base/installation.h"
#include "base/stopwatch.h"
#include "geometry/kd_tree.h"
#include "grasp/proposals.h"
#include "grasp/score_model.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp {
namespace {

using base::kMm;
using base::YamlMap;
using geometry::Observation;
using geometry::Points;
using perception::PerceivedObject;
using perception::Scene;

// Largest distance of measured points of a fixture from its drawn surface: the calibration's error
// (three times 0.1 deg and 1 mm at 1 m), the noise, and smearing at edges.
constexpr double kFixture_m = 0.010;

std::deque<GraspSelector>& Selectors() {
  static std::deque<GraspSelector> selectors;
  return selectors;
}

// Moves the object whose turn is first to the front. @return whether there is one.
bool PutFirst(const Turn& turn, Scene& scene) {
  if (!turn) return true;
  auto& objects = scene.objects;
  auto first = objects.end();
  int first_turn = 0;
  for (auto object = objects.begin(); object != objects.end(); ++object) {
    const auto its = turn(scene.SamplesOf(*object));
    if (!its || (first != objects.end() && *its >= first_turn)) continue;
    first = object;
    first_turn = *its;
  }
  if (first == objects.end()) return false;
  std::rotate(objects.begin(), first, first + 1);
  return true;
}

/// Clusters with fewer points are noise, as for segments (SegmentOptions::min_points).
constexpr std::size_t kMinClusterPoints = 40;

/// Euclidean clusters of the cloud as objects, the one with the highest point first.
/// @param link_m  points within this distance belong together
void AddClusters(double link_m, Scene& scene) {
  const geometry::KdTree tree(scene.cloud.points);
  scene.segments = geometry::GroupsWithin(scene.cloud.points, tree, link_m);
  std::erase_if(scene.segments, [](const auto& one) { return one.size() < kMinClusterPoints; });
  for (const geometry::Indices& segment : scene.segments) {
    scene.objects.push_back(ObjectOfPoints(scene, segment));
  }
  std::ranges::stable_sort(scene.objects, std::ranges::greater(), &PerceivedObject::height_m);
}

/// The dissertation's detector, or the baseline.
class OwnDetector : public Detector {
 public:
  OwnDetector(const DetectorOptions& options, const robot::Robot& robot, bool straight_down,
              SceneObserver observer)
      : options_(options),
        robot_(robot),
        straight_down_(straight_down),
        selector_(straight_down ? nullptr : FindGraspSelector(options.take)),
        observer_(std::move(observer)) {
    if (straight_down || selector_) return;
    if (const auto score = ScoreModelOf(options); !score.empty()) score_.emplace(score);
  }

  Detected Detect(const Observation& observation, base::Rng& rng, const Turn& turn) const override {
    Detected detected;
    base::Stopwatch watch;
    Scene scene = SceneOf(observation, rng);
    detected.seconds.emplace_back("perceive", watch.Restart());
    for (const auto& [step, seconds] : scene.seconds) {
      detected.seconds.emplace_back("perceive: " + step, seconds);
    }
    detected.has_turn = PutFirst(turn, scene);
    Obstacles obstacles;
    std::vector<Grasp> grasps;
    if (selector_ && selector_->prepare) selector_->prepare(scene);
    if (detected.has_turn && !scene.objects.empty()) {
      obstacles = ObstaclesOfViews(scene, 0, observation, options_.obstacles);
      detected.seconds.emplace_back("obstacles", watch.Restart());
      grasps = GraspsOf(observation, scene, obstacles, detected);
      detected.seconds.emplace_back("grasp", watch.Restart());
    }
    if (observer_) observer_(scene, grasps, observation);
    detected.segments = static_cast<int>(scene.segments.size());
    detected.detection = DetectionFrom(scene, grasps);
    detected.detection.obstacles = std::move(obstacles);
    detected.kept = scene.cloud.size();
    if (selector_) {
      for (DetectedGrasp& grasp : detected.detection.grasps) grasp.name = selector_->word;
    }
    return detected;
  }

 private:
  Scene SceneOf(const Observation& observation, base::Rng& rng) const {
    const auto workspace = WorkspaceOf(robot_, options_.workspace_margin_m);
    if (!straight_down_) {
      return perception::Perceive(observation, options_.perception, rng, workspace);
    }
    Scene scene = perception::PerceiveTable(observation, options_.perception, rng, workspace);
    AddClusters(options_.obstacles.link_gaps * GapOf(scene), scene);
    return scene;
  }

  // The first object's grasps.
  std::vector<Grasp> GraspsOf(const Observation& observation, const Scene& scene,
                              const Obstacles& obstacles, Detected& detected) const {
    const robot::HandModel& hand = robot_.hand();
    const auto& measured_C = obstacles.measured_C;
    if (straight_down_) {
      std::vector<Grasp> grasps;
      const auto& points_C = scene.objects.front().completed_C;
      for (const Proposal& way : ProposeStraightDown(points_C, scene.table.plane)) {
        grasps.push_back(PlaceHand(way, hand, options_.grasp));
      }
      CheckProposals(scene, 0, hand, options_.grasp, measured_C, grasps);
      return grasps;
    }
    if (score_) {
      return score_->Plan(observation, scene, 0, hand, Arm(robot_), options_.grasp, measured_C);
    }
    if (!selector_) return PlanGrasps(scene, 0, hand, Arm(robot_), options_.grasp, measured_C);
    auto selected = selector_->plan(scene, 0, hand, options_.grasp, measured_C);
    detected.why_none = std::move(selected.why_none);
    return std::move(selected.grasps);
  }

  const DetectorOptions& options_;
  const robot::Robot& robot_;
  bool straight_down_;
  const GraspSelector* selector_;    ///< null: anywhere
  std::optional<ScoreModel> score_;  ///< absent: by rules
  SceneObserver observer_;
};

}  // namespace

perception::Workspace WorkspaceOf(const robot::Robot& robot, double margin_m) {
  const double radius_m = robot.workspace_radius_m + margin_m;
  const Eigen::Vector3d middle_W = robot.X_WWorkspace.translation();
  std::vector<geometry::Shape> fixtures_W;
  for (const geometry::Shape& shape : robot.workcell()) {
    geometry::Shape grown = geometry::Grown(shape, kFixture_m);
    // Whether the whole fixture is beyond the radius in a direction.
    const auto beyond = [&](const Eigen::Vector3d& u) {
      return -geometry::Support(grown, base::Pose::Identity(), -u) - u.dot(middle_W) > radius_m;
    };
    const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
    if (beyond(x) || beyond(-x) || beyond(y) || beyond(-y)) continue;
    fixtures_W.push_back(std::move(grown));
  }
  return {robot.X_WWorkspace, radius_m, std::move(fixtures_W)};
}

Detection DetectionFrom(const Scene& scene, std::span<const Grasp> grasps, std::size_t object) {
  Detection detection;
  detection.table_C = scene.table.plane;
  for (const PerceivedObject& perceived : scene.objects) {
    detection.objects.push_back(
        {.samples = scene.SamplesOf(perceived),
         .surface_C = perceived.surface_C,
         .rotational = perceived.kind == perception::ObjectKind::kRotational,
         .open = perceived.open,
         .center_C = perceived.center_C,
         .size_m = perceived.size_m});
  }
  for (const Grasp& grasp : grasps) {
    detection.grasps.push_back({.object = object,
                                .X_CH = grasp.X_CH,
                                .opening_m = grasp.opening_m,
                                .width_m = grasp.width_m,
                                .contact_angle_rad = grasp.quality.angles.Larger(),
                                .approach_C = grasp.X_CG.linear().col(2),
                                .score = grasp.score,
                                .type = grasp.type,
                                .pitch_rad = grasp.pitch_rad,
                                .collides = grasp.collides,
                                .name = {},
                                .probability = grasp.probability});
  }
  return detection;
}

std::filesystem::path ScoreModelOf(const DetectorOptions& options) {
  if (options.score == ScoreKind::kRules) return {};
  return options.score_model.empty() ? base::DataFolder() / "models" / "grasp_score.json"
                                     : options.score_model;
}

void AddGraspSelector(const GraspSelector& selector) { Selectors().push_back(selector); }

const GraspSelector* FindGraspSelector(const std::string& word) {
  const auto found = std::ranges::find(Selectors(), word, &GraspSelector::word);
  return found == Selectors().end() ? nullptr : &*found;
}

Points PlacesOf(const Observation& observation) {
  Points places_C;
  for (const auto& view : observation.views) places_C.push_back(view.X_CV.translation());
  return places_C;
}

std::unique_ptr<Detector> MakeDissertationDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer) {
  return std::make_unique<OwnDetector>(options, robot, false, std::move(observer));
}

std::unique_ptr<Detector> MakeStraightDownDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer) {
  return std::make_unique<OwnDetector>(options, robot, true, std::move(observer));
}

void ReadGraspOptions(YamlMap map, DetectorOptions& all) {
  GraspOptions& options = all.grasp;
  std::vector<std::string> words = {kAnywhere};
  std::string where = "where objects are grasped: anywhere";
  for (const GraspSelector& selector : Selectors()) {
    words.push_back(selector.word);
    where += ", or " + selector.about;
  }
  map.Read("take", all.take, words, where);
  map.Read("score", all.score, "what ranks grasps; learned: the predicted probability of delivery");
  map.ReadPath("score_model", all.score_model,
               "file of the learned score, made by scripts/train-grasp-score; without it the "
               "shipped one, models/grasp_score.json");
  if (all.score == ScoreKind::kRules && !all.score_model.empty()) {
    map.Fail("score_model", "is used with `score: learned` only");
  }
  map.ReadScaled("table_clearance_mm", options.table_clearance_m, kMm, 0.0, 50.0,
                 "minimum distance between hand and table");
  map.Read("power_only", options.power_only,
           "only power grasps, also of rotational objects, as for stereo data (section 5.3.2)");
  map.Read("approach", options.approach,
           "approach of the hand: from above; sides_too: also from the sides if few grasps from "
           "above are free; sides: only from the sides (section 7.2)");
  map.Read("preshape", options.preshape,
           "open the hand a little wider than the object; off: fully");
  base::ReadAdditions<GraspAdditions>(map, options);
  map.Finish();
}

}  // namespace rangegrasp::grasp
