#include "cylinders/fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/NonLinearOptimization>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "geometry/kd_tree.h"
#include "geometry/plane.h"

namespace rangegrasp::cylinders {

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  // The cosine alone would lose angles below 1e-8.
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

Incidence IncidenceOf(const Barrel& barrel, const Eigen::Vector3d& eye, const Eigen::Vector3d& p) {
  const Eigen::Vector3d& d = barrel.axis.direction;
  const Eigen::Vector3d ray = (p - eye).stableNormalized();
  const Eigen::Vector3d across = ray - ray.dot(d) * d;
  const double length = across.norm();
  if (length == 0.0) return {0.0, 0.0};
  // In the section perpendicular to the axis: the ray's distance from it as a share of the radius.
  const double sine = std::min(
      1.0, std::abs((barrel.axis.point - eye).dot(across.cross(d))) / (length * barrel.radius_m));
  return {length * std::sqrt(1.0 - sine * sine), length * sine};
}

DistanceNoise DistanceNoiseOf(const RayNoise& noise, const Incidence& incidence, double radius_m) {
  const auto mixed = [&noise](double part) {
    return std::pow(noise.along_m * part, 2) + std::pow(noise.across_m, 2) * (1.0 - part * part);
  };
  const double tangential_m2 = mixed(incidence.tangential);
  return {tangential_m2 / (2.0 * radius_m),
          mixed(incidence.radial) + std::pow(tangential_m2 / radius_m, 2) / 2.0};
}

namespace {

/// Functor for Eigen's Levenberg-Marquardt.
class Residuals {
 public:
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  explicit Residuals(geometry::PointSpan points) : points_(points) {}

  int inputs() const { return BarrelParameters::RowsAtCompileTime; }
  int values() const { return static_cast<int>(points_.size()); }

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& values) const {
    const BarrelParameters parameters = x;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      values[static_cast<Eigen::Index>(i)] = BarrelResidual(parameters, points_[i]);
    }
    return 0;
  }
  int df(const Eigen::VectorXd& x, Eigen::MatrixXd& jacobian) const {
    const BarrelParameters parameters = x;
    BarrelParameters gradient;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      BarrelResidual(parameters, points_[i], &gradient);
      jacobian.row(static_cast<Eigen::Index>(i)) = gradient.transpose();
    }
    return 0;
  }

 private:
  geometry::PointSpan points_;
};

std::optional<Barrel> BarrelOf(const Eigen::VectorXd& x, const Eigen::Vector3d& mean) {
  const Eigen::Vector3d d = x.segment<3>(3);
  if (!x.allFinite() || d.norm() == 0.0 || x[6] <= 0.0) return std::nullopt;
  const Eigen::Vector3d direction = d.normalized();
  const Eigen::Vector3d c = x.head<3>();
  return Barrel{{c + (mean - c).dot(direction) * direction, direction}, x[6]};
}

}  // namespace

double BarrelResidual(const BarrelParameters& x, const Eigen::Vector3d& p,
                      BarrelParameters* gradient) {
  const Eigen::Vector3d d = x.segment<3>(3);
  const Eigen::Vector3d offset = p - x.head<3>();
  const double along = offset.dot(d) / d.squaredNorm();
  const Eigen::Vector3d across = offset - along * d;
  const double distance = across.norm();
  if (gradient != nullptr) {
    // On the axis itself the direction is undefined; the gradient is zero there.
    const Eigen::Vector3d outward =
        distance > 0.0 ? Eigen::Vector3d(across / distance) : Eigen::Vector3d::Zero();
    gradient->head<3>() = -outward;
    gradient->segment<3>(3) = -along * outward;
    (*gradient)[6] = -1.0;
  }
  return distance - x[6];
}

