#include "perception/rotational.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/units.h"
#include "geometry/alpha_shape.h"
#include "perception/planar.h"
#include "perception/top_surface.h"

namespace rangegrasp::perception {
namespace {

using geometry::Indices;
using geometry::PointCloud;

// Fewer body points than this say nothing about the body.
constexpr std::size_t kLeastBody = 20;
// Normals within 45 deg of the axis are of caps, floors and lips.
constexpr double kMostAlongAxis = 0.7;

// A rotational surface's normals pass the axis: their share along the circle, sin(20 deg), leaves
// room for noise and turns the ends of ellipses away.
constexpr double kMostTangential = 0.34;

struct Member {
  double distance_m;
  std::uint32_t point;
  bool normal_passes_axis;
};

/// The radius about which most members lie within the distance (a window over the sorted
/// distances), and which they are.
struct Agreement {
  double radius_m = 0.0;
  std::size_t first = 0;
  std::size_t last = 0;  ///< one past
};
Agreement Agree(std::vector<Member>& members, double distance_m) {
  std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) {
    return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.point < b.point;
  });
  Agreement best;
  std::size_t last = 0;
  for (std::size_t first = 0; first < members.size(); ++first) {
    while (last < members.size() &&
           members[last].distance_m <= members[first].distance_m + 2.0 * distance_m) {
      ++last;
    }
    if (last - first > best.last - best.first) best = {0.0, first, last};
  }
  for (std::size_t i = best.first; i < best.last; ++i) best.radius_m += members[i].distance_m;
  best.radius_m /= static_cast<double>(std::max<std::size_t>(1, best.last - best.first));
  return best;
}

double Arc(const PointCloud& cloud, const Indices& rim, const CircleFit& fit) {
  constexpr int kBins = 36;
  const Eigen::Vector3d u = fit.circle.normal.unitOrthogonal();
  const Eigen::Vector3d v = fit.circle.normal.cross(u);
  std::vector<bool> seen(kBins, false);
  for (const auto i : fit.inliers) {
    const Eigen::Vector3d d = cloud.points[rim[i]] - fit.circle.center;
    const double turn = std::atan2(d.dot(v), d.dot(u)) / (2.0 * core::kPi) + 0.5;
    seen[std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(turn * kBins))] = true;
  }
  return 2.0 * core::kPi * static_cast<double>(std::count(seen.begin(), seen.end(), true)) / kBins;
}

/// The first rule.
std::optional<RotationAxis> AxisFromRim(const PointCloud& cloud, const Indices& rim,
                                        const TopSurface& top, double least_arc_rad,
                                        const FeatureOptions& options, core::Rng& rng) {
  const auto fit = FitCircle(geometry::Select(cloud.points, rim), options, rng);
  if (!fit) return std::nullopt;
  const double share = static_cast<double>(fit->inliers.size()) / static_cast<double>(rim.size());
  if (share < options.rim_share || Arc(cloud, rim, *fit) < least_arc_rad) {
    return std::nullopt;
  }
  return RotationAxis{fit->circle.center, top.plane.normal, fit->circle.radius_m, share, 0.0};
}

/// The second rule, with the better of the plane's normal and the vertical.
bool JudgeBody(const PointCloud& cloud, const Indices& points, const TopSurface& top,
               const geometry::Plane& table, double least_share, const FeatureOptions& options,
               RotationAxis& axis) {
  const Eigen::Vector3d leaning = axis.direction_C;
  axis.body_fraction = ProfileBody(cloud, points, top, axis.center_C, leaning, options).fraction;
  // Within what a small rim leaves uncertain, an object that stands is upright.
  if (leaning.dot(table.normal) > std::cos(core::Deg(5.0))) {
    const double upright =
        ProfileBody(cloud, points, top, axis.center_C, table.normal, options).fraction;
    if (upright >= axis.body_fraction) {
      axis.direction_C = table.normal;
      axis.body_fraction = upright;
    }
  }
  return axis.body_fraction >= least_share;
}

