#include "seam/stitching/internal/seam_path.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "base/linear_algebra.h"

namespace rangegrasp::seam {
namespace {

// Windows around and next to a point; at high speed wider ones, with this many points per side.
constexpr std::array kWindows_m = {15e-3, 8e-3};
constexpr double kPointsASide = 5.0;
// Sensed points are accurate to a tenth of a millimetre, or else arbitrarily wrong.
constexpr double kNoise_m = 0.1e-3;
// Weight of this noise relative to the observed residuals, in points: few residuals may be small by
// chance.
constexpr double kNoiseWorth = 2.0;
// Residual at which a point counts half: twice the noise.
constexpr double kInlier_m = 2.0 * kNoise_m;
// A parabola has three terms; two more points are needed to judge a fit.
constexpr std::size_t kMinEdgePoints = 5;
// Maximum number of points in a window of which all triples are tried. More take more time (third
// power); fewer may miss the edge among outliers.
constexpr std::size_t kMaxBasis = 12;
// Points closer than this [windows] do not determine a parabola.
constexpr double kMinApart = 1e-3;
// Limits of a plausible parabola: slope across the track (68 degrees) and curvature (a radius of 5
// mm).
constexpr double kMaxSteepness = 2.5;
constexpr double kMaxCurvature_1_m = 200.0;
// Any three points lie on a parabola; this share of the others has to support it. A larger share
// loses edges in noise of 40 %, a smaller one accepts random parabolas.
constexpr double kSupportShare = 0.3;
// Rounds of reweighted least squares, from a start that is robust to outliers.
constexpr int kSmoothRounds = 4;
// Length whose direction extends an edge, and the steepest such direction (45 degrees).
constexpr double kExtendFrom_m = 12e-3;
constexpr double kMaxExtendSlope = 1.0;

using Parabola = Eigen::Vector3d;  // coefficients of u^0..u^2

/// A point relative to the point that is smoothed.
struct Seen {
  double u, v;  // along and across; u in windows
  Eigen::Vector3d Row() const { return {1.0, u, u * u}; }
};

double RowWeight(double residual) {
  const double t = residual / kInlier_m;
  return 1.0 / (1.0 + t * t);
}

std::optional<Parabola> Through(const Seen& a, const Seen& b, const Seen& c) {
  const double ab = b.u - a.u, bc = c.u - b.u, ac = c.u - a.u;
  if (std::min({std::abs(ab), std::abs(bc), std::abs(ac)}) < kMinApart) return std::nullopt;
  const double first = (b.v - a.v) / ab;
  const double second = ((c.v - b.v) / bc - first) / ac;
  return Parabola(a.v - first * a.u + second * a.u * b.u, first - second * (a.u + b.u), second);
}

bool Plausible(const Parabola& c, double window_m) {
  return std::abs(c[1]) <= kMaxSteepness * window_m &&
         std::abs(c[2]) <= 0.5 * kMaxCurvature_1_m * window_m * window_m;
}

// The parabola through three points that most points support; all triples of a dozen are tried, so
// the result is deterministic.
std::optional<Parabola> MostSupported(std::span<const Seen> seen, double window_m) {
  std::optional<Parabola> best;
  const auto others = static_cast<double>(seen.size() - 3);
  double max_support = 3.0 + kSupportShare * others;
  const std::size_t stride = (seen.size() + kMaxBasis - 1) / kMaxBasis;
  for (std::size_t i = 0; i < seen.size(); i += stride) {
    for (std::size_t j = i + stride; j < seen.size(); j += stride) {
      for (std::size_t k = j + stride; k < seen.size(); k += stride) {
        const auto c = Through(seen[i], seen[j], seen[k]);
        if (!c || !Plausible(*c, window_m)) continue;
        double support = 0.0;
        for (const Seen& p : seen) support += RowWeight(p.v - p.Row().dot(*c));
        if (support > max_support) {
          max_support = support;
          best = c;
        }
      }
    }
  }
  return best;
}

struct LocalFit {
  double x_m;
  double variance;  // expected variance of x_m
};

// Least squares with weights that decrease with the residuals, from a start robust to outliers.
std::optional<LocalFit> FitLocally(std::span<const Seen> seen, double window_m) {
  if (seen.size() < kMinEdgePoints) return std::nullopt;
  auto c = MostSupported(seen, window_m);
  if (!c) return std::nullopt;
  Eigen::Matrix3d normal;
  double squares = 0.0, worth = 0.0;
  for (int round = 0; round < kSmoothRounds; ++round) {
    normal.setZero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    squares = worth = 0.0;
    for (const Seen& p : seen) {
      const double residual = p.v - p.Row().dot(*c);
      const double weight = RowWeight(residual) * RowWeight(residual);
      normal += weight * p.Row() * p.Row().transpose();
      right += weight * p.v * p.Row();
      squares += weight * residual * residual;
      worth += weight;
    }
    c = base::SolveLdlt(normal, right);
  }
  const double leverage = base::SolveLdlt<3, 1>(normal, Eigen::Vector3d::UnitX())[0];
  if (!c->allFinite() || !(leverage > 0.0)) return std::nullopt;
  const double variance =
      (squares + kNoiseWorth * kNoise_m * kNoise_m) / (std::max(0.0, worth - 3.0) + kNoiseWorth);
  return LocalFit{(*c)[0], variance * leverage};
}

// The fit with the smallest expected variance in the windows around and next to the point.
std::optional<double> SmoothX(std::span<const Point> points, std::size_t at, double widen) {
  std::optional<LocalFit> best;
  std::vector<Seen> seen;
  for (const double width : kWindows_m) {
    for (const auto& [low, high] :
         {std::array{-1.0, 1.0}, std::array{-1.0, 0.0}, std::array{0.0, 1.0}}) {
      seen.clear();
      for (const Point& p : points) {
        const double u = (p.y() - points[at].y()) / (widen * width);
        if (u >= low && u <= high) seen.push_back({u, p.x() - points[at].x()});
      }
      const auto fit = FitLocally(seen, widen * width);
      if (fit && (!best || fit->variance < best->variance)) best = fit;
    }
  }
  if (!best) return std::nullopt;
  return points[at].x() + best->x_m;
}

// Low side of the disc around p at y; infinite if y is outside the disc.
double DiscX(const Point& p, double radius, double y) {
  const double d = y - p.y();
  if (std::abs(d) > radius) return std::numeric_limits<double>::infinity();
  return p.x() - std::sqrt(radius * radius - d * d);
}

// The same for the segment from a to b, moved to the low side along its normal.
double SideX(const Point& a, const Point& b, double distance, double y) {
  const Point along = (b - a).normalized();
  const Point shift = distance * Point(-along.y(), along.x());
  const double y0 = a.y() + shift.y();
  const double y1 = b.y() + shift.y();
  if (y < y0 || y > y1 || !(y1 > y0)) return std::numeric_limits<double>::infinity();
  const double x0 = a.x() + shift.x();
  return x0 + (y - y0) / (y1 - y0) * (b.x() - a.x());
}

double SlopeOf(const Point& a, const Point& b) {
  const double rise = b.y() - a.y();
  return rise > 0.0 ? std::clamp((b.x() - a.x()) / rise, -kMaxExtendSlope, kMaxExtendSlope) : 0.0;
}

}  // namespace

std::vector<Point> SmoothEdge(std::span<const Point> sensed) {
  std::vector<Point> smooth;
  if (sensed.size() < kMinEdgePoints) return smooth;
  const double spacing =
      (sensed.back().y() - sensed.front().y()) / static_cast<double>(sensed.size() - 1);
  const double reach = std::max(kWindows_m.front(), kPointsASide * spacing);
  auto begin = sensed.begin();
  auto end = sensed.begin();
  for (std::size_t i = 0; i < sensed.size(); ++i) {
    while (begin->y() < sensed[i].y() - reach) ++begin;
    while (end != sensed.end() && end->y() <= sensed[i].y() + reach) ++end;
    const auto at = i - static_cast<std::size_t>(begin - sensed.begin());
    const auto x = SmoothX(std::span(begin, end), at, reach / kWindows_m.front());
    if (x) smooth.emplace_back(*x, sensed[i].y());
  }
  return smooth;
}

std::vector<Point> Extend(std::vector<Point> edge, double before_m, double after_m) {
  if (edge.empty()) return edge;
  const auto from_first = std::ranges::find_if(
      edge, [&](const Point& p) { return p.y() >= edge.front().y() + kExtendFrom_m; });
  const auto from_last = std::find_if(edge.rbegin(), edge.rend(), [&](const Point& p) {
    return p.y() <= edge.back().y() - kExtendFrom_m;
  });
  const double first_slope = from_first == edge.end() ? 0.0 : SlopeOf(edge.front(), *from_first);
  const double last_slope = from_last == edge.rend() ? 0.0 : SlopeOf(*from_last, edge.back());
  edge.push_back(edge.back() + after_m * Point(last_slope, 1.0));
  edge.insert(edge.begin(), edge.front() - before_m * Point(first_slope, 1.0));
  return edge;
}

double OffsetX(std::span<const Point> edge, double distance_m, double y_m) {
  double x = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < edge.size(); ++i) {
    x = std::min(x, DiscX(edge[i], distance_m, y_m));
    if (i > 0) x = std::min(x, SideX(edge[i - 1], edge[i], distance_m, y_m));
  }
  return std::isfinite(x) ? x : std::numeric_limits<double>::quiet_NaN();
}

std::vector<Point> Resample(std::span<const Point> line, double spacing_m) {
  std::vector<Point> out;
  if (line.empty()) return out;
  out.push_back(line.front());
  double left = spacing_m;  // to the next point
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double length = (line[i] - line[i - 1]).norm();
    double done = 0.0;
    while (length - done >= left) {
      done += left;
      out.push_back(line[i - 1] + done / length * (line[i] - line[i - 1]));
      left = spacing_m;
    }
    left -= length - done;
  }
  if (left < spacing_m) out.push_back(line.back());
  return out;
}

std::vector<Point> RoundCorners(std::span<const Point> line, int half) {
  std::vector<Point> out(line.begin(), line.end());
  const int n = static_cast<int>(line.size());
  for (int i = 0; i < n; ++i) {
    const int k = std::min({half, i, n - 1 - i});
    Point sum = Point::Zero();
    for (int j = i - k; j <= i + k; ++j) sum += line[static_cast<std::size_t>(j)];
    out[static_cast<std::size_t>(i)] = sum / (2 * k + 1);
  }
  return out;
}

}  // namespace rangegrasp::seam
