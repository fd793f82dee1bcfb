#pragma once

#include <array>
#include <string_view>

#include "base/units.h"
#include "base/words.h"

/// Lengths are for a hand of a person's size and objects that it can hold; where no source is
/// given, the comment says what a value trades off.
namespace rangegrasp::grasp {

/// Weights and scales of Score(). A weight is what the worst counts against the best, 1; the
/// antipodal angles weigh most: a grip beyond the friction cone slips whatever else is right.
struct ScoreWeights {
  double antipodal = 1.0;
  double pitch = 0.4;
  double lever = 0.5;
  double height = 0.25;
  double drag = 0.2;
  double slope = 0.1;
  double shallow = 0.5;
  double tight = 0.3;
  double room = 0.2;
  double arm = 0.1;

  double pitch_scale_rad = 0.1745;  ///< 10 deg
  double lever_scale_m = 0.020;     ///< the pads are about 20 mm wide
  double above_scale_m = 0.030;
  double below_scale_m = 0.050;  ///< gripped below its middle an object tips less readily
  double drag_scale_m = 0.016;   ///< what the coupled hand was seen to drag and still hold
  double slope_scale_m = 0.020;
  double margin_m = 0.012;         ///< contacts this far below the top are deep enough
  double contact_scale_m2 = 4e-4;  ///< two pads of 10 x 20 mm
  double room_scale_m = 0.015;

