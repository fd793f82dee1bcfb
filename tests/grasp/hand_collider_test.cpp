#include "grasp/hand_collider.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "grasp/fixtures.h"
#include "grasp/hand_profiles.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp {
namespace {

using namespace test;

/// The distance of a point to a capsule or a box, negative inside.
double Distance(const geometry::Shape& shape, const core::Pose& X_CH, const Vector3d& p) {
  const Vector3d q = (X_CH * shape.X_BS).inverse() * p;
  if (shape.kind == geometry::Shape::Kind::kCapsule) {
    const double along = std::clamp(q.z(), -shape.size.y(), shape.size.y());
    return (q - Vector3d(0, 0, along)).norm() - shape.size.x();
  }
  const Vector3d d = q.cwiseAbs() - shape.size;
  return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
}

double Distance(const robot::HandModel::State& state, const core::Pose& X_CH,
                const geometry::Points& points) {
  double least = 1e9;
  for (const geometry::Shape& shape : state.shapes) {
    for (const Vector3d& p : points) least = std::min(least, Distance(shape, X_CH, p));
  }
  return least;
}

core::Pose RandomPose(core::Rng& rng) {
  const double a = rng.Uniform(-core::kPi, core::kPi);
  const double tilt = rng.Uniform(-0.5, 0.5);
  const double x = rng.Uniform(-0.1, 0.1);
  const double y = rng.Uniform(-0.1, 0.1);
  const double z = rng.Uniform(0.05, 0.2);
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return Move(x, y, z) * Yaw(a) * TurnX(tilt) * core::MakePose(down, Vector3d::Zero()) *
         SensorHand(2).X_HG_tip.inverse();
}

TEST(HandCollider, AgreesWithSampledPoints) {
  const auto hand = SensorHand();
  const double clearance = 0.003;
  const geometry::TriangleMesh box =
      Transformed(Extrude(Rectangle(0.06, 0.1), 0.12), At(0, 0, 0.3));
  const auto dots = Dots(box, 0.003);
  const std::vector<geometry::TriangleMesh> obstacles{box};
  const HandCollider collider(hand, obstacles, box, {}, clearance, 0.0);
  core::Rng rng(11);
  int hits = 0;
  int unclear = 0;
  for (int i = 0; i < 100; ++i) {
    const core::Pose X_CH = RandomPose(rng);
    const std::size_t state = rng.Index(hand.states.size());
    const double distance = Distance(hand.states[state], X_CH, dots);
    // Facets are within 0.5 mm of the true shapes; dots 3 mm apart leave up to 0.3 mm to a
    // finger that bulges between them. What is nearer than that to the limit is not decided here.
    const double slack = 0.0008;
    const bool own = collider.HitsOwn(X_CH, state);
    const bool near = collider.HitsObstacle(X_CH, state);
    if (distance < -slack) {
      EXPECT_TRUE(own) << i << " " << distance;
    }
    if (distance > slack) {
      EXPECT_FALSE(own) << i << " " << distance;
    }
    // A box grown by the clearance reaches up to sqrt(3) of it beyond its corners.
    if (distance < clearance - slack) {
      EXPECT_TRUE(near) << i << " " << distance;
    }
    if (distance > 1.74 * clearance + slack) {
      EXPECT_FALSE(near) << i << " " << distance;
    }
    hits += own ? 1 : 0;
    unclear += std::abs(distance) <= slack ? 1 : 0;
  }
  EXPECT_GT(hits, 10);
  EXPECT_LT(hits, 80);
  EXPECT_LT(unclear, 10);
}

TEST(HandCollider, FindsASpeckInsideTheHand) {
  const auto hand = SensorHand();
  const core::Pose X_CH = Move(0, 0, 0.3);
  const Vector3d inside = X_CH * hand.states[0].shapes[0].X_BS.translation();
  const std::vector<geometry::TriangleMesh> obstacles{SpeckMesh({{inside}}, 0.002)};
  const HandCollider collider(hand, obstacles, {}, {}, 0.002, 0.0);
  EXPECT_TRUE(collider.HitsObstacle(X_CH, 0));
  EXPECT_FALSE(collider.HitsObstacle(Move(0, 0, 0.8), 0));
}

TEST(HandCollider, MeasuresTheTableExactly) {
  const auto hand = SensorHand();
  const HandCollider collider(hand, {}, {}, {}, 0.002, 0.004);
  core::Rng rng(5);
  for (int i = 0; i < 100; ++i) {
    const core::Pose X_CH = RandomPose(rng);
    const std::size_t state = rng.Index(hand.states.size());
    double lowest = 1e9;
    for (const geometry::Shape& shape : hand.states[state].shapes) {
      for (const Vector3d& p : geometry::Tessellate(shape, 64).vertices) {
        lowest = std::min(lowest, (X_CH * p).z());
      }
    }
    // 64 sides: 0.02 mm inside a finger of 18 mm radius at most.
    EXPECT_NEAR(collider.TableDistance(X_CH, state), lowest, 5e-5);
    EXPECT_EQ(collider.HitsTable(X_CH, state), collider.TableDistance(X_CH, state) < 0.004 - 1e-6);
  }
}

TEST(Grown, MovesTheSurfaceOutByTheMargin) {
  core::Rng rng(7);
  const auto hand = SensorHand(2);
  for (const geometry::Shape& shape : hand.states[0].shapes) {
    const geometry::Shape grown = Grown(shape, 0.005);
    for (int i = 0; i < 200; ++i) {
      const double x = rng.Uniform(-0.05, 0.05);
      const double y = rng.Uniform(-0.1, 0.12);
      const double z = rng.Uniform(0.0, 0.13);
      const double distance = Distance(shape, core::Pose::Identity(), {x, y, z});
      if (distance < 0.005 - 1e-9) {
        EXPECT_TRUE(Inside(grown, {x, y, z}));
      }
      if (distance > 0.005 * 1.74) {
        EXPECT_FALSE(Inside(grown, {x, y, z}));
      }
    }
  }
}

TEST(Support, IsTheFarthestVertex) {
  core::Rng rng(9);
  for (const auto kind : {geometry::Shape::Kind::kSphere, geometry::Shape::Kind::kCapsule,
                          geometry::Shape::Kind::kCylinder, geometry::Shape::Kind::kBox,
                          geometry::Shape::Kind::kEllipsoid}) {
    geometry::Shape shape;
    shape.kind = kind;
    shape.size = Vector3d(0.02, 0.03, 0.05);
    shape.X_BS = Move(0.01, 0.02, 0.03) * TurnX(0.4);
    for (int i = 0; i < 20; ++i) {
      const double x = rng.Normal();
      const double y = rng.Normal();
      const double z = rng.Normal();
      const Vector3d d = Vector3d(x, y, z).normalized();
      double farthest = -1.0;
      for (const Vector3d& p : geometry::Tessellate(shape, 96).vertices) {
        farthest = std::max(farthest, d.dot(p));
      }
      // 96 sides: 0.05 % of at most 50 mm, both ways round.
      EXPECT_NEAR(Support(shape, core::Pose::Identity(), d), farthest, 6e-5);
    }
  }
}

}  // namespace
}  // namespace rangegrasp::grasp