std::optional<Barrel> FitLeastSquares(geometry::PointSpan points, int iterations) {
  constexpr int kParameters = BarrelParameters::RowsAtCompileTime;
  const auto line = FitLine(points);
  if (points.size() < kParameters || !line) return std::nullopt;
  double sum_m = 0.0;
  for (const auto& p : points) sum_m += line->Distance(p);
  Eigen::VectorXd x(kParameters);
  x << line->point, line->direction, sum_m / static_cast<double>(points.size());
  Residuals residuals(points);
  Eigen::LevenbergMarquardt<Residuals> solver(residuals);
  auto status = solver.minimizeInit(x);
  using Status = Eigen::LevenbergMarquardtSpace::Status;
  for (int i = 0; i < iterations; ++i) {
    if (status != Status::NotStarted && status != Status::Running) break;
    status = solver.minimizeOneStep(x);
  }
  return BarrelOf(x, line->point);
}

namespace {

/// CircleOnAxis ends after this many steps, or when a step is below this share of the radius.
/// Errors below the floor (a share of the radius) count by their square.
constexpr int kCircleRounds = 40;
constexpr double kRestShare = 1e-9;
constexpr double kFloorShare = 1e-4;
constexpr double kHalfway_rad = base::Deg(20.0);  // half of PassesGate's range around 45 deg
constexpr double kBarrel_m = 0.002;               // distance of the barrel's points (section 4.2.4)
/// Rounds of gathering the barrel and fitting its axis. Only 1 as printed, along the circle's
/// normal; a rim of r 10 mm determines it only to a few degrees: 2 mm at 30 mm from the rim.
constexpr int kBarrelRounds = 8;

/// "Top curvature points": curved points that pass the gate. Ascending.
geometry::Indices RimOf(const FitInput& input, const RcfPreparation& prepared, bool as_printed) {
  const Eigen::Matrix3d R_CS = SensorAxes(input.up, input.eye - geometry::Centroid(input.points));
  geometry::Indices rim;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    if (prepared.curved[i] && PassesGate(R_CS.transpose() * prepared.normals[i], as_printed)) {
      rim.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return rim;
}

geometry::PointCloud WallOf(const FitInput& input, const RcfPreparation& prepared,
                            const Barrel& barrel, bool as_printed) {
  geometry::PointCloud wall;
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    if (std::abs(barrel.Distance(input.points[i])) > kBarrel_m) continue;
    // The visible end is within the tolerance near its rim.
    if (!IsRadial(prepared.normals[i], barrel.axis.direction)) continue;
    // Curvature points count, too, as printed ("the curvature points of this run and all remaining
    // points").
    if (!as_printed && prepared.curved[i]) continue;
    wall.points.push_back(input.points[i]);
    wall.normals.push_back(prepared.normals[i]);
  }
  return wall;
}

}  // namespace

bool PassesGate(const Eigen::Vector3d& n_S, bool as_printed) {
  if (as_printed) return PassesSensorGate(n_S);
  const double tilt = std::acos(std::clamp(n_S.x(), -1.0, 1.0));
  return std::abs(tilt - base::Deg(45.0)) <= kHalfway_rad;
}

RcfPreparation PrepareRcf(const FitInput& input, double neighborhood_m) {
  const geometry::KdTree tree(input.points);
  geometry::NeighborLists neighbors;
  geometry::PointCloud cloud{{input.points.begin(), input.points.end()}, {}};
  cloud.normals = geometry::EstimateNormals(input.points, tree, neighborhood_m,
                                            geometry::Points{input.eye}, {}, 0.0, &neighbors);
  CurvatureOptions curvature;
  curvature.radius_m = neighborhood_m;
  auto curved = CurvedPoints(cloud, tree, curvature, neighbors);
  return {std::move(cloud.normals), std::move(curved)};
}

