#include "cylinders/fit_refined.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "base/quantile.h"
#include "cylinders/fit_least_squares.h"

namespace rangegrasp::cylinders {
namespace {

constexpr std::size_t kMinRefinedPoints = 7;
/// Standard deviation of normal values from the median of their sizes.
constexpr double kSigmaOfMedian = 1.4826;
/// Neither part of the noise is taken to be less than this share of the whole: a weight of a few
/// points at the outline alone would decide all.
constexpr double kMinNoiseShare = 0.05;
/// Noise below this [m] is rounding: exact points get equal weights.
constexpr double kRounding_m = 1e-12;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Offsets of the axis along u and v, its turns towards them, and of the radius.
using LevenbergStep = Eigen::Matrix<double, 5, 1>;

struct Across {
  Eigen::Vector3d u;
  Eigen::Vector3d v;
};
Across AcrossOf(const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = d.unitOrthogonal();
  return {u, d.cross(u)};
}

Barrel Moved(const Barrel& barrel, const LevenbergStep& step) {
  const Across across = AcrossOf(barrel.axis.direction);
  Barrel moved;
  moved.axis.point = barrel.axis.point + step[0] * across.u + step[1] * across.v;
  moved.axis.direction =
      (barrel.axis.direction + step[2] * across.u + step[3] * across.v).normalized();
  moved.radius_m = barrel.radius_m + step[4];
  return moved;
}

double Along(const Barrel& barrel, const Eigen::Vector3d& p) {
  return (p - barrel.axis.point).dot(barrel.axis.direction);
}

double Tukey(double sigmas, double cut) {
  const double t = sigmas / cut;
  return std::abs(t) >= 1.0 ? 0.0 : (1.0 - t * t) * (1.0 - t * t);
}

double Square(double x) { return x * x; }

// The variance of unit normal values, weighed by Tukey's biweight: what its weights leave of it.
// (Of values beyond the cut, which are one in 3e5 at 4.685, the formula has none.)
double KeptVariance(double cut) {
  const double c2 = cut * cut;
  return (1.0 - 6.0 / c2 + 15.0 / (c2 * c2)) / (1.0 - 2.0 / c2 + 3.0 / (c2 * c2));
}

/// A point's part in a round.
struct Term {
  double distance_m = 0.0;  ///< from the barrel, less its mean under noise
  LevenbergStep gradient;   ///< of the distance
  Incidence incidence;
  double variance_m2 = 1.0;  ///< of the distance by the point's own noise
  double weight = 0.0;       ///< of the robust loss: 0 to 1
};

class Refinement {
 public:
  Refinement(const FitInput& input, const Barrel& start, const RefineOptions& options)
      : input_(input), options_(options), barrel_(start) {
    // The middle of the points: turns of the axis then leave them where they are.
    const Eigen::Vector3d middle = geometry::Centroid(input.points);
    barrel_.axis.point += Along(start, middle) * start.axis.direction;
    for (const auto& p : input.points) reach_m_ = std::max(reach_m_, (p - middle).norm());
  }

  const Barrel& barrel() const { return barrel_; }

  /// One round. False where there is no further one to make of the points.
  bool Advance() {
    FindTerms();
    if (terms_.size() < kMinRefinedPoints) return false;
    const double sigma_m = Sigma();
    if (!noise_) noise_ = RayNoise{sigma_m, sigma_m};
    Weigh();
    if (options_.weigh_incidence) {
      EstimateNoise(sigma_m);
    } else {
      noise_ = RayNoise{sigma_m, sigma_m};
    }
    const auto step = FindStep();
    if (!step) return false;
    barrel_ = Moved(barrel_, *step);
    moved_m_ =
        step->head<2>().norm() + step->segment<2>(2).norm() * reach_m_ + std::abs((*step)[4]);
    return barrel_.radius_m > 0.0;
  }
  bool AtRest() const { return moved_m_ <= options_.rest_m; }

 private:
  void FindWall();
  void FindTerms();
  double Sigma() const;
  void Weigh();
  void EstimateNoise(double sigma_m);
  std::optional<LevenbergStep> FindStep();

