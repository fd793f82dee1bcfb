#include "grasp/hand_profiles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/support.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kSides = 12;  ///< of a tessellated capsule: at most 0.3 mm below the true surface
/// Finer than the samples that the hand closes on, which are 2 mm apart; the underside, which only
/// stops the hand above them, as fine.
constexpr double kInnerCell_m = 0.0015;
constexpr double kLowerCell_m = 0.002;
/// [m^2] twice the area of a facet seen edge on, that covers no cell: rounding.
constexpr double kMinArea_m2 = 1e-14;
/// Share of a facet's edge by which a cell's middle may lie outside, so that none falls between
/// two.
constexpr double kEdge = 1e-9;

/// A height field being drawn: coordinates u, v of the points span the grid, w is kept.
struct Canvas {
  int u, v, w;
  const Grid& grid;
  bool keep_max;
  std::vector<float>& field;
};

void Draw(const Vector3d& a, const Vector3d& b, const Vector3d& c, Canvas& canvas) {
  const Grid& g = canvas.grid;
  const Eigen::Vector2d p(a[canvas.u], a[canvas.v]);
  const Eigen::Vector2d e(b[canvas.u] - p.x(), b[canvas.v] - p.y());
  const Eigen::Vector2d f(c[canvas.u] - p.x(), c[canvas.v] - p.y());
  const double area = e.x() * f.y() - e.y() * f.x();
  // The far side of a shape, whose faces are counter-clockwise from outside, is hidden by the near
  // one.
  if ((canvas.keep_max ? area : -area) < kMinArea_m2) return;
  const auto cell = [&](double x, double x0) {
    return static_cast<int>(std::floor((x - x0) / g.cell_m - 0.5));
  };
  const double u_min = p.x() + std::min({0.0, e.x(), f.x()});
  const double u_max = p.x() + std::max({0.0, e.x(), f.x()});
  const double v_min = p.y() + std::min({0.0, e.y(), f.y()});
  const double v_max = p.y() + std::max({0.0, e.y(), f.y()});
  for (int j = std::max(0, cell(v_min, g.v0_m)); j <= std::min(g.nv - 1, cell(v_max, g.v0_m) + 1);
       ++j) {
    for (int i = std::max(0, cell(u_min, g.u0_m)); i <= std::min(g.nu - 1, cell(u_max, g.u0_m) + 1);
         ++i) {
      const double x = g.u0_m + (i + 0.5) * g.cell_m - p.x();
      const double y = g.v0_m + (j + 0.5) * g.cell_m - p.y();
      const double s = (x * f.y() - y * f.x()) / area;
      const double t = (e.x() * y - e.y() * x) / area;
      if (s < -kEdge || t < -kEdge || s + t > 1.0 + kEdge) continue;
      const auto w = static_cast<float>(a[canvas.w] + s * (b[canvas.w] - a[canvas.w]) +
                                        t * (c[canvas.w] - a[canvas.w]));
      float& kept = canvas.field[static_cast<std::size_t>(j * g.nu + i)];
      kept = canvas.keep_max ? std::max(kept, w) : std::min(kept, w);
    }
  }
}

void Draw(const geometry::Points& vertices, const geometry::TriangleMesh& mesh, Canvas& canvas) {
  for (const auto& [a, b, c] : mesh.triangles) Draw(vertices[a], vertices[b], vertices[c], canvas);
}

/// A grid that just holds the given ranges.
Grid GridOver(const Eigen::Vector2d& lower, const Eigen::Vector2d& upper, double cell_m) {
  Grid grid;
  grid.cell_m = cell_m;
  grid.u0_m = lower.x();
  grid.v0_m = lower.y();
  grid.nu = std::max(0, static_cast<int>(std::ceil((upper.x() - lower.x()) / cell_m)));
  grid.nv = std::max(0, static_cast<int>(std::ceil((upper.y() - lower.y()) / cell_m)));
  return grid;
}

}  // namespace

HandProfiles::HandProfiles(const robot::HandModel& hand) : hand_(hand) {
  robot::CheckStates(hand);
  for (geometry::Shape shape : hand.states[0].shapes) {
    shape.X_BS = base::Pose::Identity();
    meshes_.push_back(geometry::Tessellate(shape, kSides));
  }
}

base::Pose HandProfiles::X_TH(const robot::HandModel& hand, double pitch_rad) {
  return Eigen::AngleAxisd(-pitch_rad, Vector3d::UnitY()) * hand.X_HG_tip.inverse();
}

