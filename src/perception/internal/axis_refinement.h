#pragma once

#include "perception/feature_options.h"
#include "perception/scene.h"

namespace rangegrasp::perception::internal {

/// Moves the axis to where the body has it and takes the radius from the wall under the rim. The
/// rim's far side is seen at a grazing angle, so its circle lies up to a millimetre towards the
/// sensor. The body says better where the axis is: concentric circles, one radius a section, by
/// least squares (Gauss-Newton over the center; the radii follow). Leaves the axis as it is where
/// the body says too little or something else.
void RefineAxis(const geometry::PointCloud& cloud, const geometry::Indices& points,
                const TopSurface& top, const FeatureOptions& options, RotationAxis& axis);

}  // namespace rangegrasp::perception::internal
