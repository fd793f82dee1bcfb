#include <gtest/gtest.h>

#include "base/rng.h"
#include "geometry/shape.h"
#include "robot/collision/collider.h"
#include "robot/collision/sensor_hand.h"

namespace rangegrasp::collision {
namespace {

using namespace rangegrasp::test;

/// Signed distance of a point to a capsule or a box; negative inside.
double Distance(const geometry::Shape& shape, const base::Pose& X_CH, const Vector3d& p) {
  const Vector3d q = (X_CH * shape.X_BS).inverse() * p;
  if (shape.kind == geometry::Shape::Kind::kCapsule) {
    const double along = std::clamp(q.z(), -shape.size.y(), shape.size.y());
    return (q - Vector3d(0, 0, along)).norm() - shape.size.x();
  }
  const Vector3d d = q.cwiseAbs() - shape.size;
  return d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
}

double Distance(const robot::HandModel::State& state, const base::Pose& X_CH,
                const geometry::Points& points) {
  double min = 1e9;
  for (const geometry::Shape& shape : state.shapes) {
    for (const Vector3d& p : points) min = std::min(min, Distance(shape, X_CH, p));
  }
  return min;
}

base::Pose RandomPose(base::Rng& rng) {
  const double a = rng.Uniform(-base::kPi, base::kPi);
  const double tilt = rng.Uniform(-0.5, 0.5);
  const double x = rng.Uniform(-0.1, 0.1);
  const double y = rng.Uniform(-0.1, 0.1);
  const double z = rng.Uniform(0.05, 0.2);
  return Move(x, y, z) * Yaw(a) * TurnX(tilt) * TurnX(base::kPi) * SensorHand(2).X_HG_tip.inverse();
}

/// A box of 60 x 100 x 120 mm on the table, rotated by 0.3 rad.
geometry::TriangleMesh Block() {
  geometry::Shape shape;
  shape.kind = geometry::Shape::Kind::kBox;
  shape.size = Vector3d(0.03, 0.05, 0.06);
  shape.X_BS = Move(0.0, 0.0, 0.06) * Yaw(0.3);
  return geometry::Tessellate(shape);
}

/// One triangle with sides of about 1 mm.
geometry::TriangleMesh Speck(const Vector3d& p) {
  geometry::TriangleMesh mesh;
  mesh.vertices = {p + Vector3d(5e-4, 0, -5e-4), p + Vector3d(-5e-4, 5e-4, 0),
                   p + Vector3d(0, -5e-4, 5e-4)};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

/// The parameter is the number of sides of the hand's round shapes; with 0 they are exact.
class SidedHandCollider : public ::testing::TestWithParam<int> {};

TEST_P(SidedHandCollider, AgreesWithSampledPoints) {
  const auto hand = SensorHand();
  const double clearance_m = 0.003;
  const geometry::TriangleMesh block = Block();
  const auto dots = Dots(block, 0.003);
  const std::vector<geometry::TriangleMesh> obstacles{block};
  const HandCollider collider(hand, obstacles, block, {}, {clearance_m, 0.0, GetParam()});
  base::Rng rng(11);
  int hits = 0;
  int unclear = 0;
  for (int i = 0; i < 100; ++i) {
    const base::Pose X_CH = RandomPose(rng);
    const std::size_t state = rng.Index(hand.states.size());
    const double distance = Distance(hand.states[state], X_CH, dots);
    // Facets are within 0.5 mm of the true shapes, and a finger can bulge by up to 0.3 mm between
    // dots 3 mm apart. Cases closer to the limit than that are not decided here.
    const double slack = 0.0008;
    const bool own = collider.HitsOwn(X_CH, state);
    const bool near = collider.HitsObstacle(X_CH, state);
    if (distance < -slack) {
      EXPECT_TRUE(own) << i << " " << distance;
    }
    if (distance > slack) {
      EXPECT_FALSE(own) << i << " " << distance;
    }
    // A box grown by the clearance extends by up to sqrt(3) times the clearance at its corners.
    if (distance < clearance_m - slack) {
      EXPECT_TRUE(near) << i << " " << distance;
    }
    if (distance > 1.74 * clearance_m + slack) {
      EXPECT_FALSE(near) << i << " " << distance;
    }
    hits += own ? 1 : 0;
    unclear += std::abs(distance) <= slack ? 1 : 0;
  }
  EXPECT_GT(hits, 10);
  EXPECT_LT(hits, 80);
  EXPECT_LT(unclear, 10);
}

// No surfaces intersect: the obstacle is found by the position of its points, or as a solid.
TEST_P(SidedHandCollider, FindsASpeckInsideTheHand) {
  const auto hand = SensorHand();
  const base::Pose X_CH = Move(0, 0, 0.3);
  const Vector3d inside = X_CH * hand.states[0].shapes[0].X_BS.translation();
  const std::vector<geometry::TriangleMesh> obstacles{Speck(inside)};
  const HandCollider collider(hand, obstacles, {}, {}, {0.002, 0.0, GetParam()});
  EXPECT_TRUE(collider.HitsObstacle(X_CH, 0));
  EXPECT_FALSE(collider.HitsObstacle(Move(0, 0, 0.8), 0));
}

INSTANTIATE_TEST_SUITE_P(Sides, SidedHandCollider, ::testing::Values(0, 12));

// Facets are at most r (1 - cos 15 deg) away from the true surface, 0.6 mm for the ball of the
// thumb. Outside a band of that width around first contact, both kinds of hand give equal results.
TEST(HandCollider, FacetsAndExactShapesAgreeButInAThinBand) {
  const auto hand = SensorHand();
  const geometry::TriangleMesh block = Block();
  const auto collider = [&](int sides, double clearance_m) {
    return HandCollider(hand, std::vector{block}, {}, {}, {clearance_m, 0.0, sides});
  };
  const HandCollider faceted = collider(12, 0.002);
  const HandCollider tighter = collider(0, 0.002 - 0.0007);
  const HandCollider wider = collider(0, 0.002 + 0.0007);
  base::Rng rng(23);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const base::Pose X_CH = RandomPose(rng);
    const std::size_t state = rng.Index(hand.states.size());
    const bool hit = faceted.HitsObstacle(X_CH, state);
    hits += hit;
    EXPECT_LE(tighter.HitsObstacle(X_CH, state), hit) << i;
    EXPECT_LE(hit, wider.HitsObstacle(X_CH, state)) << i;
  }
  EXPECT_GT(hits, 60);
  EXPECT_LT(hits, 240);
}

TEST(HandCollider, MeasuresTheTableExactly) {
  const auto hand = SensorHand();
  const HandCollider collider(hand, {}, {}, {}, {0.002, 0.004});
  base::Rng rng(5);
  for (int i = 0; i < 100; ++i) {
    const base::Pose X_CH = RandomPose(rng);
    const std::size_t state = rng.Index(hand.states.size());
    double lowest = 1e9;
    for (const geometry::Shape& shape : hand.states[state].shapes) {
      for (const Vector3d& p : geometry::Tessellate(shape, 64).vertices) {
        lowest = std::min(lowest, (X_CH * p).z());
      }
    }
    // 64 sides: at most 0.02 mm inside a finger with a radius of 18 mm.
    EXPECT_NEAR(collider.TableDistance(X_CH, state), lowest, 5e-5);
    EXPECT_EQ(collider.HitsTable(X_CH, state), collider.TableDistance(X_CH, state) < 0.004 - 1e-6);
  }
}

// A hand made of one sphere of 10 mm, 30 mm above its root, over a tilted plane. Its distance is
// n . (p + 0.03 z) + offset - 0.01.
TEST(HandCollider, StandsOverATiltedPlaneAtTheAnalyticHeight) {
  robot::HandModel hand;
  geometry::Shape sphere;
  sphere.size = Vector3d(0.01, 0.0, 0.0);
  sphere.X_BS = Move(0.0, 0.0, 0.03);
  hand.states.resize(1);
  hand.states[0].shapes = {sphere};
  hand.states[0].is_finger = hand.states[0].is_thumb = {1};
  const geometry::Plane plane{Vector3d(0.6, 0.0, 0.8), -0.05};
  const HandCollider collider(hand, {}, {}, plane, {0.002, 0.004});
  const Vector3d p(0.1, 0.3, 0.02);
  const double height = 0.6 * 0.1 + 0.8 * 0.05 - 0.05 - 0.01;
  EXPECT_NEAR(collider.TableDistance(Move(p.x(), p.y(), p.z()), 0), height, 1e-12);
  const auto hits = [&](double clearance_m) {
    return collider.HitsTable(Move(0.1, 0.3, 0.02 + (clearance_m - height) / 0.8), 0);
  };
  EXPECT_TRUE(hits(0.00399));
  EXPECT_FALSE(hits(0.004));
}

}  // namespace
}  // namespace rangegrasp::collision
