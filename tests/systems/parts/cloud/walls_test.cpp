#include "parts/cloud/walls.h"

#include <gtest/gtest.h>

namespace rangegrasp::parts {
namespace {

/// Two squares of 20 x 20 cells of side 1, of two triangles each, one over the other; the lower one
/// is of two parts, halves, the upper one is the third.
Shape TwoSheets(double apart, Segmentation& labels) {
  constexpr std::uint32_t kCells = 20;
  Shape mesh;
  for (const double z : {0.0, apart}) {
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      for (std::uint32_t j = 0; j <= kCells; ++j) mesh.points.emplace_back(i, j, z);
    }
    for (std::uint32_t i = 0; i < kCells; ++i) {
      for (std::uint32_t j = 0; j < kCells; ++j) {
        const std::uint32_t a = first + i * (kCells + 1) + j;
        const std::uint32_t b = a + kCells + 1;
        mesh.faces.push_back({a, b, a + 1});
        mesh.faces.push_back({b, b + 1, a + 1});
        for (int k = 0; k < 2; ++k) labels.label.push_back(z > 0.0 ? 2 : (i < kCells / 2 ? 0 : 1));
      }
    }
  }
  labels.parts = 3;
  labels.tree = {{-1, 0, -1, 0.1}, {0, 1, 0, 1.0}, {0, 1, 1, 1.0}, {0, 1, 2, 1.0}};
  return mesh;
}

TEST(Walls, BothSidesOfAThinWallAreOnePart) {
  Segmentation labels;
  const Shape mesh = TwoSheets(2.0, labels);
  const Segmentation joined = JoinWalls(mesh, labels);
  EXPECT_EQ(joined.parts, 1);
  EXPECT_EQ(AtLevel(joined, 0).parts, 1);
}

TEST(Walls, SheetsApartAndPartsBesideEachOtherStayApart) {
  Segmentation labels;
  const Shape mesh = TwoSheets(8.0, labels);
  EXPECT_EQ(JoinWalls(mesh, labels).label, labels.label);
  EXPECT_EQ(JoinWalls(mesh, labels).tree.size(), labels.tree.size());
}

}  // namespace
}  // namespace rangegrasp::parts
