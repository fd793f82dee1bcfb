#include "parts/shape/shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "parts/baselines/baselines.h"
#include "parts/hierarchy/hierarchy.h"
#include "parts/mirror/mirroring.h"
#include "parts/shape/segmentation.h"
#include "parts/shape/shape_file.h"
#include "parts/shape/shape_graph.h"
#include "parts/solids.h"
#include "parts/stretched/embedding.h"
#include "temp_folder.h"

namespace rangegrasp::parts {
namespace {

using base::InputError;
using base::Rng;
using geometry::TriangleMesh;
using ::testing::HasSubstr;
using testing_support::TempFolder;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(MakeShape, AGoodMeshStaysAsItIs) {
  const Shape shape = MakeShape(samples::Tetrahedron());
  EXPECT_EQ(shape.points, samples::Tetrahedron().vertices);
  EXPECT_EQ(shape.faces, samples::Tetrahedron().triangles);
  EXPECT_EQ(shape.element_of_input, (std::vector<std::int32_t>{0, 1, 2, 3}));
}

TEST(MakeShape, LeavesOutWhatIsNoFaceAndJoinsEqualVertices) {
  TriangleMesh mesh = samples::Tetrahedron();
  mesh.vertices.push_back({kNan, 0, 0});                                     // 4
  mesh.vertices.push_back({1, 0, 0});                                        // 5: equal to 1
  mesh.vertices.push_back({9, 9, 9});                                        // 6: unused
  mesh.vertices.push_back({2, 0, 0});                                        // 7
  mesh.vertices.push_back({std::numeric_limits<double>::infinity(), 0, 0});  // 8
  mesh.triangles = {{0, 2, 1}, {0, 4, 1}, {0, 5, 3}, {1, 5, 3},  {0, 3, 2},
                    {0, 1, 7}, {5, 2, 3}, {0, 0, 1}, {0, 1, 99}, {0, 8, 1}};
  const Shape shape = MakeShape(mesh);
  EXPECT_EQ(shape.points, samples::Tetrahedron().vertices);
  EXPECT_EQ(shape.faces, samples::Tetrahedron().triangles);
  EXPECT_EQ(shape.element_of_input,
            (std::vector<std::int32_t>{0, -1, 1, -1, 2, -1, 3, -1, -1, -1}));
}

TEST(MakeShape, APointThatStandsTwiceIsOneElementOfACloud) {
  const Shape cloud = MakeShape({.vertices = {{0, 0, 0},
                                              {kNan, kNan, kNan},
                                              {1, 0, 0},
                                              {0, 1, 0},
                                              {1, 0, 0},
                                              {-0.0, 0, 0},
                                              {0, 0, 1}},
                                 .triangles = {}});
  EXPECT_EQ(cloud.points.size(), 4U);
  EXPECT_FALSE(cloud.IsMesh());
  EXPECT_EQ(cloud.element_of_input, (std::vector<std::int32_t>{0, -1, 1, 2, 1, 0, 3}));
}

void ExpectRefused(const TriangleMesh& mesh, const std::string& says) {
  EXPECT_THAT(testing_support::ErrorOf([&] { MakeShape(mesh); }), HasSubstr(says));
}

TEST(MakeShape, SaysWhatIsWrong) {
  ExpectRefused({}, "only 0 different finite points");
  ExpectRefused({.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}}, .triangles = {}},
                "only 3 different finite points");
  ExpectRefused(
      {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 7, 0}}, .triangles = {}},
      "one plane");
  ExpectRefused({.vertices = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}}, .triangles = {}},
                "one plane");
  TriangleMesh mesh = samples::Tetrahedron();
  mesh.triangles = {{0, 1, 1}, {7, 8, 9}};
  ExpectRefused(mesh, "none of its 2 faces");
  mesh.triangles = {{0, 1, 2}};
  ExpectRefused(mesh, "only 3 different finite points");
}

