#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/yaml_map.h"
#include "grasp/grasp.h"
#include "grasp/obstacles.h"
#include "perception/perceive.h"

namespace rangegrasp::grasp {

struct DetectedObject {
  std::vector<geometry::SampleId> samples;  ///< those that belong to it
  geometry::TriangleMesh surface_C;         ///< completed; may be empty
  bool rotational = false;
  bool open = false;  ///< a container
  /// False: its samples are those between a grasp's fingers, of a detector that names no objects.
  bool whole = true;
};

struct DetectedGrasp {
  std::size_t object = 0;                    ///< position in Detection::objects
  base::Pose X_CH = base::Pose::Identity();  ///< the hand's root body
  double opening_m = 0.0;                    ///< gap of the pads before closing
  double width_m = 0.0;                      ///< what the pads are expected to close on
  /// By how much the faces that are gripped lean away from facing each other; 0 if not known.
  double contact_angle_rad = 0.0;
  Eigen::Vector3d approach_C{0.0, 0.0, -1.0};  ///< unit: the way of the hand towards the object
  double score = 0.0;                          ///< higher is better, within a type
  GraspType type = GraspType::kPower;
  double pitch_rad = 0.0;
  bool collides = false;  ///< the detector's own verdict; such a grasp counts but is not tried
  std::string name;       ///< of a known object's own grasp; else empty
  std::optional<double> probability = {};  ///< of delivery, by a learned score; absent without one
};

/// What any detector hands over: what motions are planned from and detection is scored by. Nothing
/// in it is truth. C is the observation's frame (in a trial W).
struct Detection {
  geometry::Plane table_C;              ///< normal away from the table; z = 0 where none was found
  std::vector<DetectedObject> objects;  ///< in the order in which they should be taken
  std::vector<DetectedGrasp> grasps;    ///< best first
  Obstacles obstacles;                  ///< what else a motion should keep clear of
};

/// What the dissertation's method hands over.
/// @param grasps  of one object, best first (PlanGrasps)
/// @param object  position in scene.objects; its grasps take it along
Detection DetectionFrom(const perception::Scene& scene, std::span<const Grasp> grasps,
                        std::size_t object = 0);

/// `take: anywhere`: by the grasps of chapter 5, without a selector.
inline constexpr const char* kAnywhere = "anywhere";

/// Grasps at a chosen place of an object.
struct SelectedGrasps {
  std::vector<Grasp> grasps;  ///< free ones first, the best of these first
  std::string why_none;       ///< what is missing where there is none
};

/// Decides where an object is taken, e.g. by its handle. Sees what was perceived, and no truth.
struct GraspSelector {
  std::string word;   ///< of the key grasp.take, and the name of its grasps
  std::string about;  ///< for the key's documentation: "by the handle ..."
  /// Changes what was perceived before grasps are looked for; may be null.
  void (*prepare)(perception::Scene& scene) = nullptr;
  /// @param object  position in scene.objects
  /// @param obstacles_C  what the hand must not touch besides the other objects
  SelectedGrasps (*plan)(const perception::Scene& scene, std::size_t object,
                         const robot::HandModel& hand, const GraspOptions& options,
                         std::span<const geometry::TriangleMesh> obstacles_C) = nullptr;
  /// What is held there would creep about the pads: the strongest grip at once.
  bool firm = false;
};

void AddGraspSelector(const GraspSelector& selector);
/// Of a word of grasp.take; null: anywhere.
const GraspSelector* FindGraspSelector(const std::string& word);
/// kAnywhere and those of all selectors.
std::vector<std::string> GraspSelectorWords();

/// What lies within margin_m of the robot's workspace, in W, without what was measured on the work
/// cell's fixtures there (Robot::workcell).
perception::Workspace WorkspaceOf(const robot::Robot& robot, double margin_m);

/// What a detector hands over, with what a record tells of how it came to it.
struct Detected {
  Detection detection;
  std::size_t kept = 0;  ///< samples that it took for parts of objects, after its filters
  int segments = 0;
  std::string why_none;  ///< no grasp, where the detector says so; else empty
  bool has_turn = true;  ///< whether the first object may be taken; if not, none may
  std::vector<std::pair<std::string, double>> seconds;  ///< by stage
};

/// A detector that is another program gave no answer, or none that can be used: an outcome.
class DetectorFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// When an object is to be taken, by its samples: lower ones first, those of one turn in the
/// detector's own order; nullopt: not at all. Empty: the detector's own order.
using Turn = std::function<std::optional<int>(const std::vector<geometry::SampleId>&)>;

/// Stage 3: finds objects and grasps in an observation, without truth.
class Detector {
 public:
  virtual ~Detector() = default;
  /// @param turn  decides which object is taken first, and is the one with grasps
  /// @throws base::InputError for an observation in which it finds no table, DetectorFailed.
  virtual Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                          const Turn& turn = {}) const = 0;
};

/// What a viewer may see of the dissertation's method.
using SceneObserver = std::function<void(const perception::Scene&, const std::vector<Grasp>&,
                                         const geometry::Observation&)>;

/// Where the sensors stood, one a view.
geometry::Points PlacesOf(const geometry::Observation& observation);

/// What ranks free grasps: the planner's own score, or a learned one (score_model.h).
enum class ScoreKind { kRules, kLearned };
constexpr std::array<std::string_view, 2> WordsOf(ScoreKind) { return {"rules", "learned"}; }

/// What a detector is given with the observation.
struct DetectorOptions {
  perception::PerceptionOptions perception;
  GraspOptions grasp;
  ObstacleOptions obstacles;
  double workspace_margin_m = 0.15;  ///< further out stand the arm, its pedestal, the table's rim
  std::string take = kAnywhere;      ///< or the word of a selector, which ranks by rules
  ScoreKind score = ScoreKind::kLearned;
  std::filesystem::path score_model;  ///< of the learned score (score_model.h); empty: the shipped
};

/// The file of the learned score that ranks grasps; empty with rules.
std::filesystem::path ScoreModelOf(const DetectorOptions& options);

/// The dissertation's method (chapter 5): perception, then grasps for the topmost object. The
/// arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeDissertationDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer = {});

/// The baseline: what hangs together above the table is an object, the highest one is taken, by
/// ProposeStraightDown. Of the options only perception.preprocess, obstacles and what checks a hand
/// for collisions count. The arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeStraightDownDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer = {});

/// Reads the keys of the mapping `grasp`, to its end.
/// @throws base::InputError
void ReadGraspOptions(base::YamlMap map, DetectorOptions& options);

}  // namespace rangegrasp::grasp
