#include "recognition/recognize.h"

#include <algorithm>
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
using internal::Segment;
using SampleSet = std::set<geometry::SampleId>;

/// Settling a pose raises its score by less than this share of `hopeless`.
constexpr double kNearEnough = 0.5;
/// A find that scores this much less than one from fewer views explains two objects as one.
constexpr double kMuchWorse = 0.1;

/// Inputs of a recognition.
struct Query {
  const geometry::Observation& observation;
  const perception::Scene& scene;
  const Library& library;
  const RecognitionOptions& options;
};

std::size_t CountIn(const SampleSet& set, const std::vector<geometry::SampleId>& samples) {
  return static_cast<std::size_t>(std::ranges::count_if(
      samples, [&](const geometry::SampleId& id) { return set.contains(id); }));
}

FoundObject FoundAt(const Match& match, const Posed& posed, const Segment& segment,
                    const Query& query) {
  geometry::Indices explained;
  const Evidence evidence =
      internal::Weigh(match.object(), posed.X_CB, segment.rays, query.options.tolerance_m,
                      query.options.color_tolerance, &explained);
  FoundObject found;
  found.object = match.object().object.name;
  found.X_CB = posed.X_CB;
  found.score = posed.score;
  found.color = evidence.Color();
  found.share_seen = evidence.explained / (evidence.Visible() + evidence.hidden);
  found.violations = evidence.violated / evidence.Visible();
  found.rms_m = evidence.Rms_m();
  for (const auto point : explained) found.samples.push_back(query.scene.samples[point]);
  return found;
}

/// A known object matched to a segment: its poses, best first.
struct Candidate {
  Match match;
  std::vector<Posed> posed;

  double Score() const { return posed.empty() ? 0.0 : posed.front().score; }
  const std::string& Name() const { return match.object().object.name; }
};

void Sort(std::vector<Candidate>& candidates) {
  std::ranges::sort(candidates, [](const Candidate& a, const Candidate& b) {
    return a.Score() != b.Score() ? a.Score() > b.Score() : a.Name() < b.Name();
  });
}

/// Removes candidates that are hopeless compared with the best one.
void Prune(std::vector<Candidate>& candidates, double hopeless) {
  Sort(candidates);
  if (candidates.empty()) return;
  const double least = std::max(1e-6, candidates.front().Score() - hopeless);
  std::erase_if(candidates, [&](const Candidate& one) { return one.Score() < least; });
}

/// The known objects that are not hopeless at a segment, best first. None if even the best guess
/// explains little, as in most segments of merged objects: in two piles, objects that were found
/// had guesses of 0.74 or more.
/// @param only  name of an object that is compared alone; empty: all are
std::vector<Candidate> CandidatesAt(const Segment& segment, const Query& query,
                                    const std::string& only) {
  const RecognitionOptions& options = query.options;
  std::vector<Candidate> candidates;
  for (const auto& object : query.library.prepared().ready) {
    if (!only.empty() && only != object->object.name) continue;
    const Match match(*object, segment, options);
    candidates.push_back({match, match.Guesses()});
  }
  const double near_enough = kNearEnough * options.hopeless;
  const auto all_hopeless = [&] {
    return candidates.empty() || candidates.front().Score() < options.min_score - near_enough;
  };
  Prune(candidates, options.hopeless);
  if (all_hopeless()) return {};
  for (Candidate& one : candidates) one.posed = one.match.Registered(std::move(one.posed));
  Prune(candidates, near_enough);
  if (all_hopeless()) return {};
  for (Candidate& one : candidates) {
    one.match.AddTurned(one.posed);
    one.match.Settle(one.posed);
  }
  Sort(candidates);
  return candidates;
}

/// Those of the given points of the scene's cloud that are within near_m of a found object.
geometry::Indices PointsAt(const FoundObject& found, geometry::Indices points, const Query& query,
                           double near_m) {
  const geometry::KdTree surface(query.library.Find(found.object).surface_B.points);
  const base::Pose X_BC = found.X_CB.inverse();
  std::erase_if(points, [&](std::uint32_t i) {
    return surface.CountWithin(X_BC * query.scene.cloud.points[i], near_m, 1) == 0;
  });
  return points;
}

/// The share of a segment that is close to the model but not explained by it.
double Hugging(const FoundObject& found, const geometry::Indices& own, const Query& query) {
  const SampleSet explained(found.samples.begin(), found.samples.end());
  geometry::Indices rest = own;
  std::erase_if(rest, [&](auto i) { return explained.contains(query.scene.SampleOf(i)); });
  const auto hugging = PointsAt(found, std::move(rest), query, query.options.hugs_m).size();
  return static_cast<double>(hugging) / static_cast<double>(own.size());
}

