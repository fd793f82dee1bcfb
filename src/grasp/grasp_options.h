#pragma once

#include <array>
#include <string_view>

#include "base/units.h"
#include "base/words.h"

/// Lengths suit a hand of human size and objects that it can hold. Where no source is given, the
/// comment states the trade-off of a value.
namespace rangegrasp::grasp {

/// Weights and scales of the terms of Score(), which starts from 1. The antipodal angles weigh
/// most: a grip beyond the friction cone slips even if all other terms are good.
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
  double below_scale_m = 0.050;  ///< an object gripped below its middle tips less easily
  double drag_scale_m = 0.016;   ///< drag at which the coupled hand was still seen to hold
  double slope_scale_m = 0.020;
  double margin_m = 0.012;         ///< contacts at least this far below the top are deep enough
  double contact_scale_m2 = 4e-4;  ///< two pads of 10 x 20 mm
  double room_scale_m = 0.015;

  /// Upper bounds of the terms (max_multiple: height, drag, slope and shallow), so that no term
  /// outweighs all others.
  double max_square = 4.0;
  double max_multiple = 2.0;
};

/// How the hand is placed on an object along one approach.
struct PlacingOptions {
  /// Half width of the strip that the pads may touch: the SensorHand's outer pads, of 8 mm radius,
  /// are 16 mm apart.
  double contact_band_m = 0.022;
  double hand_band_m = 0.018;   ///< half width of fingers and thumb, where the extent is measured
  double max_reach_m = 0.15;    ///< below the object's top; deeper samples are not contacts
  double swing_m = 0.020;       ///< added to the hand's depth: the thumb swings down as it closes
  double upper_step_m = 0.010;  ///< step of the search for an upper part that fits into the hand
  double opening_m = 0.020;     ///< extra opening before closing, as measured surfaces are noisy
  double narrow_opening_m = 0.008;  ///< the same where neighbors leave no more room
  double min_depth_m = 0.010;       ///< of the pads' middle below the top; higher pads slip off
  int rounds = 3;                   ///< iterations that center the hand between the contacts found
  double centered_m = 0.001;        ///< tolerance of centering: half of the samples' spacing
  double same_depth_m = 0.003;  ///< placements that differ less in depth stopped at the same thing
  /// If the hand had to stop early, it is also tried this much higher: the thumb's first segment
  /// touches a wide object's edge before its tip touches the side.
  std::array<double, 3> back_offs_m{0.006, 0.012, 0.018};
  std::array<double, 3> lifts_m{0.0, 0.002, 0.004};  ///< tried if it grazes: fields are sampled
  /// A hand that came down to contact goes up in these steps until it is free of its object and of
  /// the table (section 5.2): 60 mm.
  double contact_step_m = 0.002;
  int contact_steps = 30;
};

/// How many collision checks a plan may cost, and how its candidates share them.
struct ChoosingOptions {
  int max_checks = 120;  ///< for cylindrical and for power grasps; more slow crowded scenes down
  int max_crowded_checks = 400;  ///< per round if few are free, as each may be the only one
  int enough = 6;                ///< this many grasps of enough_score end the search
  double enough_score = 0.5;
  int max_rim_checks = 60;  ///< fewer, as rim grasps are the alternative
  int power_per_group = 4;  ///< free grasps per closing direction, so that directions vary
  int rim_share = 6;        ///< one in this many returned candidates is a rim grasp, one a spare
};

/// Cylindrical grasps around a rotation axis (section 5.2).
struct CylindricalOptions {
  double pitch_rad = 0.2182;                 ///< 12.5 deg: holds cylinders best, as measured
  double second_pitch_rad = base::Deg(5.0);  ///< the second pitch tried is this much smaller
  int yaw_steps = 24;                        ///< directions around axis or rim, 15 deg apart
  double max_tilt_rad = base::Deg(45.0);     ///< largest tilt of an axis for an approach along it
};

/// Grasps of the wall of an open object, or across the rim of a closed one (section 5.2).
struct RimOptions {
  /// Radius of the curvature fit: about 50 points at 2 mm. A larger one loses weaker bends of the
  /// rim; in a smaller one, noise looks like a bend.
  double neighborhood_m = 0.008;
  double smooth_rad = 0.175;      ///< sigma of the Gaussian filter: 10 deg, 7 mm along a cup's rim
  double sector_rad = 0.2;        ///< half a sector; wall points this near to its middle are in it
  double above_rim_m = 0.002;     ///< wall points are no higher than this above the rim (noise) ...
  double below_rim_m = 0.020;     ///< ... and no further below: the pads' length
  double max_wall_m = 0.015;      ///< points further from the rim's radius are not on the wall
  double min_wall_m = 0.002;      ///< thinner walls were seen from one side only: a scan's spacing
  double assumed_wall_m = 0.005;  ///< thickness assumed in that case; a cup's
  double grip_depth_m = 0.014;    ///< depth of the pads' middle below the rim
  double tip_depth_m = 0.015;     ///< the same for a tip grasp across a closed top
  double opening_m = 0.026;       ///< extra opening over the wall before closing
  double speck_cell_m = 0.004;    ///< grid cell of the wall's points for the hand's descent
  double curvature_weight = 0.5;  ///< in the score; the side next to the arm weighs the same (5.2)
  double arm_weight = 0.5;
  double outside_bonus = 0.1;   ///< two fingers press better on the convex side
  double shallow_per_m = 50.0;  ///< subtracted per metre of missing grip depth: 10 mm cost 0.5
};

