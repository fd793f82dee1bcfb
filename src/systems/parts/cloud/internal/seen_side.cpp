#include "parts/cloud/internal/seen_side.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "base/units.h"
#include "geometry/graph.h"
#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::KdTree;

// ---- bodies of revolution ----

/// Velocities a x p + m.
struct Rotation {
  Vector3d a = Vector3d::Zero();
  Vector3d m = Vector3d::Zero();

  Vector3d VelocityAt(const Vector3d& p) const { return a.cross(p) + m; }
};

/// The sums of the least squares, about the surface's middle and in units of its size.
struct RingSums {
  Matrix3d aa = Matrix3d::Zero(), am = Matrix3d::Zero(), mm = Matrix3d::Zero();

  void Add(double weight, const Vector3d& p, const Vector3d& n) {
    const Vector3d q = p.cross(n);
    aa += weight * q * q.transpose();
    am += weight * q * n.transpose();
    mm += weight * n * n.transpose();
  }
};

/// The surface in a frame of its own.
struct RingFaces {
  Vector3d middle = Vector3d::Zero();
  double size = 0.0;
  Points center;
  const FaceFrames& frames;

  explicit RingFaces(const FaceFrames& of) : frames(of) {
    for (std::size_t f = 0; f < of.center.size(); ++f) {
      middle += of.area[f] / of.total_area * of.center[f];
    }
    for (std::size_t f = 0; f < of.center.size(); ++f) {
      center.push_back(of.center[f] - middle);
      size += of.area[f] / of.total_area * center.back().squaredNorm();
    }
    size = std::sqrt(size);
    for (Vector3d& p : center) p /= size;
  }
};

/// What a translation costs compared with a rotation: almost nothing, to decide where the
/// surface, as a cylinder, could also slide along its axis.
constexpr double kRidge = 1e-4;

/// m for a, such that the squares are least, without a pitch along a.
Rotation WithAxis(const RingSums& sums, const Vector3d& a) {
  const Matrix3d mm = sums.mm + kRidge * sums.mm.trace() * Matrix3d::Identity();
  const Vector3d m = -mm.ldlt().solve(sums.am.transpose() * a);
  return {a, m - a.dot(m) * a};
}

Rotation BestOf(const RingSums& sums) {
  const Matrix3d mm = sums.mm + kRidge * sums.mm.trace() * Matrix3d::Identity();
  const Matrix3d left = sums.aa - sums.am * mm.ldlt().solve(sums.am.transpose());
  return WithAxis(sums, Eigen::SelfAdjointEigenSolver<Matrix3d>(left).eigenvectors().col(0));
}

double TwistOf(const Rotation& rotation, const Vector3d& p, const Vector3d& n) {
  // Near to the axis its place is not known well enough for a direction round it.
  constexpr double kNearRing = 0.1;
  const Vector3d velocity = rotation.VelocityAt(p);
  return velocity.dot(n) / std::max(velocity.norm(), kNearRing);
}

Rotation Refine(const RingFaces& faces, Rotation rotation, const RevolutionOptions& options) {
  for (int round = 0; round < options.rounds; ++round) {
    RingSums sums;
    for (std::size_t f = 0; f < faces.center.size(); ++f) {
      const Vector3d& p = faces.center[f];
      const Vector3d& n = faces.frames.normal[f];
      const double twist = TwistOf(rotation, p, n) / options.softness;
      const double off = 1.0 + twist * twist;
      sums.Add(faces.frames.area[f] / (off * off), p, n);
    }
    rotation = BestOf(sums);
  }
  return rotation;
}

double ShareOf(const RingFaces& faces, const Rotation& rotation, double max_twist) {
  double area = 0.0;
  for (std::size_t f = 0; f < faces.center.size(); ++f) {
    if (std::abs(TwistOf(rotation, faces.center[f], faces.frames.normal[f])) <= max_twist) {
      area += faces.frames.area[f];
    }
  }
  return area / faces.frames.total_area;
}

// ---- joining ----