geometry::Points HandProfiles::Vertices_T(double pitch_rad, std::size_t state,
                                          std::size_t shape) const {
  const base::Pose X_TS = X_TH(hand_, pitch_rad) * hand_.states[state].shapes[shape].X_BS;
  geometry::Points vertices = meshes_[shape].vertices;
  for (Vector3d& p : vertices) p = X_TS * p;
  return vertices;
}

Grid HandProfiles::InnerGrid(double pitch_rad) const {
  const base::Pose X = X_TH(hand_, pitch_rad);
  Eigen::Vector2d lower(kFar, kFar);
  Eigen::Vector2d upper(-kFar, -kFar);
  for (const robot::HandModel::State& s : hand_.states) {
    for (std::size_t i = 0; i < s.shapes.size(); ++i) {
      if (!s.is_finger[i]) continue;
      for (int k = 0; k < 2; ++k) {
        const Vector3d axis = Vector3d::Unit(k + 1);
        lower[k] = std::min(lower[k], -geometry::Support(s.shapes[i], X, -axis));
        upper[k] = std::max(upper[k], geometry::Support(s.shapes[i], X, axis));
      }
    }
  }
  return GridOver(lower, upper, kInnerCell_m);
}

const HandProfiles::Inner& HandProfiles::InnerSide(double pitch_rad, std::size_t state) {
  const Key key{std::lround(pitch_rad * 1e6), state};
  if (const auto found = inner_.find(key); found != inner_.end()) return found->second;
  const robot::HandModel::State& s = hand_.states[state];
  auto grid = inner_grids_.find(key.first);
  if (grid == inner_grids_.end()) {
    grid = inner_grids_.emplace(key.first, InnerGrid(pitch_rad)).first;
  }
  Inner inner;
  inner.grid = grid->second;
  const auto cells = static_cast<std::size_t>(inner.grid.nu * inner.grid.nv);
  inner.finger.assign(cells, -kNone);
  inner.thumb.assign(cells, kNone);
  Canvas finger{1, 2, 0, inner.grid, true, inner.finger};
  Canvas thumb{1, 2, 0, inner.grid, false, inner.thumb};
  for (std::size_t i = 0; i < s.shapes.size(); ++i) {
    if (!s.is_finger[i]) continue;
    Draw(Vertices_T(pitch_rad, state, i), meshes_[i], s.is_thumb[i] ? thumb : finger);
  }
  inner.finger_min_m = kFar;
  inner.thumb_max_m = -kFar;
  for (const float x : inner.finger) {
    if (x != -kNone) inner.finger_min_m = std::min<double>(inner.finger_min_m, x);
  }
  for (const float x : inner.thumb) {
    if (x != kNone) inner.thumb_max_m = std::max<double>(inner.thumb_max_m, x);
  }
  return inner_.emplace(key, std::move(inner)).first->second;
}

const HandProfiles::Lower& HandProfiles::LowerSide(double pitch_rad, std::size_t state) {
  const Key key{std::lround(pitch_rad * 1e6), state};
  if (const auto found = lower_.find(key); found != lower_.end()) return found->second;
  std::vector<geometry::Points> parts;
  Vector3d low = Vector3d::Constant(kFar);
  Vector3d high = Vector3d::Constant(-kFar);
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    parts.push_back(Vertices_T(pitch_rad, state, i));
    for (const Vector3d& p : parts.back()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  Lower lower;
  lower.grid = GridOver(low.head<2>(), high.head<2>(), kLowerCell_m);
  lower.z.assign(static_cast<std::size_t>(lower.grid.nu * lower.grid.nv), -kNone);
  Canvas canvas{0, 1, 2, lower.grid, true, lower.z};
  for (std::size_t i = 0; i < meshes_.size(); ++i) Draw(parts[i], meshes_[i], canvas);
  return lower_.emplace(key, std::move(lower)).first->second;
}

Vector3d HandProfiles::PadCenter_T(double pitch_rad, std::size_t state) const {
  const robot::HandModel::State& s = hand_.states[state];
  return X_TH(hand_, pitch_rad) * (0.5 * (s.thumb_pad_H + s.finger_pad_H));
}

Vector3d HandProfiles::ToolCenter_T(double pitch_rad, std::size_t state, bool power) const {
  const robot::HandModel::State& s = hand_.states[state];
  return X_TH(hand_, pitch_rad) * (power ? s.power_center_H : s.tip_center_H);
}

double HandProfiles::Extent(double pitch_rad, std::size_t state,
                            const Vector3d& direction_T) const {
  const base::Pose X = X_TH(hand_, pitch_rad);
  double extent = -kFar;
  for (const geometry::Shape& shape : hand_.states[state].shapes) {
    extent = std::max(extent, geometry::Support(shape, X, direction_T));
  }
  return extent;
}

}  // namespace rangegrasp::grasp
