#include "tasks/demo/demo_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/number.h"
#include "core/units.h"

namespace rangegrasp::tasks::demo {
namespace {

using core::kMm;
using core::YamlMap;

/// The published gate asks for the largest x of a top's normal: x of that sensor's frame is up.
const Eigen::Matrix3d kPublishedAxes = (Eigen::Matrix3d() << 0, 0, -1, 0, 1, 0, 1, 0, 0).finished();

/// "RADIUSxHEIGHT" in mm.
cylinders::GivenCylinder GivenFrom(const YamlMap& map, const std::string& text) {
  const auto cross = text.find('x');
  if (cross != std::string::npos) {
    const auto radius_mm = core::NumberFrom<double>(text.substr(0, cross));
    const auto height_mm = core::NumberFrom<double>(text.substr(cross + 1));
    if (radius_mm && height_mm && *radius_mm > 0.0 && *height_mm > 0.0) {
      return {*radius_mm * kMm, *height_mm * kMm};
    }
  }
  map.Fail("cylinders", fmt::format("'{}' is no RADIUSxHEIGHT in mm, e.g. 25.75x173", text));
}

void ReadUser(YamlMap map, DemoOptions& options) {
  sim::UserOptions& user = options.user;
  map.Read("wait_s", user.wait_s, 0.0, 60.0, "the hand holds for so long before anyone pulls");
  map.Read("force_n", user.force_N, 0.1, 200.0, "what the pull rises to");
  map.Read("rise_s", user.rise_s, 0.01, 10.0, "in this time");
  map.Read("patience_s", user.patience_s, 0.0, 60.0, "of pulling in vain");
  map.ReadScaled("draw_mm", user.draw_m, kMm, 20.0, 1000.0,
                 "the object is drawn so far once the hand has let go");
  map.ReadScaled("spread_deg", options.pull_spread_rad, core::kDeg, 0.0, 90.0,
                 "the pull's direction is drawn within this of straight out of the open hand");
  map.Finish();
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

sim::UserOptions UserFor(const DemoOptions& options, const Eigen::Vector3d& out_H, core::Rng& rng) {
  sim::UserOptions user = options.user;
  // Even over the cap of the sphere.
  const double cosine = rng.Uniform(std::cos(options.pull_spread_rad), 1.0);
  const double round = rng.Uniform(0.0, 2.0 * core::kPi);
  const Eigen::Vector3d u = out_H.unitOrthogonal();
  const Eigen::Vector3d v = out_H.cross(u);
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  user.direction_H = cosine * out_H + sine * (std::cos(round) * u + std::sin(round) * v);
  return user;
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
  for (const auto& row : core::AdditionsTable<DemoAdditions>()) {
    keys.Read(std::string(row.key), o.*row.on, std::string(row.doc));
  }
  ReadUser(keys.Child("user", "the person who takes it"), o);
  keys.Finish();
}

Options ReadOptions(YamlMap& map) {
  Options options;
  if (map.Has("trials_per_object")) {
    map.Fail("trials_per_object", "a demo has `runs` in its place");
  }
  map.Require("cylinders");
  ReadDemoKeys(map, options.demo);
  options.grasping = grasping::ReadOptions(map);
  if (options.grasping.method == grasping::MethodKind::kPublished) {
    options.demo.detection = cylinders::AsPublished();
    options.demo.detection.R_CS = kPublishedAxes;
    core::SwitchAll<DemoAdditions>(false, options.demo);
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

}  // namespace rangegrasp::tasks::demo
