#pragma once

#include "perception/internal/planar.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// What one section plane across a rotation axis holds.
struct Section {
  double depth_m = 0.0;          ///< of the section's middle below the axis' center
  double outer_m = 0.0;          ///< radius of the points that face outward; 0: none
  double inner_m = 0.0;          ///< radius of the points that face the axis; 0: none
  std::size_t outer_points = 0;  ///< that agree with the radius
  std::size_t inner_points = 0;
};

/// The body of a rotational object along its axis.
struct BodyProfile {
  std::vector<Section> sections;  ///< those with points, from the top down
  /// Body points on their section's circle whose normals pass the axis; positions in the cloud.
  Indices agreeing;
  Indices turned;     ///< body points on the circle whose normals do not
  Indices differing;  ///< body points off it (a handle, a neighbor)
  /// Share of the body's points on their circles (eq. 5.8); 1 where there is no body to judge by.
  double fraction = 1.0;
  /// The share that is on them and whose normals pass the axis; 1 where there is no body.
  double normal_fraction = 1.0;
};

/// Section planes of the options' thickness along the axis; in each the distances of the points to
/// the axis (eq. 5.8) have to correspond: they agree with the radius about which the most of them
/// lie, within the circle distance. Points facing outward and inward (the inside of a cup) have
/// radii of their own. The top surface and points facing along the axis are not of the body.
/// O(n log n).
BodyProfile ProfileBody(const PointCloud& cloud, const Indices& points, const Plane& top,
                        const Vector3d& center_C, const Vector3d& direction_C,
                        const FeatureOptions& options);

/// The points on their sections' circles, whatever their normals; ascending.
Indices OnCircle(const BodyProfile& body);

/// The plane that a rotational part's body begins at: its top's, or the end of a lying one.
Plane EndPlane(const RotationAxis& axis, const TopSurface& top);

/// The section that a depth below the axis' center is in.
int SectionOf(double depth_m, const FeatureOptions& options);

/// Moves the axis to where the body has it and takes the radius from the wall under the rim. The
/// rim's far side is seen at a grazing angle, so its circle lies up to a millimetre towards the
/// sensor. The body says better where the axis is: concentric circles, one radius a section, by
/// least squares (Gauss-Newton over the center; the radii follow). Leaves the axis as it is where
/// the body says too little or something else.
void RefineAxis(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                const FeatureOptions& options, RotationAxis& axis);

}  // namespace rangegrasp::perception::internal
