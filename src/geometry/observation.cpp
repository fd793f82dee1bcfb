#include "geometry/observation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "base/statistics.h"

namespace rangegrasp::geometry {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kMaxCells = 1e8;  // 100 MB

/// The part of a line inside a box, as fractions of the line; false if there is none.
bool Clip(const Vector3d& from, const Vector3d& way, const Vector3d& low, const Vector3d& high,
          double& enter, double& leave) {
  enter = 0.0;
  leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (way[axis] == 0.0) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - from[axis]) / way[axis];
    const double b = (high[axis] - from[axis]) / way[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave;
}

void AddQuad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
             TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

}  // namespace

const Vector3d& RangeImage::OriginOf(std::size_t index) const {
  if (origins_C.size() == 1) return origins_C.front();
  if (samples < 1 || origins_C.size() != static_cast<std::size_t>(profiles)) {
    throw std::invalid_argument(
        fmt::format("RangeImage: {} origins for {} profiles; one is needed, or one a profile",
                    origins_C.size(), profiles));
  }
  return origins_C[index / static_cast<std::size_t>(samples)];
}

PointCloud ToCloud(const RangeImage& image) {
  PointCloud cloud;
  std::ranges::copy_if(image.points_C, std::back_inserter(cloud.points),
                       [](const Vector3d& p) { return p.allFinite(); });
  return cloud;
}

double MedianSpacing(const RangeImage& image) {
  std::vector<double> distances;
  for (int profile = 0; profile < image.profiles; ++profile) {
    for (int sample = 0; sample < image.samples; ++sample) {
      const Vector3d& point = image.points_C[image.Index(profile, sample)];
      double sum = 0.0;
      int neighbors = 0;
      const auto take = [&](const Vector3d& neighbor) {
        const double distance = (neighbor - point).norm();  // NaN if one was not measured
        if (!(distance >= 0.0)) return;
        sum += distance;
        ++neighbors;
      };
      if (sample + 1 < image.samples) take(image.points_C[image.Index(profile, sample + 1)]);
      if (profile + 1 < image.profiles) take(image.points_C[image.Index(profile + 1, sample)]);
      if (neighbors > 0) distances.push_back(sum / neighbors);
    }
  }
  return distances.empty() ? 0.0 : base::MedianOf(std::move(distances));
}

SeenSpace::SeenSpace(const Eigen::AlignedBox3d& box_C, double cell_m, const Observation& seen)
    : low_C_(box_C.min()), cell_m_(cell_m) {
  const Vector3d cells = (box_C.sizes() / cell_m).array().floor();
  if (!(cell_m > 0.0) || !cells.allFinite() || !(cells.minCoeff() >= 1.0) ||
      !(cells.prod() <= kMaxCells)) {
    throw std::invalid_argument("SeenSpace: the box must hold 1 to 1e8 cells");
  }
  size_ = cells.cast<int>();
  cells_.assign(static_cast<std::size_t>(cells.prod()), Cell::kUnseen);
  for (const View& view : seen.views) Add(view);
}

std::optional<Vector3i> SeenSpace::CellOf(const Vector3d& p_C) const {
  const Vector3i cell = ((p_C - low_C_) / cell_m_).array().floor().cast<int>();
  if ((cell.array() < 0).any() || (cell.array() >= size_.array()).any()) return std::nullopt;
  return cell;
}

Vector3d SeenSpace::MiddleOf(const Vector3i& cell) const {
  return low_C_ + cell_m_ * (cell.cast<double>().array() + 0.5).matrix();
}

double SeenSpace::UnseenVolume() const {
  return static_cast<double>(std::count(cells_.begin(), cells_.end(), Cell::kUnseen)) * cell_m_ *
         cell_m_ * cell_m_;
}

