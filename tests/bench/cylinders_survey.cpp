// How often given cylinders are found in clutter, and how well: two given ones, standing or lying,
// among three to six boxes and other cylinders, touching half of the time, as one sensor at one
// place sees them (tests/systems/cylinders/tabletop_scan.h). One line a cylinder as CSV; then, to
// stderr, recall, precision and errors. Truth scores what was found and nothing else.
//
//   rangegrasp_cylinders_survey --scenes 500 --seed N [--as-published] [--only SCENE]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/statistics.h"
#include "base/words.h"
#include "cylinders/detect.h"
#include "cylinders/tabletop_scan.h"
#include "experiment/statistics.h"

namespace rangegrasp {
namespace {

namespace scans = cylinders::samples;
using cylinders::Cylinder;
using cylinders::GivenCylinder;

/// The demonstration's (section 4.4).
const std::array<GivenCylinder, 2> kGiven = {{{0.02575, 0.173}, {0.02675, 0.134}}};

struct SurveyOptions {
  int scenes = 500;
  std::uint64_t seed = 11;
  int samples = 220;  ///< rays on each side of the image
  double noise_m = 0.0003;
  bool as_published = false;
  int only = -1;  ///< this scene alone, and what stands in it; -1: all
};

struct Truth {
  std::size_t given = 0;
  Cylinder cylinder;
};

struct Clutter {
  scans::Tabletop tabletop;
  std::vector<Truth> given;
};

/// Places things on the table by the circles about their outlines.
class Placing {
 public:
  explicit Placing(base::Rng& rng) : rng_(rng) {}

  /// Half of the time the circle touches another one; nullopt where there is no room left.
  std::optional<Eigen::Vector2d> Place(double radius_m) {
    for (int draw = 0; draw < kDraws; ++draw) {
      const Eigen::Vector2d middle = Draw(radius_m);
      if (middle.cwiseAbs().maxCoeff() > kHalfTable_m) continue;
      const bool overlaps = std::ranges::any_of(circles_, [&](const Circle& other) {
        return (other.middle - middle).norm() < other.radius_m + radius_m;
      });
      if (overlaps) continue;
      circles_.push_back({middle, radius_m});
      return middle;
    }
    return std::nullopt;
  }

 private:
  struct Circle {
    Eigen::Vector2d middle;
    double radius_m;
  };
  static constexpr int kDraws = 200;
  static constexpr double kHalfTable_m = 0.14;  ///< what the sensor sees of the table
  static constexpr double kGap_m = 0.0005;      ///< of things that touch

