#include "parts/function/description.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "geometry/graph.h"
#include "geometry/mesh.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

// ---- water ----

constexpr double kUnseen = -std::numeric_limits<double>::infinity();
constexpr int kCells = 24;  ///< along the longer side of a height map

/// Height map of an upper side, surrounded by empty cells.
struct Heights {
  int columns = 0, rows = 0;
  double cell = 0.0;
  std::vector<double> z;

  int At(int i, int j) const { return j * columns + i; }
};

Heights UpperSide(geometry::PointSpan points, const Vector3d& up) {
  const Vector3d u = up.unitOrthogonal();
  const Vector3d v = up.cross(u);
  Eigen::AlignedBox2d box;
  for (const Vector3d& p : points) box.extend(Eigen::Vector2d(u.dot(p), v.dot(p)));
  Heights heights;
  heights.cell = box.sizes().maxCoeff() / kCells;
  if (!(heights.cell > 0.0)) return heights;
  heights.columns = 3 + static_cast<int>(box.sizes().x() / heights.cell);
  heights.rows = 3 + static_cast<int>(box.sizes().y() / heights.cell);
  heights.z.assign(heights.columns * heights.rows, kUnseen);
  for (const Vector3d& p : points) {
    const auto i = 1 + static_cast<int>((u.dot(p) - box.min().x()) / heights.cell);
    const auto j = 1 + static_cast<int>((v.dot(p) - box.min().y()) / heights.cell);
    double& z = heights.z[heights.At(i, j)];
    z = std::max(z, up.dot(p));
  }
  return heights;
}

/// Water level over each cell.
std::vector<double> Levels(const Heights& heights) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  std::vector<double> level(heights.z.size(), 0.0);
  std::vector<bool> seen(heights.z.size(), false);
  seen[0] = true;
  level[0] = kUnseen;
  front.emplace(kUnseen, 0);
  while (!front.empty()) {
    const auto [water, at] = front.top();
    front.pop();
    const int i = at % heights.columns, j = at / heights.columns;
    for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      if (i + di < 0 || j + dj < 0 || i + di >= heights.columns || j + dj >= heights.rows) continue;
      const int next = heights.At(i + di, j + dj);
      if (seen[next]) continue;
      seen[next] = true;
      level[next] = std::max(water, heights.z[next]);
      front.emplace(level[next], next);
    }
  }
  return level;
}

// ---- measures of a part ----

/// Samples of a part's surface with their weights: all points of a cloud, or points of a mesh at
/// most `spacing` apart.
struct Samples {
  Points points;
  std::vector<double> weight;

  void Add(const Vector3d& p, double w) {
    points.push_back(p);
    weight.push_back(w);
  }
};

/// A longest edge this many times longer than the height over it: a triangle that is no thinner is
/// sampled evenly with little waste.
constexpr double kThin = 3.0;

/// Samples a triangle evenly. A thin one is first cut across: its samples would be as dense across
/// as along, millions for a cylinder made of strips.
void SampleTriangle(const std::array<Vector3d, 3>& corners, double spacing, Samples& samples) {
  const auto side = [&](int k) { return (corners[(k + 1) % 3] - corners[k]).norm(); };
  const int longest = side(0) >= side(1) && side(0) >= side(2) ? 0 : side(1) >= side(2) ? 1 : 2;
  const double length = side(longest);
  const Vector3d& a = corners[0];
  const Vector3d b = corners[1] - a;
  const Vector3d c = corners[2] - a;
  const double twice_area = b.cross(c).norm();
  if (length > spacing && kThin * twice_area < length * length) {
    const Vector3d &p = corners[longest], &q = corners[(longest + 1) % 3];
    const Vector3d &apex = corners[(longest + 2) % 3], middle = 0.5 * (p + q);
    SampleTriangle({p, middle, apex}, spacing, samples);
    SampleTriangle({middle, q, apex}, spacing, samples);
    return;
  }
  const int n = std::max(1, static_cast<int>(std::ceil(length / spacing)));
  const double weight = 0.5 * twice_area / (n * n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      samples.Add(a + (i + 1.0 / 3.0) / n * b + (j + 1.0 / 3.0) / n * c, weight);
      if (i + j + 1 == n) continue;
      samples.Add(a + (i + 2.0 / 3.0) / n * b + (j + 2.0 / 3.0) / n * c, weight);
    }
  }
}

