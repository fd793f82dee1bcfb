#pragma once

#include <array>

#include "base/additions.h"

namespace rangegrasp::grasp {

/// What planning grasps does beyond the dissertation; every switch off is the method as published
/// (core/additions.h): the tool centre, which is the centre of the finger tips and moves with the
/// hand's opening, comes to the top surface's centre or onto the rotation axis, the hand comes down
/// along the surface's normal until it meets the object, and of both ways round the one that
/// encloses the object more tightly wins. A grip that is held by friction alone needs more.
struct GraspAdditions {
  /// One motor drives both sides and drags an object that is not midway between them.
  bool centering = true;
  /// The fingers curl in and the thumb stays straight: level tips do not touch at one height.
  bool pitches = true;
  /// Below the widest section of a round object the pads squeeze it out upwards.
  bool depths = true;
  /// Pads that do not oppose each other squeeze the object out or turn it.
  bool directions = true;
  /// A centre of mass beside the pads' line tilts the object.
  bool offsets = true;
  /// What is predicted of the contacts ranks the candidates (score.h).
  bool contact_ranking = true;
  /// A second, narrower opening where neighbors leave no room for the first.
  bool narrow_openings = true;
  /// A rotational object that can be held neither round its body nor by its rim.
  bool power_fallback = true;
  /// Where neighbors leave few good grasps: from all round, leaning, less deep, and by an upper
  /// part of what is too wide.
  bool crowded = true;
};
constexpr std::array<base::Addition<GraspAdditions>, 9> AdditionsOf(const GraspAdditions*) {
  using A = GraspAdditions;
  return {{
      {"centering", &A::centering,
       "midway between the expected contacts; off: tool centre over the top surface's centre"},
      {"pitches", &A::pitches, "the hand is pitched, so that both sides touch at one height"},
      {"depths", &A::depths,
       "as deep as the centre of mass, deeper, or less deep; off: down to contact"},
      {"directions", &A::directions,
       "straight down, across the narrowest side and others, too; off: against the top surface, "
       "across its principal axis"},
      {"offsets", &A::offsets, "power grasps beside the middle of the object, too"},
      {"contact_ranking", &A::contact_ranking,
       "candidates are ranked by predicted contacts; off: by how much of the object they touch"},
      {"narrow_openings", &A::narrow_openings, "a narrower opening where neighbors leave no room"},
      {"power_fallback", &A::power_fallback,
       "a power grasp where a rotational object can be held in no other way"},
      {"crowded", &A::crowded,
       "more power grasps where neighbors leave few: from all round, leaning, less deep"},
  }};
}
static_assert(base::AllAdditionsListed<GraspAdditions>());

}  // namespace rangegrasp::grasp
