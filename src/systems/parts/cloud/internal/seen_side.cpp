#include "parts/cloud/internal/seen_side.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/linear_algebra.h"
#include "geometry/graph.h"
#include "geometry/kd_tree.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::KdTree;

// ---- bodies of revolution ----

/// Maximum sine by which noise tilts normals that meet the axis: 0.1 to 0.2 was measured.
constexpr double kMaxTwist = 0.3;
/// Twist at which a face's weight decreases (Geman and McClure 1987), and number of reweightings.
constexpr double kSoftness = 0.2;
constexpr int kReweightings = 20;

/// The velocity field a x p + m.
struct Rotation {
  Vector3d a = Vector3d::Zero();
  Vector3d m = Vector3d::Zero();
};

/// The sine by which a normal misses the axis; 0 without a rotation.
double TwistOf(const Rotation& rotation, const Vector3d& p, const Vector3d& n) {
  // Near the axis its position is too uncertain to give a direction around it.
  constexpr double kNearRing = 0.1;
  const Vector3d velocity = rotation.a.cross(p) + rotation.m;
  return velocity.dot(n) / std::max(velocity.norm(), kNearRing);
}

/// Sums of the least squares problem.
struct RingSums {
  Matrix3d aa = Matrix3d::Zero(), am = Matrix3d::Zero(), mm = Matrix3d::Zero();

  /// Faces weigh less if their normals miss the axis of a rotation.
  RingSums(const FaceFrames& faces, const Rotation& rotation) {
    for (std::size_t f = 0; f < faces.area.size(); ++f) {
      const Vector3d& n = faces.normal[f];
      const double twist = TwistOf(rotation, faces.center[f], n) / kSoftness;
      const double off = 1.0 + twist * twist;
      const double weight = faces.area[f] / (off * off);
      const Vector3d q = faces.center[f].cross(n);
      aa += weight * q * q.transpose();
      am += weight * q * n.transpose();
      mm += weight * n * n.transpose();
    }
  }
  /// Cost of a translation compared with a rotation: almost zero. It decides where a surface, such
  /// as a cylinder, could also slide along its axis.
  Matrix3d Ridged() const { return mm + 1e-4 * mm.trace() * Matrix3d::Identity(); }
};

/// The m with the least squares for a given a, without a pitch along a.
Rotation WithAxis(const RingSums& sums, const Vector3d& a) {
  const Vector3d m = -base::SolveLdlt<3, 1>(sums.Ridged(), sums.am.transpose() * a);
  return {a, m - a.dot(m) * a};
}

Rotation BestOf(const RingSums& sums) {
  const Matrix3d left =
      sums.aa - sums.am * base::SolveLdlt<3, 3>(sums.Ridged(), sums.am.transpose());
  return WithAxis(sums, base::SymmetricEigen(left).vectors.col(0));
}

double ShareOf(const FaceFrames& faces, const Rotation& rotation) {
  double area = 0.0;
  for (std::size_t f = 0; f < faces.area.size(); ++f) {
    const double twist = TwistOf(rotation, faces.center[f], faces.normal[f]);
    if (std::abs(twist) <= kMaxTwist) area += faces.area[f];
  }
  return area / faces.total_area;
}

// ---- joining ----

/// Joins the parts of each set. The sets are numbered by decreasing area, on ties by their first
/// parts.
Segmentation JoinParts(const Segmentation& found, const std::vector<double>& area,
                       geometry::UnionFind& sets) {
  std::vector<double> of_set(area.size(), 0.0);
  Indices roots;
  for (std::uint32_t l = 0; l < area.size(); ++l) {
    of_set[sets.Find(l)] += area[l];
    if (sets.Find(l) == l) roots.push_back(l);
  }
  const Labels number = RankLabels(roots, of_set);
  Segmentation joined = found;
  for (std::int32_t& l : joined.label) l = number[sets.Find(l)];
  joined.parts = static_cast<int>(roots.size());
  joined.has_core = joined.parts > 1;
  return joined;
}

/// Edge length of an equilateral triangle with the mean face area.
double EdgeOf(const FaceFrames& frames) {
  return std::sqrt(4.0 / std::sqrt(3.0) * frames.total_area /
                   static_cast<double>(frames.area.size()));
}

// ---- thin walls ----

/// Thickness of a wall in edge lengths. Noise that merges a wall's sides is about one edge; sides
/// three times as far apart stay separate.
constexpr double kThickness = 4.0;
/// Minimum fraction of the smaller part's area that faces the other part.
constexpr double kShare = 0.5;
/// Minimum cosines: between the normal and the way to the other face, and between both normals.
constexpr double kAcross = 0.8, kParallel = 0.7;

/// The nearest face in front of or behind a face, about parallel to it.
std::optional<std::uint32_t> Facing(const FaceFrames& frames, const KdTree& tree, std::uint32_t f,
                                    double reach, std::vector<KdTree::Neighbor>& near) {
  tree.Within(frames.center[f], reach, near);
  std::optional<std::uint32_t> best;
  double distance = reach * reach;
  for (const auto& n : near) {
    const Vector3d way = frames.center[n.index] - frames.center[f];
    if (n.index == f || n.squared_distance >= distance) continue;
    if (std::abs(way.dot(frames.normal[f])) < kAcross * way.norm()) continue;
    if (std::abs(frames.normal[f].dot(frames.normal[n.index])) < kParallel) continue;
    distance = n.squared_distance;
    best = n.index;
  }
  return best;
}

