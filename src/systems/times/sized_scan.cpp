#include "times/sized_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "grasp/workspace.h"
#include "sensing/line_scanner.h"

namespace rangegrasp::times {
namespace {

// Each scan with closer lines is this much denser than it should have to be; what is too much is
// left out.
constexpr double kSpare = 1.02;
constexpr int kScans = 6;

enum class Part { kObject, kTable, kElse };

std::vector<Part> PartsOf(const trial::Cell& cell, const sim::World& world,
                          const sensing::Scan& scan) {
  const geometry::Plane table_W = cell.TablePlane();
  const double clearance_m = cell.options.perception.preprocess.table_clearance_m;
  const auto workspace = trial::WorkspaceOf(cell.robot, cell.options.workspace_margin_m);
  std::vector<Part> parts;
  for (std::size_t i = 0; i < scan.view.image.points_C.size(); ++i) {
    const Eigen::Vector3d& p_W = scan.view.image.points_C[i];
    const auto label = static_cast<int>(scan.truth.label[i]);
    const double height_m = table_W.Distance(p_W);
    Part part = Part::kElse;
    if (p_W.allFinite() && workspace.Contains(p_W)) {
      if (label > 0 && label <= world.objects() && height_m > clearance_m) part = Part::kObject;
      if (label == 0 && std::abs(height_m) < clearance_m) part = Part::kTable;
    }
    parts.push_back(part);
  }
  return parts;
}

int Count(const std::vector<Part>& parts, Part part) {
  return static_cast<int>(std::count(parts.begin(), parts.end(), part));
}

// Of one kind so many, evenly in their order.
void Keep(const std::vector<Part>& parts, Part part, int wanted, geometry::Points& points_W) {
  const std::int64_t have = Count(parts, part);
  std::int64_t seen = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] != part) continue;
    const bool kept = (seen + 1) * wanted / have > seen * wanted / have;
    ++seen;
    if (!kept) points_W[i].setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace

geometry::Observation SizedScan(const trial::Cell& cell, const sim::World& world,
                                const ScanSize& size, base::Rng rng) {
  sensing::LineScannerOptions scanner = cell.scanner;
  for (int i = 0; i < kScans; ++i) {
    base::Rng same = rng;
    sensing::Scan scan =
        sensing::ScanScene(world.VisualMeshes(), cell.robot.X_WScanner, scanner, same);
    const auto parts = PartsOf(cell, world, scan);
    const int objects = Count(parts, Part::kObject);
    const int table = Count(parts, Part::kTable);
    if (objects == 0 || table == 0) break;
    if (objects < size.object_points || table < size.table_points) {
      const double denser =
          std::sqrt(kSpare * std::max(static_cast<double>(size.object_points) / objects,
                                      static_cast<double>(size.table_points) / table));
      scanner.samples = static_cast<int>(std::ceil(scanner.samples * denser));
      scanner.profiles = static_cast<int>(std::ceil(scanner.profiles * denser));
      continue;
    }
    auto& points_W = scan.view.image.points_C;
    Keep(parts, Part::kObject, size.object_points, points_W);
    Keep(parts, Part::kTable, size.table_points, points_W);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (parts[k] == Part::kElse) {
        points_W[k].setConstant(std::numeric_limits<double>::quiet_NaN());
      }
    }
    geometry::Observation observation;
    observation.views.push_back(std::move(scan.view));
    return observation;
  }
  throw base::InputError(fmt::format("no scan with {} points of objects and {} of the table",
                                     size.object_points, size.table_points));
}

}  // namespace rangegrasp::times
