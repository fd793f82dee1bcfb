#include "recognition/library.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "recognition/internal/prepared_object.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Vector3d;

// Errors of drawings and scans vary slowly over an object, not from point to point.
constexpr double kShortestWave_m = 0.05;
constexpr double kLongestWave_m = 0.10;
constexpr int kWaves = 12;
// A fifth of the shortest wave: longer edges could not reproduce it.
constexpr double kMaxEdge_m = 0.01;

struct Wave {
  Vector3d k, amplitude;
  double phase;
};

Vector3d RandomVector(base::Rng& rng) {
  const double x = rng.Normal();
  const double y = rng.Normal();
  const double z = rng.Normal();
  return {x, y, z};
}

std::vector<Wave> RandomWaves(base::Rng& rng) {
  std::vector<Wave> waves;
  for (int i = 0; i < kWaves; ++i) {
    const Vector3d direction = RandomVector(rng).normalized();
    const Vector3d amplitude = RandomVector(rng);
    const double length_m = rng.Uniform(kShortestWave_m, kLongestWave_m);
    const double phase = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    waves.push_back({2.0 * std::numbers::pi / length_m * direction, amplitude, phase});
  }
  return waves;
}

// A triangle with the texture coordinates of its corners, or 0 if it has none.
struct Corners {
  std::array<Vector3d, 3> p;
  std::array<Eigen::Vector2f, 3> uv;
};

// Halves the longest edge until none is longer than kMaxEdge_m. An edge of two triangles is halved
// at the same points in both, so that the surface stays closed.
void AddSplit(const Corners& t, std::vector<Corners>& parts) {
  std::size_t longest = 0;
  std::array<double, 3> length{};
  for (std::size_t i = 0; i < 3; ++i) {
    length[i] = (t.p[(i + 1) % 3] - t.p[i]).norm();
    if (length[i] > length[longest]) longest = i;
  }
  if (length[longest] <= kMaxEdge_m) {
    parts.push_back(t);
    return;
  }
  const std::size_t a = longest, b = (longest + 1) % 3;
  Corners first = t, second = t;
  first.p[b] = second.p[a] = 0.5 * (t.p[a] + t.p[b]);
  first.uv[b] = second.uv[a] = 0.5F * (t.uv[a] + t.uv[b]);
  AddSplit(first, parts);
  AddSplit(second, parts);
}

geometry::ColoredMesh Split(const geometry::ColoredMesh& whole) {
  geometry::ColoredMesh split;
  split.colors.print = whole.colors.print;
  const auto& corners = whole.mesh.vertices;
  for (std::size_t t = 0; t < whole.mesh.triangles.size(); ++t) {
    const auto [a, b, c] = whole.mesh.triangles[t];
    Corners triangle{{corners[a], corners[b], corners[c]}, {}};
    triangle.uv.fill(Eigen::Vector2f::Zero());
    if (whole.colors.print) triangle.uv = whole.colors.uv[t];
    std::vector<Corners> parts;
    AddSplit(triangle, parts);
    for (const Corners& part : parts) {
      const auto first = static_cast<std::uint32_t>(split.mesh.vertices.size());
      split.mesh.vertices.insert(split.mesh.vertices.end(), part.p.begin(), part.p.end());
      split.mesh.triangles.push_back({first, first + 1, first + 2});
      if (whole.colors.print) split.colors.uv.push_back(part.uv);
      if (!whole.colors.plain.empty()) split.colors.plain.push_back(whole.colors.plain[t]);
    }
  }
  return split;
}

}  // namespace

geometry::ColoredMesh Distorted(const geometry::ColoredMesh& exact, double rms_m, base::Rng& rng) {
  const std::vector<Wave> waves = RandomWaves(rng);
  geometry::ColoredMesh distorted = Split(exact);
  geometry::Points& vertices = distorted.mesh.vertices;
  geometry::Points displacements;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : vertices) {
    Vector3d d = Vector3d::Zero();
    for (const Wave& wave : waves) d += std::sin(wave.k.dot(p) + wave.phase) * wave.amplitude;
    displacements.push_back(d);
    mean += d / static_cast<double>(vertices.size());
  }
  double squares = 0.0;
  for (const Vector3d& d : displacements) squares += (d - mean).squaredNorm();
  const double scale = rms_m / std::sqrt(squares / static_cast<double>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    vertices[i] += scale * (displacements[i] - mean);
  }
  return distorted;
}

KnownObject MakeKnownObject(std::string name, std::string title, geometry::TriangleMesh mesh_B,
                            geometry::MeshColors colors) {
  const std::size_t triangles = mesh_B.triangles.size();
  if ((colors.print && colors.uv.size() != triangles) ||
      (!colors.plain.empty() && colors.plain.size() != triangles)) {
    throw std::invalid_argument(fmt::format("{}: its colors belong to another mesh", name));
  }
  KnownObject object;
  object.name = std::move(name);
  object.title = std::move(title);
  object.mesh_B = std::move(mesh_B);
  object.colors = std::move(colors);
  object.surface_B = SampledSurface(object.mesh_B, 0.003);
  if (object.surface_B.size() < 4) {
    throw std::invalid_argument(
        fmt::format("{}: its mesh is too small to be an object", object.name));
  }
  object.symmetry = SymmetryOf(object.mesh_B, object.surface_B);
  return object;
}

Library::Library(std::vector<KnownObject> objects) {
  for (KnownObject& object : objects) {
    for (const auto& other : prepared_) {
      if (other->object.name != object.name) continue;
      throw std::invalid_argument("two known objects have the name " + object.name);
    }
    prepared_.push_back(std::make_shared<internal::PreparedObject>(std::move(object)));
  }
}

const internal::PreparedObject& Library::FindPrepared(const std::string& name) const {
  std::vector<std::string> known;
  for (const auto& one : prepared_) {
    if (one->object.name == name) return *one;
    known.push_back(one->object.name);
  }
  throw base::InputError(
      fmt::format("unknown object '{}'; known objects: {}", name, base::Join(known)));
}

const KnownObject& Library::Find(const std::string& name) const {
  return FindPrepared(name).object;
}

}  // namespace rangegrasp::recognition
