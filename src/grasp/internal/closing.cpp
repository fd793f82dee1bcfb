#include "grasp/internal/closing.h"

#include <algorithm>
#include <limits>
#include <ranges>

namespace rangegrasp::grasp::internal {
namespace {

using Eigen::Vector2d;
using geometry::Points;

constexpr float kNone = std::numeric_limits<float>::infinity();
constexpr int kSides = 12;  ///< of a tessellated capsule: at most 0.3 mm below the true surface
/// Finer than the samples that the hand closes on, which are 2 mm apart. The grid of the underside,
/// which only stops the hand above the samples, has their spacing.
constexpr double kInnerCell_m = 0.0015;
constexpr double kLowerCell_m = 0.002;
/// [m^2] Twice the area below which a facet is seen edge on and covers no cell: rounding.
constexpr double kMinArea_m2 = 1e-14;
/// Share of a facet's edge by which a cell's middle may lie outside, so that no cell is missed.
constexpr double kEdge = 1e-9;

/// A height field being drawn: coordinates u and v of the points span the grid, w is stored.
struct Canvas {
  int u, v, w;
  const Grid& grid;
  bool keep_max;
  std::vector<float>& field;
};

void Draw(const Vector3d& a, const Vector3d& b, const Vector3d& c, Canvas& canvas) {
  const Grid& g = canvas.grid;
  const Vector2d p(a[canvas.u], a[canvas.v]);
  const Vector2d e(b[canvas.u] - p.x(), b[canvas.v] - p.y());
  const Vector2d f(c[canvas.u] - p.x(), c[canvas.v] - p.y());
  const double area = e.x() * f.y() - e.y() * f.x();
  // The near side of a shape hides its far side; its faces are counter-clockwise from outside.
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

void Draw(const Points& vertices, const TriangleMesh& mesh, Canvas& canvas) {
  for (const auto& [a, b, c] : mesh.triangles) Draw(vertices[a], vertices[b], vertices[c], canvas);
}

Grid GridOver(const Vector2d& lower, const Vector2d& upper, double cell_m) {
  const auto cells = [&](double extent_m) {
    return std::max(0, static_cast<int>(std::ceil(extent_m / cell_m)));
  };
  return {lower.x(), lower.y(), cell_m, cells(upper.x() - lower.x()), cells(upper.y() - lower.y())};
}

/// Samples this near to a pad at contact belong to it: the glove's 1.5 mm yields, and samples are 2
/// mm apart. Larger: normals around the corner count; smaller: one sample is the contact.
constexpr double kPatch_m = 0.003;
/// [m^2] Gives samples right at the patch's edge a weight.
constexpr double kMinWeight_m2 = 1e-12;

struct Sample {
  double x_T;
  std::size_t cell;   ///< in the inner side's grid
  std::size_t index;  ///< in the given points
};

struct Limits {
  double a = -kInfinity;
  double b = kInfinity;
  bool Overlap() const { return a > b; }
};

double At(const std::vector<float>& field, std::size_t cell) {
  return static_cast<double>(field[cell]);
}

/// The samples between the open jaws, where fingers or thumb may pass.
std::vector<Sample> Between(const HandProfiles::Inner& open, std::span<const Vector3d> points_A,
                            const Vector3d& origin_A) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < points_A.size(); ++i) {
    const Vector3d p = points_A[i] - origin_A;
    if (p.x() < open.finger_min_m || p.x() > open.thumb_max_m) continue;
    const int at = open.grid.Cell(p.y(), p.z());
    if (at < 0) continue;
    const auto cell = static_cast<std::size_t>(at);
    if (p.x() < At(open.finger, cell) || p.x() > At(open.thumb, cell)) continue;
    samples.push_back({p.x(), cell, i});
  }
  return samples;
}

Limits LimitsOf(const HandProfiles::Inner& inner, const std::vector<Sample>& samples) {
  Limits limits;
  for (const Sample& s : samples) {
    limits.a = std::max(limits.a, At(inner.finger, s.cell) - s.x_T);
    limits.b = std::min(limits.b, At(inner.thumb, s.cell) - s.x_T);
  }
  return limits;
}

/// The contact of one side: the mean of the samples within the glove's softness, weighted by the
/// square of their depth in it. `side` is -1 for the fingers, at smaller x, and +1 for the thumb.
struct Patch {
  Vector3d point = Vector3d::Zero();
  Vector3d out = Vector3d::Zero();
  int size = 0;
};
Patch PatchOf(const std::vector<float>& field, const std::vector<Sample>& samples,
              std::span<const Vector3d> points_A, std::span<const Vector3d> normals_A,
              double foremost, double side) {
  Patch patch;
  double weights = 0.0;
  for (const Sample& s : samples) {
    const double behind = side * (At(field, s.cell) - s.x_T - foremost);
    if (behind > kPatch_m) continue;
    const double weight = (kPatch_m - behind) * (kPatch_m - behind) + kMinWeight_m2;
    const Vector3d& n = normals_A[s.index];
    patch.point += weight * points_A[s.index];
    patch.out += weight * (n.x() * side < 0.0 ? Vector3d(-n) : n);
    weights += weight;
    ++patch.size;
  }
  patch.point /= weights;
  patch.out.normalize();
  return patch;
}

}  // namespace

