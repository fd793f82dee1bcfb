#include "parts/shape/shape_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "parts/shape/segmentation.h"
#include "parts/solids.h"
#include "temp_folder.h"

namespace rangegrasp::parts {
namespace {

using ::testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;

TEST(ShapeFileLabels, AreReadBackAsTheyWereWritten) {
  const TempFolder folder;
  base::Rng rng(1);
  Labels labels;
  for (int i = 0; i < 5000; ++i) labels.push_back(static_cast<std::int32_t>(rng.Index(300)) - 5);
  WriteLabels(folder / "a.seg", labels);
  EXPECT_EQ(ReadLabels(folder / "a.seg"), labels);
  EXPECT_EQ(ReadLabels(folder / "a.seg", labels.size()), labels);
}

TEST(ShapeFileLabels, EndsOfLinesAndBlanksRoundTheNumberDoNotCount) {
  const TempFolder folder;
  EXPECT_EQ(ReadLabels(folder.Write("a.seg", "1\r\n 2 \n3")), (Labels{1, 2, 3}));
  EXPECT_EQ(ReadLabels(folder.Write("b.seg", "1\n2\n\n\n")), (Labels{1, 2}));
  EXPECT_EQ(ReadLabels(folder.Write("c.seg", "")), Labels{});
}

TEST(ShapeFileLabels, WhatIsNoLabelIsToldWithItsLine) {
  const TempFolder folder;
  for (const char* wrong : {"x", "1.5", "1 2", "", "99999999999", "+1", "0x1"}) {
    const auto file = folder.Write("a.seg", "0\n1\n" + std::string(wrong) + "\n2\n");
    EXPECT_THAT(ErrorOf([&] { ReadLabels(file); }), HasSubstr("a.seg:3: '" + std::string(wrong)))
        << wrong;
  }
}

TEST(ShapeFileLabels, TooManyOrTooFewAreToldWithBothNumbers) {
  const TempFolder folder;
  const auto file = folder.Write("a.seg", "0\n1\n2\n");
  EXPECT_THAT(ErrorOf([&] { ReadLabels(file, 5); }), HasSubstr("a.seg:4: has 3 labels; the shape "
                                                               "has 5"));
  EXPECT_THAT(ErrorOf([&] { ReadLabels(file, 2); }), HasSubstr("a.seg:3: has 3 labels; the shape "
                                                               "has 2"));
  EXPECT_THAT(ErrorOf([&] { ReadLabels(folder / "none.seg"); }), HasSubstr("none.seg: no such"));
  EXPECT_THAT(ErrorOf([&] { ReadLabels(folder.path()); }), HasSubstr("is a folder"));
}

TEST(ShapeFileLabels, AFullDiskIsAFailedRun) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(WriteLabels("/dev/full", Labels(100000, 1)), base::RunError);
}

TEST(PartColor, TheCoreIsRedAndTheFirstPartsAreFarApart) {
  const auto [r, g, b] = PartColor(0);
  EXPECT_GT(r, 2 * std::max(g, b));
  for (std::int32_t i = 0; i < 12; ++i) {
    for (std::int32_t j = i + 1; j < 12; ++j) {
      const auto p = PartColor(i), q = PartColor(j);
      double squares = 0.0;
      for (std::size_t k = 0; k < 3; ++k) squares += std::pow(p[k] - q[k], 2.0);
      EXPECT_GT(std::sqrt(squares), 40.0) << i << " " << j;
    }
  }
  EXPECT_EQ(PartColor(-1), PartColor(-7));
}

TEST(ColoredShape, IsReadBackWithTheSameFaces) {
  const TempFolder folder;
  WriteColoredShape(folder / "a.ply", samples::Tetrahedron(), Labels{0, 1, 2, 3});
  const auto mesh = ReadPolygons(folder / "a.ply").mesh;
  ASSERT_EQ(mesh.triangles.size(), 4U);
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(mesh.vertices[mesh.triangles[f][k]],
                samples::Tetrahedron().vertices[samples::Tetrahedron().triangles[f][k]]);
    }
  }
}

TEST(ColoredShape, EveryFaceEndsWithTheColorOfItsLabel) {
  const TempFolder folder;
  const Labels labels = {0, 4, -1, 2};
  WriteColoredShape(folder / "a.ply", samples::Tetrahedron(), labels);
  const std::string bytes = base::ReadFile(folder / "a.ply");
  constexpr std::size_t kFaceBytes = 1 + 3 * 4 + 3;
  for (std::size_t f = 0; f < labels.size(); ++f) {
    const std::string end = bytes.substr(bytes.size() - (3 - f) * kFaceBytes - 3, 3);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(static_cast<std::uint8_t>(end[k]), PartColor(labels[f])[k]) << f;
    }
  }
}

TEST(ColoredShape, OfACloudIsReadBackAsACloud) {
  const TempFolder folder;
  geometry::TriangleMesh cloud = samples::Tetrahedron();
  cloud.triangles.clear();
  WriteColoredShape(folder / "a.ply", cloud, Labels{0, 1, 2, 3});
  const auto read = ReadPolygons(folder / "a.ply").mesh;
  EXPECT_TRUE(read.triangles.empty());
  EXPECT_EQ(read.vertices, cloud.vertices);
}

