#include "pcl_bridge/registration.h"

#include <gtest/gtest.h>
#include <pcl/registration/icp.h>

#include <cmath>

#include "base/units.h"
#include "error_of.h"
#include "geometry/synthetic.h"
#include "noisy_surfaces.h"
#include "pcl_bridge/pcl_segmentation.h"

namespace rangegrasp::pcl_bridge {
namespace {

class SeededRegistration : public ::testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Seeds, SeededRegistration, ::testing::Range<std::uint64_t>(0, 6));

constexpr double kRegistrationSigma_m = 0.0003;

/// Two scans of the same objects with different steps and noise, the second in a different frame.
struct Pair {
  Pair(std::uint64_t seed, base::Rng& rng) {
    synthetic::ScanOptions options;
    options.sigma_m = kRegistrationSigma_m;
    options.seed = 2 * seed;
    options.step_m = 0.003;
    target_T = synthetic::MakeScan(synthetic::MixedObjects(), options).points_W;
    options.seed += 1;
    options.step_m = 0.0037;
    X_TS = Eigen::Translation3d(0.3, -0.2, 0.1) *
           Eigen::AngleAxisd(0.8, samples::RandomDirection(rng));
    sensor_T = options.sensor_W;
    for (const auto& p_T : synthetic::MakeScan(synthetic::MixedObjects(), options).points_W) {
      source_S.push_back(X_TS.inverse() * p_T);
    }
    guess_TS = X_TS * Eigen::Translation3d(0.005 * samples::RandomDirection(rng)) *
               Eigen::AngleAxisd(base::Deg(2.0), samples::RandomDirection(rng));
  }

  geometry::Points target_T;
  geometry::Points source_S;
  Eigen::Vector3d sensor_T;
  Eigen::Isometry3d X_TS;
  Eigen::Isometry3d guess_TS;
};

/// The points that have a normal, with their normals.
geometry::PointCloud Surface(const geometry::Points& points, const Eigen::Vector3d& sensor) {
  const geometry::Points normals = EstimateNormals(points, sensor, 0.01);
  geometry::PointCloud surface;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!normals[i].allFinite()) continue;
    surface.points.push_back(points[i]);
    surface.normals.push_back(normals[i]);
  }
  return surface;
}
PlaneTarget Target(const geometry::Points& points, const Eigen::Vector3d& sensor) {
  return PlaneTarget(Surface(points, sensor));
}

/// Maximum displacement of the scene's points by the error.
double MaxError(const Pair& pair, const Eigen::Isometry3d& X_TS) {
  double max = 0.0;
  for (const auto& p_S : pair.source_S) max = std::max(max, (X_TS * p_S - pair.X_TS * p_S).norm());
  return max;
}

// About 10,000 pairs with a noise of 0.3 mm sqrt(2), a tenth of them on surfaces perpendicular to
// each direction: 0.42 mm / sqrt(1000) = 13 um. Pairs at edges, where the normals are rounded off,
// and the spacing of 3 mm add a bias on top of the noise: 0.2 mm is a fifteenth of the spacing and
// a twenty-fifth of the error of the guess.
constexpr double kMaxError_m = 2e-4;

TEST_P(SeededRegistration, PointToPlaneFindsTheKnownPose) {
  base::Rng rng(GetParam());
  const Pair pair(GetParam(), rng);
  const auto found =
      RegisterPointToPlane(pair.source_S, Target(pair.target_T, pair.sensor_T), pair.guess_TS);
  EXPECT_GT(MaxError(pair, pair.guess_TS), 10.0 * kMaxError_m);
  EXPECT_LT(MaxError(pair, found), kMaxError_m);
  EXPECT_LT((found.linear().transpose() * found.linear() - Eigen::Matrix3d::Identity()).norm(),
            1e-12);
}

