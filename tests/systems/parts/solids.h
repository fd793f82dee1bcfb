#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <vector>

#include "parts/shape/segmentation.h"

namespace rangegrasp::parts::samples {

/// A closed surface around the origin at radius(direction), with faces pointing outward: an
/// inflated cube of 6 * 2 * cells^2 triangles.
template <typename Radius>
Shape Ball(std::uint32_t cells, Radius radius) {
  Shape shape;
  const std::uint32_t side = cells + 1;
  std::vector<std::uint32_t> number(side * side * side, UINT32_MAX);
  const auto vertex = [&](const std::array<std::uint32_t, 3>& g) {
    std::uint32_t& index = number[(g[0] * side + g[1]) * side + g[2]];
    if (index == UINT32_MAX) {
      index = static_cast<std::uint32_t>(shape.points.size());
      Eigen::Vector3d p;
      for (int k = 0; k < 3; ++k) {
        p[k] = std::tan(0.25 * std::numbers::pi *
                        (2.0 * g[static_cast<std::size_t>(k)] / cells - 1.0));
      }
      p.normalize();
      shape.points.push_back(radius(p) * p);
    }
    return index;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool far : {false, true}) {
      for (std::uint32_t i = 0; i < cells; ++i) {
        for (std::uint32_t j = 0; j < cells; ++j) {
          const auto at = [&](std::uint32_t u, std::uint32_t v) {
            std::array<std::uint32_t, 3> g{};
            g[axis] = far ? cells : 0;
            g[(axis + 1) % 3] = u;
            g[(axis + 2) % 3] = v;
            return vertex(g);
          };
          std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
          if (!far) std::swap(b, d);
          shape.faces.push_back({a, b, c});
          shape.faces.push_back({a, c, d});
        }
      }
    }
  }
  return shape;
}

/// A closed tube along a curve in the plane z = 0, t from 0 to 1. It has `rings` rings of `around`
/// points (ring by ring, then the centers of the two ends).
template <typename Curve, typename Radius>
Shape Tube(std::uint32_t rings, std::uint32_t around, Curve curve, Radius radius) {
  Shape tube;
  for (std::uint32_t r = 0; r < rings; ++r) {
    const double t = static_cast<double>(r) / (rings - 1);
    const Eigen::Vector3d along = (curve(t + 1e-4) - curve(t - 1e-4)).normalized();
    const Eigen::Vector3d side(-along.y(), along.x(), 0.0);
    for (std::uint32_t k = 0; k < around; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / around;
      tube.points.push_back(curve(t) + radius(t) * (std::cos(angle) * side +
                                                    std::sin(angle) * Eigen::Vector3d::UnitZ()));
    }
  }
  tube.points.push_back(curve(0.0));
  tube.points.push_back(curve(1.0));
  const std::uint32_t last = (rings - 1) * around;
  for (std::uint32_t k = 0; k < around; ++k) {
    const std::uint32_t next = (k + 1) % around;
    for (std::uint32_t r = 0; r + 1 < rings; ++r) {
      const std::uint32_t base = r * around;
      tube.faces.push_back({base + k, base + next, base + around + next});
      tube.faces.push_back({base + k, base + around + next, base + around + k});
    }
    tube.faces.push_back({rings * around, next, k});
    tube.faces.push_back({rings * around + 1, last + k, last + next});
  }
  return tube;
}

