#include "recognition/recognize.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "core/units.h"
#include "geometry/kd_tree.h"
#include "pcl_bridge/cloud.h"
#include "pcl_bridge/registration.h"
#include "recognition/internal/evidence.h"
#include "recognition/internal/hypotheses.h"

namespace rangegrasp::recognition {
namespace {

using internal::Evidence;
using internal::PreparedObject;
using internal::SampleRays;
using internal::Segment;

/// Registered poses nearer than this to a better one are it, symmetry aside.
constexpr double kSame_m = 0.004;
constexpr double kSame_rad = 0.05;
constexpr double kSameCoarse_m = 0.015;
constexpr double kSameCoarse_rad = 0.25;
/// Pairs' distances of registration: from the first guess's error down to the scanner's.
constexpr double kPairs_m[] = {0.025, 0.008};
constexpr int kIterations[] = {15, 15};
/// Steps of the last refinement, halved so often.
constexpr double kStep_m = 0.0015;
constexpr double kStep_rad = 0.02;
constexpr int kHalvings = 3;
/// A view that has this share of a segment's points saw what faced it; with ten views or fewer
/// there is one.
constexpr double kSeenBy = 0.1;
/// What is this near to the table stands on it; so many points of it are enough.
constexpr double kContact_m = 0.002;
constexpr std::size_t kMaxContact = 80;
/// Settling a pose raises its score by less than this share of what is hopeless.
constexpr double kNearEnough = 0.5;
/// Poses of one object with scores this near are told apart by half the tolerance: by a rim of a
/// millimetre.
constexpr double kNear = 0.03;
/// A pose is compared with those that are turned by so many steps about the model's axes.
constexpr int kTurns = 18;
/// A find that scores by so much less than one of fewer views explains two objects as one.
constexpr double kMuchWorse = 0.1;
/// Poses of one object that differ by more are two: what one wants to know a pose to, 5 mm and
/// 5 deg, and a little.
constexpr double kDiffers_m = 0.006;
constexpr double kDiffers_rad = 0.105;

/// A pose with what the rays say of it.
struct Posed {
  core::Pose X_CB;
  double score = 0.0;
  bool lies = false;  ///< on the table, in one of its ways to
};

core::Pose TableFrame(const geometry::Plane& plane) {
  const Eigen::Matrix3d R =
      Eigen::Quaterniond::FromTwoVectors(plane.normal, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return core::MakePose(R, Eigen::Vector3d(0.0, 0.0, plane.Distance(Eigen::Vector3d::Zero())));
}

/// As many points of a cloud as registration wants, evenly.
geometry::Points SourceOf(const geometry::Points& points, std::size_t count) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  geometry::Points source;
  for (std::size_t i = 0; i < points.size(); i += step) source.push_back(points[i]);
  return source;
}

Segment SegmentOf(const geometry::Observation& observation, const perception::Scene& scene,
                  const geometry::Indices& own, const RecognitionOptions& options) {
  Segment segment;
  segment.cloud_C = {geometry::Select(scene.cloud.points, own),
                     geometry::Select(scene.cloud.normals, own)};
  segment.source_C = SourceOf(segment.cloud_C.points, options.source_points);
  segment.rays = internal::RaysAbout(observation, scene, own, options.beside_m);
  segment.coarse = internal::Fewer(segment.rays, options.coarse_rays);
  segment.fine = internal::Fewer(segment.rays, options.fine_rays);
  segment.X_TC = TableFrame(scene.table.plane);
  std::vector<std::size_t> seen(observation.views.size(), 0);
  for (const auto point : own) ++seen[scene.SampleOf(point).view];
  for (std::size_t view = 0; view < seen.size(); ++view) {
    if (static_cast<double>(seen[view]) < kSeenBy * static_cast<double>(own.size())) continue;
    segment.eyes_C.push_back(observation.views[view].X_CV.translation());
  }
  return segment;
}

/// How deep the lowest corner of its hull is below the table.
double Sunk(const PreparedObject& object, const core::Pose& X_CB, const Segment& segment) {
  const core::Pose X_TB = segment.X_TC * X_CB;
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& corner : object.hull_B) lowest = std::min(lowest, (X_TB * corner).z());
  return -lowest;
}

/// The best, of those near to each other one.
std::vector<Posed> Best(std::vector<Posed> posed, std::size_t count, const Symmetry& symmetry,
                        double same_m, double same_rad) {
  std::ranges::stable_sort(posed, std::greater{}, &Posed::score);
  std::vector<Posed> best;
  for (const Posed& one : posed) {
    if (best.size() == count) break;
    const bool known = std::ranges::any_of(best, [&](const Posed& other) {
      const PoseDifference d = Difference(one.X_CB, other.X_CB, symmetry);
      return d.distance_m < same_m && d.angle_rad < same_rad;
    });
    if (!known) best.push_back(one);
  }
  return best;
}

/// One known object at one perceived one.
class Match {
 public:
  Match(const PreparedObject& object, const Segment& segment, const pcl_bridge::Cloud& source,
        const RecognitionOptions& options)
      : object_(&object), segment_(&segment), source_(&source), options_(&options) {}