/// True if it is seen well enough to be named, and is not another shape of similar size.
bool IsPlausible(const FoundObject& found, const RecognitionOptions& options) {
  return found.samples.size() >= options.min_samples &&
         found.score - found.runner_up >= options.margin / std::max(0.1, found.share_seen) &&
         found.violations <= options.max_violations &&
         found.rms_m <= options.max_rms * options.tolerance_m &&
         found.hugging <= options.max_hugging &&
         (options.color_weight == 0.0 || found.color >= options.min_color) &&
         found.share_seen >= options.min_share_seen;
}

/// The known object at a segment; nullopt if none is good enough, or two are about equally good.
std::optional<FoundObject> Identify(const Query& query, const geometry::Indices& own,
                                    const std::string& only = {}) {
  const RecognitionOptions& options = query.options;
  const Segment segment = internal::SegmentOf(query.observation, query.scene, own, options);
  const auto candidates = CandidatesAt(segment, query, only);
  if (candidates.empty() || candidates.front().posed.empty()) return std::nullopt;
  const Candidate& best = candidates.front();
  if (best.match.ShapeScore(best.posed.front().X_CB) < options.min_score) return std::nullopt;
  const KnownObject& known = best.match.object().object;
  FoundObject found = FoundAt(best.match, best.posed.front(), segment, query);
  std::vector<Posed> others = best.match.Moved(best.posed.front());
  others.insert(others.begin(), best.posed.begin(), best.posed.end());
  for (const Posed& other : others) {
    const bool differs = internal::AreDistinct(other.X_CB, found.X_CB, known.symmetry);
    if (differs && other.score > found.score - options.margin) {
      found.alternatives_CB.push_back(other.X_CB);
    }
  }
  found.hugging = Hugging(found, own, query);
  if (candidates.size() > 1) found.runner_up = candidates[1].Score();
  return IsPlausible(found, options) ? std::optional(found) : std::nullopt;
}

/// An object's points with those of small pieces near it, e.g. a handle; empty if there are none.
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

/// Removes finds of which a larger one explains more than half of the samples: they are its pieces.
void DropPieces(std::vector<FoundObject>& all) {
  std::ranges::stable_sort(all, std::greater{},
                           [](const FoundObject& found) { return found.samples.size(); });
  SampleSet taken;
  std::erase_if(all, [&](const FoundObject& found) {
    if (2 * CountIn(taken, found.samples) > found.samples.size()) return true;
    taken.insert(found.samples.begin(), found.samples.end());
    return false;
  });
}

/// A find from more views replaces one from fewer, unless it fits much worse: then it explains two
/// objects as one.
/// @return the earlier finds that remain
std::vector<FoundObject> NotFoundAgain(std::vector<FoundObject> before,
                                       std::vector<FoundObject>& now) {
  std::erase_if(before, [&](const FoundObject& one) {
    const auto again = std::ranges::find_if(now, [&](const FoundObject& other) {
      const SampleSet samples(other.samples.begin(), other.samples.end());
      return 2 * CountIn(samples, one.samples) > one.samples.size();
    });
    if (again == now.end()) return false;
    if (again->score >= one.score - kMuchWorse) return true;
    now.erase(again);
    return false;
  });
  return before;
}

/// True if the new views agree with an earlier find: they see its surface, and nothing behind it.
bool StillFits(const FoundObject& found, const geometry::Indices& own, const Query& query) {
  const RecognitionOptions& options = query.options;
  const auto prepared =
      std::ranges::find_if(query.library.prepared().ready,
                           [&](const auto& object) { return object->object.name == found.object; });
  const auto rays = internal::RaysAbout(query.observation, query.scene, own, options.beside_m);
  const Evidence evidence =
      internal::Weigh(**prepared, found.X_CB, rays, options.tolerance_m, options.color_tolerance);
  return evidence.explained >= static_cast<double>(options.min_samples) &&
         evidence.violated / evidence.Visible() <= options.max_violations &&
         evidence.Rms_m() <= options.max_rms * options.tolerance_m;
}