std::optional<Circle> CircleOnAxis(geometry::PointSpan rim, const Eigen::Vector3d& axis,
                                   const Circle& start) {
  if (rim.size() < 3) return std::nullopt;
  const auto& [u, v] = Across(axis);
  Circle circle{start.center, axis, start.radius_m};
  for (int round = 0; round < kCircleRounds; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : rim) {
      const Eigen::Vector2d offset((p - circle.center).dot(u), (p - circle.center).dot(v));
      const double distance = offset.norm();
      if (distance == 0.0) continue;
      const double error = distance - circle.radius_m;
      const Eigen::Vector3d row(-offset.x() / distance, -offset.y() / distance, -1.0);
      // This weight turns squares into absolute values. Below the floor squares remain.
      const double weight = 1.0 / std::max(std::abs(error), kFloorShare * start.radius_m);
      normal += weight * row * row.transpose();
      right -= weight * error * row;
    }
    const Eigen::Vector3d step = base::SolveLdlt(normal, right);
    if (!step.allFinite()) return std::nullopt;
    circle.center += step.x() * u + step.y() * v;
    circle.radius_m += step.z();
    if (!(circle.radius_m > 0.0)) return std::nullopt;
    if (step.norm() < kRestShare * start.radius_m) break;
  }
  return circle;
}

std::optional<Barrel> FitRcf(const FitInput& input, const RcfPreparation& prepared, int draws,
                             bool as_printed, base::Rng& rng) {
  const geometry::Points rim = geometry::Select(input.points, RimOf(input, prepared, as_printed));
  const auto drawn = FitRandomCircle(rim, draws, rng);
  if (!drawn) return std::nullopt;
  Circle circle = *drawn;
  Barrel barrel{{circle.center, circle.normal}, circle.radius_m};
  for (int round = 0; round < kBarrelRounds; ++round) {
    const geometry::PointCloud wall = WallOf(input, prepared, barrel, as_printed);
    const auto line = FitLine(AxisPoints(wall.points, wall.normals, barrel.radius_m));
    if (!line) return std::nullopt;
    barrel.axis = *line;
    // As printed, the radius is that of the best triple, i.e. of three points of a rim one
    // millimetre wide.
    if (as_printed) break;
    const auto again = CircleOnAxis(rim, line->direction, circle);
    if (!again) return std::nullopt;
    circle = *again;
    barrel.radius_m = circle.radius_m;
  }
  return barrel;
}

namespace {

/// Each round computes weights, then a Gauss-Newton step. They end when no point of the barrel
/// moves by more than kRest_m.
constexpr int kRefinedRounds = 60;
constexpr double kRest_m = 1e-9;
constexpr std::size_t kMinRefinedPoints = 7;
/// Tukey's biweight: distances beyond this many standard deviations do not count. It keeps 95 % of
/// the efficiency of least squares for normally distributed noise (Huber 1981).
constexpr double kCutSigmas = 4.685;
/// Points closer to a visible end than this many sigmas of the noise along the ray are left out.
constexpr double kEndMarginSigmas = 4.0;
/// An end is visible if this share of the points lies inside the barrel by more than kInnerShare of
/// its radius.
constexpr double kEndShare = 0.01;
constexpr double kInnerShare = 0.25;
/// Factor from the median of absolute values to the standard deviation, for a normal distribution.
constexpr double kSigmaOfMedian = 1.4826;
/// Minimum share of each noise in the total; else a few points at the outline would dominate.
constexpr double kMinNoiseShare = 0.05;
/// Noise below this is rounding [m]: exact points get equal weights.
constexpr double kRounding_m = 1e-12;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Shifts of the axis along u and v, its tilts towards them, and the change of the radius.
using LevenbergStep = Eigen::Matrix<double, 5, 1>;

Barrel Moved(const Barrel& barrel, const LevenbergStep& step) {
  const Across across(barrel.axis.direction);
  const auto& [point, direction] = barrel.axis;
  return {{point + step[0] * across.u + step[1] * across.v,
           (direction + step[2] * across.u + step[3] * across.v).normalized()},
          barrel.radius_m + step[4]};
}

double Tukey(double sigmas) {
  const double t = sigmas / kCutSigmas;
  return std::abs(t) >= 1.0 ? 0.0 : (1.0 - t * t) * (1.0 - t * t);
}

double Square(double x) { return x * x; }

// Variance of standard normal values that remains after weighting by Tukey's biweight. (The formula
// neglects values beyond the cut, which are one in 3e5 at 4.685.)
double KeptVariance() {
  const double c2 = kCutSigmas * kCutSigmas;
  return (1.0 - 6.0 / c2 + 15.0 / (c2 * c2)) / (1.0 - 2.0 / c2 + 3.0 / (c2 * c2));
}

/// Contribution of a point to a round.
struct Term {
  double distance_m = 0.0;  ///< from the barrel, less the mean due to noise
  LevenbergStep gradient;   ///< gradient of the distance
  Incidence incidence;
  double variance_m2 = 1.0;  ///< of the distance, from the point's own noise
  double weight = 0.0;       ///< robust weight, 0 to 1
};

class Refinement {
 public:
  Refinement(const FitInput& input, const Barrel& start) : input_(input), barrel_(start) {
    // The axis' point is at the middle of the points, so that tilts hardly move them.
    const Eigen::Vector3d middle = geometry::Centroid(input.points);
    barrel_.axis.point += start.axis.PlaceOf(middle).along_m * start.axis.direction;
    for (const auto& p : input.points) reach_m_ = std::max(reach_m_, (p - middle).norm());
  }

