#include "parts/cloud/seen_side.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "base/units.h"
#include "geometry/kd_tree.h"
#include "geometry/union_find.h"
#include "parts/cloud/internal/join_parts.h"

namespace rangegrasp::parts {
namespace {

using Eigen::Vector3d;

/// Faces with normals that are evened out over the faces about their corners: those of single
/// triangles are as rough as noise is large beside their edges.
FaceFrames SmoothFrames(const Shape& mesh) {
  FaceFrames frames = BuildFaceFrames(mesh);
  geometry::Points of_point(mesh.points.size(), Vector3d::Zero());
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

/// Of an equilateral triangle as large as the mean.
double EdgeOf(const FaceFrames& frames) {
  return std::sqrt(4.0 / std::sqrt(3.0) * frames.total_area /
                   static_cast<double>(frames.area.size()));
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
  for (std::size_t f = 0; f < found.label.size(); ++f) {
    add(parts[static_cast<std::size_t>(found.label[f])], f);
  }
}

/// A place in the half plane that is turned about the axis.
Vector3d InProfile(const RevolutionAxis& axis, const Vector3d& p) {
  const Eigen::Vector2d at = axis.ProfileOf(p);
  return {at.x(), at.y(), 0.0};
}

void MeasureProfile(const FaceFrames& frames, const RevolutionAxis& axis, const Segmentation& found,
                    const SeenSideOptions& options, std::vector<SeenPart>& parts) {
  geometry::Points profile;
  OverFaces(found, parts, [&](const SeenPart& part, std::size_t f) {
    if (part.turned < options.sure_turned * part.area) return;
    if (part.area < options.sure_area * frames.total_area) return;
    profile.push_back(InProfile(axis, frames.center[f]));
  });
  if (profile.empty()) return;
  const double reach = options.profile_reach * EdgeOf(frames);
  const geometry::KdTree tree(profile);
  std::vector<geometry::KdTree::Neighbor> nearest;
  OverFaces(found, parts, [&](SeenPart& part, std::size_t f) {
    tree.Nearest(InProfile(axis, frames.center[f]), 1, nearest);
    if (nearest.front().squared_distance <= reach * reach) part.near += frames.area[f];
  });
}

std::vector<SeenPart> MeasureParts(const FaceFrames& frames, const RevolutionAxis& axis,
                                   const Segmentation& found, const SeenSideOptions& options) {
  std::vector<SeenPart> parts(static_cast<std::size_t>(found.parts));
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
                       const std::vector<bool>& is_body, const SeenSideOptions& options,
                       std::vector<std::int32_t>& label) {
  const double edge = EdgeOf(frames);
  const geometry::KdTree in_space(frames.center);
  std::vector<geometry::KdTree::Neighbor> near;
  const std::vector<std::int32_t> before = label;
  const auto of_body = [&](std::uint32_t f) {
    return is_body[static_cast<std::size_t>(before[f])];
  };
  // Of each face at the border: the nearest one of the other kind.
  std::vector<std::optional<std::uint32_t>> other(label.size());
  geometry::Points profile;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    in_space.Within(frames.center[f], options.border_zone * edge, near);
    const auto first =
        std::min_element(near.begin(), near.end(), [&](const auto& a, const auto& b) {
          return std::tuple(of_body(a.index) == of_body(f), a.squared_distance, a.index) <
                 std::tuple(of_body(b.index) == of_body(f), b.squared_distance, b.index);
        });
    if (of_body(first->index) != of_body(f)) other[f] = first->index;
    if (of_body(f) && !other[f]) profile.push_back(InProfile(axis, frames.center[f]));
  }
  if (profile.empty()) return;
  const geometry::KdTree tree(profile);
  const double step = options.border_step * edge;
  for (std::uint32_t f = 0; f < label.size(); ++f) {
    if (!other[f]) continue;
    tree.Nearest(InProfile(axis, frames.center[f]), 1, near);
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

double FewestLayers(const Shape& mesh) {
  constexpr int kDirections = 200;
  // Of the largest projected area: edge on, there is more border than surface.
  constexpr double kMinProjected = 0.75;
  const FaceFrames frames = BuildFaceFrames(mesh);
  geometry::Points views;
  std::vector<double> projected;
  for (int k = 0; k < kDirections; ++k) {
    // Evenly over half a ball, by the golden angle.
    const double z = (k + 0.5) / kDirections;
    const double angle = k * base::kPi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    views.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    projected.push_back(ProjectedArea(views.back(), frames));
  }
  const double enough = kMinProjected * *std::max_element(projected.begin(), projected.end());
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
  std::vector<bool> is_body;
  for (const SeenPart& part : parts) is_body.push_back(part.is_body);
  geometry::UnionFind sets = JoinedSets(axis, parts, options);
  Segmentation joined = found;
  MoveBordersOfBody(frames, axis, is_body, options, joined.label);
  std::vector<double> area;
  for (const SeenPart& part : parts) area.push_back(part.area);
  return JoinParts(joined, area, sets);
}

}  // namespace rangegrasp::parts