  const FitInput& input_;
  const RefineOptions& options_;
  Barrel barrel_;
  double reach_m_ = 0.0;
  double moved_m_ = kInfinity;
  std::optional<RayNoise> noise_;
  double low_m_ = -kInfinity;  ///< the wall alone, along the axis
  double high_m_ = kInfinity;
  std::vector<Term> terms_;
};

// Of an end that was seen many points lie far inside the barrel, about one plane.
void Refinement::FindWall() {
  low_m_ = -kInfinity;
  high_m_ = kInfinity;
  std::vector<double> inside;
  std::vector<double> on;
  for (const auto& p : input_.points) {
    const bool is_inside = barrel_.Distance(p) < -options_.inner_share * barrel_.radius_m;
    (is_inside ? inside : on).push_back(Along(barrel_, p));
  }
  const double enough = options_.end_share * static_cast<double>(input_.points.size());
  if (static_cast<double>(inside.size()) < std::max(enough, 3.0) || on.empty()) return;
  // Mixed points behind the wall lie within it, too, but all along it.
  const double spread_m = base::QuantileOf(inside, 0.75) - base::QuantileOf(inside, 0.25);
  if (spread_m > options_.inner_share * barrel_.radius_m) return;
  const double end_m = base::MedianOf(inside);
  // The end is seen at an angle: along the axis its noise is at most that along the ray.
  const double noise_m = noise_ ? std::hypot(noise_->along_m, noise_->across_m) : 0.0;
  const double margin_m = options_.end_margin_sigmas * noise_m;
  if (end_m > base::MedianOf(on)) {
    high_m_ = end_m - margin_m;
  } else {
    low_m_ = end_m + margin_m;
  }
}

void Refinement::FindTerms() {
  if (options_.drop_ends) FindWall();
  const Across across = AcrossOf(barrel_.axis.direction);
  BarrelParameters x;
  x << barrel_.axis.point, barrel_.axis.direction, barrel_.radius_m;
  terms_.clear();
  for (std::size_t i = 0; i < input_.points.size(); ++i) {
    const Eigen::Vector3d& p = input_.points[i];
    const double along_m = Along(barrel_, p);
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

double Refinement::Sigma() const {
  std::vector<double> sizes;
  sizes.reserve(terms_.size());
  for (const Term& term : terms_) sizes.push_back(std::abs(term.distance_m));
  return kSigmaOfMedian * base::MedianOf(std::move(sizes));
}

void Refinement::Weigh() {
  for (Term& term : terms_) {
    const DistanceNoise expected = DistanceNoiseOf(*noise_, term.incidence, barrel_.radius_m);
    if (options_.correct_mean) term.distance_m -= expected.mean_m;
    const double variance_m2 =
        options_.weigh_incidence ? expected.variance_m2 : Square(noise_->along_m);
    term.variance_m2 = std::max(variance_m2, Square(kRounding_m));
    term.weight = Tukey(term.distance_m / std::sqrt(term.variance_m2), options_.cut_sigmas);
  }
}

// The squares of the distances as a sum of both noises' squares, each times its part of the normal:
// weighted linear least squares with the robust loss's weights, or one point in eleven that is far
// off would widen the noise until it counts itself.
void Refinement::EstimateNoise(double sigma_m) {
  const double kept = KeptVariance(options_.cut_sigmas);
  double aa = 0.0, ab = 0.0, bb = 0.0, ay = 0.0, by = 0.0;
  for (const Term& term : terms_) {
    if (term.weight == 0.0) continue;
    const double a = Square(term.incidence.radial);
    const double b = 1.0 - a;
    // The variance of a square is twice the square of its mean.
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
  if (!(determinant > 1e-12 * aa * bb)) {  // one incidence alone
    noise_ = RayNoise{sigma_m, sigma_m};
    return;
  }
  noise_ = RayNoise{std::sqrt(std::max((ay * bb - by * ab) / determinant, least)),
                    std::sqrt(std::max((by * aa - ay * ab) / determinant, least))};
}

std::optional<LevenbergStep> Refinement::FindStep() {
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
  if (!step.allFinite()) return std::nullopt;
  return step;
}

void Check(const RefineOptions& options) {
  if (options.rounds < 1 || options.cut_sigmas <= 0.0 || options.rest_m < 0.0 ||
      options.end_margin_sigmas < 0.0) {
    throw std::invalid_argument(
        "FitRefined: rounds must be >= 1, cut_sigmas > 0, rest_m and end_margin_sigmas >= 0");
  }
}

}  // namespace

std::optional<BarrelFit> FitRefined(const FitInput& input, const Barrel& start,
                                    const RefineOptions& options) {
  Check(options);
  if (input.points.size() < kMinRefinedPoints || !(start.radius_m > 0.0)) return std::nullopt;
  Refinement refinement(input, start, options);
  int round = 0;
  while (round < options.rounds && !refinement.AtRest()) {
    if (!refinement.Advance()) return std::nullopt;
    ++round;
  }
  return BarrelFit{refinement.barrel(), round};
}

}  // namespace rangegrasp::cylinders