TEST(FaceGraph, LinksAreThoseOfBruteForce) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    Shape shape;
    shape.points.resize(12, Eigen::Vector3d::Zero());
    for (int f = 0; f < 30; ++f) {
      std::array<std::uint32_t, 3> face{};
      do {
        for (auto& v : face) v = static_cast<std::uint32_t>(rng.Index(12));
      } while (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]);
      shape.faces.push_back(face);
    }
    const FaceGraph graph = BuildFaceGraph(shape);
    using Link = std::tuple<std::uint32_t, std::uint32_t, std::array<std::uint32_t, 2>>;
    std::set<Link> expected;
    for (std::uint32_t f = 0; f < 30; ++f) {
      for (std::uint32_t g = 0; g < 30; ++g) {
        for (std::uint32_t a = 0; f != g && a < 12; ++a) {
          for (std::uint32_t b = a + 1; b < 12; ++b) {
            const auto has = [&](std::uint32_t face) {
              const auto& corners = shape.faces[face];
              return std::ranges::count(corners, a) == 1 && std::ranges::count(corners, b) == 1;
            };
            if (has(f) && has(g)) expected.insert({f, g, {a, b}});
          }
        }
      }
    }
    std::set<Link> found;
    for (std::uint32_t f = 0; f < 30; ++f) {
      for (std::uint32_t k = graph.begin[f]; k < graph.begin[f + 1]; ++k) {
        found.insert({f, graph.neighbor[k], graph.edge[k]});
      }
    }
    EXPECT_EQ(found, expected) << seed;
  }
}

