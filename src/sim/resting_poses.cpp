#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/error.h"
#include "core/units.h"
#include "geometry/hull.h"
#include "sim/internal/scene_builder.h"
#include "sim/internal/visual.h"
#include "sim/world.h"

namespace rangegrasp::sim {
namespace {

using Eigen::Vector3d;

constexpr int kSegments = 64;                // of round primitives
constexpr double kCoplanarAngle_rad = 0.01;  // triangles of one face of the hull
constexpr double kCoplanar_m = 5e-5;
constexpr double kFootTolerance_m = 1e-5;
constexpr double kTiltStep_rad = 0.5 * core::kPi / 180.0;
constexpr int kAzimuths = 24;
// A face of a polygon that stands for a round surface is no valley of its own: rises below this
// share of the height of the centre of mass are ripples.
constexpr double kRipple = 0.02;
constexpr double kSameHeight_m = 0.001;
constexpr double kSameTilt_rad = 0.05;

struct Facet {
  Vector3d normal;
  double offset = 0.0;  // normal . x = offset
  std::vector<std::size_t> triangles;
  double solid_angle = 0.0;
  // Where the foot of the centre of mass lies outside the most: the signed distance and the facet
  // beyond that edge.
  double least_inside = 0.0;
  std::size_t beyond = 0;
  std::vector<Vector3d> edge_normals;  // in the facet's plane, outward

  bool Stable() const { return least_inside > -kFootTolerance_m; }
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
    for (Facet& facet : facets_) Measure(facet);
  }

  const std::vector<Facet>& facets() const { return facets_; }

  // Height of the centre of mass when `down` points down.
  double Height(const Vector3d& down) const {
    double height = 0.0;
    for (const Vector3d& v : mesh_.vertices) height = std::max(height, v.dot(down));
    return height;
  }

  // Smallest tilt from a stable facet over which the body falls on.
  double Tipping(const Facet& facet) const {
    const Vector3d u = facet.normal.unitOrthogonal();
    const Vector3d v = facet.normal.cross(u);
    double tipping = core::kPi / 2;
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2 * core::kPi * i / kAzimuths;
      tipping = std::min(
          tipping, TippingTowards(facet.normal, std::cos(azimuth) * u + std::sin(azimuth) * v));
    }
    for (const Vector3d& edge : facet.edge_normals) {
      tipping = std::min(tipping, TippingTowards(facet.normal, edge));
    }
    return tipping;
  }

  // The facet that a body set down on `facet` ends on.
  std::size_t RestsOn(std::size_t facet) const {
    for (std::size_t rolls = 0; rolls < facets_.size() && !facets_[facet].Stable(); ++rolls) {
      facet = facets_[facet].beyond;
    }
    return facet;
  }

  double Area(const Facet& facet) const {
    double area = 0.0;
    for (const std::size_t t : facet.triangles) area += 0.5 * Cross(t).norm();
    return area;
  }

 private:
  const Vector3d& Vertex(std::size_t triangle, int corner) const {
    return mesh_.vertices[mesh_.triangles[triangle][static_cast<std::size_t>(corner % 3)]];
  }
  Vector3d Cross(std::size_t t) const {
    return (Vertex(t, 1) - Vertex(t, 0)).cross(Vertex(t, 2) - Vertex(t, 0));
  }

  // Largest triangles first, so that slivers with noisy normals join a facet rather than found one.
  void BuildFacets() {
    std::vector<std::size_t> order(mesh_.triangles.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return Cross(a).norm() > Cross(b).norm();
    });
    facet_of_.resize(order.size());
    for (const std::size_t t : order) {
      const auto same =
          std::find_if(facets_.begin(), facets_.end(), [&](const Facet& f) { return Lies(t, f); });
      if (same == facets_.end()) {
        const Vector3d normal = Cross(t).normalized();
        Facet facet;
        facet.normal = normal;
        facet.offset = normal.dot(Vertex(t, 0));
        facets_.push_back(facet);
        facet_of_[t] = facets_.size() - 1;
      } else {
        facet_of_[t] = static_cast<std::size_t>(same - facets_.begin());
      }
      facets_[facet_of_[t]].triangles.push_back(t);
    }
  }

  bool Lies(std::size_t t, const Facet& facet) const {
    for (int k = 0; k < 3; ++k) {
      if (std::abs(facet.normal.dot(Vertex(t, k)) - facet.offset) > kCoplanar_m) return false;
    }
    return Cross(t).normalized().dot(facet.normal) > std::cos(kCoplanarAngle_rad) ||
           Cross(t).norm() < 1e-8;
  }

  void Measure(Facet& facet) {
    if (twins_.empty()) {
      for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
          twins_[{mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]}] = t;
        }
      }
    }
    facet.least_inside = 1e9;
    for (const std::size_t t : facet.triangles) {
      facet.solid_angle += SolidAngle(Vertex(t, 0), Vertex(t, 1), Vertex(t, 2));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto twin = twins_.find({mesh_.triangles[t][(k + 1) % 3], mesh_.triangles[t][k]});
        if (twin == twins_.end() || facet_of_[twin->second] == facet_of_[t]) continue;
        const Vector3d& a = Vertex(t, static_cast<int>(k));
        const Vector3d outward =
            (Vertex(t, static_cast<int>(k) + 1) - a).cross(facet.normal).normalized();
        facet.edge_normals.push_back(outward);
        const double inside = outward.dot(a - facet.offset * facet.normal);
        if (inside >= facet.least_inside) continue;
        facet.least_inside = inside;
        facet.beyond = facet_of_[twin->second];
      }
    }
  }

  double TippingTowards(const Vector3d& down, const Vector3d& side) const {
    const double ripple = kRipple * Height(down);
    double highest = Height(down);
    double at = 0.0;
    for (double tilt = kTiltStep_rad; tilt < core::kPi / 2; tilt += kTiltStep_rad) {
      const double height = Height(std::cos(tilt) * down + std::sin(tilt) * side);
      if (height > highest) {
        highest = height;
        at = tilt;
      }
      if (height < highest - ripple) return at;
    }
    return core::kPi / 2;
  }

  geometry::TriangleMesh mesh_;
  std::vector<Facet> facets_;
  std::vector<std::size_t> facet_of_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> twins_;
};

