#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "geometry/observation.h"
#include "grasp/detection.h"
#include "grasp/grasp.h"
#include "grasp/grasp_options.h"
#include "grasp/obstacles.h"
#include "grasp/selector.h"
#include "perception/perceive.h"
#include "perception/scene.h"
#include "robot/robot.h"

namespace rangegrasp::grasp {

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

/// What a detector is given beside the observation.
struct DetectorOptions {
  perception::PerceptionOptions perception;
  GraspOptions grasp;
  ObstacleOptions obstacles;
  /// Points further outside the workspace are not perceived: the arm, its pedestal and the table's
  /// rim stand there.
  double workspace_margin_m = 0.15;
  /// Where objects are taken: kAnywhere, or the word of a selector.
  std::string take = kAnywhere;
};

/// The dissertation's method (chapter 5): perception, then grasps for the topmost object. The
/// arguments must outlive it. @param observer  may be empty
std::unique_ptr<Detector> MakeDissertationDetector(const DetectorOptions& options,
                                                   const robot::Robot& robot,
                                                   SceneObserver observer = {});

}  // namespace rangegrasp::grasp