TEST(FaceGraph, AFanOfManyFacesStaysInOnePieceWithFewLinks) {
  Shape shape;
  shape.points.resize(10'002, Eigen::Vector3d::Zero());
  for (std::uint32_t f = 0; f < 10'000; ++f) shape.faces.push_back({0, 1, f + 2});
  const FaceGraph graph = BuildFaceGraph(shape);
  EXPECT_EQ(graph.neighbor.size(), 2U * 9'999U);
}

TEST(VertexGraph, OfAMeshIsItsEdges) {
  const Shape ball = samples::Ball(6, [](const Eigen::Vector3d&) { return 1.0; });
  const VertexGraph graph = BuildVertexGraph(ball);
  // Euler: E = V + F - 2; each edge counts in both directions.
  EXPECT_EQ(graph.neighbor.size(), 2 * (ball.points.size() + ball.faces.size() - 2));
  for (std::uint32_t v = 0; v < ball.points.size(); ++v) {
    for (std::uint32_t k = graph.begin[v]; k < graph.begin[v + 1]; ++k) {
      EXPECT_EQ(graph.length[k], (ball.points[v] - ball.points[graph.neighbor[k]]).norm());
    }
  }
}

TEST(VertexGraph, OfACloudHoldsEveryPointsNearestBothWays) {
  Rng rng(1);
  Shape cloud;
  for (int i = 0; i < 300; ++i) {
    cloud.points.emplace_back(rng.Uniform(), rng.Uniform(), rng.Uniform());
  }
  const VertexGraph graph = BuildVertexGraph(cloud);
  const auto linked = [&](std::uint32_t a, std::uint32_t b) {
    return std::find(graph.neighbor.begin() + graph.begin[a],
                     graph.neighbor.begin() + graph.begin[a + 1],
                     b) != graph.neighbor.begin() + graph.begin[a + 1];
  };
  for (std::uint32_t a = 0; a < 300; ++a) {
    std::vector<std::pair<double, std::uint32_t>> others;
    for (std::uint32_t b = 0; b < 300; ++b) {
      if (a != b) others.emplace_back((cloud.points[a] - cloud.points[b]).norm(), b);
    }
    std::sort(others.begin(), others.end());
    for (std::size_t k = 0; k < kCloudNeighbors; ++k) {
      EXPECT_TRUE(linked(a, others[k].second));
      EXPECT_TRUE(linked(others[k].second, a));
    }
  }
}

TEST(LabelsOfInput, ElementsThatWereLeftOutTakeTheNearestOnes) {
  TriangleMesh mesh = samples::Tetrahedron();
  mesh.vertices.push_back({kNan, 0, 0});
  mesh.triangles.insert(mesh.triangles.begin(), {0, 1, 4});  // without a position
  mesh.triangles.push_back({2, 3, 2});                       // near the face 1, 2, 3
  const Shape shape = MakeShape(mesh);
  Segmentation segmentation;
  segmentation.label = {5, 6, 7, 8};
  EXPECT_EQ(LabelsOfInput(shape, mesh, segmentation),
            (std::vector<std::int32_t>{-1, 5, 6, 7, 8, 7}));
}

// ---- files ----

TEST(ReadShape, FaceIOfTheFileIsElementI) {
  const TempFolder folder;
  const std::string off =
      "OFF\n5 5 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0\n"
      "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 4 2 3\n3 0 0 1\n";
  const auto file = folder.Write("t.off", off);
  const Shape shape = ReadShape(file);
  EXPECT_EQ(shape.faces.size(), 4U);
  EXPECT_EQ(shape.element_of_input.size(), 5U);
  EXPECT_EQ(shape.element_of_input.back(), -1);
  const auto mesh = ReadPolygons(file).mesh;
  EXPECT_EQ(mesh.triangles.size(), 5U);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    EXPECT_EQ(mesh.vertices[mesh.triangles[3][corner]],
              (std::array<Eigen::Vector3d, 3>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}[corner]));
  }
}

// The number of elements of each file equals the number of its human labels.
TEST(ReadShape, ReadsTheBenchmarksModelsFaceByFace) {
  const std::filesystem::path data =
      std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared/data/psb";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no benchmark meshes at " << data;
  for (const int id : {21, 61, 341, 384}) {
    const auto off = data / "off" / (std::to_string(id) + ".off");
    const std::string seg =
        base::ReadFile(data / "seg" / std::to_string(id) / (std::to_string(id) + "_0.seg"));
    const Shape shape = ReadShape(off);
    EXPECT_EQ(shape.element_of_input.size(),
              static_cast<std::size_t>(std::count(seg.begin(), seg.end(), '\n')));
  }
}

TEST(ReadShape, APlyWithoutFacesAndAPcdAreClouds) {
  const TempFolder folder;
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n0.3 0.3 0.2\n";
  const auto ply = folder.Write("c.ply",
                                "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
                                "property float y\nproperty float z\nend_header\n" +
                                    points);
  const auto pcd = folder.Write(
      "c.pcd",
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 5\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 5\nDATA ascii\n" +
          points);
  for (const auto& file : {ply, pcd}) {
    const Shape shape = ReadShape(file);
    EXPECT_FALSE(shape.IsMesh());
    EXPECT_EQ(shape.points.size(), 5U);
  }
}

TEST(ReadShape, AnOffFileThatDoesNotHoldWhatItDeclaresIsRefused) {
  const TempFolder folder;
  const auto refused = [&](const std::string& text) {
    return testing_support::ErrorOf([&] { ReadShape(folder.Write("a.off", text)); });
  };
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const std::string three = "3 0 1 2\n3 0 1 3\n3 0 2 3\n";
  EXPECT_NO_THROW(ReadShape(folder.Write("a.off", "OFF\n4 4 0\n" + points + three + "3 1 2 3\n")));
  EXPECT_THAT(refused("OFF\n4 4 0\n" + points + three + "3 1 2 4\n"),
              HasSubstr("a.off:10: face 3 uses vertex '4'; there are 4, from 0"));
  EXPECT_THAT(refused("OFF\n4 4 0\n" + points + three + "3 1 2 -1\n"), HasSubstr("a.off:10"));
  EXPECT_THAT(refused("OFF 4 5 0\n" + points + three + "3 1 2 3\n# nothing more\n     \n"),
              HasSubstr("face 4 of 5"));
  EXPECT_THAT(refused("OFF\n4 400000000 0\n" + points + three), HasSubstr("is too short for them"));
  EXPECT_THAT(refused("OFF\n4\n" + points + three), HasSubstr("numbers of vertices and faces"));
}

TEST(ReadShape, NamesTheFile) {
  const TempFolder folder;
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"e.off", ""},
           {"t.off", "hello"},
           {"f.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n"},
           {"p.ply", "ply\n"},
           {"c.pcd", "VERSION .7\n"},
           {"s.stl", "solid x\nendsolid x\n"},
           {"o.obj", "v 0 0 0\n"},
           {"x.xyz", "1 2 3\n"}}) {
    const auto file = folder.Write(name, text);
    EXPECT_THAT(testing_support::ErrorOf([&] { ReadShape(file); }), HasSubstr(file.string()));
  }
  EXPECT_THROW(ReadShape(folder / "none.off"), InputError);
}