  Eigen::Vector2d Draw(double radius_m) {
    if (!circles_.empty() && rng_.Uniform() < 0.5) {
      const Circle& other = circles_[rng_.Index(circles_.size())];
      const double angle = rng_.Uniform(0.0, 2.0 * base::kPi);
      const double apart_m = other.radius_m + radius_m + kGap_m;
      return other.middle + apart_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    const double x = rng_.Uniform(-kHalfTable_m, kHalfTable_m);
    const double y = rng_.Uniform(-kHalfTable_m, kHalfTable_m);
    return {x, y};
  }

  base::Rng& rng_;
  std::vector<Circle> circles_;
};

/// About a lying cylinder's outline: half its length and some of its width.
double CircleOfLying(double height_m) { return 0.5 * height_m + 0.005; }

void AddGiven(std::size_t which, base::Rng& rng, Placing& placing, Clutter& clutter) {
  const auto [r, h] = kGiven[which];
  const bool lies = rng.Uniform() < 0.4;
  const double turn = rng.Uniform(0.0, base::kPi);
  const auto at = placing.Place(lies ? CircleOfLying(h) : r);
  if (!at) return;
  const Cylinder cylinder =
      lies ? scans::Lying(at->x(), at->y(), turn, r, h) : scans::Standing(at->x(), at->y(), r, h);
  clutter.tabletop.cylinders.push_back(cylinder);
  clutter.given.push_back({which, cylinder});
}

void AddBox(base::Rng& rng, Placing& placing, Clutter& clutter) {
  const double a = rng.Uniform(0.03, 0.09);
  const double b = rng.Uniform(0.03, 0.09);
  const double height = rng.Uniform(0.03, 0.16);
  const double turn = rng.Uniform(0.0, base::kPi);
  const auto at = placing.Place(0.5 * std::hypot(a, b));
  if (!at) return;
  clutter.tabletop.boxes.push_back(scans::StandingBox(at->x(), at->y(), turn, {a, b, height}));
}

void AddStanding(base::Rng& rng, Placing& placing, Clutter& clutter) {
  const double r = rng.Uniform(0.015, 0.045);
  const double h = rng.Uniform(0.04, 0.20);
  const auto at = placing.Place(r);
  if (at) clutter.tabletop.cylinders.push_back(scans::Standing(at->x(), at->y(), r, h));
}

void AddLying(base::Rng& rng, Placing& placing, Clutter& clutter) {
  const double r = rng.Uniform(0.015, 0.035);
  const double h = rng.Uniform(0.06, 0.18);
  const double turn = rng.Uniform(0.0, base::kPi);
  const auto at = placing.Place(CircleOfLying(h));
  if (at) clutter.tabletop.cylinders.push_back(scans::Lying(at->x(), at->y(), turn, r, h));
}

Clutter DrawClutter(base::Rng& rng) {
  Clutter clutter;
  Placing placing(rng);
  for (std::size_t g = 0; g < kGiven.size(); ++g) AddGiven(g, rng, placing, clutter);
  const std::size_t others = 3 + rng.Index(4);
  for (std::size_t i = 0; i < others; ++i) {
    const double kind = rng.Uniform();
    if (kind < 0.5) {
      AddBox(rng, placing, clutter);
    } else if (kind < 0.8) {
      AddStanding(rng, placing, clutter);
    } else {
      AddLying(rng, placing, clutter);
    }
  }
  return clutter;
}

enum class Verdict {
  kHit,
  kMissed,
  kHidden,  ///< too little of it was seen; whether it was found counts for nothing
  kFalse,   ///< found where there is none
  kTwin,    ///< false, too: found where another cylinder of the same size happens to be
};
constexpr std::array<std::string_view, 5> WordsOf(Verdict) {
  return {"hit", "missed", "hidden", "false", "twin"};
}

double AngleOf(const Cylinder& a, const Cylinder& b) {
  return std::acos(std::min(1.0, std::abs(a.axis.dot(b.axis))));
}

/// How far off still is that cylinder.
bool IsThere(const Cylinder& found, const Cylinder& truth) {
  constexpr double kMaxDistance_m = 0.02;
  const double max_angle_rad = base::Deg(10.0);
  return (found.center - truth.center).norm() < kMaxDistance_m &&
         AngleOf(found, truth) < max_angle_rad;
}

/// Of a size that is not told from the given one (docs/cylinders.md).
bool IsTwin(const Cylinder& other, const GivenCylinder& given) {
  constexpr double kRadius_m = 0.0005;
  constexpr double kHeight_m = 0.002;
  return std::abs(other.radius_m - given.radius_m) < kRadius_m &&
         std::abs(other.height_m - given.height_m) < kHeight_m;
}

/// A quarter of the rays to it end on it, and 200 do.
bool IsSeen(const cylinders::CylinderScene& scene, const Eigen::Vector3d& origin,
            const Cylinder& truth) {
  constexpr double kTolerance_m = 0.003;
  constexpr double kMinShare = 0.25;
  constexpr std::size_t kMinRays = 200;
  const geometry::Indices place_of(scene.points_C.size(), 0);
  const auto counts =
      cylinders::CompareWithView(scene.points_C, {&origin, 1}, place_of, truth, kTolerance_m);
  return static_cast<double>(counts.on) >= kMinShare * static_cast<double>(counts.All()) &&
         counts.on > kMinRays;
}

void PrintLine(int scene, Verdict verdict, std::size_t given, const Cylinder* truth,
               const cylinders::FoundCylinder* found) {
  fmt::print("{},{},{}", scene, base::Word(verdict), given + 1);
  for (const Cylinder* cylinder : {truth, found ? &found->cylinder_C : nullptr}) {
    if (!cylinder) {
      fmt::print(",,,,,,,");
      continue;
    }
    const auto& [center, axis, radius, height] = *cylinder;
    fmt::print(",{},{},{},{},{},{},{}", center.x(), center.y(), center.z(), axis.x(), axis.y(),
               axis.z(), radius);
  }
  if (found) {
    fmt::print(",{},{},{},{}", found->length_seen_m, found->view.on, found->view.before,
               found->view.through);
  } else {
    fmt::print(",,,,");
  }
  fmt::print("\n");
}

/// What stands there, for a look at one scene.
void PrintTabletop(const scans::Tabletop& tabletop) {
  for (const auto& [center, axis, radius, height] : tabletop.cylinders) {
    fmt::print(stderr,
               "cylinder r {:.2f} h {:.1f} mm at {:.3f} {:.3f} {:.3f}, axis {:.2f} {:.2f} {:.2f}\n",
               radius * base::kMmPerM, height * base::kMmPerM, center.x(), center.y(), center.z(),
               axis.x(), axis.y(), axis.z());
  }
  for (const auto& [X_WB, size] : tabletop.boxes) {
    const Eigen::Vector3d middle = X_WB.translation();
    fmt::print(stderr, "box {:.1f} x {:.1f} x {:.1f} mm at {:.3f} {:.3f}\n",
               size.x() * base::kMmPerM, size.y() * base::kMmPerM, size.z() * base::kMmPerM,
               middle.x(), middle.y());
  }
}

class Survey {
 public:
  explicit Survey(const SurveyOptions& options) : options_(options) {}

