#include "parts/cloud/cloud_mesh.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "base/units.h"
#include "geometry/plane.h"
#include "mesh/solid.h"
#include "parts/cloud/internal/seen_side.h"
#include "parts/shape/shape_graph.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::KdTree;
using Neighbors = std::vector<KdTree::Neighbor>;

/// Number of points sampled: their median is known to about 4 %.
constexpr std::size_t kSamples = 1000;
/// Number of neighbors in the initial ball, from which the radius is iterated.
constexpr std::size_t kFirstNeighbors = 20;
/// Radius of the ball in spacings: about 20 points, three for each parameter of a quadric.
constexpr double kBallSpacings = 2.5;
/// Its radius in noise standard deviations. In a smaller ball the slab of points has no measurable
/// thickness, and the residual is a fraction of the radius. From 4 on it is less than a quarter.
constexpr double kBallNoises = 5.0;
/// Iterations for the ball's radius to converge.
constexpr int kSamplingRounds = 6;

/// RMS distance of the points in a ball from a fitted quadric, along the normal.
std::optional<double> QuadricResidual(const Points& points, const Neighbors& near, double radius) {
  constexpr Eigen::Index kParameters = 6;
  const auto count = static_cast<Eigen::Index>(near.size());
  if (count < 2 * kParameters) return std::nullopt;
  Vector3d mean = Vector3d::Zero();
  for (const auto& n : near) mean += points[n.index] / static_cast<double>(count);
  Matrix3d spread = Matrix3d::Zero();
  for (const auto& n : near) {
    const Vector3d d = (points[n.index] - mean) / radius;
    spread += d * d.transpose();
  }
  const Matrix3d axes = base::SymmetricEigen(spread).vectors;
  Eigen::Matrix<double, Eigen::Dynamic, kParameters> terms(count, kParameters);
  Eigen::VectorXd heights(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d at = axes.transpose() * (points[near[i].index] - mean) / radius;
    terms.row(i) << 1.0, at[1], at[2], at[1] * at[1], at[1] * at[2], at[2] * at[2];
    heights[i] = at[0];
  }
  const Eigen::VectorXd quadric =
      (terms.transpose() * terms).ldlt().solve(terms.transpose() * heights);
  return radius * std::sqrt((terms * quadric - heights).squaredNorm() /
                            static_cast<double>(count - kParameters));
}

// ---- smoothing ----

/// Required accuracy of the local plane's slope [rad]; bends at cuts are some tenths.
constexpr double kSlope = 0.1;
/// Minimum plane radius, in noise standard deviations: it must span the slab of points.
constexpr double kSmoothBallNoises = 3.0;
/// The same in spacings: fewer than five neighbors do not define a plane.
constexpr double kSmoothBallSpacings = 1.5;
/// Below this required radius, in spacings, points are as accurate as their planes would be.
constexpr double kExact = 1.2;
/// Side of the averaged cubes, in noise standard deviations: a slab has few layers of them.
constexpr double kCubeNoises = 1.5;
/// Weights of a plane are exp(-kBell r^2 / radius^2): a Gaussian of 0.4 radii.
constexpr double kBell = 3.0;
/// Steps towards the plane. Each leaves about a third of a point's distance from the surface, so
/// that a point at three noise standard deviations ends at a fiftieth of one.
constexpr int kSmoothSteps = 5;
/// Noise, relative to the cubes' side, above which their means are nearer to the surface than one
/// of their points. Below it, a mean would merge the sides of thin walls.
constexpr double kMeans = 0.5;

/// A thinned cloud; a point's weight is the number of points that it stands for.
struct Thinned {
  Points points;
  std::vector<double> weight;
};

