#pragma once

#include <optional>

#include "base/rng.h"
#include "geometry/point_cloud.h"
#include "perception/preprocess_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception {

/// The deepest plane on the convex hull (eq. 5.1, figure 5.4), preselection, 100 hypotheses, refit
/// (section 5.1.1). The normal points to the sensor's side.
///
/// Of the hull's planes that have the sensor on their inner side (and, where up_C is given, a
/// normal near it), the one wins that the most raw points lie near. Stray points under
/// the table bend the hull; so the preselection is repeated once round the plane that was fitted,
/// and where a plane with points beneath it or with little support comes out, the hull's vertices
/// are taken away and the hull is built again, a bounded number of times. A scene with a background
/// behind and under the table shows no table on its hull: there the dominant plane is taken
/// (section 4.2.1).
///
/// Table::points are all points less than table_clearance_m above the plane, and all below it
/// (eq. 4.3, 4.4). O(n log n).
/// @param sensor_origin_C  where the sensor stood, or any other place on its side of the table
/// @return nullopt if no plane was found.
/// @throws std::invalid_argument if an option is out of range.
std::optional<Table> FindTable(geometry::PointSpan points_C, const Eigen::Vector3d& sensor_origin_C,
                               const PreprocessOptions& options, base::Rng& rng);

/// The table of a plane: all points less than table_clearance_m above it.
Table TableOn(const geometry::Plane& plane, geometry::PointSpan points_C,
              const PreprocessOptions& options);

}  // namespace rangegrasp::perception