/// The rim's far side is seen at a grazing angle, so its circle lies up to a millimetre towards the
/// sensor. The body says better where the axis is: concentric circles, one radius a section, by
/// least squares (Gauss-Newton over the centre; the radii follow).
void RefineAxis(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                const FeatureOptions& options, RotationAxis& axis) {
  constexpr double kMostShift_m = 0.004;
  constexpr double kLeastConditioning = 0.02;  // Of an arc of about 60 deg.
  constexpr double kTopSections_m = 0.012;
  const Eigen::Vector3d u = axis.direction_C.unitOrthogonal();
  const Eigen::Vector3d v = axis.direction_C.cross(u);
  RotationAxis refined = axis;
  for (int round = 0; round < 5; ++round) {
    const BodyProfile body =
        ProfileBody(cloud, points, top, refined.center_C, refined.direction_C, options);
    if (body.fraction < std::min(axis.body_fraction, options.body_share) ||
        body.agreeing.size() < kLeastBody) {
      return;
    }
    std::map<int, const Section*> sections;
    for (const Section& s : body.sections) {
      sections[static_cast<int>(std::floor(s.depth_m / options.section_m))] = &s;
    }
    Eigen::Matrix2d normal_matrix = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    std::map<int, std::pair<Eigen::Vector2d, int>> mean;
    const auto outer = [&](std::uint32_t i, int& key, Eigen::Vector2d& radial) {
      const Eigen::Vector3d d = cloud.points[i] - refined.center_C;
      key = static_cast<int>(std::floor(-d.dot(refined.direction_C) / options.section_m));
      radial = {d.dot(u), d.dot(v)};
      return cloud.normals[i].dot(radial.x() * u + radial.y() * v) >= 0.0;
    };
    int key = 0;
    Eigen::Vector2d radial;
    for (const auto i : body.agreeing) {
      if (!outer(i, key, radial)) continue;
      auto& [sum, count] = mean.try_emplace(key, Eigen::Vector2d::Zero(), 0).first->second;
      sum += radial.normalized();
      ++count;
    }
    double n = 0.0;
    for (const auto i : body.agreeing) {
      if (!outer(i, key, radial)) continue;
      const auto& [sum, count] = mean.at(key);
      const Eigen::Vector2d g = radial.normalized() - sum / count;
      normal_matrix += g * g.transpose();
      right += g * (radial.norm() - sections.at(key)->outer_m);
      n += 1.0;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(normal_matrix);
    if (n < kLeastBody || eigen.eigenvalues()[0] < kLeastConditioning * n) return;
    const Eigen::Vector2d shift = normal_matrix.inverse() * right;
    refined.center_C += shift.x() * u + shift.y() * v;
    if ((refined.center_C - axis.center_C).norm() > kMostShift_m) return;
  }
  const BodyProfile body =
      ProfileBody(cloud, points, top, refined.center_C, refined.direction_C, options);
  if (body.fraction < std::min(axis.body_fraction, options.body_share)) return;
  refined.body_fraction = body.fraction;
  double sum = 0.0;
  double count = 0.0;
  for (const Section& s : body.sections) {
    if (s.depth_m < 0.0 || s.depth_m > kTopSections_m) continue;
    sum += static_cast<double>(s.outer_points) * s.outer_m;
    count += static_cast<double>(s.outer_points);
  }
  // Smoothing rounds the rim; the wall under it gives the radius.
  if (count >= kLeastBody && std::abs(sum / count - axis.radius_m) < kMostShift_m) {
    refined.radius_m = sum / count;
  }
  axis = refined;
}

/// A point of a body seen along the axis: where it is, and where its normal points to.
struct Wall {
  Eigen::Vector2d p;
  Eigen::Vector2d normal;  ///< unit
};

/// The points that face sideways and away from `center`, and count against a circle about it.
bool OnCircle(const Wall& wall, const Eigen::Vector2d& center, double radius_m, double distance_m) {
  const Eigen::Vector2d radial = wall.p - center;
  const double r = radial.norm();
  return std::abs(r - radius_m) <= distance_m && wall.normal.dot(radial) > 0.0 &&
         std::abs(wall.normal.x() * radial.y() - wall.normal.y() * radial.x()) <=
             kMostTangential * r;
}

/// The centre where the normals of two wall points meet, if they are about as far from it.
std::optional<Eigen::Vector2d> NormalsMeet(const Wall& a, const Wall& b, double distance_m) {
  Eigen::Matrix2d directions;
  directions << -a.normal, b.normal;
  if (std::abs(directions.determinant()) < 0.2) return std::nullopt;
  const Eigen::Vector2d steps = directions.inverse() * (b.p - a.p);
  // p - step * normal: the centre lies behind both, at the same distance.
  if (steps.minCoeff() <= 0.0 || std::abs(steps[0] - steps[1]) > distance_m) return std::nullopt;
  return 0.5 * (a.p - steps[0] * a.normal + b.p - steps[1] * b.normal);
}

/// The least-squares circle (Kasa 1976: linear in centre and r^2 - |centre|^2) through the wall
/// points that agree.
std::pair<Eigen::Vector2d, double> RefitCircle(const std::vector<Wall>& walls,
                                               const Eigen::Vector2d& center, double radius_m,
                                               double distance_m) {
  Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Wall& wall : walls) {
    if (!OnCircle(wall, center, radius_m, distance_m)) continue;
    const Eigen::Vector2d d = wall.p - center;
    const Eigen::Vector3d row(2.0 * d.x(), 2.0 * d.y(), 1.0);
    left += row * row.transpose();
    right += d.squaredNorm() * row;
  }
  const Eigen::Vector3d solved = left.ldlt().solve(right);
  const double squared = solved[2] + solved.head<2>().squaredNorm();
  if (!solved.allFinite() || squared <= 0.0) return {center, radius_m};
  return {center + solved.head<2>(), std::sqrt(squared)};
}

