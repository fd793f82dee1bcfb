#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "geometry/random_points.h"
#include "parts/shape/shape.h"

namespace rangegrasp::parts::samples {

/// The same surface stored differently: vertices and faces in any order, rotated, scaled, shifted.
/// @param face  index of each input face in the result
inline Shape Rewritten(const Shape& shape, std::uint64_t seed, std::vector<std::uint32_t>& face) {
  base::Rng rng(seed);
  const Indices place = geometry::samples::Permutation(shape.points.size(), rng);
  face = geometry::samples::Permutation(shape.faces.size(), rng);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(
          rng.Uniform(0.0, 6.0),
          Eigen::Vector3d(rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0), 0.5).normalized())
          .toRotationMatrix();
  const double scale = std::exp(rng.Uniform(-6.0, 6.0));
  Shape other{geometry::Points(shape.points.size()), {}, {}};
  other.faces.resize(shape.faces.size());
  for (std::size_t v = 0; v < shape.points.size(); ++v) {
    other.points[place[v]] = scale * (turn * shape.points[v] + Eigen::Vector3d(1.0, -2.0, 3.0));
  }
  for (std::size_t f = 0; f < shape.faces.size(); ++f) {
    auto corners = shape.faces[f];
    std::rotate(corners.begin(), corners.begin() + static_cast<int>(rng.Index(3)), corners.end());
    for (std::uint32_t& v : corners) v = place[v];
    other.faces[face[f]] = corners;
  }
  return other;
}

/// Splits each face into four by halving its edges.
inline Shape Subdivided(const Shape& shape) {
  Shape fine{shape.points, {}, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(fine.points.size()));
    if (is_new) fine.points.emplace_back(0.5 * (shape.points[a] + shape.points[b]));
    return at->second;
  };
  for (const auto& [a, b, c] : shape.faces) {
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.faces.insert(fine.faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace rangegrasp::parts::samples