/// For each cube of a grid the mean of its points or, if `pick`, the point nearest to its middle.
Thinned ThinOut(const Points& points, double side, bool pick) {
  struct Cube {
    Vector3d sum = Vector3d::Zero();
    double count = 0.0;
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t nearest = 0;
  };
  std::map<std::array<int, 3>, Cube> cubes;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Vector3d at = points[i] / side;
    const Eigen::Vector3i corner = at.array().floor().cast<int>();
    Cube& cube = cubes[{corner.x(), corner.y(), corner.z()}];
    cube.sum += points[i];
    cube.count += 1.0;
    const double distance = (at - corner.cast<double>() - Vector3d::Constant(0.5)).squaredNorm();
    if (distance >= cube.distance) continue;
    cube.distance = distance;
    cube.nearest = i;
  }
  Thinned thinned;
  for (const auto& [corner, cube] : cubes) {
    thinned.points.push_back(pick ? points[cube.nearest] : Vector3d(cube.sum / cube.count));
    thinned.weight.push_back(cube.count);
  }
  return thinned;
}

/// Projects p onto the plane fitted to the points around it, in several steps.
Vector3d OntoSurface(const Thinned& cloud, const Neighbors& near, const Vector3d& p,
                     double radius) {
  Vector3d at = p;
  for (int step = 0; step < kSmoothSteps; ++step) {
    double sum = 0.0;
    Vector3d mean = Vector3d::Zero();
    Matrix3d square = Matrix3d::Zero();
    for (const auto& n : near) {
      const Vector3d d = cloud.points[n.index] - at;
      const double weight =
          cloud.weight[n.index] * std::exp(-kBell * d.squaredNorm() / (radius * radius));
      sum += weight;
      mean += weight * d;
      square += weight * d * d.transpose();
    }
    mean /= sum;
    const Vector3d normal =
        base::SymmetricEigenDirect(square / sum - mean * mean.transpose()).vectors.col(0);
    at += normal * normal.dot(mean);
  }
  return at;
}

/// One point in each cube of side `kept_spacing` or larger, with the noise removed; in grid order.
Points SmoothSurface(const Points& points, const CloudSampling& sampling, double kept_spacing) {
  const auto& [spacing, noise] = sampling;
  // A plane through the points of a disc of radius r, one per area of spacing^2, has a slope error
  // of 2 noise spacing / (sqrt(pi) r^2).
  const double needed = std::max(kSmoothBallNoises * noise,
                                 std::sqrt(2.0 * noise * spacing / std::sqrt(base::kPi) / kSlope));
  const bool exact = needed <= kExact * spacing;
  const double side = std::max(kept_spacing, kCubeNoises * noise);
  Thinned thinned = ThinOut(points, side, noise < kMeans * side);
  if (exact) return std::move(thinned.points);
  const double radius = std::max(needed, kSmoothBallSpacings * spacing);
  const KdTree tree(thinned.points);
  Neighbors near;
  Points smooth;
  for (const Vector3d& p : thinned.points) {
    tree.Within(p, 2.0 * radius, near);
    smooth.push_back(OntoSurface(thinned, near, p, radius));
  }
  return smooth;
}

/// A maximal subset of the points with no two of them closer than `distance`; earlier points are
/// preferred.
Points SpreadOut(const Points& points, double distance) {
  const KdTree tree(points);
  Neighbors near;
  std::vector<bool> is_near(points.size(), false);
  Points spread;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (is_near[i]) continue;
    spread.push_back(points[i]);
    tree.Within(points[i], distance, near);
    for (const auto& n : near) is_near[n.index] = true;
  }
  return spread;
}

/// Cells are of 1000 faces' areas; three times as many points as these have corners.
constexpr double kMaxPoints = 15'000;
/// Minimum distance between points, in spacings: closer points make slivers.
constexpr double kMinDistance = 0.7;

Points WithoutStrays(const Points& points) {
  const KdTree tree(points);
  std::vector<bool> keep = StrayPoints(points, tree, MeasureSampling(points, tree));
  keep.flip();
  const Points kept = geometry::Select(points, geometry::PositionsOf(keep));
  return kept.empty() ? points : kept;
}

// ---- meshes ----

using FrontKernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// A vertex or cell that CGAL compares by order of creation, not by address.
template <class Base>
class Stamped : public Base {
 public:
  template <class Tds>
  struct Rebind_TDS {
    using Other = Stamped<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  using Has_timestamp = CGAL::Tag_true;
  using Base::Base;

  std::size_t time_stamp() const { return stamp_; }
  void set_time_stamp(std::size_t stamp) { stamp_ = stamp; }