/// An upright axis from the outer wall: two wall points with their normals give a centre, the one
/// that most wall points agree with wins (as eq. 5.7, with normals in the place of a third point).
std::optional<RotationAxis> AxisFromBody(const PointCloud& cloud, const Indices& points,
                                         const TopSurface& top, const geometry::Plane& table,
                                         const FeatureOptions& options, core::Rng& rng) {
  constexpr std::size_t kLeastWall = 60;
  const PlanarFrame frame = MakePlanarFrame(table, top.center_C);
  std::vector<Wall> walls;
  for (const auto i : points) {
    const Eigen::Vector3d& normal = cloud.normals[i];
    if (std::abs(normal.dot(table.normal)) > kMostAlongAxis) continue;
    walls.push_back({frame.Flat(cloud.points[i]),
                     Eigen::Vector2d(normal.dot(frame.u), normal.dot(frame.v)).normalized()});
  }
  if (walls.size() < kLeastWall) return std::nullopt;
  Eigen::Vector2d center;
  double radius = 0.0;
  std::ptrdiff_t most = 0;
  for (int draw = 0; draw < 2 * options.circle_draws; ++draw) {
    const Wall& a = walls[rng.Index(walls.size())];
    const Wall& b = walls[rng.Index(walls.size())];
    const auto meeting = NormalsMeet(a, b, 2.0 * options.circle_distance_m);
    if (!meeting) continue;
    const double r = 0.5 * ((a.p - *meeting).norm() + (b.p - *meeting).norm());
    if (r > options.most_radius_m) continue;
    const auto count = std::count_if(walls.begin(), walls.end(), [&](const Wall& wall) {
      return OnCircle(wall, *meeting, r, options.circle_distance_m);
    });
    if (count > most) {
      most = count;
      center = *meeting;
      radius = r;
    }
  }
  if (most < static_cast<std::ptrdiff_t>(kLeastWall / 2)) return std::nullopt;
  // Two normals say little of the centre; all that agree say more.
  for (int round = 0; round < 5; ++round) {
    const auto [better, r] = RefitCircle(walls, center, radius, options.circle_distance_m);
    center = better;
    radius = r;
  }
  const Eigen::Vector3d on_table = top.center_C + center.x() * frame.u + center.y() * frame.v;
  const double height = TopHeight(cloud, points, table) - table.Distance(on_table);
  return RotationAxis{on_table + height * table.normal, table.normal, radius, 0.0, 0.0};
}

/// Whether the top is the lip of a wall about the axis: its points lie on the circle or just
/// inside, and fill little of it.
bool IsThinRing(const PointCloud& cloud, const TopSurface& top, const RotationAxis& axis,
                const FeatureOptions& options) {
  constexpr double kMostWall_m = 0.010;
  const auto on_lip = std::count_if(top.points.begin(), top.points.end(), [&](auto i) {
    const double inside =
        axis.radius_m - AxisDistance(cloud.points[i], axis.center_C, axis.direction_C);
    return inside >= -options.circle_distance_m && inside <= kMostWall_m;
  });
  if (static_cast<double>(on_lip) < options.rim_share * static_cast<double>(top.points.size())) {
    return false;
  }
  const auto flat =
      Flatten(MakePlanarFrame(top.plane, top.center_C), geometry::Select(cloud.points, top.points));
  return geometry::BuildAlphaShape2(flat, options.rim_alpha_m).area_m2 <
         options.ring_share * core::kPi * axis.radius_m * axis.radius_m;
}

