#include "seam/monitor.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/linear_algebra.h"
#include "base/units.h"
#include "seam/internal/vectorised.h"

namespace rangegrasp::seam {
namespace {

// Every eighth column (0.7 mm with the base sensor) is enough for a parabolic surface, and reduces
// the time per profile accordingly.
constexpr std::size_t kStride = 8;
// Parabolas through the medians of all triples of blocks are tried: 220 for 12 blocks. With an
// obstacle on a third of the line, 56 of them rest on the surface alone.
constexpr std::size_t kBlocks = 12;
// Rounds of least squares, each over the points that support the previous curve.
constexpr int kRefinements = 3;
// Maximum distance of surface points: covers edges (up to 1.1 mm, half on each side) and texture.
constexpr double kWithin_m = 1e-3;
// Minimum share of a line's columns that support a surface, as a profile needs enough points.
constexpr double kSurfaceShare = 0.125;
// Weight of the previous parabola in the normal equations, where each point has weight 1. It only
// decides what the points leave open.
constexpr double kPriorWeight = 1e-9;

// Gain of the mean step height of an edge, which covers this many of its last profiles.
constexpr double kStepGain = 1.0 / 32.0;
// If the edge reappears within this many windows after its end, the end was a gap; an edge that
// appears later is another one.
constexpr int kSoon = 2;

using Curve = Eigen::Vector3d;  // c0 + u (c1 + u c2), u from -1 to 1

double At(const Curve& curve, double u) { return curve[0] + u * (curve[1] + u * curve[2]); }

struct SurfacePoint {
  double u, z;
};

// Measured points of every kStride-th column, u and z separately.
struct SurfacePoints {
  std::vector<double> u, z;

  explicit SurfacePoints(std::span<const float> height) {
    const double last = static_cast<double>(height.size() - 1);
    for (std::size_t i = 0; i < height.size(); i += kStride) {
      if (!std::isfinite(height[i])) continue;
      u.push_back(2.0 * static_cast<double>(i) / last - 1.0);
      z.push_back(static_cast<double>(height[i]));
    }
  }
};

RANGEGRASP_VECTORISED std::int64_t SupportOf(const SurfacePoints& points, const Curve& curve) {
  std::int64_t support = 0;
  for (std::size_t i = 0; i < points.u.size(); ++i) {
    support += std::abs(points.z[i] - At(curve, points.u[i])) <= kWithin_m ? 1 : 0;
  }
  return support;
}

// Least squares over the points that support `curve`.
Curve Refine(const SurfacePoints& points, const Curve& curve) {
  Eigen::Matrix3d normal = kPriorWeight * Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = kPriorWeight * curve;
  for (std::size_t i = 0; i < points.u.size(); ++i) {
    const double u = points.u[i];
    if (std::abs(points.z[i] - At(curve, u)) > kWithin_m) continue;
    const Eigen::Vector3d basis(1.0, u, u * u);
    normal += basis * basis.transpose();
    right += points.z[i] * basis;
  }
  return base::SolveLdlt(normal, right);
}

// The point of median height of each block of neighboring points.
std::vector<SurfacePoint> BlockMedians(const SurfacePoints& points) {
  std::vector<SurfacePoint> medians;
  std::vector<SurfacePoint> block;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const std::size_t begin = b * points.u.size() / kBlocks;
    const std::size_t end = (b + 1) * points.u.size() / kBlocks;
    block.clear();
    for (std::size_t i = begin; i < end; ++i) block.push_back({points.u[i], points.z[i]});
    if (block.empty()) continue;
    const auto middle = block.begin() + static_cast<std::ptrdiff_t>(block.size() / 2);
    std::ranges::nth_element(block, middle, {}, &SurfacePoint::z);
    medians.push_back(*middle);
  }
  return medians;
}

Curve Through(const SurfacePoint& p, const SurfacePoint& q, const SurfacePoint& r) {
  const double pq = (q.z - p.z) / (q.u - p.u);
  const double qr = (r.z - q.z) / (r.u - q.u);
  const double c2 = (qr - pq) / (r.u - p.u);
  const double c1 = pq - c2 * (p.u + q.u);
  return {p.z - p.u * (c1 + p.u * c2), c1, c2};
}

// The parabola that most points support: neither an obstacle on a third of the line nor points off
// the surface bend it.
Curve FitSurface(std::span<const float> height, const SurfacePoints& points) {
  const auto squares = FitQuadratic(height);
  Curve best(squares[0], squares[1], squares[2]);
  auto max_support = SupportOf(points, best);
  const auto medians = BlockMedians(points);
  for (std::size_t i = 0; i < medians.size(); ++i) {
    for (std::size_t j = i + 1; j < medians.size(); ++j) {
      for (std::size_t k = j + 1; k < medians.size(); ++k) {
        const Curve curve = Through(medians[i], medians[j], medians[k]);
        const auto count = SupportOf(points, curve);
        if (count <= max_support) continue;
        max_support = count;
        best = curve;
      }
    }
  }
  for (int round = 0; round < kRefinements; ++round) best = Refine(points, best);
  return best;
}

// Height of each column above a curve that was `shift` columns further to the right.
RANGEGRASP_VECTORISED std::vector<float> Above(std::span<const float> height, const Curve& curve,
                                               double shift) {
  std::vector<float> above(height.begin(), height.end());
  const auto columns = static_cast<std::int32_t>(above.size());
  const double last = static_cast<double>(columns - 1);
  const double by = 2.0 * shift / last;
  const Curve moved(At(curve, by), curve[1] + 2.0 * by * curve[2], curve[2]);
  float* const z = above.data();
  for (std::int32_t i = 0; i < columns; ++i) {
    z[i] -= static_cast<float>(At(moved, 2.0 * static_cast<double>(i) / last - 1.0));
  }
  return above;
}

}  // namespace

