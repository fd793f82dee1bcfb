#include "parts/shape/shape_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/error.h"
#include "base/file.h"
#include "base/rng.h"
#include "error_of.h"
#include "parts/shape/segmentation.h"
#include "parts/shape/shape_graph.h"
#include "temp_folder.h"

namespace rangegrasp::parts {
namespace {

using ::testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;
using ShapeFileLabels = std::vector<std::int32_t>;

TEST(ShapeFileLabels, AreReadBackAsTheyWereWritten) {
  const TempFolder folder;
  base::Rng rng(1);
  ShapeFileLabels labels;
  for (int i = 0; i < 5000; ++i) labels.push_back(static_cast<std::int32_t>(rng.Index(300)) - 5);
  WriteLabels(folder / "a.seg", labels);
  EXPECT_EQ(ReadLabels(folder / "a.seg"), labels);
  EXPECT_EQ(ReadLabels(folder / "a.seg", labels.size()), labels);
}

TEST(ShapeFileLabels, EndsOfLinesAndBlanksRoundTheNumberDoNotCount) {
  const TempFolder folder;
  EXPECT_EQ(ReadLabels(folder.Write("a.seg", "1\r\n 2 \n3")), (ShapeFileLabels{1, 2, 3}));
  EXPECT_EQ(ReadLabels(folder.Write("b.seg", "1\n2\n\n\n")), (ShapeFileLabels{1, 2}));
  EXPECT_EQ(ReadLabels(folder.Write("c.seg", "")), ShapeFileLabels{});
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
  EXPECT_THROW(WriteLabels("/dev/full", ShapeFileLabels(100000, 1)), base::RunError);
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

geometry::TriangleMesh ShapeFileTetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

TEST(ColoredShape, IsReadBackWithTheSameFaces) {
  const TempFolder folder;
  WriteColoredShape(folder / "a.ply", ShapeFileTetrahedron(), ShapeFileLabels{0, 1, 2, 3});
  const auto mesh = ReadInput(folder / "a.ply");
  ASSERT_EQ(mesh.triangles.size(), 4U);
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(mesh.vertices[mesh.triangles[f][k]],
                ShapeFileTetrahedron().vertices[ShapeFileTetrahedron().triangles[f][k]]);
    }
  }
}

TEST(ColoredShape, EveryFaceEndsWithTheColorOfItsLabel) {
  const TempFolder folder;
  const ShapeFileLabels labels = {0, 4, -1, 2};
  WriteColoredShape(folder / "a.ply", ShapeFileTetrahedron(), labels);
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
  geometry::TriangleMesh cloud = ShapeFileTetrahedron();
  cloud.triangles.clear();
  WriteColoredShape(folder / "a.ply", cloud, ShapeFileLabels{0, 1, 2, 3});
  const auto read = ReadInput(folder / "a.ply");
  EXPECT_TRUE(read.triangles.empty());
  EXPECT_EQ(read.vertices, cloud.vertices);
}

TEST(PolygonLabels, StandOneALineOfTheFile) {
  const TempFolder folder;
  // Two quads and a triangle over them; the second quad is cut into a large and a small triangle.
  const auto input = ReadPolygons(
      folder.Write("a.off",
                   "OFF\n8 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 1\n4 1 1\n0 3 1\n"
                   "4 0 1 2 3\n4 4 5 6 7\n3 0 1 4\n2 0 1\n"));
  ASSERT_EQ(input.polygon, (std::vector<std::uint32_t>{0, 0, 1, 1, 2}));
  EXPECT_EQ(LabelsOfPolygons(input, ShapeFileLabels{5, 5, 1, 2, 3}),
            (ShapeFileLabels{5, 2, 3, -1}));
  EXPECT_EQ(LabelsOfTriangles(input, ShapeFileLabels{5, 2, 3, -1}),
            (ShapeFileLabels{5, 5, 2, 2, 3}));
  EXPECT_THROW(LabelsOfTriangles(input, ShapeFileLabels{5}), std::invalid_argument);
}

TEST(PolygonLabels, OfACloudAreThoseOfItsPoints) {
  const geometry::PolygonMesh cloud{{ShapeFileTetrahedron().vertices, {}}, {}, 0};
  EXPECT_EQ(LabelsOfPolygons(cloud, ShapeFileLabels{1, 0, 2, 0}), (ShapeFileLabels{1, 0, 2, 0}));
}

TEST(ColoredShape, NeedsOneLabelAnElement) {
  EXPECT_THROW(WriteColoredShape("never.ply", ShapeFileTetrahedron(), ShapeFileLabels{0, 1}),
               std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::parts