  const PreparedObject& object() const { return *object_; }

  /// The best poses by the coarse score, the best first.
  std::vector<Posed> Guesses(core::Rng& rng) const {
    std::vector<Posed> posed;
    for (const auto& X_CB : internal::LyingPoses(*object_, *segment_)) {
      posed.push_back(Coarse(X_CB));
      posed.back().lies = true;
    }
    const auto references = static_cast<std::size_t>(options_->references);
    for (const auto& X_CB : internal::VotedPoses(*object_, *segment_, references, rng)) {
      posed.push_back(Coarse(X_CB));
    }
    return Best(std::move(posed), static_cast<std::size_t>(options_->registered),
                object_->object->symmetry, kSameCoarse_m, kSameCoarse_rad);
  }

  /// The same, registered, the best by the fine score first.
  std::vector<Posed> Registered(std::vector<Posed> posed) const {
    for (Posed& one : posed) {
      one.X_CB = one.lies ? Registered(one.X_CB, pcl_bridge::Cloud(WithContact(one.X_CB)))
                          : Registered(one.X_CB, *source_);
      one.X_CB = Lifted(one.X_CB, std::max(0.0, Sunk(*object_, one.X_CB, *segment_)));
      one.score = FineScore(one.X_CB);
    }
    const std::size_t all = posed.size();
    return Best(std::move(posed), all, object_->object->symmetry, kSame_m, kSame_rad);
  }