HandProfiles::HandProfiles(const HandModel& hand) : hand_(hand) {
  for (geometry::Shape shape : hand.states[0].shapes) {
    shape.X_BS = Pose::Identity();
    meshes_.push_back(geometry::Tessellate(shape, kSides));
  }
}

Pose HandProfiles::X_TH(const HandModel& hand, double pitch_rad) {
  return Eigen::AngleAxisd(-pitch_rad, Vector3d::UnitY()) * hand.X_HG_tip.inverse();
}

Points HandProfiles::Vertices_T(double pitch_rad, std::size_t state, std::size_t shape) const {
  const Pose X_TS = X_TH(hand_, pitch_rad) * hand_.states[state].shapes[shape].X_BS;
  Points vertices = meshes_[shape].vertices;
  for (Vector3d& p : vertices) p = X_TS * p;
  return vertices;
}

Grid HandProfiles::InnerGrid(double pitch_rad) const {
  const Pose X = X_TH(hand_, pitch_rad);
  Vector2d lower(kInfinity, kInfinity);
  Vector2d upper(-kInfinity, -kInfinity);
  for (const HandModel::State& s : hand_.states) {
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
  const HandModel::State& s = hand_.states[state];
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
  const auto is_there = [](float x) { return std::isfinite(x); };
  for (const float x : inner.finger | std::views::filter(is_there)) {
    inner.finger_min_m = std::min<double>(inner.finger_min_m, x);
  }
  for (const float x : inner.thumb | std::views::filter(is_there)) {
    inner.thumb_max_m = std::max<double>(inner.thumb_max_m, x);
  }
  return inner_.emplace(key, std::move(inner)).first->second;
}

const HandProfiles::Lower& HandProfiles::LowerSide(double pitch_rad, std::size_t state) {
  const Key key{std::lround(pitch_rad * 1e6), state};
  if (const auto found = lower_.find(key); found != lower_.end()) return found->second;
  std::vector<Points> parts;
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    parts.push_back(Vertices_T(pitch_rad, state, i));
    box.extend(geometry::BoundsOf(parts.back()));
  }
  Lower lower;
  lower.grid = GridOver(box.min().head<2>(), box.max().head<2>(), kLowerCell_m);
  lower.z.assign(static_cast<std::size_t>(lower.grid.nu * lower.grid.nv), -kNone);
  Canvas canvas{0, 1, 2, lower.grid, true, lower.z};
  for (std::size_t i = 0; i < meshes_.size(); ++i) Draw(parts[i], meshes_[i], canvas);
  return lower_.emplace(key, std::move(lower)).first->second;
}

