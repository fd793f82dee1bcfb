#pragma once

#include <optional>

#include "parts/cloud/revolution.h"
#include "parts/shape/segmentation.h"

namespace rangegrasp::parts {

/// How many layers of a surface lie one behind the other, in the mean, seen from where they are
/// fewest: 1 of what was seen from one side, 2 of a closed surface. The sum of A |n . v| over the
/// area that is covered, least over about 200 directions v. O(faces) each.
double FewestLayers(const Shape& mesh);

struct SeenSideOptions {
  double max_layers = 1.15;    ///< one view: 0.7 to 0.95 were measured; closed clouds: 1.4 to 2.1
  double min_share = 0.6;      ///< of the area that turns about an axis, to be a body
  double max_twist = 0.3;      ///< of a face that turns about it: noise tilts faces by 0.1 to 0.2
  double min_turned = 0.5;     ///< of a part's area that does, to be of the body
  double sure_turned = 0.6;    ///< the same of parts that tell the body's profile, and
  double sure_area = 0.02;     ///< how much of the area they have at least
  double profile_reach = 2.0;  ///< half of a part of the body is so near to its profile, in edges
  double min_off = 0.02;     ///< of the area; less than this does not stand off, it is of the body
  double border_zone = 3.0;  ///< faces so near to another part, in edges, are looked at again
  double border_step = 0.4;  ///< nearer than this to the body's profile, in edges, is of the body
  double same_side_rad = 0.8;  ///< what stands off, at angles less than this apart, is one
};

/// A body of revolution that is seen from one side, its inside perhaps, too: its axis.
/// @return nullopt of a surface that is not seen from one side, and if too little turns about one
/// axis.
std::optional<RevolutionAxis> FindSeenBody(const Shape& mesh, const SeenSideOptions& options = {});

/// Joins the parts that are of the body, as outside and inside of a mug, and those that stand off
/// on one side of its axis, as a handle whose middle the body hides. Faces at the border of both go
/// by the body's profile. Its tree is the whole and what
/// it came to.
Segmentation JoinTurned(const Shape& mesh, const RevolutionAxis& axis, const Segmentation& found,
                        const SeenSideOptions& options = {});

}  // namespace rangegrasp::parts