 private:
  std::size_t stamp_ = static_cast<std::size_t>(-1);
};

/// A vertex that defines how the front queues its edges: by priority, as in CGAL, but with ties
/// broken by the numbers of their points. CGAL breaks ties by address. Since all edges that wait
/// for a wider gap are ties, a mesh would depend on the heap.
template <class Base>
class QueuedByPoints : public Base {
 public:
  template <class Tds>
  struct Rebind_TDS {
    using Other = QueuedByPoints<typename Base::template Rebind_TDS<Tds>::Other>;
  };
  using Base::Base;

  struct Radius_ptr_type {
    Radius_ptr_type(typename Base::criteria priority, typename Base::IO_edge_type* edge)
        : first(priority), second(edge) {
      const auto& [cell, i, j] = edge->first.first;
      ends = std::minmax({cell->vertex(i)->info(), cell->vertex(j)->info()});
    }
    bool operator<(const Radius_ptr_type& other) const {
      return std::tie(first, ends) < std::tie(other.first, other.ends);
    }

    typename Base::criteria first;
    typename Base::IO_edge_type* second;
    std::pair<std::size_t, std::size_t> ends;
  };
};

using Vertex = QueuedByPoints<
    Stamped<CGAL::Advancing_front_surface_reconstruction_vertex_base_3<FrontKernel>>>;
using FrontCell = Stamped<CGAL::Advancing_front_surface_reconstruction_cell_base_3<FrontKernel>>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<FrontKernel,
                                   CGAL::Triangulation_data_structure_3<Vertex, FrontCell>>;

/// Priority of a triangle: the smallest ball comes first, as in CGAL; triangles with a long edge
/// are never used.
struct ShortEdgesOnly {
  double max_edge;

  template <class Front, class FrontCell>
  double operator()(const Front& front, FrontCell& cell, const int& index) const {
    const auto is_long = [&](int i, int j) {
      return CGAL::squared_distance(cell->vertex((index + i) % 4)->point(),
                                    cell->vertex((index + j) % 4)->point()) > max_edge * max_edge;
    };
    if (is_long(1, 2) || is_long(2, 3) || is_long(3, 1)) return front.infinity();
    return front.smallest_radius_delaunay_sphere(cell, index);
  }
};

/// Widest gap that is bridged, in spacings: a random sample has some gaps of three, a scan more.
constexpr double kMaxGap = 6.0;
/// Area fraction below which a piece is not part of the surface; as HierarchyOptions::min_area.
constexpr double kMinPiece = 0.005;

/// Noise, in spacings, above which thin structures fragment: both of their sides become one, in
/// shreds. On the tuning models 0.5 % of noise is 0.40 to 1.5, and 0.3 % is 0.24 to 0.7.
constexpr double kCrumbles = 0.35;
/// For the wrap, in spacings: radius of what is bridged, and offset from the points. On the tuning
/// models with 0.5 % of noise 1.5 and 0.5 give the same result, 3 and 1 blunt creases; both cost
/// time or borders.
constexpr double kBridged = 2.0, kOffset = 0.5;

void LeaveSmallPiecesOut(Shape& mesh) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  const auto& [piece, count] = ConnectedPieces(BuildFaceGraph(mesh), AnyNeighbors);
  const std::vector<double> area = GroupSums(piece, frames.area, count);
  std::size_t kept = 0;
  for (std::size_t f = 0; f < piece.size(); ++f) {
    if (area[piece[f]] >= kMinPiece * frames.total_area) mesh.faces[kept++] = mesh.faces[f];
  }
  mesh.faces.resize(kept);
}

}  // namespace

