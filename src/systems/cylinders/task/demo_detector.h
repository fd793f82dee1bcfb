#pragma once

#include <functional>
#include <memory>

#include "cylinders/detect.h"
#include "grasp/detector.h"
#include "robot/robot.h"
#include "trial/options.h"
#include "trial/trial.h"

namespace rangegrasp::cylinders {

/// How the cylinder is delivered at the end (section 4.3).
enum class Delivery {
  kHandOver,  ///< a person pulls it out of the hand
  kPlace,     ///< it is put down at the delivery place
};
constexpr std::array<std::string_view, 2> WordsOf(Delivery) { return {"hand_over", "place"}; }

/// Additions to chapter 4 that rely on knowing the objects on the table (base/words.h).
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

/// Tables with given cylinders among other objects, and the options of their detection.
struct TableOptions {
  trial::Options grasping;
  std::vector<GivenCylinder> given;  ///< shapes of `objects`, in their order
  DetectOptions detection;
};

struct DemoOptions : DemoAdditions, TableOptions {
  int runs = 50;
  Delivery delivery = Delivery::kHandOver;
  int max_tries = 3;  ///< 1 as published
  trial::HandOverOptions hand_over;
};

/// Parses "RADIUSxHEIGHT" or "RADIUS,HEIGHT" in mm; nullopt if malformed or a value is below 1.
std::optional<GivenCylinder> GivenFrom(const std::string& text, char between);

/// Reads the key `cylinders`. @throws base::InputError
void ReadGiven(base::YamlMap& map, TableOptions& options);
/// Reads the keys that a table shares with grasping, to the end of the map.
/// @param count  the key that replaces `trials_per_object`
/// @throws base::InputError
void ReadTable(base::YamlMap& map, const char* count, std::uint64_t seed, TableOptions& options);
/// @throws base::InputError if a given cylinder's size differs by more than 15 % from its object's
/// model: it would not be found in any scan.
void CheckGiven(const base::YamlMap& map, const TableOptions& options);

/// Detection options for the first look, and for the second look if the wanted one was not found.
DetectOptions FirstLook(const DemoOptions& options);
DetectOptions SecondLook(const DemoOptions& options);

/// Reads the keys of a demo except those that it shares with grasping. @throws base::InputError
/// @param options  the defaults
DemoOptions ReadDemoKeys(base::YamlMap& map, DemoOptions options = {});
/// Reads all keys, to the end of the map. @throws base::InputError
DemoOptions ReadDemo(base::YamlMap& map, std::uint64_t seed);

/// Receives the scene of each detection, for display.
using CylinderObserver = std::function<void(const CylinderScene&, const geometry::Observation&)>;

/// Prefix of the steps of DetectCylinders in Detected::seconds; second looks are included.
inline constexpr const char* kCylinderStep = "cylinders:";

/// Chapter 4: finds the wanted one of the given cylinders; the detection is empty if it was not
/// found. The other given cylinders, with their known shapes, and chapter 5's objects are
/// obstacles. Grasps hold the barrel at the center of gravity, from above along the axis if it
/// stands. The arguments must outlive it.
/// @param wanted  position in options.given
/// @param observer  may be empty
std::unique_ptr<trial::Detector> MakeDemoDetector(const DemoOptions& options,
                                                  const robot::Robot& robot, std::size_t wanted,
                                                  CylinderObserver observer = {});

/// Inserts a cylinder as the scene's first object: closed, since its shape is known, with the
/// points near it. Objects that lie mostly in it are removed.
void PutFirst(const Cylinder& cylinder_C, bool lies, perception::Scene& scene);

/// True if the robot knows from its own sensors that it can try again: nothing was found, planned
/// or held, and nothing has been offered to a person.
bool KnowsItFailed(const trial::Attempt& attempt, Delivery delivery);

}  // namespace rangegrasp::cylinders

namespace rangegrasp::draw {

/// Draws the detection of given cylinders in a cloud, in the colors of figures 4.4, 4.7 and 4.11.
void DrawCylinders(const cylinders::CylinderScene& scene, const Eigen::Vector3d& sensor_origin_C,
                   const std::filesystem::path& png);

}  // namespace rangegrasp::draw