  const Barrel& barrel() const { return barrel_; }

  /// Does one round. Returns false if the points allow no further one.
  bool Advance() {
    FindTerms();
    if (terms_.size() < kMinRefinedPoints) return false;
    const double sigma_m = Sigma();
    if (!noise_) noise_ = RayNoise{sigma_m, sigma_m};
    Weigh();
    EstimateNoise(sigma_m);
    const auto step = FindStep();
    if (!step) return false;
    barrel_ = Moved(barrel_, *step);
    moved_m_ =
        step->head<2>().norm() + step->segment<2>(2).norm() * reach_m_ + std::abs((*step)[4]);
    return barrel_.radius_m > 0.0;
  }
  bool AtRest() const { return moved_m_ <= kRest_m; }

 private:
  // A visible end shows as many points far inside the barrel, near one plane.
  void FindWall() {
    low_m_ = -kInfinity;
    high_m_ = kInfinity;
    std::vector<double> inside;
    std::vector<double> on;
    for (const auto& p : input_.points) {
      const bool is_inside = barrel_.Distance(p) < -kInnerShare * barrel_.radius_m;
      (is_inside ? inside : on).push_back(barrel_.axis.PlaceOf(p).along_m);
    }
    const double enough = kEndShare * static_cast<double>(input_.points.size());
    if (static_cast<double>(inside.size()) < std::max(enough, 3.0) || on.empty()) return;
    // Mixed points behind the wall are also inside, but spread along its whole length.
    const double spread_m = base::QuantileOf(inside, 0.75) - base::QuantileOf(inside, 0.25);
    if (spread_m > kInnerShare * barrel_.radius_m) return;
    const double end_m = base::MedianOf(inside);
    // The end is seen at an angle; the noise along the axis is at most that along the ray.
    const double noise_m = noise_ ? std::hypot(noise_->along_m, noise_->across_m) : 0.0;
    const double margin_m = kEndMarginSigmas * noise_m;
    if (end_m > base::MedianOf(on)) {
      high_m_ = end_m - margin_m;
    } else {
      low_m_ = end_m + margin_m;
    }
  }