/// The parts in sets, numbered by falling area, ties by their first parts. The tree is the whole
/// and what it came to.
Segmentation JoinParts(const Segmentation& found, const std::vector<double>& area,
                       geometry::UnionFind& sets) {
  std::vector<double> of_set(area.size(), 0.0);
  Indices roots;
  for (std::uint32_t l = 0; l < area.size(); ++l) {
    of_set[sets.Find(l)] += area[l];
    if (sets.Find(l) == l) roots.push_back(l);
  }
  std::ranges::stable_sort(roots, std::greater<>(), [&](std::uint32_t l) { return of_set[l]; });
  Labels number(area.size());
  for (std::size_t k = 0; k < roots.size(); ++k) number[roots[k]] = static_cast<std::int32_t>(k);
  Segmentation joined = found;
  for (std::int32_t& l : joined.label) l = number[sets.Find(l)];
  joined.parts = static_cast<int>(roots.size());
  joined.has_core = joined.parts > 1;
  joined.tree = {found.tree.front()};
  joined.tree.front().label = joined.has_core ? -1 : 0;
  for (std::int32_t l = 0; joined.has_core && l < joined.parts; ++l) {
    joined.tree.push_back({0, 1, l, std::numeric_limits<double>::infinity()});
  }
  return joined;
}

/// Of an equilateral triangle as large as the mean.
double EdgeOf(const FaceFrames& frames) {
  return std::sqrt(4.0 / std::sqrt(3.0) * frames.total_area /
                   static_cast<double>(frames.area.size()));
}

// ---- thin walls ----

/// Of a wall, in edges: noise that joins a wall's sides is about one edge, and what is three times
/// as thick stays apart.
constexpr double kThickness = 4.0;
/// Of the smaller part's area, that faces the other.
constexpr double kShare = 0.5;
/// Cosines: of the way to the other face with the normal, and of both normals.
constexpr double kAcross = 0.8, kParallel = 0.7;

/// The nearest face that lies before or behind one, about parallel to it.
std::optional<std::uint32_t> Facing(const FaceFrames& frames, const KdTree& tree, std::uint32_t f,
                                    double reach, std::vector<KdTree::Neighbor>& near) {
  tree.Within(frames.center[f], reach, near);
  std::optional<std::uint32_t> best;
  double distance = reach * reach;
  for (const auto& n : near) {
    const Vector3d way = frames.center[n.index] - frames.center[f];
    if (n.squared_distance >= distance) continue;
    if (std::abs(way.dot(frames.normal[f])) < kAcross * way.norm()) continue;
    if (std::abs(frames.normal[f].dot(frames.normal[n.index])) < kParallel) continue;
    if (n.index == f) continue;
    distance = n.squared_distance;
    best = n.index;
  }
  return best;
}

// ---- one side ----

/// Faces with normals that are evened out over the faces about their corners: those of single
/// triangles are as rough as noise is large compared with their edges.
FaceFrames SmoothFrames(const Shape& mesh) {
  FaceFrames frames = BuildFaceFrames(mesh);
  Points of_point(mesh.points.size(), Vector3d::Zero());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const std::uint32_t v : mesh.faces[f]) of_point[v] += frames.area[f] * frames.normal[f];
  }
  for (Vector3d& n : of_point) n.normalize();
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [a, b, c] = mesh.faces[f];
    frames.normal[f] = (of_point[a] + of_point[b] + of_point[c]).normalized();
  }
  return frames;
}

/// The area as it is seen from a direction, each layer by itself.
double ProjectedArea(const Vector3d& view, const FaceFrames& frames) {
  double area = 0.0;
  for (std::size_t f = 0; f < frames.area.size(); ++f) {
    area += frames.area[f] * std::abs(frames.normal[f].dot(view));
  }
  return area;
}

/// What the surface covers, in cells in which a face has its middle.
double CoveredArea(const Vector3d& view, const FaceFrames& frames) {
  const double side = 2.0 * EdgeOf(frames);
  const Vector3d right = view.unitOrthogonal();
  const Vector3d up = view.cross(right);
  std::vector<std::pair<int, int>> cells;
  for (const Vector3d& p : frames.center) {
    cells.emplace_back(static_cast<int>(std::floor(right.dot(p) / side)),
                       static_cast<int>(std::floor(up.dot(p) / side)));
  }
  std::sort(cells.begin(), cells.end());
  const auto covered = std::unique(cells.begin(), cells.end()) - cells.begin();
  return static_cast<double>(covered) * side * side;
}

/// What is known of a part.
struct SeenPart {
  double area = 0.0;
  double turned = 0.0;  ///< area that turns about the axis
  double near = 0.0;    ///< area near to the body's profile
  Vector3d middle = Vector3d::Zero();
  bool is_body = false;
};

/// Sums over the faces of each part.
template <class Add>
void OverFaces(const Segmentation& found, std::vector<SeenPart>& parts, const Add& add) {
  for (std::size_t f = 0; f < found.label.size(); ++f) add(parts[found.label[f]], f);
}

