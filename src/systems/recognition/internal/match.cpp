#include "recognition/internal/match.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "base/units.h"
#include "pcl_bridge/registration.h"

namespace rangegrasp::recognition::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::Points;
using recognition::TurnAbout;

/// A segment that exceeds the object's length or height by more cannot be this object alone.
constexpr double kTooLarge_m = 0.015;
/// Minimum difference between guessed poses, modulo symmetry.
constexpr PoseDifference kSameGuess{0.010, 0.2};
/// The extent of a surface is measured on every 8th sample.
constexpr std::size_t kStride = 8;

/// Registered poses this close to a better one are duplicates, modulo symmetry.
constexpr PoseDifference kSame{0.004, 0.05};
constexpr PoseDifference kSameCoarse{0.015, 0.25};
/// Registration begins with pairs up to the error of a guess, for which every third point suffices,
/// and ends with pairs up to the error of the scanner.
constexpr pcl_bridge::RegistrationOptions kFar{
    .max_pair_distance_m = 0.025, .max_iterations = 10, .min_step_m = 3e-4, .min_step_rad = 3e-3};
constexpr pcl_bridge::RegistrationOptions kNearby{
    .max_pair_distance_m = 0.008, .max_iterations = 15, .min_step_m = 5e-5, .min_step_rad = 5e-4};
/// Guesses that are this close after the first registration end in the same pose.
constexpr PoseDifference kMeet{0.002, 0.02};
/// Guesses whose coarse score is this far below the best one's then are given up.
constexpr double kBehind = 0.15;
/// Step sizes of the final refinement, and how often they are halved.
constexpr double kStep_m = 0.0015;
constexpr double kStep_rad = 0.02;
constexpr int kHalvings = 3;
/// A view with this share of a segment's points saw that side of it; of ten views at least one has.
constexpr double kSeenBy = 0.1;
/// Points this near to the table touch it; this many of them suffice.
constexpr double kContact_m = 0.002;
constexpr std::size_t kMaxContact = 80;
/// Poses of one object with scores this close are refined, and distinguished by half the tolerance
/// (which reveals a rim of a millimetre) and by their colors.
constexpr double kNear = 0.12;
/// Steps per full turn about a principal axis, for the poses that a pose is compared with.
constexpr int kTurns = 18;
/// Steps per turn about a round body's axis, in which prints are aligned, then in smaller ones.
constexpr int kRoundTurns = 36;
constexpr double kPrintSteps_rad[] = {base::Deg(8.0), base::Deg(4.0), base::Deg(2.0)};
constexpr std::size_t kFewRays = 600;  ///< used to evaluate prints and small moves
/// Rays that choose among the poses in which an object would lie, and the number of poses chosen.
constexpr std::size_t kRoughRays = 48;
constexpr std::size_t kRoughPoses = 24;

/// The table frame, turned so that x is along the line of sight.
base::Pose AlongSight(const Segment& segment) {
  const Vector3d middle_T = segment.X_TC * geometry::Centroid(segment.cloud_C.points);
  Vector3d sight_T = middle_T - segment.X_TC * segment.eyes_C.front();
  sight_T.z() = 0.0;
  if (sight_T.norm() < 1e-6) sight_T = Vector3d::UnitX();
  const Matrix3d R = base::TurnOnto(sight_T.normalized(), Vector3d::UnitX()).toRotationMatrix();
  return base::MakePose(R, Vector3d::Zero()) * segment.X_TC;
}

bool AreNear(const base::Pose& a, const base::Pose& b, const Symmetry& symmetry,
             const PoseDifference& near) {
  const PoseDifference off = Difference(a, b, symmetry);
  return off.distance_m < near.distance_m && off.angle_rad < near.angle_rad;
}

/// Sorts them, best first, and keeps `count` at most.
void KeepBest(std::size_t count, std::vector<Posed>& posed) {
  std::ranges::stable_sort(posed, std::greater{}, &Posed::score);
  if (posed.size() > count) posed.resize(count);
}

/// The poses, best first, without those near to a better one; `count` at most.
std::vector<Posed> Best(std::vector<Posed> posed, const Symmetry& symmetry,
                        const PoseDifference& same, std::size_t count = SIZE_MAX) {
  std::ranges::stable_sort(posed, std::greater{}, &Posed::score);
  std::vector<Posed> best;
  for (const Posed& one : posed) {
    if (best.size() == count) break;
    const bool known = std::ranges::any_of(
        best, [&](const Posed& other) { return AreNear(one.X_CB, other.X_CB, symmetry, same); });
    if (!known) best.push_back(one);
  }
  return best;
}

