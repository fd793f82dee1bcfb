#include "parts/method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/words.h"
#include "parts/solids.h"

namespace rangegrasp::parts {
namespace {

// Balls of radius 1 and 0.7 in one mesh, 5 apart.
geometry::TriangleMesh TwoBalls() {
  geometry::TriangleMesh both;
  for (const double radius : {1.0, 0.7}) {
    const Shape ball = samples::Ball(12, [&](const Eigen::Vector3d&) { return radius; });
    geometry::TriangleMesh mesh{ball.points, ball.faces};
    for (Eigen::Vector3d& p : mesh.vertices) p.x() += radius < 1.0 ? 5.0 : 0.0;
    geometry::Append(mesh, both);
  }
  return both;
}

TEST(SegmentBy, WhatNothingJoinsHasNoPartInCommon) {
  const Shape shape = MakeShape(TwoBalls());
  for (const Method method : {Method::kHierarchy, Method::kKMeans, Method::kSdf, Method::kCore}) {
    const Segmentation found = SegmentBy(method, shape, {});
    const auto middle = found.label.begin() + static_cast<std::ptrdiff_t>(shape.faces.size() / 2);
    const std::set<std::int32_t> first(found.label.begin(), middle);
    for (auto label = middle; label != found.label.end(); ++label) {
      ASSERT_FALSE(first.contains(*label)) << static_cast<int>(method);
    }
  }
  // The middle of both balls is outside of either, which is an error in the chapter too.
  EXPECT_THROW(SegmentBy(Method::kMirror, shape, {}), base::InputError);
}

// Two unit balls around x = -1.3 and 1.3, joined by a neck.
Shape OrientedDumbbell() {
  const auto x = [](double t) { return 2.29 * (2.0 * t - 1.0); };
  return samples::Tube(
      60, 24, [&](double t) { return Eigen::Vector3d(x(t), 0.0, 0.0); },
      [&](double t) {
        const double to_ball = std::abs(x(t)) - 1.3;
        return std::max(std::abs(x(t)) < 1.3 ? 0.35 : 0.0,
                        std::sqrt(std::max(0.0, 1.0 - to_ball * to_ball)));
      });
}

TEST(SegmentBy, PartsAreTheSameHoweverFacesAreOriented) {
  const Shape plain = OrientedDumbbell();
  Shape inside_out = plain, mixed = plain;
  for (std::size_t f = 0; f < plain.faces.size(); ++f) {
    std::swap(inside_out.faces[f][1], inside_out.faces[f][2]);
    if (f % 3 == 0) std::swap(mixed.faces[f][1], mixed.faces[f][2]);
  }
  for (const Method method : {Method::kHierarchy, Method::kKMeans, Method::kCore}) {
    const Segmentation found = SegmentBy(method, plain, {});
    EXPECT_GE(found.parts, 2) << base::Word(method);
    EXPECT_EQ(SegmentBy(method, inside_out, {}).label, found.label) << base::Word(method);
    EXPECT_EQ(SegmentBy(method, mixed, {}).label, found.label) << base::Word(method);
  }
}

}  // namespace
}  // namespace rangegrasp::parts
