#include "parts/command/part_table.h"

#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

#include "base/csv.h"
#include "base/words.h"

namespace rangegrasp::cli {
namespace {

using nlohmann::ordered_json;

ordered_json Coordinates(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::string Number(const ordered_json& part, const std::string& key) {
  if (!part.contains(key) || part[key].is_null()) return "";
  return fmt::format("{:.6g}", part[key].get<double>());
}

void AppendVector(const ordered_json& v, std::vector<std::string>& cells) {
  for (const auto& x : v) cells.push_back(fmt::format("{:.6g}", x.get<double>()));
}

std::string NeighborsOf(const ordered_json& part) {
  std::string text;
  for (const auto& neighbor : part["neighbors"]) {
    text += fmt::format("{}{}", text.empty() ? "" : " ", neighbor["label"].get<int>());
    if (neighbor.contains("border")) {
      text += fmt::format(":{:.6g}", neighbor["border"].get<double>());
    }
  }
  return text;
}

}  // namespace

void DescribePart(const parts::PartDescription& part, bool mesh, ordered_json& json) {
  json["function"] = base::Word(part.function);
  if (mesh) json["area"] = part.area;
  if (mesh) json["volume"] = part.volume ? ordered_json(*part.volume) : ordered_json();
  json["holds"] = part.holds;
  json["center"] = Coordinates(part.center);
  json["axes"] = {Coordinates(part.axes.col(0)), Coordinates(part.axes.col(1)),
                  Coordinates(part.axes.col(2))};
  json["extents"] = Coordinates(part.extents);
  json["neighbors"] = ordered_json::array();
  for (const parts::PartNeighbor& neighbor : part.neighbors) {
    ordered_json entry = {{"label", neighbor.label}, {"joints", neighbor.joints}};
    if (mesh) entry["border"] = neighbor.border;
    json["neighbors"].push_back(entry);
  }
}

std::string PartMeasures(const ordered_json& part) {
  std::string text;
  if (part.contains("area")) text += fmt::format("area {:.4g}, ", part["area"].get<double>());
  if (part.contains("volume") && !part["volume"].is_null()) {
    text += fmt::format("volume {:.4g}, ", part["volume"].get<double>());
  }
  const auto extents = part["extents"].get<std::array<double, 3>>();
  const auto center = part["center"].get<std::array<double, 3>>();
  text += fmt::format("{:.4g} x {:.4g} x {:.4g} about ({:.4g}, {:.4g}, {:.4g})", extents[0],
                      extents[1], extents[2], center[0], center[1], center[2]);
  std::string before = ", borders on ";
  for (const auto& neighbor : part["neighbors"]) {
    text += fmt::format("{}{}", std::exchange(before, ", "), neighbor["label"].get<int>());
    if (neighbor.contains("border")) {
      text += fmt::format(" ({:.4g})", neighbor["border"].get<double>());
    }
  }
  return text;
}

std::string PartTable(const ordered_json& json) {
  std::string text = base::CsvLine({"part", "function", "elements", "share", "area", "volume",
                                    "holds", "center_x", "center_y", "center_z", "axis_x", "axis_y",
                                    "axis_z", "extent_1", "extent_2", "extent_3", "neighbors"});
  for (const auto& part : json["parts"]) {
    std::vector<std::string> cells{std::to_string(part["label"].get<int>()),
                                   part["function"].get<std::string>(),
                                   std::to_string(part["elements"].get<std::size_t>())};
    for (const char* key : {"share", "area", "volume", "holds"}) {
      cells.push_back(Number(part, key));
    }
    AppendVector(part["center"], cells);
    AppendVector(part["axes"][0], cells);
    AppendVector(part["extents"], cells);
    cells.push_back(NeighborsOf(part));
    text += base::CsvLine(cells);
  }
  return text;
}

}  // namespace rangegrasp::cli
