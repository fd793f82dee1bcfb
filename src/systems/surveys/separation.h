#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "geometry/kd_tree.h"
#include "geometry/mesh.h"

/// Agreement of found objects with labelled ones. The labels are used for evaluation only.
namespace rangegrasp::surveys {

/// Means weighted by the labelled objects' visible points |G|; S is a found object ("segment").
struct Separation {
  double overlap = 0.0;  ///< max over S of |G and S| / |G or S|; 1: every object is one segment
  double over = 0.0;     ///< 1 - |G and S*| / |G|, S* the segment that shares most points with G
  double under = 0.0;    ///< share of S* that belongs to another label, including the table
  double points = 0.0;   ///< sum of |G|: the weight of this cloud among others
  int objects = 0;       ///< number of labelled objects
  int of_table = 0;      ///< segments with more points of the table than of objects
  /// Every object has a segment with overlap >= 0.75 and no other segment of 200 points exists.
  bool right = false;
};

/// The lowest label of an object.
inline constexpr std::uint32_t kFirstObject = 20;

/// Labels: 0 not measured, 1 to 9 table, 20 and above objects. Segments: < 0 none.
inline Separation Compare(const std::vector<std::uint32_t>& label,
                          const std::vector<std::int32_t>& segment) {
  constexpr double kRightOverlap = 0.75;
  constexpr double kNoticedPoints = 200;
  std::map<std::uint32_t, std::map<std::int32_t, double>> shared;
  std::map<std::uint32_t, double> object_points;
  std::map<std::int32_t, double> size;
  std::map<std::int32_t, double> table;
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (label[i] == 0) continue;
    const std::int32_t s = segment[i];
    if (label[i] >= kFirstObject) ++object_points[label[i]];
    if (s < 0) continue;
    ++size[s];
    ++(label[i] >= kFirstObject ? shared[label[i]][s] : table[s]);
  }
  Separation sum;
  std::map<std::int32_t, bool> used;
  sum.right = true;
  for (const auto& [object, points] : object_points) {
    double best = 0.0;
    double most = 0.0;
    std::int32_t best_segment = -1;
    double other_share = 0.0;
    for (const auto& [s, both] : shared[object]) {
      const double overlap = both / (points + size[s] - both);
      if (overlap > best) best_segment = s;
      best = std::max(best, overlap);
      if (both > most) other_share = 1.0 - both / size[s];
      most = std::max(most, both);
    }
    sum.overlap += points * best;
    sum.over += points - most;
    sum.under += points * other_share;
    sum.points += points;
    ++sum.objects;
    if (best >= kRightOverlap) used[best_segment] = true;
    sum.right = sum.right && best >= kRightOverlap;
  }
  for (const auto& [s, points] : size) {
    if (points >= kNoticedPoints && !used[s]) sum.right = false;
    if (table[s] > 0.5 * points) ++sum.of_table;
  }
  for (double* mean : {&sum.overlap, &sum.over, &sum.under}) *mean /= std::max(1.0, sum.points);
  return sum;
}

/// The found object of each measured point: the one with the nearest point, if within 6 mm, so that
/// points that filters remove or shift cost nothing; -1 if there is none.
inline std::vector<std::int32_t> AssignToObjects(geometry::PointSpan measured,
                                                 const std::vector<geometry::Points>& objects) {
  constexpr double kNear_m = 0.006;
  geometry::Points all;
  std::vector<std::int32_t> owner;
  for (std::size_t k = 0; k < objects.size(); ++k) {
    all.insert(all.end(), objects[k].begin(), objects[k].end());
    owner.resize(all.size(), static_cast<std::int32_t>(k));
  }
  std::vector<std::int32_t> segment(measured.size(), -1);
  if (all.empty()) return segment;
  const Eigen::AlignedBox3d box = geometry::BoundsOf(all);
  const geometry::KdTree tree(all);
  std::vector<geometry::KdTree::Neighbor> nearest;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i].allFinite() || box.exteriorDistance(measured[i]) > kNear_m) continue;
    tree.Nearest(measured[i], 1, nearest);
    if (nearest.front().squared_distance <= kNear_m * kNear_m) {
      segment[i] = owner[nearest.front().index];
    }
  }
  return segment;
}

}  // namespace rangegrasp::surveys