// Collision vertices in the root body's frame, of an object alone at its zero pose.
geometry::TriangleMesh CollisionHull(const mjModel* model, const mjData* data, int root) {
  geometry::Points points;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!internal::Collides(model, geom)) continue;
    const core::Pose X_WG = internal::GeomPose(data, geom);
    for (const Vector3d& v : internal::GeomSurface(model, geom, kSegments).vertices)
      points.push_back(X_WG * v);
  }
  const core::Pose X_BW =
      core::MakePose(
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * root),
          Eigen::Map<const Vector3d>(data->xpos + 3 * root))
          .inverse();
  for (Vector3d& p : points) p = X_BW * p;
  return geometry::ConvexHull(points);
}

Vector3d CenterOfMass(const mjModel* model, const mjData* data, int root) {
  Vector3d moment = Vector3d::Zero();
  for (int body = root; body < model->nbody; ++body) {
    moment += model->body_mass[body] * Eigen::Map<const Vector3d>(data->xipos + 3 * body);
  }
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_WB(data->xmat + 9 * root);
  const Vector3d center_W = moment / model->body_subtreemass[root];
  return R_WB.transpose() * (center_W - Eigen::Map<const Vector3d>(data->xpos + 3 * root));
}

struct PoseClass {
  std::size_t facet;  // the lowest member stands for it
  double center_height_m;
  double area_m2;
  double tipping_rad;
  double solid_angle = 0.0;
};

// The class that a facet belongs to: found cheaply for twins of a known member, else by its tilt
// margin.
PoseClass& ClassOf(const Hull& hull, std::size_t facet, std::vector<PoseClass>& classes) {
  const double height = hull.facets()[facet].offset;
  const double area = hull.Area(hull.facets()[facet]);
  for (PoseClass& c : classes) {
    if (std::abs(c.center_height_m - height) < 0.2 * kSameHeight_m &&
        std::abs(c.area_m2 - area) < 0.02 * area) {
      return c;
    }
  }
  const double tipping = hull.Tipping(hull.facets()[facet]);
  for (PoseClass& c : classes) {
    if (std::abs(c.center_height_m - height) > kSameHeight_m ||
        std::abs(c.tipping_rad - tipping) > kSameTilt_rad) {
      continue;
    }
    if (height < c.center_height_m - 1e-6) {
      c.facet = facet;
      c.center_height_m = height;
      c.area_m2 = area;
    }
    return c;
  }
  classes.push_back({facet, height, area, tipping});
  return classes.back();
}

}  // namespace

std::vector<RestingPose> StableRestingPoses(const ObjectModel& object, double min_tipping_rad) {
  const internal::BuiltScene built = internal::BuildObject(object);
  const mjModel* model = built.model.get();
  const int root = built.objects[0].body;
  mjData* raw = nullptr;
  internal::CallEngine(nullptr, [&] { raw = mj_makeData(model); });
  const internal::DataPtr data(raw);
  internal::CallEngine(nullptr, [&] {
    mj_kinematics(model, raw);
    mj_comPos(model, raw);
  });
  const Vector3d center_B = CenterOfMass(model, raw, root);
  const Hull hull(CollisionHull(model, raw, root), center_B);

  std::vector<PoseClass> classes;
  for (std::size_t f = 0; f < hull.facets().size(); ++f) {
    const std::size_t rest = hull.RestsOn(f);
    if (!hull.facets()[rest].Stable()) continue;
    ClassOf(hull, rest, classes).solid_angle += hull.facets()[f].solid_angle;
  }
  std::erase_if(classes, [&](const PoseClass& c) { return c.tipping_rad < min_tipping_rad; });
  std::stable_sort(classes.begin(), classes.end(), [](const PoseClass& a, const PoseClass& b) {
    return a.solid_angle > b.solid_angle;
  });
  double total = 0.0;
  for (const PoseClass& c : classes) total += c.solid_angle;

  std::vector<RestingPose> poses;
  for (const PoseClass& c : classes) {
    const Facet& facet = hull.facets()[c.facet];
    RestingPose pose;
    pose.R_WO = Eigen::Quaterniond::FromTwoVectors(facet.normal, -Vector3d::UnitZ());
    pose.height_m = facet.offset + facet.normal.dot(center_B);
    pose.probability = c.solid_angle / total;
    pose.tipping_rad = c.tipping_rad;
    pose.label = "pose" + std::to_string(poses.size());
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace rangegrasp::sim
