#pragma once

#include "grasp/grasp.h"
#include "grasp/internal/closing.h"
#include "grasp/surface.h"
#include "robot/collision/collider.h"

namespace rangegrasp::grasp::internal {

using collision::HandCollider;
using perception::PerceivedObject;
using perception::Scene;

/// score = 1 - antipodal A - pitch P - lever L - height H - drag D - slope S - shallow M - room R
///         + tight T + arm C, with
///   A = (larger of both antipodal angles / friction cone)^2, at most 4,
///   P = ((pitch - best pitch) / scale)^2, at most 4,      L = (lever / scale)^2, at most 4,
///   H = (height of the contacts above the centre of mass / scale)^2, at most 2,
///   D, S = |drag|, |slope| / scale, at most 2,
///   M = how much the contacts miss of the margin below the top, 0 to 2,
///   R = (how much room misses of its scale)^2, 0 to 1,
///   T = contact area / scale, at most 1,                  C = thumb_to_arm.
/// The scales and the bounds 4 and 2 stand in ScoreWeights.
double Score(const Quality& quality, double friction_cone_rad, const ScoreWeights& weights);

/// Data for all candidates of one object. C is the cloud's frame.
struct Task {
  const Scene& scene;
  const PerceivedObject& object;
  const HandModel& hand;
  const Arm& arm;
  Vector3d up_C;  ///< the table's normal
  const GraspOptions& options;
  SurfaceSamples samples;   ///< dense, for contacts
  geometry::Points coarse;  ///< a part of them, for extents and the descent
  Vector3d com_C;
  HandProfiles profiles;

  double MaxWidth() const { return hand.MaxGap() - 2.0 * options.object_clearance_m; }
};

/// The object in a frame A with the axes of G: z the approach, x the closing direction.
struct View {
  Pose X_CA;
  geometry::Points coarse;
  Vector3d com;
  Vector3d up;            ///< the table's normal
  double table_offset_m;  ///< up . p + offset = height above the table
  double top_m;           ///< smallest z of the object: its highest point along the approach
  double bottom_m;
  double y_min_m, y_max_m;
  double thumb_to_arm;  ///< cosine
};
/// @param closing_C  must not be parallel to the approach, but need not be normal to it
View MakeView(const Task& task, geometry::PointSpan coarse_C, const Vector3d& origin_C,
              const Vector3d& approach_C, const Vector3d& closing_C);

/// The dense samples that pads at y0 may touch, in A.
struct Band {
  double y_m = 0.0;
  geometry::Points points;
  geometry::Points normals;
};
Band MakeBand(const Task& task, const View& view, double y0_m);

/// The extent of the object along x in the part that the hand passes: |y - y0| <= half_band and at
/// most reach below the top of that part.
struct Slab {
  double x_min_m = 0.0;
  double x_max_m = 0.0;
  double top_m = 0.0;
  double Width() const { return x_max_m - x_min_m; }
  double Middle() const { return 0.5 * (x_min_m + x_max_m); }
};
std::optional<Slab> SlabAt(const View& view, double y0_m, double half_band_m, double reach_m);

/// The largest depth of T's origin along the approach at (x, y) at which the hand, coming straight
/// down, is still clearance_m above the object.
double DescentLimit(const View& view, const HandProfiles::Lower& lower, double x_m, double y_m,
                    double clearance_m);
/// How far the hand reaches below T's origin, towards the table, in any state from `open` to
/// `closed`: fingers and thumb swing down while they close.
double ReachDown(Task& task, const View& view, double pitch_rad, std::size_t open,
                 std::size_t closed);
/// The largest depth of T's origin along the approach at (x, y) at which a hand that reaches
/// reach_m below it is still clearance_m above the table.
double TableLimit(const View& view, double reach_m, double x_m, double y_m, double clearance_m);

/// The smaller of TableLimit and DescentLimit with the options' clearances.
double DepthLimit(const Task& task, const View& view, const HandProfiles::Lower& lower,
                  double reach_m, double x_m, double y_m);

/// A unit vector normal to the axis: along v's part normal to it, or any if v has no such part.
Vector3d NormalPart(const Vector3d& v, const Vector3d& axis);

/// The rotation axis, pointing away from the table; nullopt if it is not upright enough
/// (CylindricalOptions::max_tilt_rad) for an approach along it from above.
std::optional<Vector3d> UprightAxis(const Task& task);

/// States of the hand.
struct Openings {
  std::size_t wide = 0;    ///< before closing
  std::size_t narrow = 0;  ///< the same, tried if the wide opening collides
  std::size_t held = 0;    ///< the state that is expected to hold
};

struct Candidate {
  Grasp grasp;
  Openings states;
  double depth_m = 0.0;     ///< z of the pads' middle in the view
  bool to_contact = false;  ///< comes down until it meets something, at any depth
  int group = 0;            ///< candidates of one group are alike; see ChooseFree
};

inline double ScoreOf(const Candidate& candidate) { return candidate.grasp.score; }

/// The candidate with T at origin_A that closes around center_A; its score must still be set.
Candidate MakeCandidate(const Task& task, const View& view, const Vector3d& origin_A,
                        const Vector3d& center_A, double pitch_rad, const Openings& states,
                        double width_m, GraspType type);

/// The target of a placement.
struct Aim {
  double pitch_rad = 0.0;
  double best_pitch_rad = 0.0;
  double depth_m = 0.0;     ///< wanted z of the pads' middle; the hand stops earlier if it must
  double back_off_m = 0.0;  ///< and then goes back up by this
  /// The object's width, if it is known from more than the part that the hand passes (a diameter).
  std::optional<double> width_m{};
  /// If the object is too wide for the hand further down, an upper part that fits is gripped.
  bool upper_part = false;
};

/// The depth of a hand that comes down until it meets the object or the table.
constexpr double kToContact_m = kInfinity;

/// Places the hand so that its pads close on the object in the band at the aim, midway between the
/// contacts; nullopt if it does not fit or if one side meets nothing. Without centering, the tool
/// centre is placed at x = 0 and the band's y instead, whatever the hand meets there.
std::optional<Candidate> Place(Task& task, const View& view, const Band& band, const Aim& aim,
                               GraspType type);
/// Place at each of the depths, starting with the first. If the hand had to stop above the first of
/// them, it is also placed a little higher (PlacingOptions::back_offs_m).
void PlaceAtDepths(Task& task, const View& view, const Band& band, Aim aim,
                   std::span<const double> depths_m, GraspType type, int group,
                   std::vector<Candidate>& candidates);

struct Quota {
  int max_free = 24;     ///< free candidates in all
  int max_of_group = 1;  ///< free candidates of one group
  int max_checks = 120;  ///< candidates checked
};

/// The first of the wide and the narrow opening that clears obstacles and the object itself.
std::optional<std::size_t> FreeOpening(const HandCollider& collider, const Pose& X_CH,
                                       const Openings& openings);
/// Whether the hand hits the table in a state from the wide opening to just beyond the held one.
bool HitsTableClosing(const HandCollider& collider, const HandModel& hand, const Pose& X_CH,
                      const Openings& openings);

struct Collected {
  std::vector<Grasp> free;         ///< by type, in the order of section 5.2
  std::vector<Grasp> unreachable;  ///< free, but out of the arm's reach
  std::vector<Grasp> colliding;
};

/// Checks candidates in the order of their scores and appends them to `out`. Of those that collide,
/// only the best of every group is kept.
void ChooseFree(const HandCollider& collider, const Task& task, std::vector<Candidate> candidates,
                const Quota& quota, Collected& out);

}  // namespace rangegrasp::grasp::internal
