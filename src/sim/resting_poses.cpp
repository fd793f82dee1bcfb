#include "sim/resting_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>

#include "base/units.h"
#include "geometry/mesh.h"
#include "sim/internal/engine.h"
#include "sim/internal/scene_builder.h"

namespace rangegrasp::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// For round primitives: 5.6 deg each; the classes below join them again.
constexpr int kHullSegments = 64;
// Tolerances for triangles of one hull face: the rounding of modelled meshes. Larger values join
// the flanks of rounded edges, smaller ones split a face.
constexpr double kCoplanarAngle_rad = 0.01;
constexpr double kCoplanar_m = 5e-5;
// Triangles below this have no reliable normal [m^2, twice the area].
constexpr double kSliver_m2 = 1e-8;
// The projected center of mass may lie this far outside a face because of rounding.
constexpr double kFootTolerance_m = 1e-5;
// Steps and directions of tilting a body until it falls; the margin is known to half a deg.
constexpr double kTiltStep_rad = base::Deg(0.5);
constexpr int kAzimuths = 24;
// Rises below this share of the height of the center of mass are ripples of a round surface's
// polygon (64 segments make 0.12 %, 16 make 2 %).
constexpr double kRipple = 0.02;
// Tolerance for a hull that a symmetry maps onto itself (rounded meshes, ripples), and the number
// of tested directions.
constexpr double kSymmetric_m = 0.0005;
constexpr int kSymmetryDirections = 64;
// Faces that a body rolls over: their heights of the center of mass differ by at most this, and
// their normals by at most this angle (11 deg: 32 segments).
constexpr double kSameHeight_m = 0.001;
constexpr double kRolls_rad = 0.2;
// A body rests on a face within this: more than half a segment, less than to the next face.
constexpr double kRests_rad = base::Deg(5.0);

struct Facet {
  Vector3d normal;
  double offset = 0.0;  // normal . x = offset
  std::vector<std::size_t> triangles;
  double solid_angle = 0.0;
  // Smallest signed distance of the projected centre of mass from an edge (negative outside), and
  // the facet beyond that edge.
  double min_inside = 0.0;
  std::size_t beyond = 0;
  std::vector<Vector3d> edge_normals;  // in the facet's plane, outward

  bool Stable() const { return min_inside > -kFootTolerance_m; }
};

// Solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983).
double SolidAngle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::abs(2.0 * std::atan2(a.dot(b.cross(c)), denominator));
}

