#include "grasp/named_grasps.h"

#include <fmt/format.h>

#include <algorithm>
#include <ranges>

#include "base/words.h"
#include "base/yaml_map.h"

namespace rangegrasp::grasp {
namespace {

using base::Pose;
using base::YamlMap;
using Eigen::Vector3d;
using geometry::TriangleMesh;
using robot::HandModel;

/// How far the angle between approach and closing direction in the file may differ from 90 deg.
constexpr double kSquare_rad = base::Deg(5.0);
/// An object tilted further is not upright: its contents have spilled.
constexpr double kUpright_rad = base::Deg(30.0);
/// Largest number of steps of the turns in a file.
constexpr int kMaxAngles = 360;
/// Largest angle in a file: a whole turn.
constexpr double kMaxAngle_deg = 360.0;

Vector3d Vector(YamlMap& map, const std::string& key, Vector3d numbers, const std::string& doc) {
  std::vector<std::string> texts;
  map.Read(key, texts, doc);
  if (!map.Has(key)) return numbers;
  if (texts.size() != 3)
    map.Fail(key, fmt::format("has {}, not 3", base::Counted(texts.size(), "number")));
  for (int i = 0; i < 3; ++i) {
    const std::string& text = texts[static_cast<std::size_t>(i)];
    const auto number = base::NumberFrom<double>(text);
    if (!number || !std::isfinite(*number)) {
      map.Fail(key, fmt::format("'{}' is not a number", text));
    }
    numbers[i] = *number;
  }
  return numbers;
}

Vector3d Direction(YamlMap& map, const std::string& key, const Vector3d& otherwise,
                   const std::string& doc) {
  const Vector3d v = Vector(map, key, otherwise, doc);
  if (v.norm() < 1e-9) map.Fail(key, "must not be zero; a direction is e.g. [0, 0, -1]");
  return v.normalized();
}

/// The ways in which a grasp can be taken: with the approach leaning about the closing direction,
/// turned about an axis through the model's origin, and with thumb and fingers exchanged.
std::vector<Proposal> WaysOf(const Pose& X_OG, double width_m, const std::vector<double>& leans_rad,
                             const Vector3d& axis_O, const std::vector<double>& turns_rad,
                             bool either_way) {
  std::vector<Proposal> ways;
  for (const double lean : leans_rad) {
    Pose X_leaning = X_OG;
    X_leaning.linear() = Eigen::AngleAxisd(lean, X_OG.linear().col(0)) * X_OG.linear();
    for (const double turn : turns_rad) {
      for (int half = 0; half < (either_way ? 2 : 1); ++half) {
        const Pose X_way = Eigen::AngleAxisd(turn, axis_O) * X_leaning *
                           Eigen::AngleAxisd(half * base::kPi, Vector3d::UnitZ());
        ways.push_back({X_way, width_m, X_way.linear().col(2), 1.0});
      }
    }
  }
  return ways;
}

std::vector<double> Angles(YamlMap& map, const std::string& key, const std::string& doc) {
  const Vector3d numbers = Vector(map, key, {0.0, 0.0, 1.0}, doc);
  const double from = numbers[0], to = numbers[1], step = numbers[2];
  if (from < -kMaxAngle_deg || to > kMaxAngle_deg || to < from || step <= 0.0 ||
      (to - from) / step > kMaxAngles) {
    map.Fail(key, fmt::format("must be FROM, TO, STEP with {} <= FROM <= TO <= {}, STEP > 0 and at "
                              "most {} steps, e.g. [0, 345, 15]",
                              -kMaxAngle_deg, kMaxAngle_deg, kMaxAngles));
  }
  std::vector<double> turns_rad;
  constexpr double kRounding = 1e-9;  // of a step: 0.3 / 0.1 is below 3
  const int steps = static_cast<int>((to - from) / step + kRounding);
  for (int i = 0; i <= steps; ++i) turns_rad.push_back(base::Deg(from + i * step));
  return turns_rad;
}

NamedGrasp GraspFrom(YamlMap map, const std::string& name) {
  NamedGrasp grasp;
  grasp.name = name;
  map.Read("for", grasp.uses, "uses of the grasp, in your own words: [drink, hand_over]");
  map.Read("upright", grasp.upright, "only if the object is upright; it is then kept upright");
  const Vector3d at =
      base::kMm * Vector(map, "at_mm", Vector3d::Zero(), "center between the pads, x, y, z");
  const Vector3d approach =
      Direction(map, "approach", -Vector3d::UnitZ(), "approach direction of the hand");
  const Vector3d closing = Direction(map, "closing", Vector3d::UnitX(),
                                     "direction from the fingers' pads to the thumb's");
  if (std::abs(approach.dot(closing)) > std::sin(kSquare_rad)) {
    map.Fail("closing", "is not perpendicular to `approach`");
  }
  double width_m = 0.0;
  map.ReadScaled("width_mm", width_m, base::kMm, 0.1, 1000.0, "width between the pads");
  const Vector3d axis_O = Direction(map, "about", Vector3d::UnitZ(), "axis of `turns_deg`");
  const auto turns_rad = Angles(map, "turns_deg",
                                "also turned about `about` through the model's origin: from, to "
                                "and step in degrees, e.g. [0, 345, 15]");
  const auto leans_rad =
      Angles(map, "leans_deg", "also with the approach turned about `closing`: from, to, step");
  bool either_way = false;
  map.Read("either_way", either_way, "also with thumb and fingers exchanged");
  map.Finish();
  for (const char* key : {"at_mm", "approach", "closing", "width_mm"}) map.Require(key);
  const Vector3d square = (closing - closing.dot(approach) * approach).normalized();
  grasp.ways_O =
      WaysOf(GraspFrame(at, approach, square), width_m, leans_rad, axis_O, turns_rad, either_way);
  return grasp;
}

Eigen::AlignedBox3d BoxFrom(YamlMap map) {
  map.Require("from_mm");
  map.Require("to_mm");
  const Vector3d from = Vector(map, "from_mm", Vector3d::Zero(), "minimum x, y, z");
  const Vector3d to = Vector(map, "to_mm", Vector3d::Zero(), "maximum x, y, z");
  if (!(to.array() > from.array()).all()) map.Fail("to_mm", "must be larger than `from_mm`");
  map.Finish();
  return {base::kMm * from, base::kMm * to};
}

std::string PlaceText(const Vector3d& place_m) {
  const Vector3d mm = place_m * base::kMmPerM;
  return fmt::format("({:.0f}, {:.0f}, {:.0f})", mm.x(), mm.y(), mm.z());
}

/// A center between the pads that is farther outside the object than any pad reaches.
std::optional<std::string> Misplaced(const Proposal& way_O, std::span<const Vector3d> points_O) {
  constexpr double kMargin_m = 0.02;
  const Eigen::AlignedBox3d box_O = geometry::BoundsOf(points_O);
  const Vector3d center_O = way_O.X_CG.translation();
  if (box_O.exteriorDistance(center_O) <= kMargin_m) return std::nullopt;
  return fmt::format("its center {} mm is outside the model, which reaches from {} to {} mm",
                     PlaceText(center_O), PlaceText(box_O.min()), PlaceText(box_O.max()));
}

/// Pads that close to a gap wider than the whole object in their direction.
std::optional<std::string> WiderThanTheObject(const Proposal& way_O,
                                              std::span<const Vector3d> points_O) {
  constexpr double kRounding_m = 0.001;  // of the number in the file
  const Vector3d closing_O = way_O.X_CG.linear().col(0);
  const auto [low, high] = std::ranges::minmax(
      points_O | std::views::transform([&](const auto& p_O) { return closing_O.dot(p_O); }));
  if (way_O.width_m <= high - low + kRounding_m) return std::nullopt;
  return fmt::format(
      "its width_mm is {:.4g}, but the whole model is only {:.4g} mm wide along `closing`",
      way_O.width_m * base::kMmPerM, (high - low) * base::kMmPerM);
}

std::optional<std::string> WiderThanTheHand(double width_m, std::optional<double> opens_m) {
  if (!opens_m || width_m <= *opens_m) return std::nullopt;
  return fmt::format("its width_mm is {:.4g}, but the hand opens only {:.4g} mm: it is never used",
                     width_m * base::kMmPerM, *opens_m * base::kMmPerM);
}

}  // namespace

std::filesystem::path NamedGraspsFile(const std::filesystem::path& mjcf) {
  return mjcf.parent_path() / "grasps.yaml";
}

std::vector<base::Finding> CheckNamedGrasps(const NamedGrasps& known,
                                            const std::filesystem::path& file,
                                            std::span<const Vector3d> points_O,
                                            std::optional<double> opens_m) {
  std::vector<base::Finding> findings;
  for (const NamedGrasp& grasp : known.grasps) {
    const auto warn = [&](const std::optional<std::string>& what, const char* cure) {
      if (!what) return;
      findings.push_back({.error = false,
                          .where = file.string(),
                          .element = fmt::format("grasp '{}'", grasp.name),
                          .what = *what,
                          .cure = cure});
    };
    const Proposal& way_O = grasp.ways_O.front();
    warn(Misplaced(way_O, points_O), "at_mm is in millimetres in the model's frame");
    warn(WiderThanTheObject(way_O, points_O),
         "width_mm is the width of what is between the closed pads, in millimetres");
    warn(WiderThanTheHand(way_O.width_m, opens_m), "grasp a narrower place, or remove it");
  }
  return findings;
}

std::set<std::string> UsesOf(const NamedGrasps& known) {
  std::set<std::string> uses;
  for (const NamedGrasp& grasp : known.grasps) uses.insert(grasp.uses.begin(), grasp.uses.end());
  return uses;
}

NamedGrasps ReadNamedGrasps(const std::filesystem::path& file) {
  NamedGrasps known;
  if (!std::filesystem::exists(file)) return known;
  YamlMap map = YamlMap::FromFile(file);
  known.up_O = Direction(map, "up", Vector3d::UnitZ(), "upward direction of the object in use");
  auto grasps = map.Child("grasps", "grasps by name, best first");
  for (const std::string& name : grasps.Names()) {
    known.grasps.push_back(GraspFrom(grasps.Child(name), name));
  }
  grasps.Finish();
  auto boxes = map.Child("keep_free", "boxes that the hand leaves free for a person, by name");
  for (const std::string& name : boxes.Names()) {
    known.keep_free_O.push_back(BoxFrom(boxes.Child(name)));
  }
  boxes.Finish();
  map.Finish();
  return known;
}

bool IsUpright(const NamedGrasps& known, const Pose& X_CO, const Vector3d& up_C) {
  return (X_CO.linear() * known.up_O).dot(up_C) >= std::cos(kUpright_rad);
}

bool IsFor(const NamedGrasp& grasp, const std::string& use) {
  return use.empty() || std::ranges::find(grasp.uses, use) != grasp.uses.end();
}

std::vector<PlacedGrasp> PlaceNamedGrasps(const NamedGrasps& known, const std::string& use,
                                          std::span<const Pose> poses_CO,
                                          const perception::Scene& scene, std::size_t object,
                                          const HandModel& hand, const GraspOptions& options,
                                          std::span<const TriangleMesh> obstacles_C) {
  std::vector<Grasp> grasps;
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < known.grasps.size(); ++i) {
    if (!IsFor(known.grasps[i], use)) continue;
    for (const Pose& X_CO : poses_CO) {
      if (known.grasps[i].upright && !IsUpright(known, X_CO, scene.table.plane.normal)) continue;
      for (Proposal way : known.grasps[i].ways_O) {
        way.X_CG = X_CO * way.X_CG;
        grasps.push_back(PlaceHand(way, hand, options));
        grasps.back().type = GraspType::kNamed;
        named.push_back(i);
      }
    }
  }
  CheckProposals(scene, object, hand, options, obstacles_C, grasps);
  std::vector<PlacedGrasp> placed;
  for (std::size_t i = 0; i < grasps.size(); ++i) placed.push_back({grasps[i], named[i]});
  std::ranges::stable_partition(placed, [](const PlacedGrasp& p) { return !p.grasp.collides; });
  return placed;
}

bool TouchesKeptFree(const Grasp& grasp, const NamedGrasps& known, const Pose& X_CO,
                     const HandModel& hand) {
  const Pose X_OH = X_CO.inverse() * grasp.X_CH;
  const HandModel::State& held = hand.AtGap(grasp.width_m);
  return std::ranges::any_of(held.shapes, [&](const geometry::Shape& shape) {
    const TriangleMesh mesh_H = geometry::Tessellate(shape);
    return std::ranges::any_of(known.keep_free_O, [&](const Eigen::AlignedBox3d& box_O) {
      // A triangle's box is sufficient: the shapes are as small as a finger's segments.
      return std::ranges::any_of(mesh_H.triangles, [&](const auto& triangle) {
        Eigen::AlignedBox3d of_triangle;
        for (const auto corner : triangle) of_triangle.extend(X_OH * mesh_H.vertices[corner]);
        return box_O.intersects(of_triangle);
      });
    });
  });
}

}  // namespace rangegrasp::grasp
