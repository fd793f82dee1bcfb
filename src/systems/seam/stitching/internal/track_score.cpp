#include "seam/stitching/internal/track_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "seam/stitching/internal/seam_path.h"

namespace rangegrasp::stitching::internal {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
// Of the true edge as a polyline: its fray varies over millimetres, so that between points it is
// off by micrometres.
constexpr double kEdgeSpacing_m = 0.1e-3;
// Beyond the wanted distance, along y: within it the nearest point of an edge is looked for.
constexpr double kReach_m = 20e-3;
constexpr double kGood_m = 1e-3;  // what the seam needs (section 3.7.1)
constexpr double kQuantile = 0.95;

double ToSegment(const Point& p, const Point& a, const Point& b) {
  const Point along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

// The true edge as a polyline that covers a path, ascending in y.
std::vector<Point> TrueEdge(const Mats& mats, double from_y, double to_y) {
  std::vector<Point> edge;
  const int n = static_cast<int>(std::ceil((to_y - from_y) / kEdgeSpacing_m));
  for (int i = 0; i <= n; ++i) {
    const double y = from_y + i * kEdgeSpacing_m;
    const double x = mats.EdgeX(y);
    if (std::isfinite(x)) edge.emplace_back(x, y);
  }
  return edge;
}

// Positive on the low side.
double Distance(const Mats& mats, const std::vector<Point>& edge, const Point& needle,
                double reach) {
  const double x = mats.EdgeX(needle.y());
  if (!std::isfinite(x)) return kNone;
  const auto first = std::lower_bound(edge.begin(), edge.end(), needle.y() - reach,
                                      [](const Point& p, double y) { return p.y() < y; });
  double nearest = std::numeric_limits<double>::infinity();
  for (auto p = first; p != edge.end() && p + 1 != edge.end(); ++p) {
    if (p->y() > needle.y() + reach) break;
    nearest = std::min(nearest, ToSegment(needle, *p, *(p + 1)));
  }
  return needle.x() > x ? -nearest : nearest;
}

bool Hits(const Mats& mats, const TrackPoint& p) {
  if (p.y_m > mats.options().end_y_m) return true;
  for (const MatOptions::Obstacle& o : mats.options().obstacles) {
    if (std::abs(p.x_m - o.x_m) <= 0.5 * o.size_x_m && std::abs(p.y_m - o.y_m) <= 0.5 * o.size_y_m)
      return true;
  }
  return false;
}

struct Piece {
  double error_m, length_m;
};

std::vector<Piece> SettledPieces(const std::vector<TrackPoint>& path, double wanted_distance_m) {
  std::vector<Piece> pieces;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double length = std::hypot(path[i].x_m - path[i - 1].x_m, path[i].y_m - path[i - 1].y_m);
    const double error = std::abs(path[i].distance_m - wanted_distance_m);
    if (path[i].y_m >= path.front().y_m + kSettle_m && std::isfinite(error) && length > 0.0) {
      pieces.push_back({error, length});
    }
  }
  return pieces;
}

void Summarise(std::vector<Piece> pieces, TrackResult& result) {
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.error_m < b.error_m; });
  double total = 0.0;
  for (const Piece& piece : pieces) total += piece.length_m;
  if (total <= 0.0) return;
  double done = 0.0, sum = 0.0, good = 0.0;
  for (const Piece& piece : pieces) {
    if (done < kQuantile * total) result.p95_error_m = piece.error_m;
    done += piece.length_m;
    sum += piece.error_m * piece.length_m;
    if (piece.error_m <= kGood_m) good += piece.length_m;
  }
  result.mean_error_m = sum / total;
  result.max_error_m = pieces.back().error_m;
  result.share_within_1mm = good / total;
}

}  // namespace

void Score(const Mats& mats, double wanted_distance_m, TrackResult& result) {
  const double reach = wanted_distance_m + kReach_m;
  const auto [low, high] =
      std::minmax_element(result.path.begin(), result.path.end(),
                          [](const TrackPoint& a, const TrackPoint& b) { return a.y_m < b.y_m; });
  const auto edge = TrueEdge(mats, low->y_m - reach, high->y_m + reach);
  for (TrackPoint& p : result.path) {
    p.distance_m = Distance(mats, edge, {p.x_m, p.y_m}, reach);
    result.reached_hazard = result.reached_hazard || Hits(mats, p);
  }
  Summarise(SettledPieces(result.path, wanted_distance_m), result);
}

}  // namespace rangegrasp::stitching::internal