  /// Adds what a pose may be taken for: turned about the model's principal axes, as far as the rays
  /// leave it open. A body that is round but for a handle is guessed where its handle is not.
  void AddTurned(std::vector<Posed>& posed) const {
    if (posed.empty() || object_->object->symmetry.axis_B) return;
    const core::Pose X_CB = posed.front().X_CB;
    const Eigen::Vector3d& center_B = object_->object->symmetry.center_B;
    const double least = Coarse(X_CB).score - options_->hopeless;
    std::vector<Posed> turned;
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 1; k < kTurns; ++k) {
        const Eigen::AngleAxisd turn(2.0 * core::kPi * k / kTurns, object_->axes_B.col(axis));
        Posed one =
            Coarse(X_CB * Eigen::Translation3d(center_B) * turn * Eigen::Translation3d(-center_B));
        one.lies = posed.front().lies;
        if (one.score >= least) turned.push_back(one);
      }
    }
    for (const Posed& one : Registered(std::move(turned))) posed.push_back(one);
    const std::size_t all = posed.size();
    posed = Best(std::move(posed), all, object_->object->symmetry, kSame_m, kSame_rad);
  }

  /// What the pose may be instead: moved along and turned about the principal axes by as much as
  /// makes another pose. A hidden end leaves open how far a body reaches.
  std::vector<Posed> Moved(const Posed& posed) const {
    std::vector<Posed> all;
    const Eigen::Vector3d& center_B = object_->object->symmetry.center_B;
    for (int axis = 0; axis < 6; ++axis) {
      for (const double sign : {1.0, -1.0}) {
        const Eigen::Vector3d along_B = object_->axes_B.col(axis % 3);
        core::Pose move = core::Pose::Identity();
        if (axis < 3) {
          move.translation() = sign * 1.01 * kDiffers_m * along_B;
        } else {
          move = Eigen::Translation3d(center_B) *
                 Eigen::AngleAxisd(sign * 1.01 * kDiffers_rad, along_B) *
                 Eigen::Translation3d(-center_B);
        }
        const core::Pose X_CB = posed.X_CB * move;
        all.push_back({X_CB, FineScore(X_CB), posed.lies});
      }
    }
    return all;
  }

  /// Poses that are about as good as the best are refined too, and the tightest of them goes first.
  void Settle(std::vector<Posed>& posed) const {
    if (posed.empty()) return;
    const double least = posed.front().score - kNear;
    posed.front() = Refined(posed.front());
    double tightest = Tight(posed.front().X_CB);
    for (std::size_t i = 1; i < posed.size(); ++i) {
      if (posed[i].score < least) continue;
      posed[i] = Refined(posed[i]);
      const double tight = Tight(posed[i].X_CB);
      if (tight <= tightest) continue;
      tightest = tight;
      std::swap(posed.front(), posed[i]);
    }
  }

 private:
  /// Climbs the score by small moves along and about the axes of the table.
  Posed Refined(Posed posed) const {
    double step_m = kStep_m;
    double step_rad = kStep_rad;
    for (int k = 0; k < kHalvings; ++k, step_m /= 2.0, step_rad /= 2.0) {
      for (int axis = 0; axis < 6; ++axis) {
        for (const double sign : {1.0, -1.0}) Climb(axis, sign * step_m, sign * step_rad, posed);
      }
    }
    return posed;
  }

  Posed Coarse(const core::Pose& X_CB) const {
    const auto evidence =
        internal::Weigh(*object_, X_CB, segment_->coarse, options_->coarse_tolerance_m);
    return {X_CB, Penalised(evidence, X_CB, options_->coarse_tolerance_m)};
  }
  double Tight(const core::Pose& X_CB) const {
    return Penalised(internal::Weigh(*object_, X_CB, segment_->fine, 0.5 * options_->tolerance_m),
                     X_CB, options_->max_sunk_m);
  }
  double FineScore(const core::Pose& X_CB) const {
    return Penalised(internal::Weigh(*object_, X_CB, segment_->fine, options_->tolerance_m), X_CB,
                     options_->max_sunk_m);
  }
  double Penalised(const Evidence& evidence, const core::Pose& X_CB, double max_sunk_m) const {
    if (Sunk(*object_, X_CB, *segment_) > max_sunk_m) return 0.0;
    return evidence.Score(*options_);
  }

  /// The source, and on the table what the object stands on: a round one would roll into the table
  /// for what is seen of it.
  geometry::Points WithContact(const core::Pose& X_CB) const {
    geometry::Points points = segment_->source_C;
    const core::Pose X_TB = segment_->X_TC * X_CB;
    const geometry::Points& surface = object_->object->surface_B.points;
    geometry::Points contact_C;
    for (const Eigen::Vector3d& p : surface) {
      Eigen::Vector3d on_table = X_TB * p;
      if (on_table.z() > kContact_m) continue;
      on_table.z() = 0.0;
      contact_C.push_back(segment_->X_TC.inverse() * on_table);
    }
    const std::size_t step = 1 + contact_C.size() / kMaxContact;
    for (std::size_t i = 0; i < contact_C.size(); i += step) points.push_back(contact_C[i]);
    return points;
  }

  core::Pose Lifted(const core::Pose& X_CB, double by_m) const {
    const Eigen::Vector3d up_C = segment_->X_TC.linear().transpose() * Eigen::Vector3d::UnitZ();
    return Eigen::Translation3d(by_m * up_C) * X_CB;
  }

  core::Pose Registered(const core::Pose& X_CB, const pcl_bridge::Cloud& source) const {
    core::Pose X_BC = X_CB.inverse();
    for (std::size_t k = 0; k < std::size(kPairs_m); ++k) {
      pcl_bridge::RegistrationOptions options;
      options.max_pair_distance_m = kPairs_m[k];
      options.max_iterations = kIterations[k];
      options.min_step_m = 5e-5;
      options.min_step_rad = 5e-4;
      X_BC = pcl_bridge::RegisterPointToPlane(source, object_->target, X_BC, options).X_TS;
    }
    return X_BC.inverse();
  }

  void Climb(int axis, double step_m, double step_rad, Posed& posed) const {
    const Eigen::Vector3d along =
        segment_->X_TC.linear().transpose() * Eigen::Vector3d::Unit(axis % 3);
    const Eigen::Vector3d center = posed.X_CB * object_->object->symmetry.center_B;
    core::Pose move = core::Pose::Identity();
    if (axis < 3) {
      move.translation() = step_m * along;
    } else {
      move = Eigen::Translation3d(center) * Eigen::AngleAxisd(step_rad, along) *
             Eigen::Translation3d(-center);
    }
    const core::Pose moved = move * posed.X_CB;
    const double score = FineScore(moved);
    if (score > posed.score) posed = {moved, score, posed.lies};
  }

  const PreparedObject* object_;
  const Segment* segment_;
  const pcl_bridge::Cloud* source_;
  const RecognitionOptions* options_;
};

