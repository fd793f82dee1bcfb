#include "parts/handle/handle_grasps.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/kd_tree.h"
#include "grasp/proposals.h"
#include "parts/function/description.h"
#include "parts/hierarchy/hierarchy.h"

namespace rangegrasp::parts {
namespace {

using grasp::Grasp;

/// Maximum fraction of the object's points in a piece that may be its handle.
constexpr double kMaxShare = 0.25;
/// Maximum gap to it: if the body hides a handle's ends, there is room for fingers between them.
constexpr double kMaxGap_m = 0.025;

using perception::PerceivedObject;

bool IsCutOff(const perception::Scene& scene, const PerceivedObject& object,
              const geometry::KdTree& tree, const PerceivedObject& piece) {
  if (static_cast<double>(piece.points.size()) >
      kMaxShare * static_cast<double>(object.points.size())) {
    return false;
  }
  return std::ranges::any_of(piece.points, [&](std::uint32_t p) {
    return tree.CountWithin(scene.cloud.points[p], kMaxGap_m, 1) > 0;
  });
}

void Join(const PerceivedObject& piece, PerceivedObject& object) {
  object.points.insert(object.points.end(), piece.points.begin(), piece.points.end());
  std::ranges::sort(object.points);
  object.completed_C.insert(object.completed_C.end(), piece.completed_C.begin(),
                            piece.completed_C.end());
  geometry::Append(piece.surface_C, object.surface_C);
}

/// Grasp proposals for the largest handle; parts are numbered by decreasing size.
std::vector<grasp::Proposal> ProposalsFor(const Shape& cloud, const Eigen::Vector3d& up_C,
                                          std::string& why_none) {
  const Segmentation found = SegmentHierarchy(cloud, {});
  const auto described = DescribeParts(cloud, found, {.one_view = true, .up = {up_C}});
  const auto handle =
      std::ranges::find(described, PartFunction::kHandle, &PartDescription::function);
  if (handle == described.end()) {
    why_none = found.parts == 1 ? "no handle: the visible surface of the object is a single part"
                                : fmt::format(
                                      "no handle: none of the object's {} parts is thin and stands "
                                      "out of its body",
                                      found.parts);
    return {};
  }
  const geometry::Points points_C = geometry::Select(
      cloud.points, geometry::PositionsWhere(
                        found.label, [&](std::int32_t label) { return label == handle->label; }));
  return grasp::ProposeHandleGrasps(points_C, described.front().center, up_C);
}

}  // namespace

void JoinCutOffHandle(perception::Scene& scene) {
  if (scene.objects.empty()) return;
  PerceivedObject& object = scene.objects.front();
  const geometry::Points points = geometry::Select(scene.cloud.points, object.points);
  const geometry::KdTree tree(points);
  const PerceivedObject alone = object;
  std::erase_if(scene.objects, [&](const PerceivedObject& other) {
    if (&other == &scene.objects.front() || !IsCutOff(scene, alone, tree, other)) return false;
    Join(other, scene.objects.front());
    return true;
  });
}

grasp::SelectedGrasps PlanHandleGrasps(const perception::Scene& scene, std::size_t object,
                                       const robot::HandModel& hand,
                                       const grasp::GraspOptions& options,
                                       std::span<const geometry::TriangleMesh> obstacles_C) {
  grasp::SelectedGrasps result;
  const Eigen::Vector3d up_C = scene.table.plane.normal;
  const Shape cloud{geometry::Select(scene.cloud.points, scene.objects[object].points), {}, {}};
  for (const grasp::Proposal& way : ProposalsFor(cloud, up_C, result.why_none)) {
    result.grasps.push_back(PlaceHand(way, hand, options));
    result.grasps.back().type = grasp::GraspType::kNamed;
  }
  if (result.grasps.empty()) return result;
  CheckProposals(scene, object, hand, options, obstacles_C, result.grasps);
  std::ranges::stable_partition(result.grasps, [](const Grasp& g) { return !g.collides; });
  return result;
}

}  // namespace rangegrasp::parts