/// The poses, best first, without those near to a better one of their kind, lying or not; `count`
/// at most. A lying pose is kept even if pairs voted for a better one nearby: it is registered
/// together with its contact points, while the other may roll or slide away.
std::vector<Posed> BestOfBoth(std::vector<Posed> posed, const Symmetry& symmetry,
                              const PoseDifference& same, std::size_t count = SIZE_MAX) {
  const auto others = std::ranges::stable_partition(
      posed, [](const Posed& one) { return one.lying_CB.has_value(); });
  auto best = Best({posed.begin(), others.begin()}, symmetry, same, count);
  std::ranges::copy(Best({others.begin(), posed.end()}, symmetry, same, count),
                    std::back_inserter(best));
  KeepBest(count, best);
  return best;
}

/// Poses in which the object would lie on the table at the segment: along and across the line of
/// sight, the middle of the segment is that of the part of the object that would be visible.
std::vector<base::Pose> LyingPoses(const PreparedObject& object, const Segment& segment) {
  const base::Pose X_SC = AlongSight(segment);
  Eigen::AlignedBox3d seen;
  for (const Vector3d& p : segment.cloud_C.points) seen.extend(X_SC * p);
  Points to_eyes;
  for (const Vector3d& eye_C : segment.eyes_C) {
    to_eyes.push_back((X_SC * eye_C - seen.center()).normalized());
  }
  Vector3d of_segment = seen.sizes();
  of_segment.z() = seen.max().z();
  const auto fits = [&](const Vector3d& size) {
    return ((of_segment - size).array() <= kTooLarge_m).all();
  };
  const geometry::PointCloud& surface = object.object.surface_B;
  std::vector<base::Pose> poses;
  for (const Matrix3d& way : object.lying) {
    Eigen::AlignedBox3d all;
    for (const Vector3d& corner : object.hull_B) all.extend(way * corner);
    if (!fits(all.sizes())) continue;
    Points to_eyes_B;
    for (const Vector3d& e : to_eyes) to_eyes_B.push_back(way.transpose() * e);
    Eigen::AlignedBox3d visible;
    for (std::size_t i = 0; i < surface.size(); i += kStride) {
      const Vector3d& normal = surface.normals[i];
      const bool faces =
          std::ranges::any_of(to_eyes_B, [&](const Vector3d& e) { return normal.dot(e) > 0.1; });
      if (faces) visible.extend(way * surface.points[i]);
    }
    const double lowest = all.min().z();
    Vector3d size = visible.sizes();
    size.z() = visible.max().z() - lowest;
    if (!fits(size)) continue;
    Vector3d shift = seen.center() - visible.center();
    shift.z() = -lowest;
    poses.push_back(X_SC.inverse() * base::MakePose(way, shift));
  }
  return poses;
}

/// Poses that pairs of the segment's points vote for, most votes first.
std::vector<Posed> VotedPoses(const PreparedObject& object, const Segment& segment) {
  std::vector<Posed> voted;
  for (const PointPairs& reference : segment.references) object.pairs.Vote(reference, voted);
  return Best(std::move(voted), object.object.symmetry, kSameGuess);
}

/// Depth of the lowest corner of its hull below the table.
double Sunk(const PreparedObject& object, const base::Pose& X_CB, const Segment& segment) {
  const base::Pose X_TB = segment.X_TC * X_CB;
  const Eigen::RowVector3d up_B = X_TB.linear().row(2);
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vector3d& corner : object.hull_B) lowest = std::min(lowest, up_B.dot(corner));
  return -lowest - X_TB.translation().z();
}

/// The points at 0, step, 2 step, ...
Points Every(std::size_t step, const Points& points) {
  Points some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return some;
}

base::Pose TurnAbout(double angle_rad, const Vector3d& axis_B, const Vector3d& about_B) {
  return TurnAbout(Eigen::AngleAxisd(angle_rad, axis_B).toRotationMatrix(), about_B);
}

/// The middle of the hull's extents along the principal axes.
Vector3d MiddleOfExtents(const PreparedObject& object) {
  Eigen::AlignedBox3d extents;
  for (const Vector3d& corner : object.hull_B) {
    extents.extend(object.axes_B.transpose() * corner);
  }
  return object.axes_B * extents.center();
}