CloudSampling MeasureSampling(const Points& points, const KdTree& tree) {
  Points sample;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kSamples);
  for (std::size_t i = 0; i < points.size(); i += step) sample.push_back(points[i]);
  Neighbors near;
  std::vector<double> reach;
  for (const Vector3d& p : sample) {
    tree.Nearest(p, kFirstNeighbors, near);
    reach.push_back(std::sqrt(near.back().squared_distance));
  }
  double radius = base::UpperMedianOf(reach);
  CloudSampling sampling;
  for (int round = 0; round < kSamplingRounds && radius > 0.0; ++round) {
    std::vector<double> residuals, spacings;
    for (const Vector3d& p : sample) {
      tree.Within(p, radius, near);
      spacings.push_back(radius * std::sqrt(base::kPi / static_cast<double>(near.size())));
      if (const auto one = QuadricResidual(points, near, radius)) residuals.push_back(*one);
    }
    sampling = {base::UpperMedianOf(spacings),
                residuals.empty() ? 0.0 : base::UpperMedianOf(residuals)};
    radius = std::max(kBallSpacings * sampling.spacing, kBallNoises * sampling.noise);
  }
  return sampling;
}

std::vector<bool> StrayPoints(const Points& points, const KdTree& tree,
                              const CloudSampling& sampling) {
  // On an even surface a ball of this radius contains about 50 points. The density of a scan varies
  // by a factor of a few.
  constexpr double kReach = 4.0;
  constexpr std::size_t kFew = 8;
  const double radius = std::max(kReach * sampling.spacing, 2.0 * sampling.noise);
  std::vector<bool> stray(points.size());
  for (const Indices& group : geometry::GroupsWithin(points, tree, radius)) {
    for (const std::uint32_t i : group) stray[i] = group.size() <= kFew;
  }
  return stray;
}

SurfacePoints PointsOfSurface(const Points& points) {
  const Points kept = WithoutStrays(points);
  const CloudSampling sampling = MeasureSampling(kept, KdTree(kept));
  const double spacing =
      sampling.spacing * std::max(1.0, std::sqrt(static_cast<double>(kept.size()) / kMaxPoints));
  return {SpreadOut(SmoothSurface(kept, sampling, spacing), kMinDistance * spacing), spacing,
          sampling.noise};
}

std::vector<Face> AdvancingFront(const Points& points, double max_edge) {
  std::vector<std::pair<FrontKernel::Point_3, std::size_t>> input;
  for (const Eigen::Vector3d& p : points) input.push_back({{p.x(), p.y(), p.z()}, input.size()});
  Delaunay delaunay(input.begin(), input.end());
  CGAL::Advancing_front_surface_reconstruction<Delaunay, ShortEdgesOnly> front(
      delaunay, ShortEdgesOnly{max_edge});
  front.run();
  std::vector<std::array<std::size_t, 3>> found;
  CGAL::write_triple_indices(std::back_inserter(found), front);
  std::vector<Face> faces;
  const auto number = [](std::size_t v) { return static_cast<std::uint32_t>(v); };
  for (const auto& [a, b, c] : found) faces.push_back({number(a), number(b), number(c)});
  return faces;
}

CloudMesh MeshOfCloud(const Points& points) {
  const CanonicalCloud canonical = MakeCanonicalCloud(points);
  SurfacePoints surface = PointsOfSurface(canonical.points);
  CloudMesh result;
  Shape& mesh = result.mesh;
  mesh.points = std::move(surface.points);
  // A flat or nearly flat surface has no third dimension to triangulate.
  if (geometry::IsFlat(mesh.points)) return {};
  mesh.faces = AdvancingFront(mesh.points, kMaxGap * surface.spacing);
  if (mesh.faces.empty()) return {};
  mesh.faces = TurnedOutwards(mesh);
  LeaveSmallPiecesOut(mesh);
  // In shreds. A surface seen from one side would get a far side.
  if (surface.noise > kCrumbles * surface.spacing && FewestLayers(mesh) > kMaxLayers) {
    const geometry::TriangleMesh wrap = geometry::AlphaWrap(
        {mesh.points, mesh.faces}, kBridged * surface.spacing, kOffset * surface.spacing);
    mesh.points = wrap.vertices;
    mesh.faces = wrap.triangles;
  }
  const FaceFrames frames = BuildFaceFrames(mesh);
  const KdTree faces(frames.center);
  std::vector<KdTree::Neighbor> near;
  result.face_of_point.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    faces.Nearest(canonical.points[i], 1, near);
    result.face_of_point[canonical.origin[i]] = near.front().index;
  }
  return result;
}

}  // namespace rangegrasp::parts
