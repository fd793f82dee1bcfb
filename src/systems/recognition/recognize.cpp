#include "recognition/recognize.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "base/units.h"
#include "base/words.h"
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

/// Whether more than half of a find's samples are in the set.
bool IsMostlyIn(const SampleSet& set, const FoundObject& found) {
  const auto in_set = std::ranges::count_if(
      found.samples, [&](const geometry::SampleId& id) { return set.contains(id); });
  return 2 * static_cast<std::size_t>(in_set) > found.samples.size();
}

/// The object in its best pose.
FoundObject FoundAt(const Match& match, const Segment& segment, const Query& query) {
  const Posed& posed = match.posed().front();
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

/// Best first; notes the best one.
void Sort(std::vector<Match>& candidates, UnknownObject& noted) {
  std::ranges::sort(candidates, [](const Match& a, const Match& b) {
    if (a.Score() != b.Score()) return a.Score() > b.Score();
    return a.object().object.name < b.object().object.name;
  });
  if (candidates.empty()) return;
  noted.nearest = candidates.front().object().object.name;
  noted.score = candidates.front().Score();
}

/// Sorts, and removes candidates that are hopeless compared with the best one; all of them if even
/// the best is below min_score.
void Prune(std::vector<Match>& candidates, double min_score, double hopeless,
           UnknownObject& noted) {
  Sort(candidates, noted);
  if (candidates.empty() || candidates.front().Score() < min_score) {
    candidates.clear();
    return;
  }
  const double least = std::max(1e-6, candidates.front().Score() - hopeless);
  std::erase_if(candidates, [&](const Match& one) { return one.Score() < least; });
}

/// The known objects that are not hopeless at a segment, best first. None if even the best guess
/// explains little, as in most segments of merged objects: in two piles, objects that were found
/// had guesses of 0.74 or more.
/// @param only  name of an object that is compared alone; empty: all are
/// @param noted  receives the best one, also if it is hopeless
std::vector<Match> CandidatesAt(const Segment& segment, const Query& query, const std::string& only,
                                UnknownObject& noted) {
  const RecognitionOptions& options = query.options;
  std::vector<Match> candidates;
  for (const auto& object : query.library.prepared()) {
    const std::string& name = object->object.name;
    if (name == options.left_out || (!only.empty() && name != only)) continue;
    candidates.emplace_back(*object, segment, options);
  }
  const double near_enough = kNearEnough * options.hopeless;
  const double min_score = options.min_score - near_enough;
  Prune(candidates, min_score, options.hopeless, noted);
  for (Match& one : candidates) one.Register();
  Prune(candidates, min_score, near_enough, noted);
  for (Match& one : candidates) {
    one.AddTurned();
    one.Settle();
  }
  Sort(candidates, noted);
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

/// Why it is not seen well enough to be named, or may be a similar shape; empty if neither holds.
std::string FlawOf(const FoundObject& found, const RecognitionOptions& options) {
  const double lead = options.margin / std::max(0.1, found.share_seen);
  const double max_rms_m = options.max_rms * options.tolerance_m;
  if (found.samples.size() < options.min_samples) {
    return fmt::format("it explains {}, at least {} are needed",
                       base::Counted(found.samples.size(), "sample"), options.min_samples);
  }
  if (found.score - found.runner_up < lead) {
    return fmt::format("another object scores {:.3f}, it must score at least {:.3f} more",
                       found.runner_up, lead);
  }
  if (found.violations > options.max_violations) {
    return fmt::format("{:.1f} % of the rays passed through it, at most {:.1f} % may",
                       100.0 * found.violations, 100.0 * options.max_violations);
  }
  if (found.rms_m > max_rms_m) {
    return fmt::format("the samples are {:.2f} mm off its surface, at most {:.2f} mm is allowed",
                       found.rms_m * base::kMmPerM, max_rms_m * base::kMmPerM);
  }
  if (found.hugging > options.max_hugging) {
    return fmt::format(
        "{:.1f} % of the samples are close to it but not on it, at most {:.1f} % may be",
        100.0 * found.hugging, 100.0 * options.max_hugging);
  }
  if (found.color < options.min_color) {
    return fmt::format("its colors agree by {:.2f}, at least {:.2f} is needed", found.color,
                       options.min_color);
  }
  if (found.share_seen < options.min_share_seen) {
    return fmt::format("{:.0f} % of it was seen, at least {:.0f} % is needed",
                       100.0 * found.share_seen, 100.0 * options.min_share_seen);
  }
  return "";
}

/// The known object at a segment; nullopt, and why in `unknown`, if none or two are good enough.
std::optional<FoundObject> Identify(const Query& query, const geometry::Indices& own,
                                    UnknownObject& unknown, const std::string& only = {}) {
  const RecognitionOptions& options = query.options;
  const Segment segment = internal::SegmentOf(query.observation, query.scene, own, options);
  const auto candidates = CandidatesAt(segment, query, only, unknown);
  unknown.reason = fmt::format("its shape must score at least {:.2f}", options.min_score);
  if (candidates.empty()) return std::nullopt;
  const Match& best = candidates.front();
  if (best.ShapeScore(best.posed().front().X_CB) < options.min_score) return std::nullopt;
  const KnownObject& known = best.object().object;
  FoundObject found = FoundAt(best, segment, query);
  std::vector<Posed> others = best.Moved();
  others.insert(others.begin(), best.posed().begin(), best.posed().end());
  for (const Posed& other : others) {
    const bool differs = internal::AreDistinct(other.X_CB, found.X_CB, known.symmetry);
    if (differs && other.score > found.score - options.margin) {
      found.alternatives_CB.push_back(other.X_CB);
    }
  }
  found.hugging = Hugging(found, own, query);
  if (candidates.size() > 1) found.runner_up = candidates[1].Score();
  unknown.reason = FlawOf(found, options);
  return unknown.reason.empty() ? std::optional(found) : std::nullopt;
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
    if (IsMostlyIn(taken, found)) return true;
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
      return IsMostlyIn(SampleSet(other.samples.begin(), other.samples.end()), one);
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
  const auto& prepared = query.library.FindPrepared(found.object);
  const auto rays = internal::RaysAbout(query.observation, query.scene, own, options.beside_m);
  const Evidence evidence =
      internal::Weigh(prepared, found.X_CB, rays, options.tolerance_m, options.color_tolerance);
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
  UnknownObject ignored;
  for (const FoundObject& before : known) {
    if (!IsMostlyIn(samples, before)) continue;
    auto found = Identify(query, own, ignored, before.object);
    if (!found) continue;
    const Symmetry& symmetry = query.library.Find(before.object).symmetry;
    if (internal::AreDistinct(found->X_CB, before.X_CB, symmetry)) continue;
    found->runner_up = before.runner_up;
    if (FlawOf(*found, query.options).empty()) return found;
  }
  return std::nullopt;
}

/// Identifies each of these perceived objects, if possible. Known ones are confirmed first.
/// @param unknown  the others are appended to it
std::vector<FoundObject> IdentifyAll(const Query& query, const std::vector<std::size_t>& which,
                                     std::vector<UnknownObject>& unknown,
                                     const std::vector<FoundObject>& known = {}) {
  std::vector<FoundObject> all;
  for (const std::size_t i : which) {
    const geometry::Indices& own = query.scene.objects[i].points;
    UnknownObject one{.object = i};
    std::optional<FoundObject> found;
    if (own.size() < query.options.min_samples) {
      one.reason = fmt::format("it has {}, at least {} are needed",
                               base::Counted(own.size(), "point"), query.options.min_samples);
    } else {
      const geometry::Indices whole = WithPieces(query.scene, i, query.options);
      found = Confirm(query, whole.empty() ? own : whole, known);
      if (!found && !whole.empty()) found = Identify(query, whole, one);
      if (!found) found = Identify(query, own, one);
    }
    if (found) {
      all.push_back(std::move(*found));
    } else {
      unknown.push_back(std::move(one));
    }
  }
  DropPieces(all);
  return all;
}

SampleSet SamplesOf(const std::vector<FoundObject>& found) {
  SampleSet samples;
  for (const FoundObject& one : found) samples.insert(one.samples.begin(), one.samples.end());
  return samples;
}

/// Whether the set has at least half of a perceived object's samples.
bool IsExplained(const perception::Scene& scene, std::size_t object, const SampleSet& samples) {
  const geometry::Indices& own = scene.objects[object].points;
  const auto in_set = std::ranges::count_if(
      own, [&](std::uint32_t point) { return samples.contains(scene.SampleOf(point)); });
  return 2 * static_cast<std::size_t>(in_set) >= own.size();
}

}  // namespace

std::vector<FoundObject> Recognize(const geometry::Observation& observation,
                                   const perception::Scene& scene, const Library& library,
                                   const RecognitionOptions& options,
                                   std::vector<FoundObject> known,
                                   std::vector<UnknownObject>* unknown) {
  std::vector<std::size_t> which(scene.objects.size());
  std::iota(which.begin(), which.end(), std::size_t{0});
  const Query query{observation, scene, library, options};
  std::vector<UnknownObject> unnamed;
  auto all = IdentifyAll(query, which, unnamed, known);
  known = NotFoundAgain(std::move(known), all);
  const auto claimed = Claim(query, known);
  if (!known.empty()) {
    // The rest of their segments are other objects.
    perception::Scene rest = scene;
    std::vector<std::size_t> changed;
    for (std::size_t i = 0; i < rest.objects.size(); ++i) {
      const auto taken = std::erase_if(rest.objects[i].points,
                                       [&](std::uint32_t point) { return claimed[point]; });
      if (taken > 0) changed.push_back(i);
    }
    std::vector<UnknownObject> ignored;
    auto beside = IdentifyAll({observation, rest, library, options}, changed, ignored);
    std::ranges::move(beside, std::back_inserter(all));
    DropPieces(all);
    std::ranges::move(known, std::back_inserter(all));
  }
  if (unknown) {
    const SampleSet explained = SamplesOf(all);
    std::erase_if(unnamed, [&](const UnknownObject& one) {
      return IsExplained(scene, one.object, explained);
    });
    *unknown = std::move(unnamed);
  }
  std::ranges::stable_sort(all, std::greater{}, &FoundObject::score);
  return all;
}

std::vector<std::size_t> OpenObjects(const perception::Scene& scene,
                                     const std::vector<FoundObject>& found,
                                     const RecognitionOptions& options) {
  const SampleSet sure = SamplesOf(SureOnes(found));
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].points.size() < options.min_samples) continue;
    if (!IsExplained(scene, i, sure)) open.push_back(i);
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