std::vector<Samples> SampleParts(const Shape& shape, const Segmentation& segmentation) {
  // Half a cell of the water grid, for a part a fifth as large as the whole.
  const double spacing = geometry::BoundsOf(shape.points).diagonal().norm() / 240.0;
  std::vector<Samples> samples(segmentation.parts);
  for (std::size_t i = 0; i < shape.Elements(); ++i) {
    Samples& part = samples[segmentation.label[i]];
    if (shape.IsMesh()) {
      const auto& [a, b, c] = shape.faces[i];
      SampleTriangle({shape.points[a], shape.points[b], shape.points[c]}, spacing, part);
    } else {
      part.Add(shape.points[i], 1.0);
    }
  }
  return samples;
}

/// Number of joints: seams that share an end belong to one joint.
int Joints(const std::vector<Edge>& seams) {
  std::map<std::uint32_t, std::uint32_t> number;
  for (const Edge& seam : seams) {
    for (const std::uint32_t end : seam) {
      number.try_emplace(end, static_cast<std::uint32_t>(number.size()));
    }
  }
  geometry::UnionFind sets(number.size());
  auto joints = static_cast<int>(number.size());
  for (const Edge& seam : seams) {
    if (sets.Unite(number[seam[0]], number[seam[1]])) --joints;
  }
  return joints;
}

void DescribeNeighbors(const Shape& shape, const Labels& label,
                       std::vector<PartDescription>& parts) {
  // Seams between each two parts: edges of a mesh, links between the points of a cloud.
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Edge>> between;
  const auto add = [&](std::uint32_t a, std::uint32_t b, const Edge& seam) {
    if (label[a] != label[b]) between[{label[a], label[b]}].push_back(seam);
  };
  if (shape.IsMesh()) {
    const FaceGraph graph = BuildFaceGraph(shape);
    ForEachLink(graph, [&](std::uint32_t f, std::uint32_t g, std::uint32_t k) {
      add(f, g, graph.edge[k]);
    });
  } else {
    ForEachLink(BuildVertexGraph(shape), [&](std::uint32_t p, std::uint32_t q, std::uint32_t) {
      add(p, q, {p, q});
    });
  }
  for (const auto& [pair, seams] : between) {
    PartNeighbor& neighbor =
        parts[pair.first].neighbors.emplace_back(PartNeighbor{pair.second, 0.0, Joints(seams)});
    for (const Edge& seam : seams) {
      if (shape.IsMesh()) neighbor.border += LengthOf(shape.points, seam);
    }
  }
}

void DescribeExtents(const Samples& samples, PartDescription& part) {
  double weight = 0.0;
  part.center = Vector3d::Zero();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    part.center += samples.weight[i] * samples.points[i];
    weight += samples.weight[i];
  }
  part.center /= weight;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Vector3d d = samples.points[i] - part.center;
    covariance += samples.weight[i] * d * d.transpose();
  }
  part.axes = base::SymmetricEigen(covariance).vectors.rowwise().reverse();
  part.axes.col(2) = part.axes.col(0).cross(part.axes.col(1));
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : samples.points) box.extend(Vector3d(part.axes.transpose() * p));
  part.extents = box.sizes();
}

/// In a part alone, water would also stand in the stump where a limb was cut off. It must therefore
/// stand in the whole shape, too.
void PourInto(const Samples& samples, const Points& whole, std::vector<Vector3d> directions,
              PartDescription& part) {
  for (int k = 0; k < 3; ++k) directions.emplace_back(part.axes.col(k));
  for (const Vector3d& direction : directions) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d up = sign * direction;
      part.holds =
          std::max(part.holds, std::min(HeldWater(samples.points, up), HeldWater(whole, up)));
    }
  }
}

/// The first of the points that are farthest in a direction. std::ranges::max_element would compute
/// two projections per point, and most of the time of a description is spent here.
const Vector3d& FarthestIn(const Vector3d& direction, const Points& points) {
  std::size_t farthest = 0;
  double most = direction.dot(points[0]);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double along = direction.dot(points[i]);
    if (!(along > most)) continue;
    most = along;
    farthest = i;
  }
  return points[farthest];
}