class Hull {
 public:
  // Vertices are moved so that the centre of mass is the origin.
  Hull(const geometry::TriangleMesh& mesh_B, const Vector3d& center_B) : mesh_(mesh_B) {
    for (Vector3d& v : mesh_.vertices) v -= center_B;
    BuildFacets();
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        twins_[{mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]}] = t;
      }
    }
    for (Facet& facet : facets_) Measure(facet);
  }

  const std::vector<Facet>& facets() const { return facets_; }

  // Height of the centre of mass when `down` points down.
  double Height(const Vector3d& down) const {
    double height = 0.0;
    for (const Vector3d& v : mesh_.vertices) height = std::max(height, v.dot(down));
    return height;
  }

  // Minimum tilt from a stable facet at which the body tips over.
  double Tipping(const Facet& facet) const {
    const Vector3d u = facet.normal.unitOrthogonal();
    const Vector3d v = facet.normal.cross(u);
    double tipping = base::kPi / 2;
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2 * base::kPi * i / kAzimuths;
      tipping = std::min(
          tipping, TippingTowards(facet.normal, std::cos(azimuth) * u + std::sin(azimuth) * v));
    }
    for (const Vector3d& edge : facet.edge_normals) {
      tipping = std::min(tipping, TippingTowards(facet.normal, edge));
    }
    return tipping;
  }

  // The facet on which a body ends that is set down on `facet`.
  std::size_t RestsOn(std::size_t facet) const {
    for (std::size_t rolls = 0; rolls < facets_.size() && !facets_[facet].Stable(); ++rolls) {
      facet = facets_[facet].beyond;
    }
    return facet;
  }

 private:
  const Vector3d& Vertex(std::size_t triangle, std::size_t corner) const {
    return mesh_.vertices[mesh_.triangles[triangle][corner % 3]];
  }
  Vector3d Cross(std::size_t t) const {
    return (Vertex(t, 1) - Vertex(t, 0)).cross(Vertex(t, 2) - Vertex(t, 0));
  }

  // Large triangles come first, so that slivers with noisy normals join a facet and start none.
  void BuildFacets() {
    std::vector<std::size_t> order(mesh_.triangles.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(
        order, [&](std::size_t a, std::size_t b) { return Cross(a).norm() > Cross(b).norm(); });
    facet_of_.resize(order.size());
    for (const std::size_t t : order) {
      auto facet = std::ranges::find_if(facets_, [&](const Facet& f) { return Lies(t, f); });
      if (facet == facets_.end()) {
        facet = facets_.emplace(facet);
        facet->normal = Cross(t).normalized();
        facet->offset = facet->normal.dot(Vertex(t, 0));
      }
      facet_of_[t] = facet - facets_.begin();
      facet->triangles.push_back(t);
    }
  }

  bool Lies(std::size_t t, const Facet& facet) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs(facet.normal.dot(Vertex(t, k)) - facet.offset) > kCoplanar_m) return false;
    }
    return Cross(t).normalized().dot(facet.normal) > std::cos(kCoplanarAngle_rad) ||
           Cross(t).norm() < kSliver_m2;
  }

  void Measure(Facet& facet) {
    facet.min_inside = std::numeric_limits<double>::infinity();
    for (const std::size_t t : facet.triangles) {
      facet.solid_angle += SolidAngle(Vertex(t, 0), Vertex(t, 1), Vertex(t, 2));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto twin = twins_.find({mesh_.triangles[t][(k + 1) % 3], mesh_.triangles[t][k]});
        if (twin == twins_.end() || facet_of_[twin->second] == facet_of_[t]) continue;
        const Vector3d& a = Vertex(t, k);
        const Vector3d outward = (Vertex(t, k + 1) - a).cross(facet.normal).normalized();
        facet.edge_normals.push_back(outward);
        const double inside = outward.dot(a - facet.offset * facet.normal);
        if (inside >= facet.min_inside) continue;
        facet.min_inside = inside;
        facet.beyond = facet_of_[twin->second];
      }
    }
  }

  double TippingTowards(const Vector3d& down, const Vector3d& side) const {
    const double ripple = kRipple * Height(down);
    double highest = Height(down);
    double at = 0.0;
    for (double tilt = kTiltStep_rad; tilt < base::kPi / 2; tilt += kTiltStep_rad) {
      const double height = Height(std::cos(tilt) * down + std::sin(tilt) * side);
      if (height > highest) {
        highest = height;
        at = tilt;
      }
      if (height < highest - ripple) return at;
    }
    return base::kPi / 2;
  }

  geometry::TriangleMesh mesh_;
  std::vector<Facet> facets_;
  std::vector<std::size_t> facet_of_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> twins_;
};

// Convex hull of the collision geometry in the root body's frame; the object is at its zero pose.
geometry::TriangleMesh CollisionHull(const mjModel* model, const mjData* data, int root) {
  const base::Pose X_BW = internal::BodyPose(data, root).inverse();
  geometry::Points points = internal::CollisionVertices(model, data, kHullSegments);
  for (Vector3d& p : points) p = X_BW * p;
  return geometry::ConvexHull(points);
}

// Evenly distributed directions (a Fibonacci lattice).
std::vector<Vector3d> EvenDirections(int count) {
  std::vector<Vector3d> directions;
  const double golden = base::kPi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count;
    const double r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return directions;
}

// Whether the rotation R maps the hull onto itself.
bool MapsOntoItself(const Hull& hull, const Matrix3d& R) {
  static const std::vector<Vector3d> directions = EvenDirections(kSymmetryDirections);
  return std::ranges::all_of(directions, [&](const Vector3d& d) {
    return std::abs(hull.Height(d) - hull.Height(R * d)) < kSymmetric_m;
  });
}

// A frame whose z axis is the face's normal and whose x axis is one of its edge normals.
Matrix3d FrameOf(const Facet& facet, const Vector3d& edge_normal) {
  Matrix3d frame;
  frame << edge_normal, facet.normal.cross(edge_normal), facet.normal;
  return frame;
}

// Whether a symmetry of the body maps one face onto the other.
bool Symmetric(const Hull& hull, const Facet& a, const Facet& b) {
  if (std::abs(a.offset - b.offset) > kSymmetric_m || a.edge_normals.empty()) return false;
  const Matrix3d A = FrameOf(a, a.edge_normals.front());
  return std::ranges::any_of(b.edge_normals, [&](const Vector3d& edge) {
    return MapsOntoItself(hull, FrameOf(b, edge) * A.transpose());
  });
}

