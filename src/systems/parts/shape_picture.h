#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "geometry/draw/canvas.h"

namespace rangegrasp::draw {

/// Red, green, blue of a label.
using LabelColor = std::function<std::array<std::uint8_t, 3>(std::int32_t)>;

/// A mesh with its faces, or a cloud (no triangles) with its points, in the colours of their
/// labels; points that are not finite, and faces with one, are left out.
/// @throws std::invalid_argument if there is not one label a face (a point).
Canvas DrawLabels(const geometry::TriangleMesh& shape, std::span<const std::int32_t> labels,
                  const LabelColor& color);

/// A view of the whole of a shape, from the front right and above. Any unit.
/// @param up  the shape's axis that points up: 0, 1, 2 for x, y, z; the front is the next axis but
///            one, against its direction for z (-y), along it for y (+z).
/// @throws std::invalid_argument without a finite point, or for another axis.
View LookAtShape(geometry::PointSpan points, int up);

}  // namespace rangegrasp::draw
