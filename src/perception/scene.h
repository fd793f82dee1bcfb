#pragma once

#include <string>
#include <utility>

#include "geometry/mesh.h"
#include "geometry/observation.h"
#include "perception/sampling.h"

namespace rangegrasp::perception {

using geometry::SampleId;

/// The table: its plane (normal towards the sensor) and its points.
struct Table {
  geometry::Plane plane;
  geometry::Indices points;  ///< positions in the perceived points
};

/// The top surface of an object (section 5.1.3).
struct TopSurface {
  geometry::Plane plane;     ///< normal away from the table
  geometry::Indices points;  ///< positions in Scene::cloud
  Eigen::Vector3d center_C;  ///< centre of gravity [m]
  Eigen::Vector3d major_C;   ///< unit; principal axis in the plane
  Eigen::Vector3d minor_C;   ///< unit; normal x major
  double major_m = 0.0;      ///< full extent along major_C
  double minor_m = 0.0;      ///< full extent along minor_C
  /// The highest part is a ridge (a lying cylinder, a roof), not a plane: major_C runs along it,
  /// and points is the strip around it.
  bool ridge = false;
  /// Outer boundary by the 2-D alpha shape, in order; positions in Scene::cloud.
  geometry::Indices rim;
  geometry::Indices bridged_rim;  ///< the same over wider gaps; empty if it was not requested
};

/// A rotation axis: the centre and radius of the circle at its end, and the direction out of the
/// body there. A standing body's end is its top, so the direction points away from the table.
struct RotationAxis {
  Eigen::Vector3d center_C;
  Eigen::Vector3d direction_C;
  double radius_m = 0.0;
  /// Share of the rim points on the circle (the first 80 % rule); 0 for an axis from the body.
  double rim_fraction = 0.0;
  /// Share of the points that agree with their section circle (the second 80 % rule).
  double body_fraction = 0.0;
  /// Length of a lying body from end to end; 0: it stands and reaches down to its support.
  double length_m = 0.0;

  bool Lies() const { return length_m > 0.0; }
};

enum class ObjectKind { kRotational, kOther };
constexpr std::array<std::string_view, 2> WordsOf(ObjectKind) { return {"rotational", "other"}; }

/// One perceived object: the points of one segment, or of several that were merged.
struct PerceivedObject {
  geometry::Indices points;  ///< positions in Scene::cloud
  ObjectKind kind = ObjectKind::kOther;
  bool open = false;  ///< a container, by the sphere of eq. 5.9
  std::optional<TopSurface> top;
  std::optional<RotationAxis> axis;  ///< for kRotational
  double height_m = 0.0;             ///< height of its highest points above the table
  double base_m = 0.0;               ///< height of its lowest points above the table
  /// Centre of the completed shape's bounding box.
  Eigen::Vector3d center_C = Eigen::Vector3d::Zero();
  /// The box: along its principal axes in the table's plane (longest first), and height.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  /// Unit, in the table's plane: the direction of size_m[0].
  Eigen::Vector3d axis_C = Eigen::Vector3d::Zero();
  geometry::Points completed_C;      ///< the points and those added by completion (section 5.1.4)
  geometry::TriangleMesh surface_C;  ///< the completed shape, for collision and pictures
};

/// Wall-clock seconds of each step, in order.
using StageSeconds = std::vector<std::pair<std::string, double>>;

struct Scene {
  /// The perceived points: the measured points in the workspace, view after view, each in the order
  /// of its scan.
  geometry::Points points_C;
  std::vector<SampleId> samples;  ///< one per point of points_C: its measured sample
  Sampling sampling;              ///< measured or stated; zeros if lengths were not adapted
  Table table;                    ///< its points are positions in points_C
  geometry::PointCloud cloud;  ///< points above the table after the filters, smoothed, with normals
  geometry::Indices source;    ///< one per point of cloud: its position in points_C
  geometry::Indices outliers;  ///< removed by the filter; positions in points_C
  std::vector<geometry::Indices> segments;  ///< before merging; positions in cloud, largest first
  /// Walls of an open box that objects lie in, which are obstacles; positions in cloud, in no
  /// segment or object.
  geometry::Indices container;
  std::vector<PerceivedObject> objects;  ///< topmost first
  StageSeconds seconds;

  /// The measured sample of a point of the cloud (and of an object).
  const SampleId& SampleOf(std::uint32_t point) const { return samples[source[point]]; }
  std::vector<SampleId> SamplesOf(const PerceivedObject& object) const {
    std::vector<SampleId> of_object;
    of_object.reserve(object.points.size());
    for (const auto point : object.points) of_object.push_back(SampleOf(point));
    return of_object;
  }
};

}  // namespace rangegrasp::perception