/// Power grasps of any other object (section 5.2).
struct PowerOptions {
  double pitch_rad = 0.1396;  ///< 8 deg: as measured, boxes hold at 0 to 15, bottles at 5 to 8
  std::array<double, 3> pitches_rad{0.0, base::Deg(4.0), base::Deg(13.0)};  ///< other pitches tried
  std::size_t max_fine_directions = 6;  ///< only the most promising ones are searched finely
  /// Offsets of the hand along the object, and the smallest distance of the pads from its ends.
  std::array<double, 4> offsets_m{0.010, -0.010, 0.025, -0.025};
  double end_m = 0.012;
  double below_center_m = 0.012;  ///< the second depth tried: this far below the centre of mass
  int narrow_steps = 90;          ///< directions compared to find the narrowest, 2 deg apart
  double same_width_m = 0.0005;   ///< widths that differ less are a tie: a scan's noise
  /// Closing directions are also tried rotated by these, unless one within distinct_rad is listed.
  std::array<double, 3> turns_rad{0.0, base::Deg(15.0), base::Deg(-15.0)};
  double distinct_rad = base::Deg(6.0);
  // Used if GraspAdditions::crowded is on.
  int crowded_turns = 12;  ///< closing directions
  int crowded_depths = 3;  ///< from the shallowest to the centre of mass
  std::array<double, 2> crowded_leans_rad{base::Deg(20.0), base::Deg(40.0)};  ///< approach tilts
  int crowded_sides = 8;                                                      ///< their sides
  std::array<double, 3> crowded_offsets_m{0.0, 0.03, -0.03};                  ///< along the object
  /// A top surface tilted between these angles is also approached against its normal.
  double min_tilt_rad = base::Deg(8.0);
  double max_tilt_rad = base::Deg(45.0);
};

/// Power grasps from the side (section 7.2).
struct LateralOptions {
  std::array<double, 2> downwards_rad{0.0, base::Deg(20.0)};  ///< most arms reach steep ones better
  double turn_rad = base::Deg(15.0);                          ///< angle between approaches
  int turns_each_way = 6;  ///< from the arm's direction; beyond, the arm has to reach around
  double height_step_m = 0.015;
  int heights = 4;            ///< number of pad heights, from the centre of mass up
  double max_lever_m = 0.03;  ///< horizontal, contacts to centre of mass; beyond, the object tips
};

/// Where the hand comes from. kSidesToo: also from the sides if few grasps from above are free.
enum class ApproachKind { kAbove, kSidesToo, kSides };
constexpr std::array<std::string_view, 3> WordsOf(ApproachKind) {
  return {"above", "sides_too", "sides"};
}

/// Extensions of grasp planning beyond the dissertation (base/words.h). With all off, it is the
/// published method: the centre of the finger tips moves to the top surface's centre or onto the
/// rotation axis, the hand moves down along the surface's normal until it meets the object, and of
/// the two opposite orientations the one that encloses the object more tightly wins.
struct GraspAdditions {         // with the reason for each
  bool centering = true;        ///< one motor drives both sides, which drags an off-center object
  bool pitches = true;          ///< the fingers curl, the thumb does not: level tips touch unevenly
  bool depths = true;           ///< below the widest section the pads squeeze a round object out
  bool directions = true;       ///< pads that do not oppose each other squeeze the object out
  bool offsets = true;          ///< a centre of mass off the pads' line tilts the object
  bool contact_ranking = true;  ///< see Score (internal/placing.h)
  bool narrow_openings = true;
  bool power_fallback = true;
  bool crowded = true;  ///< also grips an upper part of an object that is too wide
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
       "rank candidates by their predicted contacts, and drop those without; off: by the share of "
       "the object that they touch"},
      {"narrow_openings", &A::narrow_openings, "open the hand less where neighbors leave no room"},
      {"power_fallback", &A::power_fallback,
       "power grasps of a rotational object if no other grasp is possible"},
      {"crowded", &A::crowded,
       "more power grasps if neighbors leave few: from all directions, tilted, less deep"},
      {"reachable", &A::reachable,
       "count only grasps that the arm can reach when deciding whether enough were found"},
  }};
}
static_assert(base::AllAdditionsListed<GraspAdditions>());

/// The switches of its base class are the extensions beyond the dissertation.
struct GraspOptions : GraspAdditions {
  bool preshape = true;               ///< as in the dissertation's pictures
  double friction_cone_rad = 0.46;    ///< half angle assumed when contacts are scored (mu 0.5)
  double table_clearance_m = 0.004;   ///< while closing; if larger, flat objects cannot be gripped
  double object_clearance_m = 0.002;  ///< to other objects, and during the descent: a scan's noise
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
