#include "grasp/hand_profiles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/shape.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr int kSides = 20;  // of a tessellated capsule: 0.12 mm below the true surface at 10 mm radius

/// A height field being drawn: coordinates u, v of the points span the grid, w is kept.
struct Canvas {
  int u, v, w;
  const Grid& grid;
  bool largest;
  std::vector<float>& field;
};

void Draw(const Vector3d& a, const Vector3d& b, const Vector3d& c, Canvas& canvas) {
  const Grid& g = canvas.grid;
  const Eigen::Vector2d p(a[canvas.u], a[canvas.v]);
  const Eigen::Vector2d e(b[canvas.u] - p.x(), b[canvas.v] - p.y());
  const Eigen::Vector2d f(c[canvas.u] - p.x(), c[canvas.v] - p.y());
  const double area = e.x() * f.y() - e.y() * f.x();
  if (std::abs(area) < 1e-14) return;
  const auto cell = [&](double x, double x0) {
    return static_cast<int>(std::floor((x - x0) / g.cell_m - 0.5));
  };
  const double u_min = p.x() + std::min({0.0, e.x(), f.x()});
  const double u_max = p.x() + std::max({0.0, e.x(), f.x()});
  const double v_min = p.y() + std::min({0.0, e.y(), f.y()});
  const double v_max = p.y() + std::max({0.0, e.y(), f.y()});
  for (int j = std::max(0, cell(v_min, g.v0_m)); j <= std::min(g.nv - 1, cell(v_max, g.v0_m) + 1); ++j) {
    for (int i = std::max(0, cell(u_min, g.u0_m)); i <= std::min(g.nu - 1, cell(u_max, g.u0_m) + 1);
         ++i) {
      const double x = g.u0_m + (i + 0.5) * g.cell_m - p.x();
      const double y = g.v0_m + (j + 0.5) * g.cell_m - p.y();
      const double s = (x * f.y() - y * f.x()) / area;
      const double t = (e.x() * y - e.y() * x) / area;
      if (s < -1e-9 || t < -1e-9 || s + t > 1.0 + 1e-9) continue;
      const auto w = static_cast<float>(a[canvas.w] + s * (b[canvas.w] - a[canvas.w]) +
                                        t * (c[canvas.w] - a[canvas.w]));
      float& kept = canvas.field[static_cast<std::size_t>(j * g.nu + i)];
      kept = canvas.largest ? std::max(kept, w) : std::min(kept, w);
    }
  }
}

void Draw(const geometry::Points& vertices, const geometry::TriangleMesh& mesh, Canvas& canvas) {
  for (const auto& [a, b, c] : mesh.triangles) Draw(vertices[a], vertices[b], vertices[c], canvas);
}

Grid GridOver(const std::vector<geometry::Points>& parts, int u, int v, double cell_m) {
  double u_min = 1e9, v_min = 1e9, u_max = -1e9, v_max = -1e9;
  for (const geometry::Points& points : parts) {
    for (const Vector3d& p : points) {
      u_min = std::min(u_min, p[u]);
      u_max = std::max(u_max, p[u]);
      v_min = std::min(v_min, p[v]);
      v_max = std::max(v_max, p[v]);
    }
  }
  Grid grid;
  grid.cell_m = cell_m;
  grid.u0_m = u_min;
  grid.v0_m = v_min;
  grid.nu = std::max(0, static_cast<int>(std::ceil((u_max - u_min) / cell_m)));
  grid.nv = std::max(0, static_cast<int>(std::ceil((v_max - v_min) / cell_m)));
  return grid;
}

}  // namespace

std::size_t StateAtGap(const robot::HandModel& hand, double gap_m) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < hand.states.size(); ++i) {
    if (hand.states[i].gap_m >= gap_m && hand.states[i].gap_m < hand.states[best].gap_m) best = i;
  }
  return best;
}