void MeasureProfile(const FaceFrames& frames, const RevolutionAxis& axis, const Segmentation& found,
                    const SeenSideOptions& options, std::vector<SeenPart>& parts) {
  Points profile;
  OverFaces(found, parts, [&](const SeenPart& part, std::size_t f) {
    if (part.turned < options.sure_turned * part.area) return;
    if (part.area < options.sure_area * frames.total_area) return;
    profile.push_back(axis.ProfileOf(frames.center[f]));
  });
  if (profile.empty()) return;
  const double reach = options.profile_reach * EdgeOf(frames);
  const KdTree tree(profile);
  std::vector<KdTree::Neighbor> nearest;
  OverFaces(found, parts, [&](SeenPart& part, std::size_t f) {
    tree.Nearest(axis.ProfileOf(frames.center[f]), 1, nearest);
    if (nearest.front().squared_distance <= reach * reach) part.near += frames.area[f];
  });
}

std::vector<SeenPart> MeasureParts(const FaceFrames& frames, const RevolutionAxis& axis,
                                   const Segmentation& found, const SeenSideOptions& options) {
  std::vector<SeenPart> parts(found.parts);
  OverFaces(found, parts, [&](SeenPart& part, std::size_t f) {
    part.area += frames.area[f];
    part.middle += frames.area[f] * frames.center[f];
    const bool turns = axis.Twist(frames.center[f], frames.normal[f]) <= options.max_twist;
    if (turns) part.turned += frames.area[f];
  });
  MeasureProfile(frames, axis, found, options, parts);
  for (SeenPart& part : parts) {
    part.middle /= part.area;
    part.is_body = part.turned >= options.min_turned * part.area && part.near >= 0.5 * part.area;
  }
  return parts;
}

/// Moves faces where the body and others meet: what lies on the body's profile, as the body shows
/// it elsewhere, is of the body, all else goes with the nearest other part.
void MoveBordersOfBody(const FaceFrames& frames, const RevolutionAxis& axis,
                       const std::vector<SeenPart>& parts, const SeenSideOptions& options,
                       Labels& label) {
  const double edge = EdgeOf(frames);
  const KdTree in_space(frames.center);
  std::vector<KdTree::Neighbor> near;
  const Labels before = label;
  const auto of_body = [&](std::uint32_t f) { return parts[before[f]].is_body; };
  // Of each face at the border: the nearest one of the other kind.
  std::vector<std::optional<std::uint32_t>> other(label.size());
  Points profile;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    in_space.Within(frames.center[f], options.border_zone * edge, near);
    const auto first = std::ranges::min_element(near, {}, [&](const KdTree::Neighbor& n) {
      return std::tuple(of_body(n.index) == of_body(f), n.squared_distance, n.index);
    });
    if (of_body(first->index) != of_body(f)) other[f] = first->index;
    if (of_body(f) && !other[f]) profile.push_back(axis.ProfileOf(frames.center[f]));
  }
  if (profile.empty()) return;
  const KdTree tree(profile);
  const double step = options.border_step * edge;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (!other[f]) continue;
    tree.Nearest(axis.ProfileOf(frames.center[f]), 1, near);
    const bool on_profile = near.front().squared_distance <= step * step;
    const bool turns = axis.Twist(frames.center[f], frames.normal[f]) <= options.max_twist;
    const bool moves = of_body(f) ? !on_profile && !turns : on_profile;
    if (moves) label[f] = before[*other[f]];
  }
}

bool OnOneSide(const RevolutionAxis& axis, const SeenPart& a, const SeenPart& b, double angle) {
  const Vector3d of_a = axis.direction.cross(a.middle - axis.point);
  const Vector3d of_b = axis.direction.cross(b.middle - axis.point);
  return of_a.dot(of_b) >= std::cos(angle) * of_a.norm() * of_b.norm();
}

/// Parts of the body, parts on one side of it, and with the body what is too little to stand off.
geometry::UnionFind JoinedSets(const RevolutionAxis& axis, const std::vector<SeenPart>& parts,
                               const SeenSideOptions& options) {
  geometry::UnionFind sets(parts.size());
  double total = 0.0;
  std::optional<std::uint32_t> body;
  for (std::uint32_t a = 0; a < parts.size(); ++a) {
    total += parts[a].area;
    if (parts[a].is_body && !body) body = a;
    for (std::uint32_t b = a + 1; b < parts.size(); ++b) {
      if (parts[a].is_body != parts[b].is_body) continue;
      if (parts[a].is_body || OnOneSide(axis, parts[a], parts[b], options.same_side_rad)) {
        sets.Unite(a, b);
      }
    }
  }
  if (!body) return sets;
  std::vector<double> area(parts.size(), 0.0);
  for (std::uint32_t l = 0; l < parts.size(); ++l) area[sets.Find(l)] += parts[l].area;
  for (std::uint32_t l = 0; l < parts.size(); ++l) {
    if (area[sets.Find(l)] < options.min_off * total) sets.Unite(l, *body);
  }
  return sets;
}

}  // namespace

