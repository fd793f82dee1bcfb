#pragma once

#include "cylinders/barrel.h"
#include "cylinders/rims.h"
#include "perception/perceive.h"

namespace rangegrasp::cylinders {

/// Criteria for accepting a given cylinder. Adaptive lengths grow with the noise and the gaps.
struct AcceptOptions {
  /// Maximum distance of a rim's points from the circle (eq. 4.26).
  perception::AdaptiveLength rim_distance_m{0.002, {.noises = 2.5, .spacings = 0.67}};
  double min_rim_share = 0.8;  ///< share of the rim's points on the circle (section 4.2.4)
  /// Maximum error of the circle's radius: the range tolerance of section 4.2.4 (eq. 4.27 takes the
  /// nearest radius without a limit). Larger: other cylinders are mistaken for given ones.
  perception::AdaptiveLength max_rim_error_m{0.002, {.noises = 4.0}};
  /// Maximum error of the barrel's radius: with the line scanner 0.1 mm, one in twenty 0.4 mm.
  /// Increased by two standard deviations of the fit (short arcs), at most to twice the value.
  perception::AdaptiveLength max_radius_error_m{0.0005, {.noises = 1.5}};
  /// Maximum error of the visible height: a row of points at each end.
  perception::AdaptiveLength max_height_error_m{0.003, {.noises = 4.0, .gaps = 1.0}};
  /// The same for ends that are seen as faces, which have many points each.
  perception::AdaptiveLength max_face_error_m{0.002, {.noises = 4.0}};
  /// Minimum visible share of the height: the full length of a shorter piece cannot be estimated.
  double min_length_share = 0.2;
  double min_arc_rad = base::Deg(45.0);  ///< a shorter arc fits almost any curved object
  /// Limit of RefinedAxis. Larger: box corners pass as barrels; smaller: noisy barrels fail.
  double max_normal_angle_rad = base::Deg(9.0);
  /// Minimum share of the rays that should have ended on the cylinder and did: all in 1,500 scenes;
  /// the margin is for mixed points and holes. Smaller: other objects are mistaken for it.
  double min_agreement = 0.95;
  /// Maximum share of the rays to a part without points that pass through it (others end before).
  double max_missing_seen = 0.05;
  /// Slices of such a part, to find how far the cylinder may extend. More: more accurate, slower.
  int hidden_steps = 8;
  /// Minimum share of all rays to the cylinder that end on it. Smaller: more of it may be hidden.
  double min_seen_share = 0.12;
  /// Maximum distance of a ray's end from the surface.
  perception::AdaptiveLength view_tolerance_m{0.004, {.noises = 5.0, .gaps = 0.7}};
  double max_standing_tilt_rad = base::Deg(30.0);  ///< maximum, of a standing axis to the vertical
  double max_shared = 0.3;  ///< maximum share of points that also belong to another cylinder
};

/// Defaults with an equation or section come from the dissertation; the others are our own.
struct DetectOptions {
  bool as_published = false;  ///< without the additions to chapter 4; set by AsPublished
  /// Table, filter and normals of chapter 5. Without smoothing, which would make barrels thinner.
  perception::PreprocessOptions preprocess;
  perception::SamplingOptions sampling;
  CurvatureOptions curvature;
  FragmentOptions fragments;
  int circle_draws = 100;  ///< number of triples (section 4.2.4)
  AcceptOptions accept;
  BarrelOptions barrel;
  BarrelSearchOptions search;
  /// As published: a plane with a smaller share of the points is not a table.
  double min_table_share = 0.05;
};

DetectOptions AsPublished();

// Detection of given cylinders among other objects on a table (section 4.2).

/// The shape of a cylinder to be found [m].
struct GivenCylinder {
  double radius_m = 0.0;
  double height_m = 0.0;
};

/// A fragment of curvature points whose circle passed the 80 % rule.
struct Rim {
  Circle circle_C;
  double share = 0.0;        ///< share of its points that are on the circle (eq. 4.26)
  geometry::Indices points;  ///< positions in CylinderScene::cloud
};

/// A given cylinder that was found.
struct FoundCylinder {
  std::size_t given = 0;       ///< index of the given cylinder
  Cylinder cylinder_C;         ///< radius as measured, height as given
  bool lies = false;           ///< its axis is not upright
  double rim_share = 0.0;      ///< Rim::share; 0 if found by its barrel
  double length_seen_m = 0.0;  ///< of the barrel along the axis; 0: only its rim was seen
  ViewCounts view;             ///< agreement with the scan; zeros as published
  geometry::Indices barrel;    ///< positions in CylinderScene::cloud

  bool IsFromRim() const { return rim_share > 0.0; }
};

struct CylinderScene {
  geometry::Points points_C;  ///< the measured points in the workspace, in the order of the scan
  perception::Sampling sampling;  ///< zeros as published
  perception::Table table;        ///< positions in points_C
  geometry::PointCloud cloud;     ///< points above the table after the filter, with normals
  geometry::Indices source;       ///< position in points_C of each point of cloud
  geometry::Indices outliers;     ///< removed by the filter; positions in points_C
  geometry::Indices curved;       ///< curvature points by normals (eq. 4.13); positions in cloud
  geometry::Indices edges;        ///< curvature points by scan lines (eq. 4.14); positions in cloud
  std::vector<geometry::Indices> fragments;  ///< of the top curvature points; positions in cloud
  std::vector<Rim> rims;
  std::vector<FoundCylinder> cylinders;  ///< in the order of the given cylinders
  bool scan_order = false;  ///< the cloud is in scan order; otherwise there are no line edges
  perception::StageSeconds seconds;

  /// The first find of a given cylinder; null if it was not found.
  const FoundCylinder* Find(std::size_t which) const {
    const auto found = std::ranges::find(cylinders, which, &FoundCylinder::given);
    return found == cylinders.end() ? nullptr : &*found;
  }
};

/// F_p F_c > 0: p is on the sensor's side of the plane (eq. 4.1 to 4.4).
inline bool IsOnSensorSide(const geometry::Plane& plane, const Eigen::Vector3d& sensor_origin,
                           const Eigen::Vector3d& p) {
  return plane.Distance(p) * plane.Distance(sensor_origin) > 0.0;
}

/// Detection by section 4.2: table, filter, normals, curvature points, fragments, circles, axes. An
/// image with more than one profile is in scan order.
/// @param given  at least one, with sizes above 0; other cylinders are ignored
/// @throws base::InputError if there are fewer than 100 points, or if no table can be found.
/// @throws std::invalid_argument if a view has neither one origin nor one per profile.
CylinderScene DetectCylinders(const geometry::Observation& observation,
                              std::span<const GivenCylinder> given, const DetectOptions& options,
                              base::Rng& rng,
                              const std::optional<perception::Workspace>& workspace = std::nullopt);

}  // namespace rangegrasp::cylinders