/// The zero level set of a field, by marching tetrahedra in a grid of cubes, each split into six
/// tetrahedra. Faces point towards greater values.
template <typename Field>
Shape Isosurface(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double step,
                 Field field) {
  Shape shape;
  const Eigen::Vector3i count = ((high - low) / step).array().ceil().matrix().template cast<int>();
  const auto position = [&](const Eigen::Vector3i& g) {
    return Eigen::Vector3d(low + step * g.cast<double>());
  };
  std::map<std::array<int, 3>, double> values;
  const auto value = [&](const Eigen::Vector3i& g) {
    const auto [at, is_new] = values.try_emplace({g.x(), g.y(), g.z()}, 0.0);
    if (is_new) at->second = field(position(g));
    return at->second;
  };
  std::map<std::array<int, 6>, std::uint32_t> vertices;
  const auto vertex = [&](Eigen::Vector3i a, Eigen::Vector3i b) {
    if (std::lexicographical_compare(b.data(), b.data() + 3, a.data(), a.data() + 3)) {
      std::swap(a, b);
    }
    const auto [at, is_new] = vertices.try_emplace({a.x(), a.y(), a.z(), b.x(), b.y(), b.z()},
                                                   static_cast<std::uint32_t>(shape.points.size()));
    if (is_new) {
      const double s = std::clamp(value(a) / (value(a) - value(b)), 0.05, 0.95);
      shape.points.push_back((1.0 - s) * position(a) + s * position(b));
    }
    return at->second;
  };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c,
                       const Eigen::Vector3d& out) {
    const Eigen::Vector3d n =
        (shape.points[b] - shape.points[a]).cross(shape.points[c] - shape.points[a]);
    if (n.dot(out) < 0.0) std::swap(b, c);
    shape.faces.push_back({a, b, c});
  };
  const std::vector<std::array<int, 3>> orders = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                                  {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int x = 0; x < count.x(); ++x) {
    for (int y = 0; y < count.y(); ++y) {
      for (int z = 0; z < count.z(); ++z) {
        for (const auto& order : orders) {
          std::vector<Eigen::Vector3i> in, out;
          Eigen::Vector3i g(x, y, z);
          for (int k = 0; k < 4; ++k) {
            (value(g) < 0.0 ? in : out).push_back(g);
            if (k < 3) ++g[order[static_cast<std::size_t>(k)]];
          }
          if (in.empty() || out.empty()) continue;
          const Eigen::Vector3d outward = position(out[0]) - position(in[0]);
          if (in.size() == 2) {
            const std::uint32_t a = vertex(in[0], out[0]), b = vertex(in[0], out[1]);
            const std::uint32_t c = vertex(in[1], out[1]), d = vertex(in[1], out[0]);
            add(a, b, c, outward);
            add(a, c, d, outward);
          } else {
            const bool lone_in = in.size() == 1;
            const auto& lone = lone_in ? in : out;
            const auto& rest = lone_in ? out : in;
            add(vertex(lone[0], rest[0]), vertex(lone[0], rest[1]), vertex(lone[0], rest[2]),
                outward);
          }
        }
      }
    }
  }
  return shape;
}

inline double ToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                        const Eigen::Vector3d& b) {
  const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - s * (b - a)).norm();
}

/// A ball as palm and five fingers, each bent once by about 50 degrees.
struct Hand {
  std::vector<std::array<Eigen::Vector3d, 3>> fingers;
  Shape shape;
};
inline Hand BentHand() {
  Hand hand;
  for (int k = 0; k < 5; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 5.0;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    hand.fingers.push_back({0.5 * out, 1.9 * out,
                            1.9 * out + (k % 2 == 0 ? 0.9 : 0.5) *
                                            Eigen::Vector3d(0.65 * out.x(), 0.65 * out.y(), 0.76)});
  }
  hand.shape =
      Isosurface(Eigen::Vector3d(-2.8, -2.8, -1.2), Eigen::Vector3d(2.8, 2.8, 1.4), 0.09,
                 [&](const Eigen::Vector3d& p) {
                   double d = p.norm() - 1.0;
                   for (const auto& [a, b, c] : hand.fingers) {
                     d = std::min({d, ToSegment(p, a, b) - 0.25, ToSegment(p, b, c) - 0.25});
                   }
                   return d;
                 });
  return hand;
}

inline geometry::TriangleMesh Tetrahedron() {
  return {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

/// Signed distances to a mug: a cup about z, and half a ring as handle at its side.
inline constexpr double kMugInner = 0.8, kMugOuter = 0.9, kMugFloor = 0.15, kMugTall = 2.0;
inline double ToCup(const Eigen::Vector3d& p) {
  const double r = p.head<2>().norm();
  const double solid = std::max({r - kMugOuter, -p.z(), p.z() - kMugTall});
  return std::max(solid, -std::max(r - kMugInner, kMugFloor - p.z()));
}
inline double ToHandle(const Eigen::Vector3d& p, double girth_radius) {
  const Eigen::Vector3d q = p - Eigen::Vector3d(kMugOuter - 0.05, 0.0, 1.0);
  return std::max(std::hypot(std::hypot(q.x(), q.z()) - 0.55, q.y()) - girth_radius, -q.x());
}

inline Eigen::Vector3d FaceCenter(const Shape& shape, std::size_t f) {
  const auto& [a, b, c] = shape.faces[f];
  return (shape.points[a] + shape.points[b] + shape.points[c]) / 3.0;
}

/// Two copies of a shape, the second one shifted by 9 along x.
inline Shape Twice(const Shape& one) {
  Shape two = one;
  const auto n = static_cast<std::uint32_t>(one.points.size());
  for (const auto& p : one.points) two.points.emplace_back(p + Eigen::Vector3d(9.0, 0.0, 0.0));
  for (const auto& [a, b, c] : one.faces) two.faces.push_back({a + n, b + n, c + n});
  return two;
}

}  // namespace rangegrasp::parts::samples
