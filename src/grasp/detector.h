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
  std::vector<geometry::SampleId> samples;  ///< the samples that belong to it
  geometry::TriangleMesh surface_C;         ///< completed; may be empty
  bool rotational = false;
  bool open = false;  ///< a container
  /// False: its samples are those between a grasp's fingers, from a detector that names no objects.
  bool whole = true;
  Eigen::Vector3d center_C = Eigen::Vector3d::Zero();  ///< its box: PerceivedObject::center_C
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();    ///< PerceivedObject::size_m
};

struct DetectedGrasp {
  std::size_t object = 0;                    ///< position in Detection::objects
  base::Pose X_CH = base::Pose::Identity();  ///< the hand's root body
  double opening_m = 0.0;                    ///< gap of the pads before closing
  double width_m = 0.0;                      ///< expected gap of the pads after closing
  /// Angle by which the gripped faces deviate from facing each other; 0 if not known.
  double contact_angle_rad = 0.0;
  Eigen::Vector3d approach_C{0.0, 0.0, -1.0};  ///< unit: direction of the hand towards the object
  double score = 0.0;                          ///< higher is better; comparable within a type only
  GraspType type = GraspType::kPower;
  double pitch_rad = 0.0;
  bool collides = false;  ///< the detector's own verdict; such a grasp counts but is not tried
  std::string name;       ///< name of a known object's grasp; else empty
  std::optional<double> probability = {};  ///< of delivery, by a learned score; absent without one
};

/// Output of any detector: motions are planned from it, and detection is scored by it. It contains
/// no ground truth. C is the observation's frame (W in a trial).
struct Detection {
  geometry::Plane table_C;              ///< normal away from the table; z = 0 if none was found
  std::vector<DetectedObject> objects;  ///< in the order in which they should be grasped
  std::vector<DetectedGrasp> grasps;    ///< best first
  Obstacles obstacles;                  ///< other things that a motion should avoid
};

/// Output of the dissertation's method.
/// @param grasps  of one object, best first (PlanGrasps)
/// @param object  position in scene.objects; stored with its grasps
Detection DetectionFrom(const perception::Scene& scene, std::span<const Grasp> grasps,
                        std::size_t object = 0);

/// `take: anywhere`: the grasps of chapter 5, without a selector.
inline constexpr const char* kAnywhere = "anywhere";

/// Grasps at a chosen place of an object.
struct SelectedGrasps {
  std::vector<Grasp> grasps;  ///< free ones first, the best of these first
  std::string why_none;       ///< what is missing if there is none
};

/// Decides where an object is grasped, e.g. by its handle, without ground truth.
struct GraspSelector {
  std::string word;   ///< value of the key grasp.take, and the name of its grasps
  std::string about;  ///< for the key's documentation: "by the handle ..."
  /// Changes the perceived scene before grasps are planned; may be null.
  void (*prepare)(perception::Scene& scene) = nullptr;
  /// @param object  position in scene.objects
  /// @param obstacles_C  what the hand must not touch besides the other objects
  SelectedGrasps (*plan)(const perception::Scene& scene, std::size_t object,
                         const robot::HandModel& hand, const GraspOptions& options,
                         std::span<const geometry::TriangleMesh> obstacles_C) = nullptr;
  /// An object held there would creep between the pads, so the strongest grip is used at once.
  bool firm = false;
};

void AddGraspSelector(const GraspSelector& selector);
/// The selector of a word of grasp.take; null: anywhere.
const GraspSelector* FindGraspSelector(const std::string& word);

/// The region within margin_m of the robot's workspace, in W, without the samples measured there on
/// the work cell's fixtures (Robot::workcell).
perception::Workspace WorkspaceOf(const robot::Robot& robot, double margin_m);

/// Output of a detector, with data on how it was obtained, for the record.
struct Detected {
  Detection detection;
  std::size_t kept = 0;      ///< samples taken for parts of objects, after its filters
  std::size_t answered = 0;  ///< grasps in the answer of an outside detector
  int segments = 0;
  std::string why_none;  ///< why there is no grasp, if the detector says so; else empty
  bool has_turn = true;  ///< whether the first object may be grasped; if not, none may
  std::vector<std::pair<std::string, double>> seconds;  ///< time of each stage
};

/// An external detector gave no answer, or no usable one. This counts as an outcome.
class DetectorFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Decides when an object is grasped, from its samples: lower values come first, equal ones in the
/// detector's own order; nullopt: not at all. If empty, the detector's own order is used.
using Turn = std::function<std::optional<int>(const std::vector<geometry::SampleId>&)>;

/// Stage 3: finds objects and grasps in an observation, without ground truth.
class Detector {
 public:
  virtual ~Detector() = default;
  /// @param turn  decides which object comes first; only that one has grasps
  /// @throws base::InputError if it finds no table in the observation, DetectorFailed.
  virtual Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                          const Turn& turn = {}) const = 0;
};

/// Receives the intermediate results of the dissertation's method, for a viewer.
using SceneObserver = std::function<void(const perception::Scene&, const std::vector<Grasp>&,
                                         const geometry::Observation&)>;

/// Positions of the sensors, one per view.
geometry::Points PlacesOf(const geometry::Observation& observation);

/// Which score ranks free grasps: the planner's own, or a learned one (score_model.h).
enum class ScoreKind { kRules, kLearned };
constexpr std::array<std::string_view, 2> WordsOf(ScoreKind) { return {"rules", "learned"}; }

/// Options of a detector.
struct DetectorOptions {
  perception::PerceptionOptions perception;
  GraspOptions grasp;
  ObstacleOptions obstacles;
  double workspace_margin_m = 0.15;  ///< beyond are the arm, its pedestal and the table's rim
  std::string take = kAnywhere;      ///< or the word of a selector, which ranks by rules
  ScoreKind score = ScoreKind::kLearned;
  std::filesystem::path score_model;  ///< learned score's file (score_model.h); empty: shipped one
};

/// The file of the learned score that ranks grasps; empty with ScoreKind::kRules.
std::filesystem::path ScoreModelOf(const DetectorOptions& options);

/// The dissertation's method (chapter 5): perception, then grasps for the topmost object. The
/// arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeDissertationDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer = {});

/// The baseline: a connected group of points above the table is an object, and the highest one is
/// grasped, by ProposeStraightDown. It uses only the options perception.preprocess and obstacles,
/// and those for collision checks of a hand. The arguments must outlive it.
/// @param observer  may be empty
std::unique_ptr<Detector> MakeStraightDownDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer = {});

/// Reads all keys of the mapping `grasp`.
/// @throws base::InputError
void ReadGraspOptions(base::YamlMap map, DetectorOptions& options);

}  // namespace rangegrasp::grasp