HandProfiles::HandProfiles(const robot::HandModel& hand) : hand_(hand) {
  if (hand.states.empty()) throw std::invalid_argument("hand model: no states");
  for (const robot::HandModel::State& state : hand.states) {
    if (state.shapes.size() != hand.states[0].shapes.size() ||
        state.is_finger.size() != state.shapes.size() ||
        state.is_thumb.size() != state.shapes.size()) {
      throw std::invalid_argument("hand model: states differ in their shapes");
    }
  }
  for (geometry::Shape shape : hand.states[0].shapes) {
    shape.X_BS = core::Pose::Identity();
    meshes_.push_back(geometry::Tessellate(shape, kSides));
  }
}

core::Pose HandProfiles::X_TH(const robot::HandModel& hand, double pitch_rad) {
  return Eigen::AngleAxisd(-pitch_rad, Vector3d::UnitY()) * hand.X_HG_tip.inverse();
}

geometry::Points HandProfiles::Vertices_T(double pitch_rad, std::size_t state,
                                          std::size_t shape) const {
  const core::Pose X_TS = X_TH(hand_, pitch_rad) * hand_.states[state].shapes[shape].X_BS;
  geometry::Points vertices = meshes_[shape].vertices;
  for (Vector3d& p : vertices) p = X_TS * p;
  return vertices;
}

const HandProfiles::Inner& HandProfiles::InnerSide(double pitch_rad, std::size_t state) {
  const Key key{std::lround(pitch_rad * 1e6), state};
  if (const auto found = inner_.find(key); found != inner_.end()) return found->second;
  const robot::HandModel::State& s = hand_.states[state];
  std::vector<geometry::Points> parts;
  std::vector<std::size_t> shapes;
  for (std::size_t i = 0; i < s.shapes.size(); ++i) {
    if (!s.is_finger[i] && !s.is_thumb[i]) continue;
    shapes.push_back(i);
    parts.push_back(Vertices_T(pitch_rad, state, i));
  }
  Inner inner;
  inner.grid = GridOver(parts, 1, 2, 0.0015);
  const auto cells = static_cast<std::size_t>(inner.grid.nu * inner.grid.nv);
  inner.finger.assign(cells, -kNone);
  inner.thumb.assign(cells, kNone);
  Canvas finger{1, 2, 0, inner.grid, true, inner.finger};
  Canvas thumb{1, 2, 0, inner.grid, false, inner.thumb};
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    Draw(parts[k], meshes_[shapes[k]], s.is_thumb[shapes[k]] ? thumb : finger);
  }
  inner.finger_min_m = 1e9;
  inner.thumb_max_m = -1e9;
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
  for (std::size_t i = 0; i < meshes_.size(); ++i) parts.push_back(Vertices_T(pitch_rad, state, i));
  Lower lower;
  lower.grid = GridOver(parts, 0, 1, 0.002);
  lower.z.assign(static_cast<std::size_t>(lower.grid.nu * lower.grid.nv), -kNone);
  Canvas canvas{0, 1, 2, lower.grid, true, lower.z};
  for (std::size_t i = 0; i < meshes_.size(); ++i) Draw(parts[i], meshes_[i], canvas);
  return lower_.emplace(key, std::move(lower)).first->second;
}

Vector3d HandProfiles::PadCenter_T(double pitch_rad, std::size_t state) const {
  const robot::HandModel::State& s = hand_.states[state];
  return X_TH(hand_, pitch_rad) * (0.5 * (s.thumb_pad_H + s.finger_pad_H));
}

double HandProfiles::Extent(double pitch_rad, std::size_t state, const Vector3d& direction_T) const {
  const core::Pose X = X_TH(hand_, pitch_rad);
  double extent = -1e9;
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const core::Pose X_TS = X * hand_.states[state].shapes[i].X_BS;
    const Vector3d direction_S = X_TS.linear().transpose() * direction_T;
    double farthest = -1e9;
    for (const Vector3d& p : meshes_[i].vertices) farthest = std::max(farthest, direction_S.dot(p));
    extent = std::max(extent, farthest + direction_T.dot(X_TS.translation()));
  }
  return extent;
}

}  // namespace rangegrasp::grasp