/// The pose turned about the principal axes and the axis of revolution, and upside down.
std::vector<base::Pose> Turned(const PreparedObject& object, const base::Pose& X_CB) {
  const Symmetry& symmetry = object.object.symmetry;
  std::vector<base::Pose> turned;
  const auto add = [&](double angle_rad, const Vector3d& axis_B, const Vector3d& about_B) {
    turned.push_back(X_CB * TurnAbout(angle_rad, axis_B, about_B));
  };
  // Upside down it has the same extent as before; its center of mass need not be in the middle.
  const Vector3d middle_B = MiddleOfExtents(object);
  if (symmetry.axis_B) {
    if (symmetry.rotations.size() == 1) {
      add(base::kPi, symmetry.axis_B->unitOrthogonal(), middle_B);
    }
    return turned;
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d axis_B = object.axes_B.col(axis);
    for (int k = 1; k < kTurns; ++k) {
      add(2.0 * base::kPi * k / kTurns, axis_B, symmetry.center_B);
    }
    add(base::kPi, axis_B, middle_B);
  }
  if (object.round) {
    const auto& [point_B, direction_B] = *object.round;
    for (int k = 1; k < kRoundTurns; ++k) {
      add(2.0 * base::kPi * k / kRoundTurns, direction_B, point_B);
    }
  }
  return turned;
}

/// The segment's source and contact points, without which a round object rolls into the table.
Points WithContact(const PreparedObject& object, const Segment& segment, const base::Pose& X_CB) {
  const base::Pose X_TB = segment.X_TC * X_CB;
  Points contact_C;
  for (const Vector3d& p : object.object.surface_B.points) {
    Vector3d on_table = X_TB * p;
    if (on_table.z() > kContact_m) continue;
    on_table.z() = 0.0;
    contact_C.push_back(segment.X_TC.inverse() * on_table);
  }
  Points points = segment.source_C;
  std::ranges::copy(Every(1 + contact_C.size() / kMaxContact, contact_C),
                    std::back_inserter(points));
  return points;
}

base::Pose RegisteredPose(const PreparedObject& object, const base::Pose& X_CB,
                          const Points& source_C, const pcl_bridge::RegistrationOptions& options) {
  return pcl_bridge::RegisterPointToPlane(source_C, object.target, X_CB.inverse(), options)
      .inverse();
}

}  // namespace

bool AreDistinct(const base::Pose& a, const base::Pose& b, const Symmetry& symmetry) {
  return !AreNear(a, b, symmetry, kDiffers);
}

Segment SegmentOf(const geometry::Observation& observation, const perception::Scene& scene,
                  const geometry::Indices& own, const RecognitionOptions& options) {
  Segment segment;
  segment.cloud_C = {geometry::Select(scene.cloud.points, own),
                     geometry::Select(scene.cloud.normals, own)};
  segment.source_C =
      Every(std::max<std::size_t>(1, own.size() / options.source_points), segment.cloud_C.points);
  segment.rays = RaysAbout(observation, scene, own, options.beside_m);
  segment.rough = Fewer(segment.rays, kRoughRays);
  segment.coarse = Fewer(segment.rays, options.coarse_rays);
  segment.fine = Fewer(segment.rays, options.fine_rays);
  segment.few = Fewer(segment.rays, kFewRays);
  segment.colored = std::ranges::any_of(
      segment.few, [](const SampleRay& ray) { return !std::isnan(ray.tone.x()); });
  segment.references = ReferencesOf(segment.cloud_C, options.references);
  const geometry::Plane& table = scene.table.plane;
  segment.X_TC = base::MakePose(base::TurnOnto(table.normal, Vector3d::UnitZ()).toRotationMatrix(),
                                Vector3d(0.0, 0.0, table.Distance(Vector3d::Zero())));
  std::vector<std::size_t> seen(observation.views.size(), 0);
  for (const auto point : own) ++seen[scene.SampleOf(point).view];
  for (std::size_t view = 0; view < seen.size(); ++view) {
    if (static_cast<double>(seen[view]) < kSeenBy * static_cast<double>(own.size())) continue;
    segment.eyes_C.push_back(observation.views[view].X_CV.translation());
  }
  return segment;
}