std::vector<float> HeightAboveSurface(const PreparedProfile& profile) {
  std::vector<float> above = profile.original_m;
  if (above.size() < 2 * kStride) return std::vector<float>(above.size(), 0.0F);
  return Above(above, FitSurface(above, SurfacePoints(above)), 0.0);
}

std::vector<bool> RisingColumns(std::span<const float> above, std::size_t width, double height) {
  std::vector<bool> rising(above.size(), false);
  const auto wanted = static_cast<float>(height);
  if (std::ranges::none_of(above, [&](float z) { return z >= wanted; })) return rising;
  std::size_t high = 0;
  std::size_t low = 0;
  std::size_t marked = 0;
  const auto count = [&](float z, std::size_t change) {  // NaN is neither
    if (z >= wanted) high += change;
    if (z < wanted) low += change;
  };
  for (std::size_t end = 1; end <= above.size(); ++end) {
    count(above[end - 1], 1);
    if (end < width) continue;
    if (end > width) count(above[end - width - 1], static_cast<std::size_t>(-1));
    if (low > 0 || 6 * high < 5 * width) continue;
    for (marked = std::max(marked, end - width); marked < end; ++marked) rising[marked] = true;
  }
  return rising;
}

void ReadMonitorOptions(base::YamlMap map, MonitorOptions& options) {
  map.ReadScaled("obstacle_height_mm", options.obstacle_height_m, base::kMm, 0.5, 100.0,
                 "minimum height of an obstacle above the surface");
  map.ReadScaled("obstacle_width_mm", options.obstacle_width_m, base::kMm, 0.1, 100.0,
                 "minimum width of an obstacle");
  map.Read("obstacle_profiles", options.obstacle_profiles, 1, 1000,
           "number of the last profiles that must show an obstacle in the same place");
  map.ReadScaled("min_step_mm", options.min_step_m, base::kMm, 0.001, 100.0,
                 "minimum height of a mat's edge; voting and weights use 0.3 mm");
  map.Read("mat_end_profiles", options.mat_end_profiles, 1, 1000,
           "number of the last usable profiles without an edge that means the end of the mats");
  map.Read("window", options.window, 1, 1000, "number of the last profiles for these counts");
  map.Read("outage_profiles", options.outage_profiles, 1, 1000,
           "number of consecutive unusable profiles that means an outage of the sensor");
  if (options.window < std::max(options.obstacle_profiles, options.mat_end_profiles)) {
    map.Fail("window",
             fmt::format("{} must not be shorter than obstacle_profiles ({}) or "
                         "mat_end_profiles ({})",
                         options.window, options.obstacle_profiles, options.mat_end_profiles));
  }
  map.Finish();
}