Vector3d RevolutionAxis::ProfileOf(const Vector3d& p) const {
  const Vector3d d = p - point;
  return {direction.cross(d).norm(), direction.dot(d), 0.0};
}

double RevolutionAxis::Twist(const Vector3d& p, const Vector3d& normal) const {
  const Vector3d round = direction.cross(p - point);
  const double distance = round.norm();
  return distance > 0.0 ? std::abs(round.dot(normal)) / distance : 0.0;
}

std::optional<RevolutionAxis> FindRevolution(const FaceFrames& frames,
                                             const RevolutionOptions& options) {
  if (!(frames.total_area > 0.0)) return std::nullopt;
  const RingFaces faces(frames);
  RingSums all;
  for (std::size_t f = 0; f < faces.center.size(); ++f) {
    all.Add(frames.area[f], faces.center[f], frames.normal[f]);
  }
  std::vector<Rotation> guesses = {BestOf(all)};
  const Matrix3d of_normals = Eigen::SelfAdjointEigenSolver<Matrix3d>(all.mm).eigenvectors();
  for (int k = 0; k < 3; ++k) guesses.push_back(WithAxis(all, of_normals.col(k)));
  Rotation best;
  double share = -1.0;
  for (const Rotation& guess : guesses) {
    const Rotation refined = Refine(faces, guess, options);
    const double one = ShareOf(faces, refined, options.max_twist);
    if (one <= share) continue;
    share = one;
    best = refined;
  }
  // m = c x a for a point c of the axis.
  return RevolutionAxis{faces.middle + faces.size * best.a.cross(best.m), best.a, share};
}

Segmentation JoinWalls(const Shape& mesh, const Segmentation& found) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  const double edge = EdgeOf(frames);
  const KdTree tree(frames.center);
  std::vector<KdTree::Neighbor> near;
  std::map<std::pair<std::int32_t, std::int32_t>, double> facing;
  std::vector<double> area(found.parts, 0.0);
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
    area[found.label[f]] += frames.area[f];
    const auto other = Facing(frames, tree, f, kThickness * edge, near);
    if (other) facing[{found.label[f], found.label[*other]}] += frames.area[f];
  }
  geometry::UnionFind sets(area.size());
  bool any = false;
  for (const auto& [parts, size] : facing) {
    const auto& [a, b] = parts;
    if (area[a] <= area[b] && size >= kShare * area[a]) any = sets.Unite(a, b) || any;
  }
  return any ? JoinParts(found, area, sets) : found;
}

double FewestLayers(const Shape& mesh) {
  constexpr int kDirections = 200;
  // Of the largest projected area: edge on, there is more border than surface.
  constexpr double kMinProjected = 0.75;
  const FaceFrames frames = BuildFaceFrames(mesh);
  Points views;
  std::vector<double> projected;
  for (int k = 0; k < kDirections; ++k) {
    // Evenly over half a ball, by the golden angle.
    const double z = (k + 0.5) / kDirections;
    const double angle = k * base::kPi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    views.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    projected.push_back(ProjectedArea(views.back(), frames));
  }
  const double enough = kMinProjected * *std::ranges::max_element(projected);
  double fewest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < views.size(); ++k) {
    if (projected[k] < enough) continue;
    fewest = std::min(fewest, projected[k] / CoveredArea(views[k], frames));
  }
  return fewest;
}

std::optional<RevolutionAxis> FindSeenBody(const Shape& mesh, const SeenSideOptions& options) {
  if (FewestLayers(mesh) > options.max_layers) return std::nullopt;
  const auto axis = FindRevolution(SmoothFrames(mesh), {.max_twist = options.max_twist});
  return axis && axis->share >= options.min_share ? axis : std::nullopt;
}

Segmentation JoinTurned(const Shape& mesh, const RevolutionAxis& axis, const Segmentation& found,
                        const SeenSideOptions& options) {
  const FaceFrames frames = SmoothFrames(mesh);
  const std::vector<SeenPart> parts = MeasureParts(frames, axis, found, options);
  geometry::UnionFind sets = JoinedSets(axis, parts, options);
  Segmentation joined = found;
  MoveBordersOfBody(frames, axis, parts, options, joined.label);
  std::vector<double> area;
  for (const SeenPart& part : parts) area.push_back(part.area);
  return JoinParts(joined, area, sets);
}

}  // namespace rangegrasp::parts
