#include "cylinders/fit_refined.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/quantile.h"
#include "cylinders/fit_least_squares.h"

namespace rangegrasp::cylinders {
namespace {

constexpr std::size_t kMinPoints = 7;
/// Standard deviation of normal values from the median of their sizes.
constexpr double kSigmaOfMedian = 1.4826;
/// Neither part of the noise is taken to be less than this share of the whole: a weight of a few
/// points at the outline alone would decide all.
constexpr double kMinNoiseShare = 0.05;
/// Noise below this [m] is rounding: exact points get equal weights.
constexpr double kRounding_m = 1e-12;

void Check(const RefineOptions& options) {
  if (options.rounds < 1 || options.cut_sigmas <= 0.0 || options.rest_m < 0.0 ||
      options.end_margin_sigmas < 0.0) {
    throw std::invalid_argument(
        "FitRefined: rounds must be >= 1, cut_sigmas > 0, rest_m and end_margin_sigmas >= 0");
  }
}

/// A point's part in a round.
struct Term {
  std::size_t point = 0;
  double distance_m = 0.0;  ///< of the barrel, less its mean under noise
  Incidence incidence;
  double variance_m2 = 1.0;
  double weight = 0.0;  ///< of the robust loss: 0 to 1
};

double Tukey(double sigmas, double cut) {
  const double t = sigmas / cut;
  return std::abs(t) >= 1.0 ? 0.0 : (1.0 - t * t) * (1.0 - t * t);
}

double Along(const Barrel& barrel, const Eigen::Vector3d& p) {
  return (p - barrel.axis.point).dot(barrel.axis.direction);
}

/// What of the axis belongs to the wall alone.
struct Span {
  double low_m;
  double high_m;
};

// Of an end that was seen many points lie far inside the barrel, about one plane.
Span WallOf(const FitInput& input, const Barrel& barrel, const RayNoise& noise,
            const RefineOptions& options) {
  Span wall{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::vector<double> inside;
  std::vector<double> on;
  for (const auto& p : input.points) {
    const bool is_inside = barrel.Distance(p) < -options.inner_share * barrel.radius_m;
    (is_inside ? inside : on).push_back(Along(barrel, p));
  }
  const auto enough = options.end_share * static_cast<double>(input.points.size());
  if (static_cast<double>(inside.size()) < std::max(enough, 3.0) || on.empty()) return wall;
  const double end_m = core::MedianOf(inside);
  // The end is seen at an angle: along the axis its noise is at most that along the ray.
  const double margin_m = options.end_margin_sigmas * std::hypot(noise.along_m, noise.across_m);
  if (end_m > core::MedianOf(on)) {
    wall.high_m = end_m - margin_m;
  } else {
    wall.low_m = end_m + margin_m;
  }
  return wall;
}

std::vector<Term> TermsOf(const FitInput& input, const Barrel& barrel, const Span& wall) {
  std::vector<Term> terms;
  terms.reserve(input.points.size());
  for (std::size_t i = 0; i < input.points.size(); ++i) {
    const Eigen::Vector3d& p = input.points[i];
    const double along_m = Along(barrel, p);
    if (along_m < wall.low_m || along_m > wall.high_m) continue;
    terms.push_back({i, barrel.Distance(p), IncidenceOf(barrel, input.eye, p), 1.0, 0.0});
  }
  return terms;
}

double SigmaOf(const std::vector<Term>& terms) {
  std::vector<double> sizes;
  sizes.reserve(terms.size());
  for (const Term& term : terms) sizes.push_back(std::abs(term.distance_m));
  return kSigmaOfMedian * core::MedianOf(std::move(sizes));
}

// The squares of the distances as a sum of both noises' squares, each times its part of the normal:
// weighted linear least squares over the points that count.
RayNoise NoiseOf(const std::vector<Term>& terms, double sigma_m) {
  double aa = 0.0, ab = 0.0, bb = 0.0, ay = 0.0, by = 0.0;
  for (const Term& term : terms) {
    if (term.weight == 0.0) continue;
    const double a = term.incidence.radial * term.incidence.radial;
    const double b = 1.0 - a;
    // The variance of a square is twice the square of its mean.
    const double w = 1.0 / (term.variance_m2 * term.variance_m2);
    const double y = term.distance_m * term.distance_m;
    aa += w * a * a;
    ab += w * a * b;
    bb += w * b * b;
    ay += w * a * y;
    by += w * b * y;
  }
  const double determinant = aa * bb - ab * ab;
  const double least = std::pow(kMinNoiseShare * sigma_m, 2);
  if (!(determinant > 1e-12 * aa * bb)) return {sigma_m, sigma_m};  // one incidence alone
  return {std::sqrt(std::max((ay * bb - by * ab) / determinant, least)),
          std::sqrt(std::max((by * aa - ay * ab) / determinant, least))};
}

void Weigh(const Barrel& barrel, const RayNoise& noise, const RefineOptions& options,
           std::vector<Term>& terms) {
  for (Term& term : terms) {
    const DistanceNoise expected = DistanceNoiseOf(noise, term.incidence, barrel.radius_m);
    if (options.correct_mean) term.distance_m -= expected.mean_m;
    term.variance_m2 =
        options.weigh_incidence ? expected.variance_m2 : noise.along_m * noise.along_m;
    term.variance_m2 = std::max(term.variance_m2, kRounding_m * kRounding_m);
    term.weight = Tukey(term.distance_m / std::sqrt(term.variance_m2), options.cut_sigmas);
  }
}

/// Offsets of the axis along u and v, its turns towards them, and of the radius.
using Step = Eigen::Matrix<double, 5, 1>;

struct Across {
  Eigen::Vector3d u;
  Eigen::Vector3d v;
};
Across AcrossOf(const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = d.unitOrthogonal();
  return {u, d.cross(u)};
}

std::optional<Step> StepOf(const FitInput& input, const Barrel& barrel,
                           const std::vector<Term>& terms) {
  BarrelParameters x;
  x << barrel.axis.point, barrel.axis.direction, barrel.radius_m;
  const Across across = AcrossOf(barrel.axis.direction);
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Step right = Step::Zero();
  std::size_t used = 0;
  for (const Term& term : terms) {
    if (term.weight == 0.0) continue;
    BarrelParameters g;
    BarrelResidual(x, input.points[term.point], &g);
    Step row;
    row << g.head<3>().dot(across.u), g.head<3>().dot(across.v), g.segment<3>(3).dot(across.u),
        g.segment<3>(3).dot(across.v), g[6];
    const double w = term.weight / term.variance_m2;
    normal += w * row * row.transpose();
    right -= w * term.distance_m * row;
    ++used;
  }
  if (used < kMinPoints) return std::nullopt;
  const Step step = normal.ldlt().solve(right);
  if (!step.allFinite()) return std::nullopt;
  return step;
}

Barrel Moved(const Barrel& barrel, const Step& step) {
  const Across across = AcrossOf(barrel.axis.direction);
  Barrel moved;
  moved.axis.point = barrel.axis.point + step[0] * across.u + step[1] * across.v;
  moved.axis.direction =
      (barrel.axis.direction + step[2] * across.u + step[3] * across.v).normalized();
  moved.radius_m = barrel.radius_m + step[4];
  return moved;
}

}  // namespace

Incidence IncidenceOf(const Barrel& barrel, const Eigen::Vector3d& eye, const Eigen::Vector3d& p) {
  const Eigen::Vector3d& d = barrel.axis.direction;
  const Eigen::Vector3d ray = (p - eye).stableNormalized();
  const Eigen::Vector3d across = ray - ray.dot(d) * d;
  const double length = across.norm();
  if (length == 0.0) return {0.0, 0.0};
  // The ray's distance from the axis, as a share of the radius: the sine of its incidence in the
  // section square to the axis.
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

std::optional<BarrelFit> FitRefined(const FitInput& input, const Barrel& start,
                                    const RefineOptions& options) {
  Check(options);
  if (input.points.size() < kMinPoints || !(start.radius_m > 0.0)) return std::nullopt;
  BarrelFit fit{start, 0};
  // The middle of the points: turns of the axis then leave them where they are.
  Line& axis = fit.barrel.axis;
  axis.point += Along(start, geometry::Centroid(input.points)) * axis.direction;
  const double reach_m = 0.5 * std::sqrt(3.0) * [&] {
    Eigen::Vector3d low = input.points.front(), high = low;
    for (const auto& p : input.points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    return (high - low).maxCoeff();
  }();
  std::optional<RayNoise> noise;
  for (; fit.iterations < options.rounds;) {
    const Span wall = options.drop_ends
                          ? WallOf(input, fit.barrel, noise.value_or(RayNoise{}), options)
                          : Span{-reach_m * 1e3, reach_m * 1e3};
    std::vector<Term> terms = TermsOf(input, fit.barrel, wall);
    if (terms.size() < kMinPoints) return std::nullopt;
    const double sigma_m = SigmaOf(terms);
    Weigh(fit.barrel, noise.value_or(RayNoise{sigma_m, sigma_m}), options, terms);
    noise = options.weigh_incidence ? NoiseOf(terms, sigma_m) : RayNoise{sigma_m, sigma_m};
    const auto step = StepOf(input, fit.barrel, terms);
    if (!step) return std::nullopt;
    fit.barrel = Moved(fit.barrel, *step);
    ++fit.iterations;
    if (!(fit.barrel.radius_m > 0.0)) return std::nullopt;
    const double moved_m =
        step->head<2>().norm() + step->segment<2>(2).norm() * reach_m + std::abs((*step)[4]);
    if (moved_m <= options.rest_m) break;
  }
  return fit;
}

}  // namespace rangegrasp::cylinders
