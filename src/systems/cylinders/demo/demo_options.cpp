#include "cylinders/demo/demo_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/number.h"
#include "base/units.h"

namespace rangegrasp::demo {
namespace {

using base::kMm;
using base::YamlMap;

/// The published gate asks for the largest x of a top's normal: x of that sensor's frame is up.
const Eigen::Matrix3d kPublishedAxes = (Eigen::Matrix3d() << 0, 0, -1, 0, 1, 0, 1, 0, 0).finished();

/// "RADIUSxHEIGHT" in mm.
cylinders::GivenCylinder GivenFrom(const YamlMap& map, const std::string& text) {
  const auto cross = text.find('x');
  if (cross != std::string::npos) {
    const auto radius_mm = base::NumberFrom<double>(text.substr(0, cross));
    const auto height_mm = base::NumberFrom<double>(text.substr(cross + 1));
    if (radius_mm && height_mm && *radius_mm > 0.0 && *height_mm > 0.0) {
      return {*radius_mm * kMm, *height_mm * kMm};
    }
  }
  map.Fail("cylinders", fmt::format("'{}' is no RADIUSxHEIGHT in mm, e.g. 25.75x173", text));
}

}  // namespace

cylinders::DetectOptions FirstLook(const DemoOptions& options) {
  cylinders::DetectOptions look = options.detection;
  if (!options.thorough) return look;
  look.search.draws = std::max(look.search.draws, options.lying_draws);
  look.search.max_lying = std::max(look.search.max_lying, options.max_lying);
  look.search.max_standing = std::max(look.search.max_standing, options.max_standing);
  look.search.max_leaning = std::max(look.search.max_leaning, options.max_leaning);
  return look;
}

cylinders::DetectOptions SecondLook(const DemoOptions& options) {
  cylinders::DetectOptions look = FirstLook(options);
  cylinders::AcceptOptions& accept = look.accept;
  accept.min_arc_rad = options.second_min_arc_rad;
  accept.min_length_share = options.second_min_length_share;
  accept.min_seen_share = options.second_min_seen_share;
  return look;
}

void ReadDemoKeys(YamlMap& map, DemoOptions& o) {
  map.Read("runs", o.runs, 1, 100000, "runs; the given cylinders are wanted in turn");
  std::vector<std::string> given;
  map.Read("cylinders", given,
           "the shapes that are given to the program, RADIUSxHEIGHT in mm, of `objects` in order");
  for (const std::string& text : given) o.given.push_back(GivenFrom(map, text));
  auto keys = map.Child("demo", "from the detected cylinder to the person");
  keys.Read("delivery", o.delivery, "what becomes of the cylinder at the end");
  keys.Read("max_tries", o.max_tries, 1, 20,
            "a robot that found nothing, no way, or holds nothing looks and tries again, so often "
            "at most");
  keys.ReadScaled("grown_mm", o.grown_m, kMm, 0.0, 50.0,
                  "what is perceived this near to the cylinder is of it");
  for (const auto& row : base::AdditionsTable<DemoAdditions>()) {
    keys.Read(std::string(row.key), o.*row.on, std::string(row.doc));
  }
  ReadUser(keys.Child("user", "the person who takes it"), o.hand_over);
  keys.Finish();
}

Options ReadOptions(YamlMap& map) {
  Options options;
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "a demo has `runs` in its place");
  }
  map.Require("cylinders");
  ReadDemoKeys(map, options.demo);
  options.grasping = trial::ReadOptions(map);
  if (options.grasping.take != grasp::kAnywhere) {
    map.Fail("grasp", "take: `task: demo` has no use for it, `task: grasping` has");
  }
  if (options.grasping.method == trial::MethodKind::kPublished) {
    options.demo.detection = cylinders::AsPublished();
    options.demo.detection.R_CS = kPublishedAxes;
    base::SwitchAll<DemoAdditions>(false, options.demo);
    options.demo.max_tries = 1;
  }
  const std::size_t objects = options.grasping.objects.size();
  if (options.demo.given.size() != objects) {
    map.Fail("cylinders",
             fmt::format("names {} shapes, objects names {}", options.demo.given.size(), objects));
  }
  // Each run has all of them on the table.
  options.grasping.clutter.always = options.grasping.objects;
  return options;
}

}  // namespace rangegrasp::demo
