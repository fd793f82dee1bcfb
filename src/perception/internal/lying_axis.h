#pragma once

#include <optional>

#include "base/rng.h"
#include "perception/feature_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// The axis of a rotational body that lies, from its normals alone: the direction that most
/// of them are square to, and across it the circle that the body is seen as along that direction
/// (CircleAcross). Its body has to agree with the sections as an upright one's (eq. 5.8),
/// goes far enough round, and stays above the table, where half a cylinder on its flat side would
/// be under it.
/// @return nullopt if there is no such direction or the body is not rotational about it.
std::optional<RotationAxis> FindLyingAxis(const geometry::PointCloud& cloud,
                                          const geometry::Indices& points,
                                          const geometry::Plane& table,
                                          const FeatureOptions& options, base::Rng& rng);

}  // namespace rangegrasp::perception::internal
