#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/rng.h"
#include "core/units.h"
#include "core/yaml_map.h"
#include "cylinders/detect.h"
#include "tasks/grasping/options.h"

namespace rangegrasp::tasks::demo {

/// What becomes of the cylinder at the end (section 4.3).
enum class Delivery {
  kHandOver,  ///< a person draws it out of the hand
  kPlace,     ///< it is put down at the delivery place
};
constexpr std::array<std::string_view, 2> WordsOf(Delivery) { return {"hand_over", "place"}; }

struct DemoOptions {
  int runs = 50;
  /// The shapes that are given to the program, of `objects` in their order.
  std::vector<cylinders::GivenCylinder> given;
  Delivery delivery = Delivery::kHandOver;
  cylinders::DetectOptions detection;
  /// The fit criterion is a cylinder grown by this much: what is perceived within it is the
  /// cylinder, not an obstacle. A scan's noise and the pose's error.
  double grown_m = 0.006;
  sim::UserOptions user;
  /// The pull's direction is drawn within this of the one that the palm faces: people stand
  /// somewhere. Larger: the object is drawn through fingers.
  double pull_spread_rad = core::Deg(30.0);
};

/// A demo, as its file states it.
struct Options {
  grasping::Options grasping;
  DemoOptions demo;
};

/// The person of one run.
sim::UserOptions UserFor(const DemoOptions& options, core::Rng& rng);

/// The keys of a demo but those that it shares with grasping. @throws core::InputError
void ReadDemoKeys(core::YamlMap& map, DemoOptions& options);
/// All keys, to the end of the map. @throws core::InputError
Options ReadOptions(core::YamlMap& map);

}  // namespace rangegrasp::tasks::demo