// ---- one side ----

/// Faces with normals averaged over the faces around their corners. Normals of single triangles are
/// rough if noise is large compared with their edges.
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

/// The projected area in a view direction, each layer counted by itself.
double ProjectedArea(const Vector3d& view, const FaceFrames& frames) {
  double area = 0.0;
  for (std::size_t f = 0; f < frames.area.size(); ++f) {
    area += frames.area[f] * std::abs(frames.normal[f].dot(view));
  }
  return area;
}

/// The area that the surface covers, counted in cells that contain a face's middle.
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

/// Minimum fraction of the area that is symmetric about an axis, for a body.
constexpr double kMinBodyShare = 0.6;
/// Minimum fraction of a part's area that is symmetric about the axis, for a part of the body. The
/// same for parts that define the body's profile, and their minimum fraction of the whole area.
constexpr double kMinTurned = 0.5, kSureTurned = 0.6, kSureArea = 0.02;
/// Half of a part of the body is this close to the body's profile, in edge lengths.
constexpr double kProfileReach = 2.0;
/// Joined parts with a smaller fraction of the area do not protrude but belong to the body.
constexpr double kMinOff = 0.02;
/// In edge lengths: faces this close to another part are reassigned; those within the step of the
/// body's profile belong to the body.
constexpr double kBorderZone = 3.0, kBorderStep = 0.4;
/// Protrusions at angles closer than this are joined.
constexpr double kSameSide_rad = 0.8;

/// Measures of a part.
struct SeenPart {
  double area = 0.0;
  double turned = 0.0;  ///< area that is symmetric about the axis
  double near = 0.0;    ///< area close to the body's profile
  Vector3d middle = Vector3d::Zero();
  bool is_body = false;
};

std::vector<SeenPart> MeasureParts(const FaceFrames& frames, const RevolutionAxis& axis,
                                   const Segmentation& found) {
  const FaceFrames sums = GroupFrames(frames, found.label, found.parts);
  std::vector<SeenPart> parts(found.parts);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    parts[p].area = sums.area[p];
    parts[p].middle = sums.center[p];
  }
  for (std::size_t f = 0; f < found.label.size(); ++f) {
    const bool turns = axis.Twist(frames.center[f], frames.normal[f]) <= kMaxTwist;
    if (turns) parts[found.label[f]].turned += frames.area[f];
  }
  Points profile;
  for (std::size_t f = 0; f < found.label.size(); ++f) {
    const SeenPart& part = parts[found.label[f]];
    if (part.turned < kSureTurned * part.area) continue;
    if (part.area < kSureArea * frames.total_area) continue;
    profile.push_back(axis.ProfileOf(frames.center[f]));
  }
  if (profile.empty()) return parts;
  const double reach = kProfileReach * EdgeOf(frames);
  const KdTree tree(profile);
  std::vector<KdTree::Neighbor> nearest;
  for (std::size_t f = 0; f < found.label.size(); ++f) {
    tree.Nearest(axis.ProfileOf(frames.center[f]), 1, nearest);
    const bool is_near = nearest.front().squared_distance <= reach * reach;
    if (is_near) parts[found.label[f]].near += frames.area[f];
  }
  for (SeenPart& part : parts) {
    part.is_body = part.turned >= kMinTurned * part.area && part.near >= 0.5 * part.area;
  }
  return parts;
}

/// Reassigns faces where the body and other parts meet. Faces on the body's profile, as the body
/// shows it elsewhere, go to the body; all others go to the nearest other part.
void MoveBordersOfBody(const FaceFrames& frames, const RevolutionAxis& axis,
                       const std::vector<SeenPart>& parts, Labels& label) {
  const double edge = EdgeOf(frames);
  const KdTree in_space(frames.center);
  std::vector<KdTree::Neighbor> near;
  const Labels before = label;
  const auto of_body = [&](std::uint32_t f) { return parts[before[f]].is_body; };
  // For each face at the border: the nearest face of the other kind.
  std::vector<std::optional<std::uint32_t>> other(label.size());
  Points profile;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    in_space.Within(frames.center[f], kBorderZone * edge, near);
    const auto first = std::ranges::min_element(near, {}, [&](const KdTree::Neighbor& n) {
      return std::tuple(of_body(n.index) == of_body(f), n.squared_distance, n.index);
    });
    if (of_body(first->index) != of_body(f)) other[f] = first->index;
    if (of_body(f) && !other[f]) profile.push_back(axis.ProfileOf(frames.center[f]));
  }
  if (profile.empty()) return;
  const KdTree tree(profile);
  const double step = kBorderStep * edge;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (!other[f]) continue;
    tree.Nearest(axis.ProfileOf(frames.center[f]), 1, near);
    const bool on_profile = near.front().squared_distance <= step * step;
    const bool turns = axis.Twist(frames.center[f], frames.normal[f]) <= kMaxTwist;
    const bool moves = of_body(f) ? !on_profile && !turns : on_profile;
    if (moves) label[f] = before[*other[f]];
  }
}

