#include "recognition/learn.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "error_of.h"
#include "geometry/mesh.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Vector3d;

const Vector3d kSize(0.06, 0.04, 0.09);

/// A box standing on a table with frame T, seen from all sides and from above, except for its
/// lowest 4 mm.
perception::Scene BoxOnTable(const base::Pose& X_CT, bool back_seen = true) {
  perception::Scene scene;
  const Vector3d up = X_CT.linear().col(2);
  scene.table.plane = {up, -up.dot(X_CT.translation())};
  constexpr double kStep = 0.001;
  perception::PerceivedObject box;
  const auto add = [&](double x, double y, double z, const Vector3d& normal) {
    box.points.push_back(static_cast<std::uint32_t>(scene.cloud.size()));
    scene.cloud.points.push_back(X_CT * Vector3d(x + 0.2, y - 0.1, z));
    scene.cloud.normals.push_back(X_CT.linear() * normal);
  };
  const Vector3d half = 0.5 * kSize;
  for (double x = -half.x(); x <= half.x(); x += kStep) {
    for (double y = -half.y(); y <= half.y(); y += kStep) add(x, y, kSize.z(), Vector3d::UnitZ());
    for (double z = 0.004; z <= kSize.z(); z += kStep) {
      add(x, -half.y(), z, -Vector3d::UnitY());
      if (back_seen) add(x, half.y(), z, Vector3d::UnitY());
    }
  }
  for (double y = -half.y(); y <= half.y(); y += kStep) {
    for (double z = 0.004; z <= kSize.z(); z += kStep) {
      add(-half.x(), y, z, -Vector3d::UnitX());
      add(half.x(), y, z, Vector3d::UnitX());
    }
  }
  scene.objects.push_back(box);
  return scene;
}

TEST(Learn, ABoxIsItDownToTheTable) {
  const auto model = Learn(BoxOnTable(base::Pose::Identity()));
  const auto box = geometry::BoundsOf(model.mesh_B.vertices);
  EXPECT_TRUE(box.sizes().isApprox(kSize, 0.04)) << box.sizes().transpose();
  EXPECT_NEAR(box.min().z(), 0.0, 0.001);
  EXPECT_LT(box.center().head<2>().norm(), 1e-9);
  EXPECT_NEAR(geometry::Volume(model.mesh_B) / kSize.prod(), 1.0, 0.04);
  EXPECT_GT(model.share_seen, 0.99);
  EXPECT_TRUE(model.X_CB.translation().isApprox(Vector3d(0.2, -0.1, 0.0), 0.02));
}

TEST(Learn, InAnyFrame) {
  base::Pose X_CT = base::Pose::Identity();
  X_CT.linear() = Eigen::AngleAxisd(2.1, Vector3d(0.6, 0.0, 0.8)).toRotationMatrix();
  X_CT.translation() = Vector3d(0.3, 1.0, -0.4);
  const auto model = Learn(BoxOnTable(X_CT));
  EXPECT_NEAR(geometry::Volume(model.mesh_B) / kSize.prod(), 1.0, 0.04);
  EXPECT_GT(model.X_CB.linear().col(2).dot(X_CT.linear().col(2)), 0.9999);
}

TEST(Learn, TellsWhatNobodySaw) {
  const auto model = Learn(BoxOnTable(base::Pose::Identity(), false));
  // Unseen: one side of 60 mm of the circumference of 60 + 60 + 40 + 40 mm and the top.
  EXPECT_NEAR(model.share_seen, 1.0 - 60.0 * 75.0 / (200.0 * 75.0 + 60.0 * 40.0), 0.08);
}

// A kilometre of surface in triangles of 1 mm would never finish.
TEST(Learn, AnOutlierFarAwayIsNamed) {
  auto scene = BoxOnTable(base::Pose::Identity());
  scene.objects[0].points.push_back(static_cast<std::uint32_t>(scene.cloud.size()));
  scene.cloud.points.emplace_back(0.2, -0.1, 1000.0);
  scene.cloud.normals.push_back(Vector3d::UnitZ());
  EXPECT_THAT(testing_support::ErrorOf([&] { Learn(scene); }),
              testing::HasSubstr("is an outlier among them?"));
}

// Two boxes 0.7 m apart, 0.76 m wide together: no surface closes both, and the mesher may not end.
TEST(Learn, ObjectsFarApartAreRefused) {
  auto scene = BoxOnTable(base::Pose::Identity());
  auto other = scene.objects[0];
  for (auto& i : other.points) {
    const auto shifted = static_cast<std::uint32_t>(scene.cloud.size());
    const Vector3d point = scene.cloud.points[i], normal = scene.cloud.normals[i];
    scene.cloud.points.emplace_back(point + Vector3d(0.7, 0.0, 0.0));
    scene.cloud.normals.push_back(normal);
    i = shifted;
  }
  scene.objects.push_back(other);
  EXPECT_THAT(testing_support::ErrorOf([&] { Learn(scene); }),
              testing::HasSubstr("2 objects, 0.8 m wide together, would become one model: use "
                                 "--crop to exclude the others"));
}

TEST(Learn, OfAnEmptyTableIsRefused) {
  perception::Scene scene;
  EXPECT_THAT(testing_support::ErrorOf([&] { Learn(scene); }),
              testing::HasSubstr("only 0 points belong to an object on the table"));
}

}  // namespace
}  // namespace rangegrasp::recognition