// Valid files, before they are damaged.
std::vector<std::pair<std::string, std::string>> WholeFiles() {
  const Shape ball =
      samples::Ball(2, [](const Eigen::Vector3d& d) { return 1.0 + 0.5 * std::max(0.0, d.x()); });
  std::string off = "OFF\n" + std::to_string(ball.points.size()) + " " +
                    std::to_string(ball.faces.size()) + " 0\n";
  std::string ply = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(ball.points.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                    std::to_string(ball.faces.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string pcd = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
                    std::to_string(ball.points.size()) +
                    "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
                    std::to_string(ball.points.size()) + "\nDATA ascii\n";
  std::string obj;
  std::string stl = "solid ball\n";
  const auto text = [](const Eigen::Vector3d& p) {
    return std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  };
  for (const auto& p : ball.points) {
    off += text(p);
    ply += text(p);
    pcd += text(p);
    obj += "v " + text(p);
  }
  for (const auto& f : ball.faces) {
    const auto corners = [&f](std::uint32_t from) {
      return std::to_string(f[0] + from) + " " + std::to_string(f[1] + from) + " " +
             std::to_string(f[2] + from) + "\n";
    };
    off += "3 " + corners(0);
    ply += "3 " + corners(0);
    obj += "f " + corners(1);
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const std::uint32_t v : f) stl += "vertex " + text(ball.points[v]);
    stl += "endloop\nendfacet\n";
  }
  return {{"b.off", off},
          {"b.ply", ply},
          {"b.pcd", pcd},
          {"b.obj", obj},
          {"b.stl", stl + "endsolid ball\n"}};
}

std::string CleanShapeDamaged(std::string bytes, Rng& rng) {
  if (rng.Uniform() < 0.2) bytes.resize(rng.Index(bytes.size()));
  const std::size_t changes = rng.Index(8);
  for (std::size_t k = 0; k < changes && !bytes.empty(); ++k) {
    const std::string pool = "0123456789.-e \nnaif\0\xff";
    char& c = bytes[rng.Index(bytes.size())];
    c = rng.Uniform() < 0.7 ? pool[rng.Index(pool.size())] : static_cast<char>(rng.Index(256));
  }
  if (rng.Uniform() < 0.2) {  // a line repeated or removed
    const std::size_t at = std::min(bytes.find('\n', rng.Index(bytes.size() + 1)), bytes.size());
    const std::size_t end = std::min(bytes.find('\n', at + 1), bytes.size());
    if (rng.Uniform() < 0.5) {
      bytes.erase(at, end - at);
    } else {
      bytes.insert(at, bytes.substr(at, end - at));
    }
  }
  return bytes;
}

void ExpectLabels(const Shape& shape, const Segmentation& parts) {
  ASSERT_EQ(parts.label.size(), shape.Elements());
  ASSERT_GE(parts.parts, 1);
  for (const std::int32_t l : parts.label) {
    ASSERT_GE(l, 0);
    ASSERT_LT(l, parts.parts);
  }
}

void ExpectEveryMethodToAnswer(const Shape& shape) {
  ExpectLabels(shape, SegmentByMirroring(shape, /*go_on_outside=*/true));
  ExpectLabels(shape, SegmentByMirroring(PoseInvariant(shape), /*go_on_outside=*/true));
  if (!shape.IsMesh()) return;
  ExpectLabels(shape, SegmentHierarchy(shape, {}));
  ExpectLabels(shape, SegmentByKMeans(shape, {}));
  ExpectLabels(shape, SegmentBySdf(shape));
  ExpectLabels(shape, SegmentByCoreExtraction(shape));
}

TEST(Robustness, OddShapesHaveAResultWithEveryMethod) {
  const auto round = [](const Eigen::Vector3d&) { return 1.0; };
  const Shape shape = samples::Ball(6, round);
  const TriangleMesh ball{shape.points, shape.faces};
  ExpectEveryMethodToAnswer(MakeShape(ball));
  TriangleMesh open = ball;
  open.triangles.resize(open.triangles.size() / 2);
  ExpectEveryMethodToAnswer(MakeShape(open));
  TriangleMesh pieces = ball;  // three balls: two far apart and one inside another
  for (const double scale : {0.5, 0.2}) {
    TriangleMesh piece = ball;
    for (auto& p : piece.vertices) {
      p = scale * p + Eigen::Vector3d(scale > 0.3 ? 4.0 : 0.0, 0.0, 0.0);
    }
    geometry::Append(piece, pieces);
  }
  ExpectEveryMethodToAnswer(MakeShape(pieces));
  TriangleMesh fins = ball;  // three more faces on one edge, and every face twice
  for (int k = 0; k < 3; ++k) {
    fins.vertices.emplace_back(2.0, 0.3 * k, 1.0);
    fins.triangles.push_back({ball.triangles[0][0], ball.triangles[0][1],
                              static_cast<std::uint32_t>(fins.vertices.size() - 1)});
  }
  fins.triangles.insert(fins.triangles.end(), ball.triangles.begin(), ball.triangles.end());
  ExpectEveryMethodToAnswer(MakeShape(fins));
  ExpectEveryMethodToAnswer(MakeShape(samples::Tetrahedron()));
  ExpectEveryMethodToAnswer(MakeShape({.vertices = ball.vertices, .triangles = {}}));
  ExpectEveryMethodToAnswer(
      MakeShape({.vertices = samples::Tetrahedron().vertices, .triangles = {}}));
}

TEST(Robustness, AThousandDamagedFilesGiveAResultOrAnErrorThatNamesThem) {
  const TempFolder folder;
  int segmented = 0;
  int refused = 0;
  for (const auto& [name, whole] : WholeFiles()) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      Rng rng(seed);
      const auto file = folder.Write(name, CleanShapeDamaged(whole, rng));
      Shape shape;
      try {
        shape = ReadShape(file);
      } catch (const InputError& error) {
        ASSERT_THAT(error.what(), HasSubstr(name));
        ++refused;
        continue;
      }
      const Segmentation parts = SegmentByMirroring(shape, /*go_on_outside=*/true);
      ExpectLabels(shape, parts);
      ++segmented;
      if (!shape.IsMesh() || seed % 5 != 0) continue;
      ExpectLabels(shape, SegmentHierarchy(shape, {}));
      ExpectLabels(shape, SegmentByKMeans(shape, {}));
      ExpectLabels(shape, SegmentByCoreExtraction(shape));
      ExpectLabels(shape, SegmentBySdf(shape));
      ExpectLabels(shape, SegmentByMirroring(PoseInvariant(shape), /*go_on_outside=*/true));
    }
  }
  EXPECT_GT(segmented, 200);
  EXPECT_GT(refused, 200);
}