MonitorOptions MonitorFor(MonitorOptions options, DecisionMethod method) {
  if (method == DecisionMethod::kSteps) return options;
  options.min_step_m = kThinnestMat_m;
  options.usual_share = 0.0;
  return options;
}

SurfaceMonitor::SurfaceMonitor(const LineGeometry& line, const MonitorOptions& options)
    : width_(static_cast<std::size_t>(
          std::max(1L, std::lround(options.obstacle_width_m * line.columns_per_m)))),
      columns_per_m_(line.columns_per_m),
      options_(options) {}

// An obstacle rises above the surface around it. If it is fitted as the surface itself (because it
// is wide, or the mat around it returns no light), it rises above the earlier surface: in two
// profiles, because noise may falsify one. It must be seen repeatedly in one column.
bool SurfaceMonitor::SeesObstacle(const PreparedProfile& profile) {
  const auto& now = profile.original_m;
  if (now.size() < 2 * kStride) return false;
  const double moved_m = profile.moved_m + (seen_.empty() ? 0.0 : seen_.back().moved_m);
  const SurfacePoints points(now);
  Curve surface = FitSurface(now, points);
  // The head moves along the line; over a curved mould, this changes the heights of the columns.
  const auto rising_above = [&](const Curve& curve, double since_m) {
    return RisingColumns(Above(now, curve, (moved_m - since_m) * columns_per_m_), width_,
                         options_.obstacle_share * options_.obstacle_height_m);
  };
  auto rising = rising_above(surface, moved_m);
  if (seen_.size() >= 2) {
    const auto first = rising_above(seen_[0].surface, seen_[0].moved_m);
    const auto second = rising_above(seen_[1].surface, seen_[1].moved_m);
    for (std::size_t i = 0; i < now.size(); ++i) rising[i] = rising[i] || (first[i] && second[i]);
  }
  if (static_cast<double>(SupportOf(points, surface) * kStride) <
      kSurfaceShare * static_cast<double>(now.size())) {
    surface.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  seen_.push_back({surface, moved_m, std::move(rising)});
  if (seen_.size() > static_cast<std::size_t>(options_.window)) seen_.pop_front();
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!seen_.back().rising[i]) continue;
    const auto times = std::ranges::count_if(
        seen_, [i](const Seen& s) { return i < s.rising.size() && s.rising[i]; });
    if (times >= options_.obstacle_profiles) return true;
  }
  return false;
}

std::optional<StopReason> SurfaceMonitor::Update(const PreparedProfile& profile,
                                                 const Reading& reading) {
  if (stop_ == StopReason::kObstacle) return stop_;
  if (SeesObstacle(profile)) return stop_ = StopReason::kObstacle;
  const bool usable = reading.status != ProfileStatus::kUnusable;
  unusable_ = usable ? 0 : unusable_ + 1;
  if (!stop_ && unusable_ >= options_.outage_profiles) return StopReason::kOutage;
  if (!usable) return stop_;  // gives no information about the mats
  if (stop_ && (++ended_ > kSoon * options_.window || !reading.sure.value_or(false))) return stop_;
  if (stop_) no_edge_.clear();
  stop_.reset();
  edge_seen_ = edge_seen_ || reading.status == ProfileStatus::kEdge;
  // An edge that is reported only because of earlier profiles does not count here.
  const bool decided = reading.status == ProfileStatus::kEdge && reading.goes_on;
  const double decided_m = decided ? reading.step_m : 0.0;
  const double step_m = std::max(decided_m, reading.followed_step_m);
  const bool edge = step_m >= std::max(options_.min_step_m, options_.usual_share * usual_step_m_);
  if (edge) usual_step_m_ += kStepGain * (step_m - usual_step_m_);
  no_edge_.push_back(edge_seen_ && !edge);
  if (no_edge_.size() > static_cast<std::size_t>(options_.window)) no_edge_.pop_front();
  if (std::ranges::count(no_edge_, true) >= options_.mat_end_profiles) {
    stop_ = StopReason::kMatEnd;
    ended_ = 0;
  }
  return stop_;
}

bool SurfaceMonitor::SeesEdge() const {
  return edge_seen_ &&
         2 * std::ranges::count(no_edge_, false) > static_cast<std::ptrdiff_t>(no_edge_.size());
}

}  // namespace rangegrasp::seam