/// Convex hull of the points that are farthest in directions all around (a spiral on the sphere).
/// The hull of all points takes seconds for a round surface, and no decision depends on the
/// difference.
geometry::TriangleMesh RoughHull(const Points& points) {
  constexpr int kDirections = 300;
  Points farthest;
  for (int k = 0; k < kDirections; ++k) {
    const Vector3d direction = SpiralDirection(k, 1.0 - (2.0 * k + 1.0) / kDirections);
    farthest.push_back(FarthestIn(direction, points));
  }
  return geometry::ConvexHull(farthest);
}

int JointsWith(const PartDescription& part, std::int32_t other) {
  const auto found = std::ranges::find(part.neighbors, other, &PartNeighbor::label);
  return found == part.neighbors.end() ? 0 : found->joints;
}

/// Minimum fraction of all elements for a container; less is an ear, whatever it would hold.
constexpr double kMinShare = 0.2;

void AssignFunctions(const Shape& shape, const Segmentation& segmentation,
                     const std::vector<Samples>& samples, const FunctionOptions& options,
                     std::vector<PartDescription>& parts) {
  const auto elements_of = [&](std::int32_t label) {
    return static_cast<double>(std::ranges::count(segmentation.label, label));
  };
  const auto hull_of = [&](const PartDescription& part) {
    return RoughHull(samples[part.label].points);
  };
  auto container = std::ranges::max_element(parts, {}, &PartDescription::holds);
  geometry::TriangleMesh hull = hull_of(*container);
  const double share =
      elements_of(container->label) / static_cast<double>(segmentation.label.size());
  if (!hull.triangles.empty() && share >= kMinShare &&
      container->holds >= options.min_held * geometry::Volume(hull)) {
    container->function = PartFunction::kContainer;
  } else {
    if (!options.one_view) return;
    container = parts.begin();
    hull = hull_of(*container);
  }
  const double size = container->extents.minCoeff();
  const int joints = options.one_view ? 0 : shape.IsMesh() ? 2 : 1;
  for (PartDescription& part : parts) {
    if (part.label == container->label || JointsWith(part, container->label) < joints) continue;
    if (part.extents.minCoeff() > options.max_thickness * size) continue;
    if (elements_of(part.label) > options.max_share * elements_of(container->label)) continue;
    // Half of the points or more protrude from the hull by this distance.
    const double out = base::UpperMedianOf(HeightsAbove(hull, samples[part.label].points));
    if (std::max(0.0, out) >= options.min_out * size) part.function = PartFunction::kHandle;
  }
}

}  // namespace

double HeldWater(geometry::PointSpan points, const Vector3d& up) {
  const Heights heights = UpperSide(points, up);
  if (heights.z.empty()) return 0.0;
  const std::vector<double> level = Levels(heights);
  double lowest = std::numeric_limits<double>::infinity();  // lowest seen cell that holds water
  for (std::size_t k = 0; k < level.size(); ++k) {
    if (heights.z[k] > kUnseen && level[k] > heights.z[k]) lowest = std::min(lowest, heights.z[k]);
  }
  double volume = 0.0;
  for (std::size_t k = 0; k < level.size(); ++k) {
    if (level[k] == kUnseen) continue;
    const double floor = heights.z[k] > kUnseen ? heights.z[k] : std::min(lowest, level[k]);
    volume += (level[k] - floor) * heights.cell * heights.cell;
  }
  return volume;
}

std::vector<PartDescription> DescribeParts(const Shape& shape, const Segmentation& segmentation,
                                           const FunctionOptions& options) {
  const std::vector<Samples> samples = SampleParts(shape, segmentation);
  Points whole;
  for (const Samples& part : samples) {
    whole.insert(whole.end(), part.points.begin(), part.points.end());
  }
  std::vector<PartDescription> parts(samples.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p].label = static_cast<std::int32_t>(p);
    DescribeExtents(samples[p], parts[p]);
    PourInto(samples[p], whole, options.up, parts[p]);
    if (!shape.IsMesh()) continue;
    for (const double weight : samples[p].weight) parts[p].area += weight;
  }
  DescribeNeighbors(shape, segmentation.label, parts);
  AssignFunctions(shape, segmentation, samples, options, parts);
  return parts;
}

}  // namespace rangegrasp::parts
