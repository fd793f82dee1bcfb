#include "perception/internal/body_profile.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "perception/internal/circle.h"

namespace rangegrasp::perception::internal {
namespace {

using geometry::Indices;
using geometry::PointCloud;

struct Member {
  double distance_m;
  std::uint32_t point;
  bool normal_passes_axis;
};

/// The points of each section, those that face outward before those that face the axis.
using Members = std::map<std::pair<int, bool>, std::vector<Member>>;

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

Members BySection(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                  const Eigen::Vector3d& center_C, const Eigen::Vector3d& direction_C,
                  const FeatureOptions& options) {
  Members sections;
  for (const auto i : points) {
    const Eigen::Vector3d& normal = cloud.normals[i];
    if (std::abs(top.plane.Distance(cloud.points[i])) <= options.top.plane_distance_m ||
        std::abs(normal.dot(direction_C)) > options.axis.max_along_axis) {
      continue;
    }
    const Eigen::Vector3d d = cloud.points[i] - center_C;
    const double depth = -d.dot(direction_C);
    const Eigen::Vector3d radial = d + depth * direction_C;
    const bool passes_axis =
        !options.radial_normals || std::abs(normal.dot(direction_C.cross(radial))) <=
                                       options.axis.max_tangential * radial.norm();
    sections[{SectionOf(depth, options), normal.dot(radial) < 0.0}].push_back(
        {AxisDistance(cloud.points[i], center_C, direction_C), i, passes_axis});
  }
  return sections;
}

void AddMembers(const std::vector<Member>& members, const Agreement& agreement, bool inward,
                BodyProfile& profile) {
  Section& section = profile.sections.back();
  (inward ? section.inner_m : section.outer_m) = agreement.radius_m;
  (inward ? section.inner_points : section.outer_points) = agreement.last - agreement.first;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const bool agrees = k >= agreement.first && k < agreement.last && members[k].normal_passes_axis;
    (agrees ? profile.agreeing : profile.differing).push_back(members[k].point);
  }
}

}  // namespace

int SectionOf(double depth_m, const FeatureOptions& options) {
  return static_cast<int>(std::floor(depth_m / options.axis.section_m));
}

BodyProfile ProfileBody(const PointCloud& cloud, const Indices& points, const TopSurface& top,
                        const Eigen::Vector3d& center_C, const Eigen::Vector3d& direction_C,
                        const FeatureOptions& options) {
  BodyProfile profile;
  Members sections = BySection(cloud, points, top, center_C, direction_C, options);
  for (auto& [key, members] : sections) {
    const double depth = (key.first + 0.5) * options.axis.section_m;
    if (profile.sections.empty() || profile.sections.back().depth_m != depth) {
      profile.sections.push_back({depth, 0.0, 0.0, 0, 0});
    }
    AddMembers(members, Agree(members, options.circle.distance_m), key.second, profile);
  }
  const std::size_t all = profile.agreeing.size() + profile.differing.size();
  if (all >= static_cast<std::size_t>(options.axis.min_body_points)) {
    profile.fraction = static_cast<double>(profile.agreeing.size()) / static_cast<double>(all);
  }
  std::sort(profile.agreeing.begin(), profile.agreeing.end());
  std::sort(profile.differing.begin(), profile.differing.end());
  return profile;
}

}  // namespace rangegrasp::perception::internal