FoundObject Told(const PreparedObject& object, const Posed& posed, const Segment& segment,
                 const perception::Scene& scene, const RecognitionOptions& options) {
  geometry::Indices explained;
  const Evidence evidence =
      internal::Weigh(object, posed.X_CB, segment.rays, options.tolerance_m, &explained);
  FoundObject found;
  found.object = object.object->name;
  found.X_CB = posed.X_CB;
  found.score = posed.score;
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
    core::Rng rng(core::DeriveSeed(seed, object->object->name));
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
  const core::Pose X_BC = found.X_CB.inverse();
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
         found.hugging <= options.max_hugging && found.share_seen >= options.min_share_seen;
}

/// The object that a segment is; nullopt where none is good enough, or two are about as good.
std::optional<FoundObject> Identify(const geometry::Observation& observation,
                                    const perception::Scene& scene, const geometry::Indices& own,
                                    const Library& library, const RecognitionOptions& options,
                                    core::Rng& rng) {
  const std::uint64_t seed = rng.Next();
  const Segment segment = SegmentOf(observation, scene, own, options);
  const pcl_bridge::Cloud source(segment.source_C);
  const auto candidates = CandidatesAt(segment, source, library, options, seed);
  if (candidates.empty() || candidates.front().Score() < options.min_score) return std::nullopt;
  const Candidate& best = candidates.front();
  FoundObject found = Told(best.match.object(), best.posed.front(), segment, scene, options);
  std::vector<Posed> others(best.posed);
  std::ranges::copy(best.match.Moved(best.posed.front()), std::back_inserter(others));
  for (const Posed& other : others) {
    const PoseDifference off =
        Difference(other.X_CB, found.X_CB, best.match.object().object->symmetry);
    const bool differs = off.distance_m > kDiffers_m || off.angle_rad > kDiffers_rad;
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
  const core::Pose X_BC = found.X_CB.inverse();
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
      options.tolerance_m);
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
                                     const RecognitionOptions& options, core::Rng& rng) {
  std::vector<FoundObject> all;
  for (const std::size_t i : which) {
    const geometry::Indices& own = scene.objects[i].points;
    core::Rng of_object(rng.Next());
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
                                   const RecognitionOptions& options, core::Rng& rng,
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
