#pragma once

#include "perception/internal/objects.h"

namespace rangegrasp::perception::internal {

/// One section plane across a rotation axis.
struct Section {
  double depth_m = 0.0;          ///< depth of the section's middle below the axis' center
  double outer_m = 0.0;          ///< radius of the points that face outward; 0: none
  double inner_m = 0.0;          ///< radius of the points that face the axis; 0: none
  std::size_t outer_points = 0;  ///< points that agree with the radius
  std::size_t inner_points = 0;
};

/// The body of a rotational object along its axis.
struct BodyProfile {
  std::vector<Section> sections;  ///< those with points, from the top down
  /// Body points on their section's circle whose normals pass the axis; positions in the cloud.
  Indices agreeing;
  Indices turned;     ///< body points on the circle whose normals do not
  Indices differing;  ///< body points off it (a handle, a neighbor)
  /// Share of the body's points on their circles (eq. 5.8); 1 if there is no body to judge by.
  double fraction = 1.0;
  /// The share that is on them and whose normals pass the axis; 1 if there is no body.
  double normal_fraction = 1.0;
};

/// Cuts the body along the axis into sections of the options' thickness. In each, the distances of
/// the points to the axis (eq. 5.8) have to correspond: points agree with the radius about which
/// most of them lie, within the circle distance. Points that face outward and points that face
/// inward (the inside of a cup) have separate radii. The top surface and points that face along the
/// axis are not part of the body. O(n log n).
BodyProfile ProfileBody(const ObjectContext& context, const Indices& points, const Plane& top,
                        const RotationAxis& axis);

/// The points on their sections' circles, whatever their normals; ascending.
Indices OnCircle(const BodyProfile& body);

/// The plane at which a rotational part's body begins: its top's, or the end of a lying body.
Plane EndPlane(const RotationAxis& axis, const TopSurface& top);

/// The index of the section that contains a depth below the axis' center.
int SectionOf(double depth_m, const FeatureOptions& options);

/// Moves the axis to the body's axis and takes the radius from the wall under the rim. The rim's
/// far side is seen at a grazing angle, so its circle lies up to a millimetre towards the sensor.
/// The body locates the axis better: concentric circles, one radius per section, are fitted by
/// least squares (Gauss-Newton over the center; the radii follow). Leaves the axis unchanged if the
/// body has too little information or contradicts it.
void RefineAxis(const ObjectContext& context, const Indices& points, const TopSurface& top,
                RotationAxis& axis);

}  // namespace rangegrasp::perception::internal
