#include "recognition/recognize.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

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

/// A pose with what the rays say of it.
struct Posed {
  core::Pose X_CB;
  double score = 0.0;
};

core::Pose TableFrame(const geometry::Plane& plane) {
  const Eigen::Matrix3d R =
      Eigen::Quaterniond::FromTwoVectors(plane.normal, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return core::MakePose(R, Eigen::Vector3d(0.0, 0.0, plane.Distance(Eigen::Vector3d::Zero())));
}

Segment SegmentOf(const geometry::Observation& observation, const perception::Scene& scene,
                  const geometry::Indices& own, const RecognitionOptions& options) {
  Segment segment;
  segment.cloud_C = {geometry::Select(scene.cloud.points, own),
                     geometry::Select(scene.cloud.normals, own)};
  segment.rays = internal::RaysAbout(observation, scene, own, options.beside_m);
  segment.coarse = internal::Fewer(segment.rays, options.coarse_rays);
  segment.fine = internal::Fewer(segment.rays, options.fine_rays);
  segment.X_TC = TableFrame(scene.table.plane);
  std::vector<std::size_t> seen(observation.views.size(), 0);
  for (const auto point : own) ++seen[scene.SampleOf(point).view];
  const auto most = std::ranges::max_element(seen) - seen.begin();
  segment.eye_C = observation.views[static_cast<std::size_t>(most)].X_CV.translation();
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
      : object_(object), segment_(segment), source_(source), options_(options) {}

  /// The best poses, registered, the best first.
  std::vector<Posed> Run(core::Rng& rng) const {
    const Symmetry& symmetry = object_.object->symmetry;
    std::vector<Posed> posed;
    for (const auto& X_CB : internal::LyingPoses(object_, segment_)) posed.push_back(Coarse(X_CB));
    const auto voted =
        internal::VotedPoses(object_, segment_, static_cast<std::size_t>(options_.references), rng);
    for (const auto& X_CB : voted) posed.push_back(Coarse(X_CB));
    posed = Best(std::move(posed), static_cast<std::size_t>(options_.registered), symmetry,
                 kSameCoarse_m, kSameCoarse_rad);
    for (Posed& one : posed) {
      one.X_CB = Registered(one.X_CB);
      one.score = FineScore(one.X_CB);
    }
    return Best(std::move(posed), posed.size(), symmetry, kSame_m, kSame_rad);
  }

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

 private:
  Posed Coarse(const core::Pose& X_CB) const {
    return {X_CB,
            Penalised(internal::Weigh(object_, X_CB, segment_.coarse, options_.coarse_tolerance_m),
                      X_CB, options_.coarse_tolerance_m)};
  }
  double FineScore(const core::Pose& X_CB) const {
    return Penalised(internal::Weigh(object_, X_CB, segment_.fine, options_.tolerance_m), X_CB,
                     options_.max_sunk_m);
  }
  double Penalised(const Evidence& evidence, const core::Pose& X_CB, double max_sunk_m) const {
    if (Sunk(object_, X_CB, segment_) > max_sunk_m) return 0.0;
    return evidence.Score(options_.unexplained_weight);
  }

  core::Pose Registered(const core::Pose& X_CB) const {
    core::Pose X_BC = X_CB.inverse();
    for (std::size_t k = 0; k < std::size(kPairs_m); ++k) {
      pcl_bridge::RegistrationOptions options;
      options.max_pair_distance_m = kPairs_m[k];
      options.max_iterations = kIterations[k];
      options.min_step_m = 5e-5;
      options.min_step_rad = 5e-4;
      X_BC = pcl_bridge::RegisterPointToPlane(source_, object_.target, X_BC, options).X_TS;
    }
    return X_BC.inverse();
  }

  void Climb(int axis, double step_m, double step_rad, Posed& posed) const {
    const Eigen::Vector3d along =
        segment_.X_TC.linear().transpose() * Eigen::Vector3d::Unit(axis % 3);
    const Eigen::Vector3d center = posed.X_CB * object_.object->symmetry.center_B;
    core::Pose move = core::Pose::Identity();
    if (axis < 3) {
      move.translation() = step_m * along;
    } else {
      move = Eigen::Translation3d(center) * Eigen::AngleAxisd(step_rad, along) *
             Eigen::Translation3d(-center);
    }
    const core::Pose moved = move * posed.X_CB;
    const double score = FineScore(moved);
    if (score > posed.score) posed = {moved, score};
  }

  const PreparedObject& object_;
  const Segment& segment_;
  const pcl_bridge::Cloud& source_;
  const RecognitionOptions& options_;
};

/// The thinned points of a segment, as many as registration wants.
geometry::Points SourceOf(const Segment& segment, std::size_t count) {
  const auto& points = segment.cloud_C.points;
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  geometry::Points source;
  for (std::size_t i = 0; i < points.size(); i += step) source.push_back(points[i]);
  return source;
}

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
  found.share_seen = evidence.explained / visible;
  found.violations = evidence.violated / visible;
  found.rms_m = std::sqrt(evidence.squares_m2 / std::max(1.0, evidence.explained));
  for (const auto point : explained) found.samples.push_back(scene.samples[point]);
  return found;
}

