#include "parts/shape_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace rangegrasp::draw {
namespace {

geometry::TriangleMesh Tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

std::array<std::uint8_t, 3> RedOrBlue(std::int32_t label) {
  return label == 0 ? std::array<std::uint8_t, 3>{255, 0, 0}
                    : std::array<std::uint8_t, 3>{0, 0, 255};
}

// How many pixels are more red, and more blue, than anything else.
std::pair<int, int> Count(const image::Image& image) {
  int red = 0, blue = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    red += image.rgb[i] > image.rgb[i + 2] + 50 ? 1 : 0;
    blue += image.rgb[i + 2] > image.rgb[i] + 50 ? 1 : 0;
  }
  return {red, blue};
}

TEST(ShapePicture, ShowsFacesInTheColoursOfTheirLabels) {
  const auto mesh = Tetrahedron();
  for (const int label : {0, 1}) {
    const std::vector<std::int32_t> labels(4, label);
    const auto image =
        Render(DrawLabels(mesh, labels, RedOrBlue), LookAtShape(mesh.vertices, 2), 160, 120);
    const auto [red, blue] = Count(image);
    EXPECT_GT(label == 0 ? red : blue, 500);
    EXPECT_EQ(label == 0 ? blue : red, 0);
  }
}

TEST(ShapePicture, TheFaceInFrontHidesTheOnesBehind) {
  // Seen from the front right above, of a tetrahedron's faces the slanted one (3) is in front.
  const auto mesh = Tetrahedron();
  auto view = LookAtShape(mesh.vertices, 2);
  view.eye = Eigen::Vector3d(3, 3, 3);
  const std::vector<std::int32_t> labels = {0, 0, 0, 1};
  const auto [red, blue] = Count(Render(DrawLabels(mesh, labels, RedOrBlue), view, 160, 120));
  EXPECT_GT(blue, 500);
  EXPECT_LT(red, blue / 20);
}

TEST(ShapePicture, TheWholeShapeIsInView) {
  // Corners of a box must fall within the view's cone, for every axis that points up and any scale.
  for (const int up : {0, 1, 2}) {
    for (const Eigen::Vector3d& sides :
         {Eigen::Vector3d(5e-3, 1e-3, 2e-3), Eigen::Vector3d(5, 1, 2),
          Eigen::Vector3d(5e4, 1e4, 2e4), Eigen::Vector3d(5, 0.2, 0.2),
          Eigen::Vector3d(0.2, 5, 0.2), Eigen::Vector3d(0.2, 0.2, 5)}) {
      geometry::Points corners;
      for (int i = 0; i < 8; ++i) {
        corners.push_back(
            sides.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : 0, i & 2 ? 1 : 0, i & 4 ? 1 : 0)));
      }
      const View view = LookAtShape(corners, up);
      const Eigen::Vector3d ahead = (view.target - view.eye).normalized();
      EXPECT_GT(view.eye[up], view.target[up]) << "from above";
      for (const auto& p : corners) {
        const double angle = std::acos(std::min(1.0, ahead.dot((p - view.eye).normalized())));
        EXPECT_LE(angle, 0.5 * view.field_of_view_rad + 1e-9);
      }
    }
  }
}

TEST(ShapePicture, PointsThatAreNotFiniteAreLeftOut) {
  auto mesh = Tetrahedron();
  mesh.vertices[3].x() = NAN;
  const Canvas canvas = DrawLabels(mesh, std::vector<std::int32_t>(4, 0), RedOrBlue);
  ASSERT_EQ(canvas.surfaces.size(), 1U);
  EXPECT_EQ(canvas.surfaces[0].mesh.triangles.size(), 1U);
  EXPECT_TRUE(LookAtShape(mesh.vertices, 2).eye.allFinite());
  mesh.vertices[3].x() = INFINITY;
  EXPECT_TRUE(LookAtShape(mesh.vertices, 2).eye.allFinite());
}

TEST(ShapePicture, ACloudIsDots) {
  auto cloud = Tetrahedron();
  cloud.triangles.clear();
  const std::vector<std::int32_t> labels = {0, 1, 1, 1};
  const Canvas canvas = DrawLabels(cloud, labels, RedOrBlue);
  ASSERT_EQ(canvas.dots.size(), 2U);
  EXPECT_EQ(canvas.dots[1].points.size(), 3U);
}

TEST(ShapePicture, RefusesLabelsThatDoNotFitAndNothingToSee) {
  EXPECT_THROW(DrawLabels(Tetrahedron(), std::vector<std::int32_t>(3, 0), RedOrBlue),
               std::invalid_argument);
  EXPECT_THROW(LookAtShape({}, 2), std::invalid_argument);
  EXPECT_THROW(LookAtShape(Tetrahedron().vertices, 3), std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::draw
