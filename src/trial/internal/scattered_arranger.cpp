#include "trial/internal/scattered_arranger.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "trial/internal/arranging.h"
#include "trial/internal/resting.h"
#include "trial/objects.h"

namespace rangegrasp::trial::internal {
namespace {

// Places that are tried for one object among those that lie there already.
constexpr int kMaxPlaces = 100;
// Drops of something that is to lie and comes to stand.
constexpr int kMaxDrops = 20;

void AddOnce(const std::vector<std::string>& names, std::vector<std::string>& list) {
  for (const std::string& name : names) {
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  }
}

class ScatteredArranger : public Arranger {
 public:
  ScatteredArranger(const Options& options, const robot::Robot& robot,
                    const sensing::LineScannerOptions& scanner)
      : options_(options),
        clutter_(options.clutter),
        robot_(robot),
        scanner_(scanner),
        resting_(options, robot, AllObjects(options)) {
    for (const std::string& target : options.objects) {
      const std::size_t count = Choice(target).size();
      if (count >= static_cast<std::size_t>(clutter_.max_others)) continue;
      throw base::InputError(
          fmt::format("arrangement: scattered: clutter.max_others is {}, but clutter.others (by "
                      "default objects) names {} beside {} and clutter.always",
                      clutter_.max_others, count, target));
    }
  }

  std::optional<Arrangement> Arrange(const std::string& target, base::Rng& rng,
                                     Redraws& redraws) const override {
    Arrangement trial{WorldWith(target, rng)};
    trial.world.SetArm(robot_.home);
    for (int draw = 0; draw < clutter_.max_draws; ++draw) {
      if (const auto wrong = PutDownAll(rng, trial)) {
        ++redraws[*wrong];
        continue;
      }
      return trial;
    }
    return std::nullopt;
  }

 private:
  static std::vector<std::string> AllObjects(const Options& options) {
    std::vector<std::string> all = options.objects;
    AddOnce(options.clutter.always, all);
    AddOnce(options.clutter.others, all);
    return all;
  }

  /// What may lie beside a target and what is always there.
  std::vector<std::string> Choice(const std::string& target) const {
    std::vector<std::string> choice;
    AddOnce(clutter_.others.empty() ? options_.objects : clutter_.others, choice);
    std::erase_if(choice, [&](const std::string& name) {
      const auto& always = clutter_.always;
      return name == target || std::find(always.begin(), always.end(), name) != always.end();
    });
    return choice;
  }

  /// The target first, then what is always there, then others.
  sim::World WorldWith(const std::string& target, base::Rng& rng) const {
    std::vector<std::string> names{target};
    AddOnce(clutter_.always, names);
    std::vector<std::string> others = Choice(target);
    const auto range = static_cast<std::size_t>(clutter_.max_others - clutter_.min_others + 1);
    const std::size_t count = static_cast<std::size_t>(clutter_.min_others) + rng.Index(range);
    Shuffle(others, rng);
    others.resize(count);
    AddOnce(others, names);
    std::vector<sim::ObjectModel> models;
    for (const std::string& name : names) models.push_back(ObjectModelOf(options_, name));
    return sim::World(options_.scene, models, options_.physics);
  }

  /// @return what is wrong with the arrangement.
  std::optional<Redraw> PutDownAll(base::Rng& rng, Arrangement& trial) const {
    sim::World& world = trial.world;
    for (int object = 0; object < world.objects(); ++object) world.ParkObject(object);
    std::vector<sim::AtRest> rests;
    for (int object = 0; object < world.objects(); ++object) {
      const auto rest = PoseFor(world, object, rng);
      if (!rest) return Redraw::kOtherPose;
      rests.push_back(*rest);
    }
    std::vector<base::Pose> poses_W;
    for (int object = 0; object < world.objects(); ++object) {
      const auto X_WO =
          PlaceBeside(*rests[static_cast<std::size_t>(object)].face, object, rng, world);
      if (!X_WO) return Redraw::kDoesNotFit;
      poses_W.push_back(*X_WO);
    }
    if (!world.Settle(clutter_.settle_limit_s)) return Redraw::kNotAtRest;
    for (int object = 0; object < world.objects(); ++object) {
      const base::Pose& X_WO = poses_W[static_cast<std::size_t>(object)];
      if (!Resting::IsAsPutDown(X_WO, world, object)) return Redraw::kOtherPose;
      if (world.RobotDistance(object, clutter_.touch_m) < clutter_.touch_m) {
        return Redraw::kTouchesArm;
      }
    }
    if (!OutOfView(world, robot_.X_WScanner, scanner_).empty()) return Redraw::kOutOfView;
    if (clutter_.min_seen_share > 0.0 &&
        SeenShare(world, 0, robot_.X_WScanner, scanner_) < clutter_.min_seen_share) {
      return Redraw::kHidden;
    }
    trial.pose_class = rests.front().pose->label;
    trial.touching = Touching(world);
    return std::nullopt;
  }

  /// @return nullopt for a pose that is not to be.
  std::optional<sim::AtRest> PoseFor(sim::World& world, int object, base::Rng& rng) const {
    const auto& share = clutter_.standing_share;
    const bool chosen = share && MayBeTarget(world, object);
    if (chosen && rng.Uniform(0.0, 1.0) < *share) {
      return resting_.Standing(world.object_name(object), rng);
    }
    for (int drop = 0; drop < kMaxDrops; ++drop) {
      const auto rest = resting_.Drop(world, object, rng);
      world.ParkObject(object);
      if (!rest || !chosen || !Resting::Stands(*rest->face)) return rest;
    }
    return std::nullopt;
  }

  bool MayBeTarget(const sim::World& world, int object) const {
    const auto& always = clutter_.always;
    return object == 0 ||
           std::find(always.begin(), always.end(), world.object_name(object)) != always.end();
  }

  /// Where it is inside none of those before it. It may touch them.
  std::optional<base::Pose> PlaceBeside(const sim::RestingFace& face, int object, base::Rng& rng,
                                        sim::World& world) const {
    for (int place = 0; place < kMaxPlaces; ++place) {
      const base::Pose X_WO = resting_.PutDown(face, RadiusFor(world, object), world, object, rng);
      bool free = true;
      for (int other = 0; free && other < object; ++other) {
        free = world.ObjectDistance(object, other, 0.0) >= 0.0;
      }
      if (free) return X_WO;
    }
    return std::nullopt;
  }

  /// What may be a target lies where the arm reaches it.
  double RadiusFor(const sim::World& world, int object) const {
    return MayBeTarget(world, object)
               ? robot_.workspace_radius_m
               : std::max(robot_.workspace_radius_m, clutter_.scatter_radius_m);
  }

  int Touching(const sim::World& world) const {
    int touching = 0;
    for (int other = 1; other < world.objects(); ++other) {
      if (world.ObjectDistance(0, other, clutter_.touch_m) < clutter_.touch_m) ++touching;
    }
    return touching;
  }

  const Options& options_;
  const ClutterOptions& clutter_;
  const robot::Robot& robot_;
  const sensing::LineScannerOptions& scanner_;
  Resting resting_;
};

}  // namespace

std::unique_ptr<Arranger> MakeScatteredArranger(const Options& options, const robot::Robot& robot,
                                                const sensing::LineScannerOptions& scanner) {
  return std::make_unique<ScatteredArranger>(options, robot, scanner);
}

}  // namespace rangegrasp::trial::internal