  void Look(int which) {
    base::Rng rng(base::DeriveSeed(options_.seed, static_cast<std::uint64_t>(which)));
    const Clutter clutter = DrawClutter(rng);
    if (options_.only >= 0) PrintTabletop(clutter.tabletop);
    scans::Sensor sensor;
    sensor.noise_m = options_.noise_m;
    sensor.profiles = sensor.samples = options_.samples;
    const auto observation = scans::Scan(clutter.tabletop, sensor, rng);
    base::Rng draws(base::DeriveSeed(options_.seed, "d"));
    const auto scene = cylinders::DetectCylinders(
        observation, kGiven,
        options_.as_published ? cylinders::AsPublished() : cylinders::DetectOptions{}, draws);
    for (const auto& [step, seconds] : scene.seconds) seconds_[step] += seconds;
    Score(which, clutter, scene, sensor.origin);
  }

  void PrintSums() const {
    const auto of = [&](Verdict verdict) {
      const auto at = counts_.find(verdict);
      return at == counts_.end() ? 0 : at->second;
    };
    const int seen = of(Verdict::kHit) + of(Verdict::kMissed);
    const int right = found_ - of(Verdict::kFalse) - of(Verdict::kTwin);
    const auto recall = experiment::WilsonInterval(of(Verdict::kHit), seen);
    const auto precision = experiment::WilsonInterval(right, found_);
    fmt::print(stderr, "{} scenes, seed {}: {} given cylinders seen, {} hidden\n", options_.scenes,
               options_.seed, seen, of(Verdict::kHidden));
    fmt::print(stderr, "recall {:.2f} % ({:.1f}-{:.1f}), {} of {}\n",
               Percent(of(Verdict::kHit), seen), 100.0 * recall.first, 100.0 * recall.second,
               of(Verdict::kHit), seen);
    fmt::print(stderr, "precision {:.2f} % ({:.1f}-{:.1f}), {} of {}\n", Percent(right, found_),
               100.0 * precision.first, 100.0 * precision.second, right, found_);
    fmt::print(stderr, "  of the {} false ones {} are other cylinders of the same size\n",
               found_ - right, of(Verdict::kTwin));
    PrintErrors("radius [mm]", radius_mm_);
    PrintErrors("axis [deg]", axis_deg_);
    PrintErrors("position [mm]", position_mm_);
    fmt::print(stderr, "mean time [ms]:");
    for (const auto& [step, seconds] : seconds_) {
      fmt::print(stderr, " {} {:.1f}", step, seconds * 1e3 / options_.scenes);
    }
    fmt::print(stderr, "\n");
  }