bool OnOneSide(const RevolutionAxis& axis, const SeenPart& a, const SeenPart& b) {
  const Vector3d of_a = axis.direction.cross(a.middle - axis.point);
  const Vector3d of_b = axis.direction.cross(b.middle - axis.point);
  return of_a.dot(of_b) >= std::cos(kSameSide_rad) * of_a.norm() * of_b.norm();
}

/// Joins parts of the body, parts on one side of it, and parts too small to protrude with the body.
geometry::UnionFind JoinedSets(const RevolutionAxis& axis, const std::vector<SeenPart>& parts) {
  geometry::UnionFind sets(parts.size());
  double total = 0.0;
  std::optional<std::uint32_t> body;
  for (std::uint32_t a = 0; a < parts.size(); ++a) {
    total += parts[a].area;
    if (parts[a].is_body && !body) body = a;
    for (std::uint32_t b = a + 1; b < parts.size(); ++b) {
      if (parts[a].is_body != parts[b].is_body) continue;
      if (parts[a].is_body || OnOneSide(axis, parts[a], parts[b])) sets.Unite(a, b);
    }
  }
  if (!body) return sets;
  std::vector<double> area(parts.size(), 0.0);
  for (std::uint32_t l = 0; l < parts.size(); ++l) area[sets.Find(l)] += parts[l].area;
  for (std::uint32_t l = 0; l < parts.size(); ++l) {
    if (area[sets.Find(l)] < kMinOff * total) sets.Unite(l, *body);
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

std::optional<RevolutionAxis> FindRevolution(const FaceFrames& frames) {
  if (!(frames.total_area > 0.0)) return std::nullopt;
  FaceFrames faces = frames;  // relative to their middle and in units of their size
  Vector3d middle = Vector3d::Zero();
  double squared = 0.0;
  for (std::size_t f = 0; f < faces.area.size(); ++f) {
    middle += faces.area[f] / faces.total_area * faces.center[f];
  }
  for (std::size_t f = 0; f < faces.area.size(); ++f) {
    faces.center[f] -= middle;
    squared += faces.area[f] / faces.total_area * faces.center[f].squaredNorm();
  }
  const double size = std::sqrt(squared);
  for (Vector3d& p : faces.center) p /= size;

  const RingSums all(faces, {});
  std::vector<Rotation> guesses = {BestOf(all)};
  const Matrix3d of_normals = base::SymmetricEigen(all.mm).vectors;
  for (int k = 0; k < 3; ++k) guesses.push_back(WithAxis(all, of_normals.col(k)));
  Rotation best;
  double share = -1.0;
  for (Rotation& guess : guesses) {
    for (int round = 0; round < kReweightings; ++round) guess = BestOf({faces, guess});
    const double one = ShareOf(faces, guess);
    if (one <= share) continue;
    share = one;
    best = guess;
  }
  // m = c x a for a point c of the axis.
  return RevolutionAxis{middle + size * best.a.cross(best.m), best.a, share};
}

Segmentation JoinWalls(const Shape& mesh, const Segmentation& found) {
  const FaceFrames frames = BuildFaceFrames(mesh);
  const double edge = EdgeOf(frames);
  const KdTree tree(frames.center);
  std::vector<KdTree::Neighbor> near;
  std::map<std::pair<std::int32_t, std::int32_t>, double> facing;
  const std::vector<double> area = GroupSums(found.label, frames.area, found.parts);
  for (std::uint32_t f = 0; f < frames.area.size(); ++f) {
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
  // Fraction of the largest projected area. Seen edge on, there is more border than surface.
  constexpr double kMinProjected = 0.75;
  const FaceFrames frames = BuildFaceFrames(mesh);
  Points views;
  std::vector<double> projected;
  for (int k = 0; k < kDirections; ++k) {
    views.push_back(SpiralDirection(k, (k + 0.5) / kDirections));  // evenly over a hemisphere
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

std::optional<RevolutionAxis> FindSeenBody(const Shape& mesh) {
  if (FewestLayers(mesh) > kMaxLayers) return std::nullopt;
  const auto axis = FindRevolution(SmoothFrames(mesh));
  return axis && axis->share >= kMinBodyShare ? axis : std::nullopt;
}

Segmentation JoinTurned(const Shape& mesh, const RevolutionAxis& axis, const Segmentation& found) {
  const FaceFrames frames = SmoothFrames(mesh);
  const std::vector<SeenPart> parts = MeasureParts(frames, axis, found);
  geometry::UnionFind sets = JoinedSets(axis, parts);
  Segmentation joined = found;
  MoveBordersOfBody(frames, axis, parts, joined.label);
  return JoinParts(joined, GroupSums(found.label, frames.area, found.parts), sets);
}

}  // namespace rangegrasp::parts