/// Earlier finds that agree with the new views claim the points near them; the others are removed.
/// @return for each point of the scene's cloud, whether it is claimed
std::vector<bool> Claim(const Query& query, std::vector<FoundObject>& known) {
  const perception::Scene& scene = query.scene;
  std::vector<bool> claimed(scene.cloud.size(), false);
  geometry::Indices everywhere(scene.cloud.size());
  std::iota(everywhere.begin(), everywhere.end(), 0u);
  std::erase_if(known, [&](FoundObject& found) {
    const auto own = PointsAt(found, everywhere, query, 2.0 * query.options.tolerance_m);
    if (!StillFits(found, own, query)) return true;
    SampleSet samples(found.samples.begin(), found.samples.end());
    for (const auto point : own) {
      claimed[point] = true;
      samples.insert(scene.SampleOf(point));
    }
    found.samples.assign(samples.begin(), samples.end());
    return false;
  });
  return claimed;
}

/// The known find with most of its samples in a segment if it is identified there again, in the
/// same pose. It was compared with the other objects before.
std::optional<FoundObject> Confirm(const Query& query, const geometry::Indices& own,
                                   const std::vector<FoundObject>& known) {
  if (known.empty()) return std::nullopt;
  SampleSet samples;
  for (const auto point : own) samples.insert(query.scene.SampleOf(point));
  for (const FoundObject& before : known) {
    if (2 * CountIn(samples, before.samples) <= before.samples.size()) continue;
    auto found = Identify(query, own, before.object);
    if (!found) continue;
    const Symmetry& symmetry = query.library.Find(before.object).symmetry;
    if (internal::AreDistinct(found->X_CB, before.X_CB, symmetry)) continue;
    found->runner_up = before.runner_up;
    if (IsPlausible(*found, query.options)) return found;
  }
  return std::nullopt;
}

/// Identifies each of these perceived objects, if possible. Known ones are confirmed first.
std::vector<FoundObject> IdentifyAll(const Query& query, const std::vector<std::size_t>& which,
                                     const std::vector<FoundObject>& known = {}) {
  std::vector<FoundObject> all;
  for (const std::size_t i : which) {
    const geometry::Indices& own = query.scene.objects[i].points;
    if (own.size() < query.options.min_samples) continue;
    const geometry::Indices whole = WithPieces(query.scene, i, query.options);
    auto found = Confirm(query, whole.empty() ? own : whole, known);
    if (!found && !whole.empty()) found = Identify(query, whole);
    if (!found) found = Identify(query, own);
    if (found) all.push_back(std::move(*found));
  }
  DropPieces(all);
  return all;
}

/// Removes claimed points from the perceived objects. @return the objects that lost points
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
                                   const RecognitionOptions& options,
                                   std::vector<FoundObject> known) {
  std::vector<std::size_t> which(scene.objects.size());
  std::iota(which.begin(), which.end(), std::size_t{0});
  const Query query{observation, scene, library, options};
  auto all = IdentifyAll(query, which, known);
  known = NotFoundAgain(std::move(known), all);
  const auto claimed = Claim(query, known);
  if (!known.empty()) {
    // The rest of their segments are other objects.
    perception::Scene rest = scene;
    const auto changed = TakeOff(claimed, rest);
    auto beside = IdentifyAll({observation, rest, library, options}, changed);
    std::ranges::move(beside, std::back_inserter(all));
    DropPieces(all);
    std::ranges::move(known, std::back_inserter(all));
  }
  std::ranges::stable_sort(all, std::greater{}, &FoundObject::score);
  return all;
}

std::vector<std::size_t> OpenObjects(const perception::Scene& scene,
                                     const std::vector<FoundObject>& found,
                                     const RecognitionOptions& options) {
  SampleSet sure;
  for (const FoundObject& one : SureOnes(found)) {
    sure.insert(one.samples.begin(), one.samples.end());
  }
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const geometry::Indices& own = scene.objects[i].points;
    if (own.size() < options.min_samples) continue;
    const auto known = std::ranges::count_if(
        own, [&](std::uint32_t point) { return sure.contains(scene.SampleOf(point)); });
    if (2 * static_cast<std::size_t>(known) < own.size()) open.push_back(i);
  }
  return open;
}

std::vector<FoundObject> SureOnes(std::vector<FoundObject> found) {
  std::erase_if(found, [](const FoundObject& one) { return !one.alternatives_CB.empty(); });
  return found;
}

std::vector<FoundObject> AsFirstSeen(std::vector<FoundObject> found) {
  for (FoundObject& one : found) {
    std::erase_if(one.samples, [](const geometry::SampleId& id) { return id.view != 0; });
  }
  std::erase_if(found, [](const FoundObject& one) { return one.samples.empty(); });
  return found;
}

}  // namespace rangegrasp::recognition