Match::Match(const PreparedObject& object, const Segment& segment,
             const RecognitionOptions& options)
    : object_(&object), segment_(&segment), options_(&options) {
  std::vector<Posed> guesses;
  for (const auto& X_CB : LyingPoses(object, segment)) {
    guesses.push_back({X_CB, CoarseScore(segment.rough, X_CB), X_CB});
  }
  KeepBest(kRoughPoses, guesses);
  std::ranges::copy(VotedPoses(object, segment), std::back_inserter(guesses));
  for (Posed& one : guesses) one.score = CoarseScore(segment.coarse, one.X_CB);
  const auto count = static_cast<std::size_t>(options.registered);
  posed_ = BestOfBoth(std::move(guesses), object.object.symmetry, kSameCoarse, count);
}

std::vector<Posed> Match::Registered(std::vector<Posed> posed) const {
  const Vector3d up_C = segment_->X_TC.linear().transpose() * Vector3d::UnitZ();
  const auto source_of = [this](const Posed& one) {
    return one.lying_CB ? WithContact(*object_, *segment_, *one.lying_CB) : segment_->source_C;
  };
  for (Posed& one : posed) {
    one.X_CB = RegisteredPose(*object_, one.X_CB, Every(3, source_of(one)), kFar);
    one.score = CoarseScore(segment_->coarse, one.X_CB);
  }
  posed = BestOfBoth(std::move(posed), object_->object.symmetry, kMeet);
  const double least = posed.empty() ? 0.0 : posed.front().score - kBehind;
  std::erase_if(posed, [least](const Posed& one) { return one.score < least; });
  for (Posed& one : posed) {
    one.X_CB = RegisteredPose(*object_, one.X_CB, source_of(one), kNearby);
    const double sunk_m = std::max(0.0, Sunk(*object_, one.X_CB, *segment_));
    one.X_CB = Eigen::Translation3d(sunk_m * up_C) * one.X_CB;
    one.score = ShapeScore(one.X_CB);
  }
  return Best(std::move(posed), object_->object.symmetry, kSame);
}

void Match::AddTurned() {
  const Posed& front = posed_.front();
  const double least = CoarseScore(segment_->coarse, front.X_CB) - options_->hopeless;
  std::vector<Posed> turned;
  for (const base::Pose& X_CB : Turned(*object_, front.X_CB)) {
    Posed one{X_CB, CoarseScore(segment_->coarse, X_CB)};
    if (front.lying_CB) one.lying_CB = X_CB;
    if (one.score >= least) turned.push_back(one);
  }
  std::ranges::copy(Registered(std::move(turned)), std::back_inserter(posed_));
  posed_ = Best(std::move(posed_), object_->object.symmetry, kSame);
}

std::vector<Posed> Match::Moved() const {
  const Posed& best = posed_.front();
  std::vector<Posed> moved;
  for (int axis = 0; axis < 6; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d along_B = object_->axes_B.col(axis % 3);
      const base::Pose move =
          axis < 3 ? base::Pose(Eigen::Translation3d(sign * 1.01 * kDiffers.distance_m * along_B))
                   : TurnAbout(sign * 1.01 * kDiffers.angle_rad, along_B,
                               object_->object.symmetry.center_B);
      const base::Pose X_CB = best.X_CB * move;
      moved.push_back({X_CB, Fine(X_CB).Score(*options_)});
    }
  }
  return moved;
}

/// The pose turned so that the colors agree best: by the rotations that map the shape onto itself,
/// and by a few degrees about the principal axes, since nearly round bodies were guessed in steps.
base::Pose Match::Aimed(const base::Pose& X_CB) const {
  const Symmetry& symmetry = object_->object.symmetry;
  Posed best{X_CB, -1.0};
  const auto consider = [&](const base::Pose& pose, Posed& so_far) {
    if (Sunk(*object_, pose, *segment_) > options_->max_sunk_m) return;
    const double score =
        Weigh(*object_, pose, segment_->few, options_->tolerance_m, options_->color_tolerance)
            .Score(*options_);
    if (score > so_far.score) so_far = {pose, score};
  };
  const int turns = symmetry.axis_B ? kRoundTurns : 1;
  for (const Matrix3d& rotation : symmetry.rotations) {
    for (int k = 0; k < turns; ++k) {
      const Eigen::AngleAxisd about(2.0 * base::kPi * k / turns,
                                    symmetry.axis_B.value_or(Vector3d::UnitZ()));
      consider(X_CB * TurnAbout(rotation * about.toRotationMatrix(), symmetry.center_B), best);
    }
  }
  for (const double step_rad : kPrintSteps_rad) {
    Posed next = best;
    for (const double angle : {-step_rad, step_rad}) {
      for (int axis = 0; axis < 3; ++axis) {
        consider(best.X_CB * TurnAbout(angle, object_->axes_B.col(axis), symmetry.center_B), next);
      }
      if (!object_->round) continue;
      const auto& [point_B, direction_B] = *object_->round;
      consider(best.X_CB * TurnAbout(angle, direction_B, point_B), next);
    }
    best = next;
  }
  return best.X_CB;
}