TEST(PolygonLabels, StandOneALineOfTheFile) {
  const TempFolder folder;
  // Two quads and a triangle above; the second quad is split into a large and a small triangle.
  const auto input = ReadPolygons(
      folder.Write("a.off",
                   "OFF\n8 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 1\n4 1 1\n0 3 1\n"
                   "4 0 1 2 3\n4 4 5 6 7\n3 0 1 4\n2 0 1\n"));
  ASSERT_EQ(input.polygon, (std::vector<std::uint32_t>{0, 0, 1, 1, 2}));
  EXPECT_EQ(LabelsOfPolygons(input, Labels{5, 5, 1, 2, 3}), (Labels{5, 2, 3, -1}));
}

TEST(PolygonLabels, OfACloudAreThoseOfItsPoints) {
  const geometry::PolygonMesh cloud{{samples::Tetrahedron().vertices, {}}, {}, 0};
  EXPECT_EQ(LabelsOfPolygons(cloud, Labels{1, 0, 2, 0}), (Labels{1, 0, 2, 0}));
}

// Numbers of pixels that are mainly red (label 0) and mainly blue (label 1).
std::pair<int, int> Count(const image::Image& image) {
  int red = 0, blue = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    red += image.rgb[i] > image.rgb[i + 2] + 50 ? 1 : 0;
    blue += image.rgb[i + 2] > image.rgb[i] + 50 ? 1 : 0;
  }
  return {red, blue};
}

TEST(ShapePicture, ShowsFacesInTheColoursOfTheirLabels) {
  const auto mesh = samples::Tetrahedron();
  for (const int label : {0, 1}) {
    const std::vector<std::int32_t> labels(4, label);
    const auto image = draw::Render(DrawLabels(mesh, labels), LookAtShape(mesh.vertices), 160, 120);
    const auto [red, blue] = Count(image);
    EXPECT_GT(label == 0 ? red : blue, 500);
    EXPECT_EQ(label == 0 ? blue : red, 0);
  }
}

TEST(ShapePicture, TheFaceInFrontHidesTheOnesBehind) {
  // Seen from the front right and above, the slanted face (3) of a tetrahedron is in front.
  const auto mesh = samples::Tetrahedron();
  auto view = LookAtShape(mesh.vertices);
  view.eye = Eigen::Vector3d(3, 3, 3);
  const std::vector<std::int32_t> labels = {0, 0, 0, 1};
  const auto [red, blue] = Count(draw::Render(DrawLabels(mesh, labels), view, 160, 120));
  EXPECT_GT(blue, 500);
  EXPECT_LT(red, blue / 20);
}

TEST(ShapePicture, TheWholeShapeIsInView) {
  // All corners of a box must lie in the view's cone, for every scale.
  for (const Eigen::Vector3d& sides :
       {Eigen::Vector3d(5e-3, 1e-3, 2e-3), Eigen::Vector3d(5, 1, 2), Eigen::Vector3d(5e4, 1e4, 2e4),
        Eigen::Vector3d(5, 0.2, 0.2), Eigen::Vector3d(0.2, 5, 0.2), Eigen::Vector3d(0.2, 0.2, 5)}) {
    geometry::Points corners;
    for (int i = 0; i < 8; ++i) {
      corners.push_back(
          sides.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : 0, i & 2 ? 1 : 0, i & 4 ? 1 : 0)));
    }
    const draw::View view = LookAtShape(corners);
    const Eigen::Vector3d ahead = (view.target - view.eye).normalized();
    EXPECT_GT(view.eye.z(), view.target.z()) << "from above";
    for (const auto& p : corners) {
      const double angle = std::acos(std::min(1.0, ahead.dot((p - view.eye).normalized())));
      EXPECT_LE(angle, 0.5 * view.field_of_view_rad + 1e-9);
    }
  }
}

TEST(ShapePicture, PointsThatAreNotFiniteAreLeftOut) {
  auto mesh = samples::Tetrahedron();
  mesh.vertices[3].x() = NAN;
  const draw::Canvas canvas = DrawLabels(mesh, std::vector<std::int32_t>(4, 0));
  ASSERT_EQ(canvas.surfaces.size(), 1U);
  EXPECT_EQ(canvas.surfaces[0].mesh.triangles.size(), 1U);
  EXPECT_TRUE(LookAtShape(mesh.vertices).eye.allFinite());
  mesh.vertices[3].x() = INFINITY;
  EXPECT_TRUE(LookAtShape(mesh.vertices).eye.allFinite());
}

TEST(ShapePicture, ACloudIsDots) {
  auto cloud = samples::Tetrahedron();
  cloud.triangles.clear();
  const std::vector<std::int32_t> labels = {0, 1, 1, 1};
  const draw::Canvas canvas = DrawLabels(cloud, labels);
  ASSERT_EQ(canvas.dots.size(), 2U);
  EXPECT_EQ(canvas.dots[1].points.size(), 3U);
}

}  // namespace
}  // namespace rangegrasp::parts