// The area by Heron's formula, from the three sides alone. The normal is perpendicular to all sides
// and points to the side from which the corners run counterclockwise.
TEST(FaceFrames, OfRandomTrianglesAreThoseOfTheirSides) {
  base::Rng rng(1);
  Shape soup;
  for (std::uint32_t f = 0; f < 1000; ++f) {
    for (int i = 0; i < 3; ++i) soup.points.emplace_back(rng.Normal(), rng.Normal(), rng.Normal());
    soup.faces.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  const FaceFrames frames = BuildFaceFrames(soup);
  double total = 0.0;
  for (std::size_t f = 0; f < 1000; ++f) {
    const Eigen::Vector3d &p = soup.points[3 * f], &q = soup.points[3 * f + 1],
                          &r = soup.points[3 * f + 2];
    const double a = (q - p).norm(), b = (r - q).norm(), c = (p - r).norm(), s = 0.5 * (a + b + c);
    // Heron's formula loses half of the digits for slivers.
    const double area = std::sqrt(std::max(0.0, s * (s - a) * (s - b) * (s - c)));
    EXPECT_NEAR(frames.area[f], area, 1e-7);
    EXPECT_NEAR(frames.normal[f].norm(), 1.0, 1e-12);
    for (const Eigen::Vector3d side : {q - p, r - q, p - r}) {
      EXPECT_NEAR(frames.normal[f].dot(side), 0.0, 1e-9);
    }
    EXPECT_GT(frames.normal[f].dot((q - p).cross(r - p)), 0.0);
    EXPECT_LT((3.0 * frames.center[f] - p - q - r).norm(), 1e-12);
    total += area;
  }
  EXPECT_NEAR(frames.total_area, total, 1e-6);
}

// The area is less than that of the ball, because the faces' corners lie on it.
TEST(FaceFrames, AreasOfABallAddUpToItsSurface) {
  const FaceFrames frames =
      BuildFaceFrames(samples::Ball(24, [](const Eigen::Vector3d&) { return 2.0; }));
  EXPECT_LT(frames.total_area, 16.0 * M_PI);
  // A spherical triangle is larger than the flat one by (a^2 + b^2 + c^2) / 24; on the unit ball no
  // side is longer than a cell's diagonal, sqrt(2) * 2 / 24.
  const double side = std::sqrt(2.0) * 2.0 / 24.0;
  EXPECT_GT(frames.total_area, 16.0 * M_PI * (1.0 - 3.0 * side * side / 24.0));
  for (std::size_t f = 0; f < frames.area.size(); ++f) {
    EXPECT_GT(frames.normal[f].dot(frames.center[f]), 0.0);
  }
}

}  // namespace
}  // namespace rangegrasp::parts