void Match::Aim() {
  const double least = posed_.front().score - kNear;
  for (Posed& one : posed_) {
    if (one.score >= least) one.X_CB = Aimed(one.X_CB);
    one.score = Fine(one.X_CB).Score(*options_);
  }
  std::ranges::stable_sort(posed_, std::greater{}, &Posed::score);
}

void Match::Settle() {
  if (segment_->colored && object_->has_tones()) Aim();
  const double least = posed_.front().score - kNear;
  posed_.front() = Refined(posed_.front());
  const auto tight_score = [this](const Posed& one) {
    return Fine(one.X_CB, 0.5).Score(*options_);
  };
  double tightest = tight_score(posed_.front());
  for (std::size_t i = 1; i < posed_.size(); ++i) {
    if (posed_[i].score < least) continue;
    posed_[i] = Refined(posed_[i]);
    const double tight = tight_score(posed_[i]);
    if (tight <= tightest) continue;
    tightest = tight;
    std::swap(posed_.front(), posed_[i]);
  }
}

/// Hill climbing of the shape's score by small moves along and about the table's axes. Colors are
/// not used, since they are seen slightly displaced.
Posed Match::Refined(Posed posed) const {
  double step_m = kStep_m;
  double step_rad = kStep_rad;
  posed.score = FewScore(posed.X_CB);
  for (int k = 0; k < kHalvings; ++k, step_m /= 2.0, step_rad /= 2.0) {
    for (int axis = 0; axis < 6; ++axis) {
      for (const double sign : {1.0, -1.0}) Climb(axis, sign * step_m, sign * step_rad, posed);
    }
  }
  posed.score = Fine(posed.X_CB).Score(*options_);
  return posed;
}

Evidence Match::WeighAbove(double max_sunk_m, const base::Pose& X_CB, const SampleRays& rays,
                           double tolerance_m) const {
  if (Sunk(*object_, X_CB, *segment_) > max_sunk_m) return {};
  return Weigh(*object_, X_CB, rays, tolerance_m, options_->color_tolerance);
}

/// Without colors, since prints are displaced in a pose of this accuracy.
double Match::CoarseScore(const SampleRays& rays, const base::Pose& X_CB) const {
  const double tolerance_m = options_->coarse_tolerance_m;
  return WeighAbove(tolerance_m, X_CB, rays, tolerance_m).ShapeScore(*options_);
}

Evidence Match::Fine(const base::Pose& X_CB, double tolerance_share) const {
  return WeighAbove(options_->max_sunk_m, X_CB, segment_->fine,
                    tolerance_share * options_->tolerance_m);
}

double Match::ShapeScore(const base::Pose& X_CB) const { return Fine(X_CB).ShapeScore(*options_); }

double Match::FewScore(const base::Pose& X_CB) const {
  return WeighAbove(options_->max_sunk_m, X_CB, segment_->few, options_->tolerance_m)
      .ShapeScore(*options_);
}

void Match::Climb(int axis, double step_m, double step_rad, Posed& posed) const {
  const Vector3d along = segment_->X_TC.linear().transpose() * Vector3d::Unit(axis % 3);
  const Vector3d center = posed.X_CB * object_->object.symmetry.center_B;
  const base::Pose move = axis < 3
                              ? base::Pose(Eigen::Translation3d(step_m * along))
                              : Eigen::Translation3d(center) * Eigen::AngleAxisd(step_rad, along) *
                                    Eigen::Translation3d(-center);
  const base::Pose moved = move * posed.X_CB;
  const double score = FewScore(moved);
  if (score > posed.score) posed = {moved, score};
}

}  // namespace rangegrasp::recognition::internal