/// The object that a segment is; nullopt where none is good enough, or two are about as good.
std::optional<FoundObject> Identify(const geometry::Observation& observation,
                                    const perception::Scene& scene, const geometry::Indices& own,
                                    const Library& library, const RecognitionOptions& options,
                                    core::Rng& rng) {
  if (own.size() < options.min_samples) return std::nullopt;
  const Segment segment = SegmentOf(observation, scene, own, options);
  const pcl_bridge::Cloud source(SourceOf(segment, options.source_points));
  const std::uint64_t seed = rng.Next();
  struct Candidate {
    const PreparedObject* object;
    Posed posed;
  };
  std::vector<Candidate> candidates;
  for (const auto& object : library.prepared().ready) {
    core::Rng of_object(core::DeriveSeed(seed, object->object->name));
    const Match match(*object, segment, source, options);
    const auto posed = match.Run(of_object);
    if (posed.empty() || posed.front().score <= 0.0) continue;
    candidates.push_back({object.get(), posed.front()});
  }
  const auto better = [](const Candidate& a, const Candidate& b) {
    if (a.posed.score != b.posed.score) return a.posed.score > b.posed.score;
    return a.object->object->name < b.object->object->name;
  };
  std::ranges::sort(candidates, better);
  constexpr std::size_t kRefined = 3;
  if (candidates.size() > kRefined)
    candidates.erase(candidates.begin() + kRefined, candidates.end());
  for (Candidate& one : candidates) {
    one.posed = Match(*one.object, segment, source, options).Refined(one.posed);
  }
  std::ranges::sort(candidates, better);
  if (candidates.empty() || candidates.front().posed.score < options.min_score) return std::nullopt;
  if (candidates.size() > 1 &&
      candidates[0].posed.score - candidates[1].posed.score < options.margin) {
    return std::nullopt;
  }
  FoundObject found =
      Told(*candidates.front().object, candidates.front().posed, segment, scene, options);
  if (found.samples.size() < options.min_samples) return std::nullopt;
  return found;
}

}  // namespace

std::vector<FoundObject> Recognize(const geometry::Observation& observation,
                                   const perception::Scene& scene, const Library& library,
                                   const RecognitionOptions& options, core::Rng& rng) {
  std::vector<FoundObject> all;
  for (const auto& object : scene.objects) {
    auto found = Identify(observation, scene, object.points, library, options, rng);
    if (found) all.push_back(std::move(*found));
  }
  std::ranges::stable_sort(all, std::greater{}, &FoundObject::score);
  return all;
}

}  // namespace rangegrasp::recognition