struct PoseClass {
  std::vector<std::size_t> facets;
  std::size_t lowest = 0;  // the lowest of them represents the class
  double solid_angle = 0.0;
};

// The stable faces, grouped by pose.
std::vector<PoseClass> ClassesOf(const Hull& hull) {
  std::vector<PoseClass> classes;
  for (std::size_t f = 0; f < hull.facets().size(); ++f) {
    if (!hull.facets()[f].Stable()) continue;
    const Facet& facet = hull.facets()[f];
    const auto rolls_onto_it = [&](std::size_t other) {
      const Facet& from = hull.facets()[other];
      return std::abs(from.offset - facet.offset) < kSameHeight_m &&
             from.normal.dot(facet.normal) > std::cos(kRolls_rad);
    };
    PoseClass joined{{f}, f, 0.0};
    // This face may belong to several classes, which it joins.
    std::erase_if(classes, [&](const PoseClass& c) {
      const bool same = Symmetric(hull, hull.facets()[c.lowest], facet) ||
                        std::ranges::any_of(c.facets, rolls_onto_it);
      if (same) {
        joined.facets.insert(joined.facets.end(), c.facets.begin(), c.facets.end());
        if (hull.facets()[c.lowest].offset <= hull.facets()[joined.lowest].offset) {
          joined.lowest = c.lowest;
        }
      }
      return same;
    });
    classes.push_back(std::move(joined));
  }
  return classes;
}

// Classes by descending solid angle of the faces from which a body falls onto them.
std::vector<PoseClass> WeighedClasses(const Hull& hull) {
  std::vector<PoseClass> classes = ClassesOf(hull);
  for (std::size_t f = 0; f < hull.facets().size(); ++f) {
    const std::size_t rest = hull.RestsOn(f);
    for (PoseClass& c : classes) {
      if (std::ranges::find(c.facets, rest) == c.facets.end()) continue;
      c.solid_angle += hull.facets()[f].solid_angle;
    }
  }
  std::ranges::stable_sort(classes, std::greater(), &PoseClass::solid_angle);
  return classes;
}

}  // namespace

std::vector<RestingPose> StableRestingPoses(const ObjectModel& object, double min_tipping_rad) {
  const internal::BuiltScene built = internal::BuildObject(object);
  const mjModel* model = built.model.get();
  const int root = built.objects[0].body;
  const internal::DataPtr data = internal::DataAtZero(model);
  const base::Pose X_WB = internal::BodyPose(data.get(), root);
  const Vector3d center_B = X_WB.linear().transpose() *
                            (internal::CenterOfMass(model, data.get(), root) - X_WB.translation());
  const Hull hull(CollisionHull(model, data.get(), root), center_B);
  const auto face_of = [&](std::size_t f) {
    const Facet& facet = hull.facets()[f];
    return RestingFace{base::TurnOnto(facet.normal, -Vector3d::UnitZ()),
                       facet.offset + facet.normal.dot(center_B)};
  };
  std::vector<RestingPose> poses;
  double total = 0.0;
  for (const PoseClass& c : WeighedClasses(hull)) {
    RestingPose pose;
    pose.tipping_rad = hull.Tipping(hull.facets()[c.lowest]);
    if (pose.tipping_rad < min_tipping_rad) continue;
    pose.faces = {face_of(c.lowest)};
    for (const std::size_t f : c.facets) {
      if (f != c.lowest) pose.faces.push_back(face_of(f));
    }
    pose.probability = c.solid_angle;
    pose.label = fmt::format("pose{}", poses.size());
    total += pose.probability;
    poses.push_back(std::move(pose));
  }
  for (RestingPose& pose : poses) pose.probability /= total;
  return poses;
}

std::optional<AtRest> FaceAtRest(const std::vector<RestingPose>& poses, const Matrix3d& R_WO) {
  const Vector3d down_O = -R_WO.row(2).transpose();
  std::optional<AtRest> nearest;
  double most = std::cos(kRests_rad);
  for (const RestingPose& pose : poses) {
    for (const RestingFace& face : pose.faces) {
      const double cosine = down_O.dot(face.R_WO.conjugate() * -Vector3d::UnitZ());
      if (cosine <= most) continue;
      most = cosine;
      nearest = {&pose, &face};
    }
  }
  return nearest;
}

}  // namespace rangegrasp::sim
