#include "recognition/recognize.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "geometry/kd_tree.h"
#include "recognition/internal/match.h"

namespace rangegrasp::recognition {
namespace {

using internal::Evidence;
using internal::Match;
using internal::Posed;
using internal::PreparedObject;
using internal::Segment;

/// Settling a pose raises its score by less than this share of what is hopeless.
constexpr double kNearEnough = 0.5;
/// A find that scores by so much less than one of fewer views explains two objects as one.
constexpr double kMuchWorse = 0.1;

FoundObject Told(const PreparedObject& object, const Posed& posed, const Segment& segment,
                 const perception::Scene& scene, const RecognitionOptions& options) {
  geometry::Indices explained;
  const Evidence evidence = internal::Weigh(object, posed.X_CB, segment.rays, options.tolerance_m,
                                            options.color_tolerance, &explained);
  FoundObject found;
  found.object = object.object->name;
  found.X_CB = posed.X_CB;
  found.score = posed.score;
  found.color = evidence.Color();
  const double visible = std::max(1.0, evidence.explained + evidence.violated);
  found.share_seen = evidence.explained / (visible + evidence.hidden);
  found.violations = evidence.violated / visible;
  found.rms_m = std::sqrt(evidence.squares_m2 / std::max(1.0, evidence.explained));
  for (const auto point : explained) found.samples.push_back(scene.samples[point]);
  return found;
}

/// A known object at a segment: its poses, the best first.
struct Candidate {
  Match match;
  std::vector<Posed> posed;

