#include "grasp/surface.h"

#include <map>

#include "perception/perceive.h"

namespace rangegrasp::grasp {
namespace {

using Eigen::Vector3d;
using geometry::TriangleMesh;
using perception::PerceivedObject;
using perception::Scene;

/// Area of a perceived point: neighbors are about 2 mm apart in a scan.
constexpr double kPointArea_m2 = 4e-6;
/// Smallest share of the bounding box that a solid fills: less than any shape met. Below it, the
/// surface is a shell with gaps, and its "volume" is noise.
constexpr double kMinFilled = 0.1;
/// Half the side of a speck: as small as a point in comparisons, but with an area.
constexpr double kHalfSpeck_m = 0.0005;

double TotalArea(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d& p = mesh.vertices[a];
    area += 0.5 * (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm();
  }
  return area;
}

double Fraction(double x) { return x - std::floor(x); }

/// Grid of the specks for objects whose surface is not known.
constexpr double kSpeckCell_m = 0.002;

}  // namespace

SurfaceSamples SampleSurface(const TriangleMesh& mesh, std::size_t count) {
  SurfaceSamples samples;
  const double total = TotalArea(mesh);
  if (total <= 0.0 || count == 0) return samples;
  samples.area_m2 = total / static_cast<double>(count);
  // 1/g and 1/g^2 of the plastic number g.
  constexpr double kU = 0.7548776662466927;
  constexpr double kV = 0.5698402909980532;
  double due = 0.5;
  std::size_t drawn = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d& p = mesh.vertices[a];
    const Vector3d& q = mesh.vertices[b];
    const Vector3d& r = mesh.vertices[c];
    const Vector3d w = (q - p).cross(r - p);
    const double norm = w.norm();
    if (norm <= 0.0) continue;
    due += 0.5 * norm / samples.area_m2;
    for (; due >= 1.0; due -= 1.0, ++drawn) {
      const auto k = static_cast<double>(drawn + 1);
      samples.points.push_back(
          geometry::TrianglePoint(p, q, r, Fraction(0.5 + k * kU), Fraction(0.5 + k * kV)));
      samples.normals.push_back(w / norm);
    }
  }
  return samples;
}

SurfaceSamples SampleObject(const Scene& scene, const PerceivedObject& object, std::size_t count) {
  SurfaceSamples samples = SampleSurface(object.surface_C, count);
  if (!samples.points.empty()) return samples;
  const bool normals = scene.cloud.normals.size() == scene.cloud.points.size();
  for (const std::uint32_t i : object.points) {
    samples.points.push_back(scene.cloud.points[i]);
    samples.normals.push_back(normals ? scene.cloud.normals[i] : scene.table.plane.normal);
  }
  samples.area_m2 = kPointArea_m2;
  return samples;
}

Vector3d CenterOfMass(const TriangleMesh& mesh, geometry::PointSpan sampled) {
  if (sampled.empty()) return Vector3d::Zero();
  const Vector3d mean = geometry::Centroid(sampled);
  const Eigen::AlignedBox3d box = geometry::BoundsOf(sampled);
  double six_volumes = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d u = mesh.vertices[a] - mean;
    const Vector3d v = mesh.vertices[b] - mean;
    const Vector3d w = mesh.vertices[c] - mean;
    const double six = u.dot(v.cross(w));
    six_volumes += six;
    moment += six * (u + v + w) / 4.0;
  }
  if (std::abs(six_volumes) / 6.0 < kMinFilled * box.volume()) return mean;
  const Vector3d center = mean + moment / six_volumes;
  return box.contains(center) ? center : mean;
}

std::array<long, 3> GridCell(const Vector3d& p, double cell_m) {
  const Vector3d c = (p / cell_m).array().floor();
  return {std::lround(c.x()), std::lround(c.y()), std::lround(c.z())};
}

TriangleMesh SpeckMesh(geometry::PointSpan points, double cell_m) {
  std::map<std::array<long, 3>, Vector3d> cells;
  for (const Vector3d& p : points) cells.try_emplace(GridCell(p, cell_m), p);
  TriangleMesh mesh;
  for (const auto& [cell, p] : cells) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(p + Vector3d(kHalfSpeck_m, 0.0, -kHalfSpeck_m));
    mesh.vertices.push_back(p + Vector3d(-kHalfSpeck_m, kHalfSpeck_m, 0.0));
    mesh.vertices.push_back(p + Vector3d(0.0, -kHalfSpeck_m, kHalfSpeck_m));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

PerceivedObject ObjectOfPoints(const Scene& scene, geometry::Indices points) {
  PerceivedObject object;
  object.points = std::move(points);
  object.completed_C = geometry::Select(scene.cloud.points, object.points);
  object.surface_C = SpeckMesh(object.completed_C, kSpeckCell_m);
  perception::SetBox(scene.table.plane, object);
  return object;
}

TriangleMesh SurfaceOf(const PerceivedObject& object) {
  if (!object.surface_C.triangles.empty()) return object.surface_C;
  return SpeckMesh(object.completed_C, kSpeckCell_m);
}

std::vector<TriangleMesh> Others(const Scene& scene, std::size_t own,
                                 std::span<const TriangleMesh> obstacles_C) {
  std::vector<TriangleMesh> surfaces(obstacles_C.begin(), obstacles_C.end());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (i != own) surfaces.push_back(SurfaceOf(scene.objects[i]));
  }
  return surfaces;
}

}  // namespace rangegrasp::grasp
