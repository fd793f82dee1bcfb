#include "parts/task/parts_view.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "parts/shape_picture.h"

namespace rangegrasp::parts_task {
namespace {

using experiment::View;
using Labels = std::vector<std::int32_t>;

constexpr int kViewAxisUp = 2;

geometry::TriangleMesh InUnitBox(geometry::TriangleMesh mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    if (parts::IsUsable(p)) box.extend(p);
  }
  for (Eigen::Vector3d& p : mesh.vertices) {
    if (!parts::IsUsable(p)) p = box.center();
    p = ((p - box.center()) / box.sizes().maxCoeff()).eval();
  }
  return mesh;
}

View::Painted PaintedBy(const geometry::TriangleMesh& mesh, const std::string& name,
                        const Labels& labels) {
  constexpr std::size_t kMaxColors = std::numeric_limits<std::uint8_t>::max() + 1;
  std::map<std::int32_t, std::size_t> position;
  View::Painted painted;
  painted.mesh_W = mesh;
  for (const std::int32_t label : labels) {
    const auto [place, is_new] = position.emplace(label, position.size());
    // Nobody tells more colors apart; beyond them they come again.
    painted.paint.push_back(static_cast<std::uint8_t>(place->second % kMaxColors));
    if (!is_new || painted.colors.size() == kMaxColors) continue;
    const auto [r, g, b] = parts::PartColor(label);
    painted.colors.emplace_back(static_cast<float>(r) / 255.0F, static_cast<float>(g) / 255.0F,
                                static_cast<float>(b) / 255.0F, 1.0F);
  }
  painted.layer =
      fmt::format("{}: {} part{}", name, position.size(), position.size() == 1 ? "" : "s");
  return painted;
}

}  // namespace

Labels MatchedLabels(const Labels& labels, const Labels& reference) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> shares;
  for (std::size_t i = 0; i < labels.size(); ++i) ++shares[{labels[i], reference[i]}];
  std::vector<std::tuple<int, std::int32_t, std::int32_t>> order;
  for (const auto& [pair, faces] : shares) order.emplace_back(-faces, pair.first, pair.second);
  std::sort(order.begin(), order.end());
  std::map<std::int32_t, std::int32_t> matched;
  std::set<std::int32_t> taken(reference.begin(), reference.end());
  std::int32_t next = taken.empty() ? 0 : *taken.rbegin() + 1;
  taken.clear();
  for (const auto& [faces, label, other] : order) {
    if (!matched.contains(label) && taken.insert(other).second) matched[label] = other;
  }
  Labels result;
  for (const std::int32_t label : labels) {
    const auto [place, is_new] = matched.emplace(label, next);
    next += is_new ? 1 : 0;
    result.push_back(place->second);
  }
  return result;
}

View PartsView(const parts::HumanModel& model, const std::string& name, const Labels& found) {
  const geometry::TriangleMesh mesh = InUnitBox(model.input.mesh);
  View view;
  if (!found.empty()) view.painted.push_back(PaintedBy(mesh, name, found));
  for (std::size_t h = 0; h < model.humans.size(); ++h) {
    const Labels& human = model.humans[h];
    view.painted.push_back(PaintedBy(mesh, fmt::format("person {}", h + 1),
                                     found.empty() ? human : MatchedLabels(human, found)));
  }
  const draw::View look = draw::LookAtShape(mesh.vertices, kViewAxisUp);
  view.eye_W = look.eye;
  view.target_W = look.target;
  return view;
}

}  // namespace rangegrasp::parts_task
