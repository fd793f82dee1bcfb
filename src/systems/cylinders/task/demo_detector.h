#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "base/words.h"
#include "base/yaml_map.h"
#include "cylinders/detect.h"
#include "grasp/detector.h"
#include "robot/robot.h"
#include "trial/options.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {

/// What becomes of the cylinder at the end (section 4.3).
enum class Delivery {
  kHandOver,  ///< a person draws it out of the hand
  kPlace,     ///< it is put down at the delivery place
};
constexpr std::array<std::string_view, 2> WordsOf(Delivery) { return {"hand_over", "place"}; }

/// What the demo does beyond chapter 4 because it is known what is on the table (base/words.h).
struct DemoAdditions {
  bool thorough = true;
  bool purity = true;
  bool second_look = true;
  bool roomy_grasps = true;
};
constexpr std::array<base::Addition<DemoAdditions>, 4> AdditionsOf(const DemoAdditions*) {
  using A = DemoAdditions;
  return {{
      {"thorough", &A::thorough,
       "more draws and more candidates; off: as in the command `cylinders`"},
      {"purity", &A::purity,
       "of several possible targets, choose the one that covers the largest share of its segment; "
       "off: the one with most points"},
      {"second_look", &A::second_look,
       "if a cylinder that must be present was not found, search again with lower thresholds; off: "
       "end the run"},
      {"roomy_grasps", &A::roomy_grasps,
       "prefer grasps with more distance to the neighbors, whose far sides are unseen; off: rank "
       "by score only"},
  }};
}
static_assert(base::AllAdditionsListed<DemoAdditions>());

/// Tables with given cylinders among other objects, and how the cylinders are looked for.
struct TableOptions {
  trial::Options grasping;
  std::vector<GivenCylinder> given;  ///< of `objects` in their order
  DetectOptions detection;
};

struct DemoOptions : DemoAdditions, TableOptions {
  int runs = 50;
  Delivery delivery = Delivery::kHandOver;
  int max_tries = 3;  ///< as published 1
  /// Of the thorough detection: a barrel that shows a fiftieth of the points is drawn 12 times, and
  /// boxes' faces, which are the first candidates, do not use up all that are examined.
  int lying_draws = 600;
  int max_lying = 24;
  int max_standing = 24;
  int max_leaning = 6;
  /// Of the second look: little of it is enough. Smaller: another thing is taken for it.
  double second_min_arc_rad = base::Deg(30.0);
  double second_min_length_share = 0.1;
  double second_min_seen_share = 0.05;
  /// What is perceived this near to the cylinder is no obstacle: noise and the pose's error.
  double grown_m = 0.006;
  /// Between the open hand and others, of a roomy grasp: what completed surfaces are off by.
  double room_m = 0.010;
  trial::HandOverOptions hand_over;
};

/// "RADIUSxHEIGHT" or "RADIUS,HEIGHT" in mm; nullopt if the text is neither, or one is not above 0.
std::optional<GivenCylinder> GivenFrom(const std::string& text, char between);

/// The key `cylinders`. @throws base::InputError
void ReadGiven(base::YamlMap& map, TableOptions& options);
/// The keys that a table shares with grasping, to the end of the map.
/// @param count  the key in place of `trials_per_object`
/// @throws base::InputError
void ReadTable(base::YamlMap& map, const char* count, TableOptions& options);

/// How the cylinders are looked for at first, and again if the wanted one was not found.
DetectOptions FirstLook(const DemoOptions& options);
DetectOptions SecondLook(const DemoOptions& options);

/// The keys of a demo but those that it shares with grasping. @throws base::InputError
void ReadDemoKeys(base::YamlMap& map, DemoOptions& options);
/// All keys, to the end of the map. @throws base::InputError
DemoOptions ReadDemo(base::YamlMap& map);

/// What a viewer may see of a detection.
using CylinderObserver = std::function<void(const CylinderScene&, const geometry::Observation&)>;

/// Before the name of a step of DetectCylinders in Detected::seconds; second looks count.
inline constexpr const char* kCylinderStep = "cylinders:";

/// Chapter 4: finds the wanted one of the given cylinders (an empty detection: it was not found);
/// everything else that chapter 5's perception finds is an obstacle, other given cylinders with
/// their known shapes. Grasps hold it round its barrel at the centre of gravity, from above along
/// its axis where it stands. The arguments must outlive it.
/// @param wanted  position in options.given
/// @param observer  may be empty
std::unique_ptr<trial::Detector> MakeDemoDetector(const DemoOptions& options,
                                                  const robot::Robot& robot, std::size_t wanted,
                                                  CylinderObserver observer = {});

/// Makes a cylinder the scene's first object: closed, since its shape is known, with the points
/// within `grown_m` of it. Objects that lie in it mostly are left out.
void PutFirst(const Cylinder& cylinder_C, bool lies, double grown_m, perception::Scene& scene);

}  // namespace rangegrasp::cylinders
