#include <gtest/gtest.h>

#include <array>
#include <set>
#include <vector>

#include "geometry/ray_caster.h"
#include "sim/bodies.h"
#include "sim/scene_files.h"

namespace rangegrasp::sim {
namespace {

using geometry::Rgb;
using samples::RepositoryObject;

/// The color that a ray from 1 m outside towards a point in the body's frame hits.
Rgb Seen(const geometry::ColoredMesh& surface, const Eigen::Vector3f& from,
         const Eigen::Vector3f& to) {
  const std::array meshes = {&surface.mesh};
  const geometry::RayCaster caster(meshes);
  std::vector<geometry::Hit> hits;
  const std::array rays = {geometry::Ray{to + from, -from, 0.0f, 2.0f}};
  caster.FirstHits(rays, hits);
  return hits[0].found() ? surface.colors.At(hits[0]).value() : Rgb{0, 0, 0};
}

// The label of the dextrose box has one red and one white end. The cup has a print on its side:
// white with brown letters.
TEST(ObjectSurface, HasWhatIsPrintedOnIt) {
  const auto box = ObjectSurface(RepositoryObject("dextrose"));
  ASSERT_EQ(box.colors.uv.size(), box.mesh.triangles.size());
  ASSERT_EQ(box.colors.plain.size(), box.mesh.triangles.size());
  // Next to the letters.
  const Eigen::Vector3f beside(0.004f, 0.018f, 0.0f);
  const std::set<Rgb> ends = {Seen(box, Eigen::Vector3f::UnitZ(), beside),
                              Seen(box, -Eigen::Vector3f::UnitZ(), beside)};
  EXPECT_EQ(ends, (std::set<Rgb>{{205, 35, 40}, {245, 245, 240}}));
  const auto cup = ObjectSurface(RepositoryObject("coffee_cup"));
  int white = 0, brown = 0, others = 0;
  for (int k = 0; k < 360; ++k) {
    const float angle = static_cast<float>(k) * 0.01745f;
    const Rgb color = Seen(cup, {std::cos(angle), std::sin(angle), 0.0f}, Eigen::Vector3f::Zero());
    const bool is_white = color[0] > 200 && color[2] > 200;
    const bool is_brown = color[0] > color[1] + 20 && color[2] < 80;
    ++(is_white ? white : is_brown ? brown : others);
  }
  EXPECT_GT(white, 200);
  EXPECT_GT(brown, 20);
  EXPECT_LT(others, 20);  // edges of letters
}

// A primitive has its own color, without a print.
TEST(ObjectSurface, APrimitiveIsOfOneColor) {
  const auto ball = ObjectSurface(
      samples::MakeObject("ball", R"(<geom type="sphere" size="0.03" rgba="1 0.5 0 1"/>)"));
  EXPECT_FALSE(ball.colors.print);
  EXPECT_TRUE(ball.colors.uv.empty());
  EXPECT_EQ(Seen(ball, Eigen::Vector3f::UnitZ(), Eigen::Vector3f::Zero()), (Rgb{255, 128, 0}));
}

}  // namespace
}  // namespace rangegrasp::sim