/// How far round the axis the points go [rad].
double BodyArc(const PointCloud& cloud, const Indices& points, const RotationAxis& axis) {
  const CircleFit all{{axis.center_C, axis.direction_C, axis.radius_m}, [&] {
                        Indices each(points.size());
                        std::iota(each.begin(), each.end(), 0U);
                        return each;
                      }()};
  return Arc(cloud, points, all);
}

}  // namespace

double ShareOnCircle(const PointCloud& cloud, const Indices& points, const Circle& circle,
                     double distance_m) {
  if (points.empty()) return 0.0;
  const auto on = std::count_if(points.begin(), points.end(), [&](auto i) {
    return CircleDistance(circle, cloud.points[i]) <= distance_m;
  });
  return static_cast<double>(on) / static_cast<double>(points.size());
}

BodyProfile ProfileBody(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                        const Eigen::Vector3d& center_C, const Eigen::Vector3d& direction_C,
                        const FeatureOptions& options) {
  std::map<std::pair<int, bool>, std::vector<Member>> sections;
  for (const auto i : points) {
    const Eigen::Vector3d d = cloud.points[i] - center_C;
    const Eigen::Vector3d& normal = cloud.normals[i];
    if (std::abs(top.plane.Distance(cloud.points[i])) <= options.plane_distance_m ||
        std::abs(normal.dot(direction_C)) > kMostAlongAxis) {
      continue;
    }
    const double depth = -d.dot(direction_C);
    const Eigen::Vector3d radial = d + depth * direction_C;
    sections[{static_cast<int>(std::floor(depth / options.section_m)), normal.dot(radial) < 0.0}]
        .push_back(
            {AxisDistance(cloud.points[i], center_C, direction_C), i,
             std::abs(normal.dot(direction_C.cross(radial))) <= kMostTangential * radial.norm()});
  }
  BodyProfile profile;
  for (auto& [key, members] : sections) {
    const double depth = (key.first + 0.5) * options.section_m;
    if (profile.sections.empty() || profile.sections.back().depth_m != depth) {
      profile.sections.push_back({depth, 0.0, 0.0, 0, 0});
    }
    const Agreement agreement = Agree(members, options.circle_distance_m);
    Section& section = profile.sections.back();
    (key.second ? section.inner_m : section.outer_m) = agreement.radius_m;
    (key.second ? section.inner_points : section.outer_points) = agreement.last - agreement.first;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const bool agrees =
          k >= agreement.first && k < agreement.last && members[k].normal_passes_axis;
      (agrees ? profile.agreeing : profile.differing).push_back(members[k].point);
    }
  }
  const std::size_t all = profile.agreeing.size() + profile.differing.size();
  if (all >= kLeastBody) {
    profile.fraction = static_cast<double>(profile.agreeing.size()) / static_cast<double>(all);
  }
  std::sort(profile.agreeing.begin(), profile.agreeing.end());
  std::sort(profile.differing.begin(), profile.differing.end());
  return profile;
}

std::optional<RotationAxis> FindRotationAxis(const PointCloud& cloud, const Indices& points,
                                             const TopSurface& top, const geometry::Plane& table,
                                             const FeatureOptions& options, core::Rng& rng) {
  for (const bool bridged : {false, true}) {
    if (top.ridge) break;
    const Indices rim =
        bridged ? OuterRim(cloud, top.points, top.plane, options.bridged_rim_alpha_m) : top.rim;
    const double least_arc = bridged ? options.least_bridged_arc_rad : options.least_arc_rad;
    auto axis = AxisFromRim(cloud, rim, top, least_arc, options, rng);
    if (axis && JudgeBody(cloud, points, top, table, options.body_share, options, *axis)) {
      RefineAxis(cloud, points, top, options, *axis);
      return axis;
    }
  }
  if (!options.axis_from_body) return std::nullopt;
  auto axis = AxisFromBody(cloud, points, top, table, options, rng);
  if (!axis || !IsThinRing(cloud, top, *axis, options) ||
      !JudgeBody(cloud, points, top, table, options.ring_body_share, options, *axis)) {
    return std::nullopt;
  }
  const BodyProfile body =
      ProfileBody(cloud, points, top, axis->center_C, axis->direction_C, options);
  if (BodyArc(cloud, body.agreeing, *axis) < options.least_arc_rad) return std::nullopt;
  RefineAxis(cloud, points, top, options, *axis);
  return axis;
}

}  // namespace rangegrasp::perception