  void FindTerms() {
    FindWall();
    const Across across(barrel_.axis.direction);
    BarrelParameters x;
    x << barrel_.axis.point, barrel_.axis.direction, barrel_.radius_m;
    terms_.clear();
    for (std::size_t i = 0; i < input_.points.size(); ++i) {
      const Eigen::Vector3d& p = input_.points[i];
      const double along_m = barrel_.axis.PlaceOf(p).along_m;
      if (along_m < low_m_ || along_m > high_m_) continue;
      Term term;
      BarrelParameters g;
      term.distance_m = BarrelResidual(x, p, &g);
      const Eigen::Vector3d inward = g.head<3>();
      const Eigen::Vector3d turned = g.segment<3>(3);
      term.gradient << inward.dot(across.u), inward.dot(across.v), turned.dot(across.u),
          turned.dot(across.v), g[6];
      term.incidence = IncidenceOf(barrel_, input_.eye, p);
      terms_.push_back(term);
    }
  }

  double Sigma() const {
    std::vector<double> sizes;
    for (const Term& term : terms_) sizes.push_back(std::abs(term.distance_m));
    return kSigmaOfMedian * base::MedianOf(std::move(sizes));
  }

  void Weigh() {
    for (Term& term : terms_) {
      const DistanceNoise expected = DistanceNoiseOf(*noise_, term.incidence, barrel_.radius_m);
      term.distance_m -= expected.mean_m;
      term.variance_m2 = std::max(expected.variance_m2, Square(kRounding_m));
      term.weight = Tukey(term.distance_m / std::sqrt(term.variance_m2));
    }
  }

  // Fits the squared distances by a sum of both noise variances, each times its part of the normal:
  // linear least squares with the robust weights; else outliers would increase the noise.
  void EstimateNoise(double sigma_m) {
    const double kept = KeptVariance();
    double aa = 0.0, ab = 0.0, bb = 0.0, ay = 0.0, by = 0.0;
    for (const Term& term : terms_) {
      if (term.weight == 0.0) continue;
      const double a = Square(term.incidence.radial);
      const double b = 1.0 - a;
      // The variance of a squared normal value is twice the square of its mean.
      const double w = term.weight / Square(term.variance_m2);
      const double y = Square(term.distance_m) / kept;
      aa += w * a * a;
      ab += w * a * b;
      bb += w * b * b;
      ay += w * a * y;
      by += w * b * y;
    }
    const double determinant = aa * bb - ab * ab;
    const double least = Square(kMinNoiseShare * sigma_m);
    if (!(determinant > 1e-12 * aa * bb)) {  // all points have the same incidence
      noise_ = RayNoise{sigma_m, sigma_m};
      return;
    }
    noise_ = RayNoise{std::sqrt(std::max((ay * bb - by * ab) / determinant, least)),
                      std::sqrt(std::max((by * aa - ay * ab) / determinant, least))};
  }

  std::optional<LevenbergStep> FindStep() {
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    LevenbergStep right = LevenbergStep::Zero();
    std::size_t used = 0;
    for (const Term& term : terms_) {
      if (term.weight == 0.0) continue;
      const double w = term.weight / term.variance_m2;
      normal += w * term.gradient * term.gradient.transpose();
      right -= w * term.distance_m * term.gradient;
      ++used;
    }
    if (used < kMinRefinedPoints) return std::nullopt;
    const LevenbergStep step = normal.ldlt().solve(right);
    return step.allFinite() ? std::optional(step) : std::nullopt;
  }

  const FitInput& input_;
  Barrel barrel_;
  double reach_m_ = 0.0;
  double moved_m_ = kInfinity;
  std::optional<RayNoise> noise_;
  double low_m_ = -kInfinity;  ///< bounds of the wall without the end, along the axis
  double high_m_ = kInfinity;
  std::vector<Term> terms_;
};

}  // namespace

std::optional<Barrel> FitRefined(const FitInput& input, const Barrel& start) {
  if (input.points.size() < kMinRefinedPoints || !(start.radius_m > 0.0)) return std::nullopt;
  Refinement refinement(input, start);
  for (int round = 0; round < kRefinedRounds && !refinement.AtRest(); ++round) {
    if (!refinement.Advance()) return std::nullopt;
  }
  return refinement.barrel();
}

}  // namespace rangegrasp::cylinders
