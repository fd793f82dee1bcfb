#include "seam/task/internal/table_parts.h"

#include <cmath>

#include "base/csv.h"
#include "base/words.h"

namespace rangegrasp::seam_task::internal {
namespace {

// NaN of fewer than two.
double StandardError(const std::vector<Part>& parts) {
  double part = 0.0;
  double whole = 0.0;
  for (const Part& p : parts) {
    part += p.part;
    whole += p.whole;
  }
  double squares = 0.0;
  for (const Part& p : parts) squares += std::pow(p.part - part / whole * p.whole, 2);
  const auto n = static_cast<double>(parts.size());
  return std::sqrt(n / (n - 1.0) * squares) / whole;
}

}  // namespace

Published ReadPublished(const std::string& csv, const std::string& name) {
  Published published;
  if (csv.empty()) return published;
  const auto table = base::CsvTable::Parse(csv, name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    auto& numbers = published[table.Cell(row, 0)];
    for (std::size_t c = 1; c < table.header().size(); ++c) {
      numbers.push_back(table.OptionalNumber(row, c));
    }
  }
  return published;
}

Facts FactsOf(const experiment::Stamp& stamp) {
  const auto at = [&](const char* name) { return experiment::Need(stamp.data, name); };
  Facts facts{base::FromWord<SeamKind>(at("kind"), "kind"),
              {},
              std::stoi(at("profiles_per_seam")),
              std::stod(at("columns_per_m")),
              std::stod(at("wanted_m")),
              0.0,
              ReadPublished(at("reference"), at("reference_file")),
              ReadPublished(at("improvements"), at("improvements_file")),
              {}};
  // Runs of earlier versions have none.
  const auto runtimes = stamp.data.find("runtimes");
  if (runtimes != stamp.data.end()) {
    facts.runtimes = ReadPublished(runtimes->second, at("runtimes_file"));
  }
  const auto beside = stamp.data.find("beside_corners_m");
  if (beside != stamp.data.end()) facts.beside_corners_m = std::stod(beside->second);
  for (const std::string& word : base::Split(at("shapes"), ',')) {
    facts.shapes.push_back(base::FromWord<stitching::EdgeShape>(word, "shapes"));
  }
  return facts;
}

bool Failed(const experiment::Record& record) {
  return record.result.outcome == experiment::kCrashed ||
         record.result.outcome == experiment::kTimedOut;
}

std::string ShareCell(int k, int n) { return n > 0 ? experiment::Fixed(100.0 * k / n, 2) : "-"; }

experiment::Grid NumberGrid(Cells header) {
  experiment::Grid grid;
  grid.left.assign(header.size(), false);
  grid.left[0] = true;
  grid.header = std::move(header);
  return grid;
}

std::string ErrorCell(const std::vector<Part>& parts) {
  const double error = 100.0 * StandardError(parts);
  return std::isfinite(error) ? experiment::Fixed(error, 2) : "-";
}

}  // namespace rangegrasp::seam_task::internal