  double Score() const { return posed.empty() ? 0.0 : posed.front().score; }
  const std::string& Name() const { return match.object().object->name; }
};

void Sort(std::vector<Candidate>& candidates) {
  std::ranges::sort(candidates, [](const Candidate& a, const Candidate& b) {
    return a.Score() != b.Score() ? a.Score() > b.Score() : a.Name() < b.Name();
  });
}

/// Leaves out what is hopeless beside the best.
void Prune(std::vector<Candidate>& candidates, double hopeless) {
  Sort(candidates);
  if (candidates.empty()) return;
  const double least = std::max(1e-6, candidates.front().Score() - hopeless);
  std::erase_if(candidates, [&](const Candidate& one) { return one.Score() < least; });
}

/// All known objects at a segment, as far as they are not hopeless, the best first.
std::vector<Candidate> CandidatesAt(const Segment& segment, const pcl_bridge::Cloud& source,
                                    const Library& library, const RecognitionOptions& options,
                                    std::uint64_t seed) {
  std::vector<Candidate> candidates;
  for (const auto& object : library.prepared().ready) {
    base::Rng rng(base::DeriveSeed(seed, object->object->name));
    const Match match(*object, segment, source, options);
    candidates.push_back({match, match.Guesses(rng)});
  }
  Prune(candidates, options.hopeless);
  for (Candidate& one : candidates) one.posed = one.match.Registered(std::move(one.posed));
  Prune(candidates, kNearEnough * options.hopeless);
  for (Candidate& one : candidates) {
    if (one.Score() < options.min_score - options.hopeless) continue;
    one.match.AddTurned(one.posed);
    one.match.Settle(one.posed);
  }
  Sort(candidates);
  return candidates;
}

/// The share of a segment that lies close about the model and is not explained by it.
double Hugging(const FoundObject& found, const KnownObject& object, const perception::Scene& scene,
               const geometry::Indices& own, const RecognitionOptions& options) {
  const std::set<geometry::SampleId> explained(found.samples.begin(), found.samples.end());
  const geometry::KdTree surface(object.surface_B.points);
  const base::Pose X_BC = found.X_CB.inverse();
  const auto hugging = std::ranges::count_if(own, [&](std::uint32_t point) {
    return !explained.contains(scene.SampleOf(point)) &&
           surface.CountWithin(X_BC * scene.cloud.points[point], options.hugs_m, 1) > 0;
  });
  return static_cast<double>(hugging) / static_cast<double>(own.size());
}

/// Whether it is seen well enough to be named, and not another shape of about its size.
bool IsPlausible(const FoundObject& found, const RecognitionOptions& options) {
  return found.samples.size() >= options.min_samples &&
         found.score - found.runner_up >= options.margin / std::max(0.1, found.share_seen) &&
         found.violations <= options.max_violations &&
         found.rms_m <= options.max_rms * options.tolerance_m &&
         found.hugging <= options.max_hugging &&
         (options.color_weight == 0.0 || found.color >= options.min_color) &&
         found.share_seen >= options.min_share_seen;
}

/// The object that a segment is; nullopt where none is good enough, or two are about as good.
std::optional<FoundObject> Identify(const geometry::Observation& observation,
                                    const perception::Scene& scene, const geometry::Indices& own,
                                    const Library& library, const RecognitionOptions& options,
                                    base::Rng& rng) {
  const std::uint64_t seed = rng.Next();
  const Segment segment = internal::SegmentOf(observation, scene, own, options);
  const pcl_bridge::Cloud source(segment.source_C);
  const auto candidates = CandidatesAt(segment, source, library, options, seed);
  if (candidates.empty() || candidates.front().posed.empty()) return std::nullopt;
  const Candidate& best = candidates.front();
  if (best.match.ShapeScore(best.posed.front().X_CB) < options.min_score) return std::nullopt;
  FoundObject found = Told(best.match.object(), best.posed.front(), segment, scene, options);
  std::vector<Posed> others(best.posed);
  std::ranges::copy(best.match.Moved(best.posed.front()), std::back_inserter(others));
  for (const Posed& other : others) {
    const PoseDifference off =
        Difference(other.X_CB, found.X_CB, best.match.object().object->symmetry);
    const bool differs =
        off.distance_m > internal::kDiffers_m || off.angle_rad > internal::kDiffers_rad;
    if (differs && other.score > found.score - options.margin) {
      found.alternatives_CB.push_back(other.X_CB);
    }
  }
  found.hugging = Hugging(found, *best.match.object().object, scene, own, options);
  if (candidates.size() > 1) found.runner_up = candidates[1].Score();
  return IsPlausible(found, options) ? std::optional(found) : std::nullopt;
}

/// An object's points with those of small pieces beside it, which may be a part of it that was
/// perceived apart, such as a handle; empty if there are none.
geometry::Indices WithPieces(const perception::Scene& scene, std::size_t object,
                             const RecognitionOptions& options) {
  const geometry::Indices& own = scene.objects[object].points;
  const geometry::Points points = geometry::Select(scene.cloud.points, own);
  const geometry::KdTree tree(points);
  geometry::Indices all = own;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const geometry::Indices& piece = scene.objects[i].points;
    const double share = static_cast<double>(piece.size()) / static_cast<double>(own.size());
    if (i == object || share > options.max_piece) continue;
    const bool beside = std::ranges::any_of(piece, [&](std::uint32_t point) {
      return tree.CountWithin(scene.cloud.points[point], options.piece_gap_m, 1) > 0;
    });
    if (beside) all.insert(all.end(), piece.begin(), piece.end());
  }
  return all.size() > own.size() ? all : geometry::Indices();
}

/// Leaves out what more than half of the samples of which a larger find explains: a piece of it.
void DropPieces(std::vector<FoundObject>& all) {
  std::ranges::stable_sort(all, std::greater{},
                           [](const FoundObject& found) { return found.samples.size(); });
  std::set<geometry::SampleId> taken;
  std::erase_if(all, [&](const FoundObject& found) {
    const auto known = std::ranges::count_if(
        found.samples, [&](const geometry::SampleId& id) { return taken.contains(id); });
    if (2 * static_cast<std::size_t>(known) > found.samples.size()) return true;
    taken.insert(found.samples.begin(), found.samples.end());
    return false;
  });
}

/// How many of an earlier find's samples a new one explains.
std::size_t Shared(const FoundObject& before, const FoundObject& now) {
  const std::set<geometry::SampleId> samples(now.samples.begin(), now.samples.end());
  return static_cast<std::size_t>(std::ranges::count_if(
      before.samples, [&](const geometry::SampleId& id) { return samples.contains(id); }));
}

/// What more views tell counts before what fewer told of the same place, but where it fits much
/// worse: then two objects have become one segment. @return the earlier finds that are left
std::vector<FoundObject> NotFoundAgain(std::vector<FoundObject> before,
                                       std::vector<FoundObject>& now) {
  std::erase_if(before, [&](const FoundObject& one) {
    const auto again = std::ranges::find_if(
        now, [&](const FoundObject& other) { return 2 * Shared(one, other) > one.samples.size(); });
    if (again == now.end()) return false;
    if (again->score >= one.score - kMuchWorse) return true;
    now.erase(again);
    return false;
  });
  return before;
}

/// The points of the scene's cloud this near to a found object.
geometry::Indices PointsAt(const FoundObject& found, const KnownObject& object,
                           const perception::Scene& scene, double near_m) {
  const geometry::KdTree surface(object.surface_B.points);
  const base::Pose X_BC = found.X_CB.inverse();
  geometry::Indices points;
  for (std::uint32_t i = 0; i < scene.cloud.size(); ++i) {
    if (surface.CountWithin(X_BC * scene.cloud.points[i], near_m, 1) > 0) points.push_back(i);
  }
  return points;
}

/// Whether the new views agree with what was found before them: something is measured there, lies
/// on its surface, and nothing behind it.
bool StillFits(const FoundObject& found, const geometry::Observation& observation,
               const perception::Scene& scene, const geometry::Indices& own, const Library& library,
               const RecognitionOptions& options) {
  const auto prepared = std::ranges::find_if(library.prepared().ready, [&](const auto& object) {
    return object->object->name == found.object;
  });
  const Evidence evidence = internal::Weigh(
      **prepared, found.X_CB, internal::RaysAbout(observation, scene, own, options.beside_m),
      options.tolerance_m, options.color_tolerance);
  const double visible = std::max(1.0, evidence.explained + evidence.violated);
  const double rms_m = std::sqrt(evidence.squares_m2 / std::max(1.0, evidence.explained));
  return evidence.explained >= static_cast<double>(options.min_samples) &&
         evidence.violated / visible <= options.max_violations &&
         rms_m <= options.max_rms * options.tolerance_m;
}

/// Of earlier finds those that the new views agree with take the points near to them.
/// @return whether a point of the scene's cloud is theirs
std::vector<bool> Claim(const geometry::Observation& observation, const perception::Scene& scene,
                        const Library& library, const RecognitionOptions& options,
                        std::vector<FoundObject>& known) {
  std::vector<bool> claimed(scene.cloud.size(), false);
  std::erase_if(known, [&](FoundObject& found) {
    const auto own = PointsAt(found, library.Find(found.object), scene, 2.0 * options.tolerance_m);
    if (!StillFits(found, observation, scene, own, library, options)) return true;
    std::set<geometry::SampleId> samples(found.samples.begin(), found.samples.end());
    for (const auto point : own) {
      claimed[point] = true;
      samples.insert(scene.SampleOf(point));
    }
    found.samples.assign(samples.begin(), samples.end());
    return false;
  });
  return claimed;
}

/// What each of these perceived objects is, as far as that is known.
std::vector<FoundObject> IdentifyAll(const geometry::Observation& observation,
                                     const perception::Scene& scene,
                                     const std::vector<std::size_t>& which, const Library& library,
                                     const RecognitionOptions& options, base::Rng& rng) {
  std::vector<FoundObject> all;
  for (const std::size_t i : which) {
    const geometry::Indices& own = scene.objects[i].points;
    base::Rng of_object(rng.Next());
    std::optional<FoundObject> found;
    if (own.size() >= options.min_samples) {
      const geometry::Indices whole = WithPieces(scene, i, options);
      if (!whole.empty()) {
        found = Identify(observation, scene, whole, library, options, of_object);
      }
      if (!found) found = Identify(observation, scene, own, library, options, of_object);
    }
    if (found) all.push_back(std::move(*found));
  }
  DropPieces(all);
  return all;
}

/// Takes the points that are claimed off the perceived objects. @return those that lost some
std::vector<std::size_t> TakeOff(const std::vector<bool>& claimed, perception::Scene& scene) {
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const auto taken =
        std::erase_if(scene.objects[i].points, [&](std::uint32_t point) { return claimed[point]; });
    if (taken > 0) changed.push_back(i);
  }
  return changed;
}

}  // namespace

std::vector<FoundObject> Recognize(const geometry::Observation& observation,
                                   const perception::Scene& scene, const Library& library,
                                   const RecognitionOptions& options, base::Rng& rng,
                                   std::vector<FoundObject> known) {
  std::vector<std::size_t> which(scene.objects.size());
  std::iota(which.begin(), which.end(), std::size_t{0});
  auto all = IdentifyAll(observation, scene, which, library, options, rng);
  known = NotFoundAgain(std::move(known), all);
  const auto claimed = Claim(observation, scene, library, options, known);
  if (!known.empty()) {
    // What lies beside them in their segments is another object.
    perception::Scene rest = scene;
    const auto changed = TakeOff(claimed, rest);
    auto beside = IdentifyAll(observation, rest, changed, library, options, rng);
    std::ranges::move(beside, std::back_inserter(all));
    DropPieces(all);
    std::ranges::move(known, std::back_inserter(all));
  }
  std::ranges::stable_sort(all, std::greater{}, &FoundObject::score);
  return all;
}

}  // namespace rangegrasp::recognition