/// Visits the cells along the line in order, with the distances [m] from `from_C` to where it
/// enters and leaves each, as long as visit returns true (Amanatides and Woo 1987).
template <typename Visit>
void SeenSpace::Walk(const Vector3d& from_C, const Vector3d& to_C, const Visit& visit) const {
  const Vector3d way = to_C - from_C;
  double enter, leave;
  if (!Clip(from_C, way, low_C_, low_C_ + cell_m_ * size_.cast<double>(), enter, leave)) return;
  const double length_m = way.norm();
  const Vector3d start = (from_C + enter * way - low_C_) / cell_m_;
  Vector3i cell = start.array().floor().cast<int>();
  cell = cell.cwiseMax(0).cwiseMin(size_ - Vector3i::Ones());
  Vector3d next, each;  // fractions of the line: at the next face, between faces
  for (int axis = 0; axis < 3; ++axis) {
    const double along = way[axis] / cell_m_;
    const double face = cell[axis] + (along > 0.0 ? 1.0 : 0.0);
    each[axis] = along == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / std::abs(along);
    next[axis] = along == 0.0 ? each[axis] : enter + (face - start[axis]) / along;
  }
  for (double in = enter;;) {
    int axis;
    const double out = next.minCoeff(&axis);
    if (!visit(cell, in * length_m, std::min(out, leave) * length_m) || out >= leave) return;
    in = out;
    cell[axis] += way[axis] > 0.0 ? 1 : -1;
    if (cell[axis] < 0 || cell[axis] >= size_[axis]) return;
    next[axis] += each[axis];
  }
}

void SeenSpace::Add(const View& view) {
  const RangeImage& image = view.image;
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    const Vector3d& p_C = image.points_C[i];
    if (!p_C.allFinite()) continue;
    const Vector3d& origin_C = image.OriginOf(i);
    const double free_m = (p_C - origin_C).norm() - cell_m_;
    Walk(origin_C, p_C, [&](const Vector3i& cell, double, double out_m) {
      if (out_m > free_m) return false;
      Cell& state = cells_[Index(cell)];
      if (state == Cell::kUnseen) state = Cell::kFree;
      return true;
    });
    if (const auto cell = CellOf(p_C)) cells_[Index(*cell)] = Cell::kSurface;
  }
}

double SeenSpace::GainFrom(const base::Pose& X_CS, const Field& field,
                           const Eigen::AlignedBox3d& region_C, double depth_m) const {
  const Vector3d origin_C = X_CS.translation();
  // Neighboring rays are one cell apart at the center of the region.
  const double step = cell_m_ / std::max((region_C.center() - origin_C).norm(), cell_m_);
  std::vector<float> chances(cells_.size(), 0.0F);
  for (double down = -field.half_down_rad; down <= field.half_down_rad; down += step) {
    for (double right = -field.half_right_rad; right <= field.half_right_rad; right += step) {
      const Vector3d ray_S = Vector3d(std::tan(right), std::tan(down), 1.0).normalized();
      const Vector3d end_C = origin_C + field.far_m * (X_CS.linear() * ray_S);
      double chance = 1.0;
      Walk(origin_C, end_C, [&](const Vector3i& cell, double in, double out) {
        const std::size_t i = Index(cell);
        if (cells_[i] == Cell::kSurface) return out < field.near_m;
        if (cells_[i] == Cell::kFree || out < field.near_m) return true;
        if (region_C.contains(MiddleOf(cell))) {
          chances[i] = std::max(chances[i], static_cast<float>(chance));
        }
        chance *= std::exp(-(out - in) / depth_m);
        return chance > 0.01;  // the rest is negligible
      });
    }
  }
  return std::accumulate(chances.begin(), chances.end(), 0.0) * cell_m_ * cell_m_ * cell_m_;
}

TriangleMesh SeenSpace::Ceiling(double margin_m) const {
  TriangleMesh mesh;
  const auto top = [&](int x, int y) {
    const bool outside = x < 0 || y < 0 || x >= size_.x() || y >= size_.y();
    int cells = 0;
    while (!outside && cells < size_.z() && At({x, y, cells}) != Cell::kFree) ++cells;
    return low_C_.z() + (cells > 0 ? cells * cell_m_ + margin_m : 0.0);
  };
  for (int y = 0; y <= size_.y(); ++y) {
    for (int x = 0; x <= size_.x(); ++x) {
      const double x0 = low_C_.x() + x * cell_m_, x1 = x0 + cell_m_;
      const double y0 = low_C_.y() + y * cell_m_, y1 = y0 + cell_m_;
      const double here = top(x, y), left = top(x - 1, y), front = top(x, y - 1);
      if (here > low_C_.z()) {
        AddQuad({x0, y0, here}, {x1, y0, here}, {x1, y1, here}, {x0, y1, here}, mesh);
      }
      if (here != left) {
        AddQuad({x0, y0, left}, {x0, y1, left}, {x0, y1, here}, {x0, y0, here}, mesh);
      }
      if (here != front) {
        AddQuad({x0, y0, front}, {x1, y0, front}, {x1, y0, here}, {x0, y0, here}, mesh);
      }
    }
  }
  return mesh;
}

}  // namespace rangegrasp::geometry