 private:
  static double Percent(int k, int n) { return n == 0 ? 0.0 : 100.0 * k / n; }

  static void PrintErrors(const char* name, const std::vector<double>& errors) {
    if (errors.empty()) return;
    fmt::print(stderr, "{}: median {:.3f}, 95 % {:.3f}, largest {:.3f}\n", name,
               base::MedianOf(errors), base::QuantileOf(errors, 0.95), std::ranges::max(errors));
  }

  void Score(int which, const Clutter& clutter, const cylinders::CylinderScene& scene,
             const Eigen::Vector3d& origin) {
    std::vector<bool> used(scene.cylinders.size(), false);
    for (const auto& [given, truth] : clutter.given) {
      const cylinders::FoundCylinder* match = nullptr;
      for (std::size_t i = 0; i < used.size() && !match; ++i) {
        const auto& found = scene.cylinders[i];
        if (used[i] || found.given != given || !IsThere(found.cylinder_C, truth)) continue;
        used[i] = true;
        match = &found;
      }
      if (match) AddErrors(match->cylinder_C, truth);
      Verdict verdict = match ? Verdict::kHit : Verdict::kMissed;
      if (!IsSeen(scene, origin, truth)) verdict = Verdict::kHidden;
      ++counts_[verdict];
      PrintLine(which, verdict, given, &truth, match);
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
      ++found_;
      if (used[i]) continue;
      const auto& found = scene.cylinders[i];
      const bool twin = std::ranges::any_of(clutter.tabletop.cylinders, [&](const Cylinder& other) {
        return IsTwin(other, kGiven[found.given]) && IsThere(found.cylinder_C, other);
      });
      const Verdict verdict = twin ? Verdict::kTwin : Verdict::kFalse;
      ++counts_[verdict];
      PrintLine(which, verdict, found.given, nullptr, &found);
    }
  }

  void AddErrors(const Cylinder& found, const Cylinder& truth) {
    radius_mm_.push_back(std::abs(found.radius_m - truth.radius_m) * base::kMmPerM);
    axis_deg_.push_back(base::ToDeg(AngleOf(found, truth)));
    position_mm_.push_back((found.center - truth.center).norm() * base::kMmPerM);
  }

  const SurveyOptions& options_;
  std::map<Verdict, int> counts_;
  int found_ = 0;
  std::vector<double> radius_mm_, axis_deg_, position_mm_;
  std::map<std::string, double> seconds_;
};

int Run(int argc, char** argv) {
  CLI::App app("finds given cylinders in clutter and scores what was found");
  SurveyOptions options;
  double noise_mm = options.noise_m * base::kMmPerM;
  app.add_option("--scenes", options.scenes)->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed);
  app.add_option("--samples", options.samples, "rays on each side of the image");
  app.add_option("--noise", noise_mm, "along each ray [mm]")->check(CLI::NonNegativeNumber);
  app.add_flag("--as-published", options.as_published);
  app.add_option("--only", options.only, "this scene alone, and what stands in it");
  CLI11_PARSE(app, argc, argv);
  options.noise_m = noise_mm * base::kMm;
  fmt::print(
      "scene,verdict,given,true_x_m,true_y_m,true_z_m,true_axis_x,true_axis_y,true_axis_z,"
      "true_radius_m,x_m,y_m,z_m,axis_x,axis_y,axis_z,radius_m,length_seen_m,"
      "on,before,through\n");
  Survey survey(options);
  for (int scene = 0; scene < options.scenes; ++scene) {
    if (options.only < 0 || options.only == scene) survey.Look(scene);
  }
  survey.PrintSums();
  return 0;
}

}  // namespace
}  // namespace rangegrasp

int main(int argc, char** argv) { return rangegrasp::Run(argc, argv); }