Vector3d HandProfiles::PadCenter_T(double pitch_rad, std::size_t state) const {
  const HandModel::State& s = hand_.states[state];
  return X_TH(hand_, pitch_rad) * (0.5 * (s.thumb_pad_H + s.finger_pad_H));
}

Vector3d HandProfiles::ToolCenter_T(double pitch_rad, std::size_t state, bool power) const {
  const HandModel::State& s = hand_.states[state];
  return X_TH(hand_, pitch_rad) * (power ? s.power_center_H : s.tip_center_H);
}

double HandProfiles::Extent(double pitch_rad, std::size_t state,
                            const Vector3d& direction_T) const {
  const Pose X = X_TH(hand_, pitch_rad);
  double extent = -kInfinity;
  for (const geometry::Shape& shape : hand_.states[state].shapes) {
    extent = std::max(extent, geometry::Support(shape, X, direction_T));
  }
  return extent;
}

std::optional<Closing> CloseOn(HandProfiles& hand, double pitch_rad, std::size_t open_state,
                               std::span<const Vector3d> points_A,
                               std::span<const Vector3d> normals_A, double sample_area_m2,
                               const Vector3d& origin_A) {
  const std::vector<Sample> samples =
      Between(hand.InnerSide(pitch_rad, open_state), points_A, origin_A);
  const auto limits = [&](std::size_t s) {
    return LimitsOf(hand.InnerSide(pitch_rad, s), samples);
  };
  std::size_t free = open_state;
  std::size_t closed = hand.hand().states.size() - 1;
  Limits at_free = limits(free);
  Limits at_closed = limits(closed);
  if (at_free.Overlap() || !at_closed.Overlap()) return std::nullopt;
  while (closed - free > 1) {
    const std::size_t middle = (free + closed) / 2;
    const Limits at = limits(middle);
    (at.Overlap() ? closed : free) = middle;
    (at.Overlap() ? at_closed : at_free) = at;
  }

  Closing closing;
  // If one side met nothing in the state before, the contact is that of the closed state.
  const bool both = std::isfinite(at_free.a) && std::isfinite(at_free.b);
  const double room = at_free.b - at_free.a;
  const double f = both ? room / (room + at_closed.a - at_closed.b) : 1.0;
  const double gap_free = hand.hand().states[free].gap_m;
  const double gap_closed = hand.hand().states[closed].gap_m;
  closing.gap_m = gap_free + f * (gap_closed - gap_free);
  closing.drag_m =
      both ? at_free.a + f * (at_closed.a - at_free.a) : 0.5 * (at_closed.a + at_closed.b);
  closing.state = both && f < 0.5 ? free : closed;
  const Limits& at = closing.state == free ? at_free : at_closed;
  const HandProfiles::Inner& inner = hand.InnerSide(pitch_rad, closing.state);
  const Patch finger = PatchOf(inner.finger, samples, points_A, normals_A, at.a, -1.0);
  const Patch thumb = PatchOf(inner.thumb, samples, points_A, normals_A, at.b, 1.0);
  closing.finger_T = finger.point - origin_A;
  closing.thumb_T = thumb.point - origin_A;
  closing.finger_out_T = finger.out;
  closing.thumb_out_T = thumb.out;
  closing.contact_m2 = sample_area_m2 * (finger.size + thumb.size);
  return closing;
}

AntipodalAngles Antipodal(const Vector3d& finger, const Vector3d& finger_out, const Vector3d& thumb,
                          const Vector3d& thumb_out) {
  const Vector3d line = (thumb - finger).normalized();
  const auto angle = [](const Vector3d& u, const Vector3d& v) {
    return std::atan2(u.cross(v).norm(), u.dot(v));
  };
  return {angle(-finger_out, line), angle(thumb_out, line)};
}

}  // namespace rangegrasp::grasp::internal