  /// Squares and multiples of their scales count at most this: no term outweighs all others.
  double max_square = 4.0;
  double max_multiple = 2.0;
};

/// How the hand is placed on an object from one direction.
struct PlacingOptions {
  /// Half width of the strip that the pads may meet: the SensorHand's outer pads, of 8 mm radius,
  /// are 16 mm apart.
  double contact_band_m = 0.022;
  double hand_band_m = 0.018;   ///< half width that fingers and thumb lie in: of the extent across
  double max_reach_m = 0.15;    ///< below the object's top; deeper samples are no contacts
  double swing_m = 0.020;       ///< deeper than the hand: the thumb swings down as it closes
  double upper_step_m = 0.010;  ///< in which an upper part that fits into the hand is sought
  double opening_m = 0.020;     ///< wider than the object, before closing: seen surfaces are noisy
  double narrow_opening_m = 0.008;  ///< where neighbors leave no more
  double min_depth_m = 0.010;       ///< of the pads' middle below the top; higher ones slip off
  int rounds = 3;  ///< of moving the hand to midway between the contacts that closing found
  double centered_m = 0.001;    ///< half of the samples' spacing
  double same_depth_m = 0.003;  ///< placings no further apart stopped at the same thing
  /// Tried this much higher where the hand had to stop: the thumb's first segment touches a wide
  /// object's edge before its tip touches the side.
  std::array<double, 3> back_offs_m{0.006, 0.012, 0.018};
  std::array<double, 3> lifts_m{0.0, 0.002, 0.004};  ///< where it grazes: fields are sampled
  /// A hand that comes down to contact goes up by these until it is free (section 5.2): 60 mm.
  double contact_step_m = 0.002;
  int contact_steps = 30;
};

/// How many collision checks a plan may cost, and how its candidates share them.
struct ChoosingOptions {
  int max_checks = 120;  ///< of cylindrical and power grasps each; more: crowded scenes take longer
  int max_crowded_checks = 400;  ///< of each round where few are free: each may be the only one
  int enough = 6;                ///< grasps of this score make further rounds unnecessary
  double enough_score = 0.5;
  int max_rim_checks = 60;  ///< fewer: rim grasps are the alternative
  int power_per_group = 4;  ///< free grasps of one closing direction, so that there are others
  int rim_share = 6;        ///< one in so many candidates returned is a rim grasp, one a spare
};

/// Cylindrical grasps round a rotation axis (section 5.2).
struct CylindricalOptions {
  double pitch_rad = 0.2182;                 ///< 12.5 deg: measured, cylinders hold best
  double second_pitch_rad = base::Deg(5.0);  ///< the other pitch tried is this much flatter
  int yaw_steps = 24;                        ///< round the axis, and of the rim: 15 deg apart
  double opening_m = 0.020;                  ///< wider than the diameter, before closing
  double max_tilt_rad = base::Deg(45.0);     ///< of an axis that is approached along
};

/// Grasps of the wall of an open object, or across the rim of a closed one (section 5.2).
struct RimOptions {
  /// That the curvature is fitted to: about 50 points at 2 mm. Larger: weaker bends of the rim are
  /// lost; smaller: noise bends it.
  double neighborhood_m = 0.008;
  double smooth_rad = 0.175;      ///< of the Gaussian filter: 10 deg, 7 mm along the rim of a cup
  double sector_rad = 0.2;        ///< half; wall points this near to a sector's middle are its
  double above_rim_m = 0.002;     ///< wall points are no higher than this above the rim (noise) ...
  double below_rim_m = 0.020;     ///< ... and no further below: the pads' length
  double max_wall_m = 0.015;      ///< what is further from the rim's radius is not the wall
  double min_wall_m = 0.002;      ///< what measures less was seen from one side: a scan's spacing
  double assumed_wall_m = 0.005;  ///< then; a cup's
  double grip_depth_m = 0.014;    ///< pads' middle below the rim
  double tip_depth_m = 0.015;     ///< of a tip grasp across a closed top
  double opening_m = 0.026;       ///< wider than the wall, before closing
  double speck_cell_m = 0.004;    ///< grid of the wall's points where the hand comes down
  double curvature_weight = 0.5;  ///< of the score; the side next to the arm weighs alike (5.2)
  double arm_weight = 0.5;
  double outside_bonus = 0.1;   ///< two fingers bear better on the convex side
  double shallow_per_m = 50.0;  ///< off for each metre of grip depth missing: 10 mm cost 0.5
};

/// Power grasps of any other object (section 5.2).
struct PowerOptions {
  double pitch_rad = 0.1396;  ///< 8 deg: measured, boxes hold at 0 to 15, bottles at 5 to 8
  std::array<double, 3> pitches_rad{0.0, base::Deg(4.0), base::Deg(13.0)};  ///< the others tried
  std::size_t max_fine_directions = 6;  ///< the most promising ones are searched finely
  /// Offsets of the hand along the object, and how far the pads stay from its ends.
  std::array<double, 4> offsets_m{0.010, -0.010, 0.025, -0.025};
  double end_m = 0.012;
  double below_center_m = 0.012;  ///< the second depth tried, below the centre of mass
  int narrow_steps = 90;          ///< directions compared for the narrowest: 2 deg apart
  double same_width_m = 0.0005;   ///< widths no further apart are a tie: a scan's noise
  /// Closing directions are also tried turned by these, where none is within distinct_rad yet.
  std::array<double, 3> turns_rad{0.0, base::Deg(15.0), base::Deg(-15.0)};
  double distinct_rad = base::Deg(6.0);
  // With crowded.
  int crowded_turns = 12;  ///< closing directions
  int crowded_depths = 3;  ///< from the shallowest to the centre of mass
  std::array<double, 2> crowded_leans_rad{base::Deg(20.0), base::Deg(40.0)};  ///< of approaches
  int crowded_sides = 8;                                                      ///< they come from
  std::array<double, 3> crowded_offsets_m{0.0, 0.03, -0.03};                  ///< along the object
  /// A top that leans between these is approached against its normal, too.
  double min_tilt_rad = base::Deg(8.0);
  double max_tilt_rad = base::Deg(45.0);
};

/// Power grasps from the side (section 7.2).
struct LateralOptions {
  std::array<double, 2> downwards_rad{0.0, base::Deg(20.0)};  ///< most arms reach better if steep
  double turn_rad = base::Deg(15.0);                          ///< between approaches
  int turns_each_way = 6;  ///< from the arm's direction: further round it has to reach
  double height_step_m = 0.015;
  int heights = 4;            ///< of the pads, from the centre of mass up
  double max_lever_m = 0.03;  ///< of the contacts' middle from above the centre of mass: it tips
};

/// Where the hand comes from; kSidesToo: where few grasps from above are free.
enum class ApproachKind { kAbove, kSidesToo, kSides };
constexpr std::array<std::string_view, 3> WordsOf(ApproachKind) {
  return {"above", "sides_too", "sides"};
}

/// What planning grasps does beyond the dissertation (base/words.h). All off, the method as
/// published: the centre of the finger tips comes to the top surface's centre or onto the rotation
/// axis, the hand comes down along the surface's normal until it meets the object, and of both ways
/// round the one that encloses the object more tightly wins.
struct GraspAdditions {         // with the reason for each
  bool centering = true;        ///< one motor drives both sides and drags what is not between them
  bool pitches = true;          ///< fingers curl, the thumb does not: level tips touch unevenly
  bool depths = true;           ///< below the widest section the pads squeeze a round object out
  bool directions = true;       ///< pads that do not oppose each other squeeze the object out
  bool offsets = true;          ///< a centre of mass off the pads' line tilts the object
  bool contact_ranking = true;  ///< see Score (internal/placing.h)
  bool narrow_openings = true;
  bool power_fallback = true;
  bool crowded = true;  ///< and by an upper part of what is too wide
  bool reachable = true;
};
constexpr std::array<base::Addition<GraspAdditions>, 10> AdditionsOf(const GraspAdditions*) {
  using A = GraspAdditions;
  return {{
      {"centering", &A::centering,
       "center the hand between the expected contacts; off: over the center of the top surface"},
      {"pitches", &A::pitches, "pitch the hand so that both sides make contact at the same height"},
      {"depths", &A::depths,
       "grasp at the depth of the center of mass, deeper, and less deep; off: down to contact"},
      {"directions", &A::directions,
       "also grasp straight down, across the narrowest side and other directions; off: along the "
       "normal of the top surface, across its principal axis"},
      {"offsets", &A::offsets, "also power grasps off the middle of the object"},
      {"contact_ranking", &A::contact_ranking,
       "rank candidates by their predicted contacts; off: by the share of the object that they "
       "touch"},
      {"narrow_openings", &A::narrow_openings, "open the hand less where neighbors leave no room"},
      {"power_fallback", &A::power_fallback,
       "power grasps of a rotational object if no other grasp is possible"},
      {"crowded", &A::crowded,
       "more power grasps if neighbors leave few: from all directions, tilted, less deep"},
      {"reachable", &A::reachable,
       "do not count grasps that the arm cannot reach among those that are enough"},
  }};
}
static_assert(base::AllAdditionsListed<GraspAdditions>());

/// The switches of its base are what goes beyond the dissertation.
struct GraspOptions : GraspAdditions {
  bool preshape = true;               ///< as in the dissertation's pictures
  double friction_cone_rad = 0.46;    ///< half angle assumed when contacts are scored (mu 0.5)
  double table_clearance_m = 0.004;   ///< while it closes. Larger: flat objects cannot be gripped
  double object_clearance_m = 0.002;  ///< to other objects, and when coming down: a scan's noise
  int max_candidates = 24;
  bool power_only = false;
  ApproachKind approach = ApproachKind::kAbove;
  ScoreWeights score;
  PlacingOptions placing;
  ChoosingOptions choosing;
  CylindricalOptions cylindrical;
  RimOptions rim;
  PowerOptions power;
  LateralOptions lateral;
};

}  // namespace rangegrasp::grasp
