#include "labelled_scan.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "grasp/detector.h"
#include "sim/visual_mesh.h"

namespace rangegrasp::bench {
namespace {

using trial::Cell;
using trial::TrialSpec;

constexpr std::uint32_t kScene = 1;
constexpr std::uint32_t kFirstObject = 20;

template <typename T>
void Write(std::ofstream& out, const std::vector<T>& values) {
  const std::uint64_t count = values.size();
  out.write(reinterpret_cast<const char*>(&count), sizeof count);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(count * sizeof(T)));
}

template <typename T>
std::vector<T> Read(std::ifstream& in) {
  std::uint64_t count = 0;
  in.read(reinterpret_cast<char*>(&count), sizeof count);
  std::vector<T> values(count);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
  return values;
}

/// False where there is none.
bool ReadScan(const std::filesystem::path& file, LabelledScan& scan) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return false;
  auto& image = scan.observation.views.emplace_back().image;
  const auto size = Read<std::int32_t>(in);
  image.profiles = size.at(0);
  image.samples = size.at(1);
  image.points_C = Read<Eigen::Vector3d>(in);
  image.origins_C = Read<Eigen::Vector3d>(in);
  scan.label = Read<std::uint32_t>(in);
  return true;
}

void WriteScan(const std::filesystem::path& file, const LabelledScan& scan) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream out(file, std::ios::binary);
  const auto& image = scan.image();
  Write<std::int32_t>(out, {image.profiles, image.samples});
  Write(out, image.points_C);
  Write(out, image.origins_C);
  Write(out, scan.label);
}

std::uint32_t LabelOf(const Eigen::Vector3d& p_C, std::uint32_t body,
                      const perception::Workspace& workspace) {
  const bool counts = p_C.allFinite() && workspace.Contains(p_C);
  if (!counts) return 0;
  return body == 0 || body == sim::kContainerLabel ? kScene : kFirstObject + body - 1;
}

}  // namespace

geometry::Points LabelledScan::Measured() const {
  geometry::Points measured;
  for (std::size_t i = 0; i < label.size(); ++i) {
    const auto& p = image().points_C[i];
    // A depth camera's points without a label are measured all the same.
    if (p.allFinite() && (label[i] > 0 || !workspace)) measured.push_back(p);
  }
  return measured;
}

LabelledScan OfCamera(labelled::Cloud cloud, std::string name) {
  LabelledScan scan;
  scan.name = std::move(name);
  scan.label = std::move(cloud.labels);
  scan.depth_camera = true;
  scan.observation = geometry::ObservationOf({.profiles = 1,
                                              .samples = static_cast<int>(scan.label.size()),
                                              .points_C = std::move(cloud.file.points),
                                              .origins_C = {Eigen::Vector3d::Zero()}});
  return scan;
}

std::optional<LabelledScan> OfTrial(const Cell& cell, const TrialSpec& spec,
                                    const std::string& keep) {
  LabelledScan scan;
  scan.name = TrialId(spec);
  scan.workspace = trial::WorkspaceOf(cell.robot, cell.options.workspace_margin_m);
  const auto file =
      std::filesystem::path(keep) / fmt::format("{}-{:016x}.scan", scan.name, spec.seed);
  if (keep.empty() || !ReadScan(file, scan)) {
    const auto arranged = ArrangeTrial(cell, spec);
    if (!arranged) return std::nullopt;
    auto sensed = Look(cell, arranged->world, spec.seed);
    scan.observation = std::move(sensed.observation);
    const auto& points_C = scan.image().points_C;
    for (std::size_t i = 0; i < points_C.size(); ++i) {
      scan.label.push_back(LabelOf(points_C[i], sensed.truth.front().label[i], *scan.workspace));
    }
    if (!keep.empty()) WriteScan(file, scan);
  }
  scan.origin_C = geometry::Centroid(scan.image().origins_C);
  return scan;
}

}  // namespace rangegrasp::bench
