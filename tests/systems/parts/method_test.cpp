#include "parts/method.h"

#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
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

}  // namespace
}  // namespace rangegrasp::parts
