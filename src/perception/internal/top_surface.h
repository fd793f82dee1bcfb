#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/rng.h"
#include "perception/feature_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// The top surface of a segment: RANSAC plane over the points whose normals are near the table's
/// (eq. 5.5), its principal axis, extents and rim. Takes the strip along the ridge where the top
/// curves about a lying axis, and the highest points where no plane is near enough to the table's
/// inclination (a lying prism), both with `ridge` set.
/// @return nullopt if the segment has fewer than three points or they lie on one line.
std::optional<TopSurface> FindTopSurface(const geometry::PointCloud& cloud,
                                         const geometry::Indices& segment,
                                         const geometry::Plane& table,
                                         const FeatureOptions& options, base::Rng& rng);

/// The highest points as a top surface, whatever the plane that holds the most: the lip of a bowl
/// has fewer points than its floor. nullopt where they are a fold.
std::optional<TopSurface> FindLip(const geometry::PointCloud& cloud,
                                  const geometry::Indices& segment, const geometry::Plane& table,
                                  const FeatureOptions& options);

/// The outer boundary of points on a plane by the 2-D alpha shape, in order; positions in the
/// cloud. The convex hull's corners where the alpha shape is empty. One for each alpha.
std::vector<geometry::Indices> OuterRims(const geometry::PointCloud& cloud,
                                         const geometry::Indices& points,
                                         const geometry::Plane& plane,
                                         std::span<const double> alphas_m);

/// The height [m] above the table that a few points reach: the fifth highest, so that a single
/// stray point does not count.
double TopHeight(const geometry::PointCloud& cloud, const geometry::Indices& points,
                 const geometry::Plane& table);

/// The same at the lower end.
double BaseHeight(const geometry::PointCloud& cloud, const geometry::Indices& points,
                  const geometry::Plane& table);

}  // namespace rangegrasp::perception::internal