/// The library's method with its own search.
Eigen::Isometry3d Reference(const geometry::Points& source, const geometry::PointCloud& target,
                            const Eigen::Isometry3d& X_TS, const RegistrationOptions& options) {
  using Cloud = pcl::PointCloud<pcl::PointNormal>;
  const auto to = pcl::make_shared<Cloud>();
  const auto from = pcl::make_shared<Cloud>();
  for (std::size_t i = 0; i < target.size(); ++i) {
    pcl::PointNormal p;
    p.getVector3fMap() = target.points[i].cast<float>();
    p.getNormalVector3fMap() = target.normals[i].cast<float>();
    to->push_back(p);
  }
  for (const auto& point : source) {
    pcl::PointNormal p;
    p.getVector3fMap() = point.cast<float>();
    from->push_back(p);
  }
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal, double> method;
  method.setInputSource(from);
  method.setInputTarget(to);
  method.setTransformationEstimation(
      pcl::make_shared<pcl::registration::TransformationEstimationPointToPlaneLLS<
          pcl::PointNormal, pcl::PointNormal, double>>());
  method.setTransformationEpsilon(options.min_step_m * options.min_step_m);
  method.setTransformationRotationEpsilon(std::cos(options.min_step_rad));
  method.setMaxCorrespondenceDistance(options.max_pair_distance_m);
  method.setMaximumIterations(options.max_iterations);
  Cloud aligned;
  method.align(aligned, X_TS.matrix());
  return Eigen::Isometry3d(method.getFinalTransformation());
}

// From guesses so bad that pairs change in each iteration and many points have none.
TEST_P(SeededRegistration, AgreesWithTheLibrarysSearch) {
  base::Rng rng(GetParam());
  const Pair pair(GetParam(), rng);
  const geometry::PointCloud target = Surface(pair.target_T, pair.sensor_T);
  const RegistrationOptions options{.max_pair_distance_m = 0.01, .max_iterations = 8};
  const Eigen::Isometry3d guess = pair.guess_TS * Eigen::Translation3d(0.02, 0.01, 0.0);
  const auto found = RegisterPointToPlane(pair.source_S, PlaneTarget(target), guess, options);
  const auto expected = Reference(pair.source_S, target, guess, options);
  EXPECT_GT((found.matrix() - guess.matrix()).norm(), 1e-3);
  EXPECT_LT((found.matrix() - expected.matrix()).norm(), 1e-7);  // clouds are of float
}

TEST(Registration, SameCloudsGiveTheSamePoseTwice) {
  base::Rng rng(2);
  const Pair pair(2, rng);
  const auto run = [&] {
    return RegisterPointToPlane(pair.source_S, Target(pair.target_T, pair.sensor_T), pair.guess_TS);
  };
  const auto a = run();
  const auto b = run();
  EXPECT_EQ(a.matrix(), b.matrix());
}

// On a plane a cloud can slide and rotate freely.
TEST(Registration, APlaneAloneLeavesThePoseOpen) {
  geometry::Points plane;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) plane.emplace_back(0.01 * i, 0.01 * j, 1.0);
  }
  const PlaneTarget target({plane, geometry::Points(plane.size(), -Eigen::Vector3d::UnitZ())});
  const Eigen::Isometry3d X_TS(Eigen::Translation3d(0.001, 0.0, 0.0));
  EXPECT_EQ(RegisterPointToPlane(plane, target, X_TS).matrix(), X_TS.matrix());
}

TEST(Registration, CloudsOutOfReachStayWhereTheyWere) {
  base::Rng rng(3);
  const Pair pair(3, rng);
  const Eigen::Isometry3d far = Eigen::Translation3d(5, 0, 0) * pair.X_TS;
  const auto found = RegisterPointToPlane(pair.source_S, Target(pair.target_T, pair.sensor_T), far);
  EXPECT_LT((found.matrix() - far.matrix()).norm(), 1e-9);
}

TEST(Registration, ATargetWithAPointThatIsNotFiniteIsRefused) {
  geometry::PointCloud surface{geometry::Points(3, Eigen::Vector3d::UnitZ()),
                               geometry::Points(3, Eigen::Vector3d::UnitZ())};
  surface.points[1].x() = std::nan("");
  EXPECT_EQ(testing_support::ErrorOf<std::invalid_argument>([&] { PlaneTarget target(surface); }),
            "PlaneTarget: points and normals must be finite");
}

TEST(Registration, TooFewPointsAreRefused) {
  EXPECT_THROW(PlaneTarget({{{0, 0, 1}, {1, 0, 1}}, {{0, 0, 1}, {0, 0, 1}}}),
               std::invalid_argument);
  const PlaneTarget target({geometry::Points(3, Eigen::Vector3d::UnitZ()),
                            geometry::Points(3, Eigen::Vector3d::UnitZ())});
  EXPECT_THROW(RegisterPointToPlane(geometry::PointSpan(), target, Eigen::Isometry3d::Identity()),
               std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
