#include "seam/task/seam_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/hash.h"
#include "seam/task/internal/rate_tables.h"
#include "seam/task/internal/run_tables.h"

namespace rangegrasp::seam_task {
namespace {

using experiment::Record;
using experiment::Stamp;
using stitching::EdgeShape;

// The text of a published table; empty where there is none. Read once, so that a broken one shows.
std::string PublishedText(const std::filesystem::path& file) {
  if (file.empty()) return "";
  std::string text = base::ReadFile(file);
  internal::ReadPublished(text, file.string());
  return text;
}

std::string ShapeWords(std::vector<EdgeShape> shapes) {
  std::ranges::sort(shapes);
  shapes.erase(std::unique(shapes.begin(), shapes.end()), shapes.end());
  std::vector<std::string> words;
  for (const EdgeShape shape : shapes) words.emplace_back(base::Word(shape));
  return base::Join(words, ",");
}

}  // namespace

void AddTo(Stamp& stamp, const SeamExperiment& experiment) {
  stamp.identity["sensor_hash"] = base::Hex(base::Fnv1a(base::ReadFile(experiment.sensor_file)));
  stamp.data["kind"] = base::Word(experiment.kind);
  stamp.data["shapes"] = ShapeWords(experiment.shapes);
  stamp.data["profiles_per_seam"] = fmt::format("{}", experiment.record.profiles);
  stamp.data["columns_per_m"] = fmt::format("{}", experiment.sensor.line.columns_per_m);
  stamp.data["wanted_m"] = fmt::format("{}", experiment.track.length_m - stitching::kSettle_m);
  const auto corners = CornersOf(experiment);
  if (!corners.empty()) {
    stamp.data["beside_corners_m"] =
        fmt::format("{}", experiment.track.length_m - stitching::kSettle_m -
                              2.0 * kCorner_m * static_cast<double>(corners.size()));
  }
  stamp.data["reference"] = PublishedText(experiment.reference);
  stamp.data["reference_file"] = experiment.reference.filename().string();
  stamp.data["improvements"] = PublishedText(experiment.improvements);
  stamp.data["improvements_file"] = experiment.improvements.filename().string();
  stamp.data["runtimes"] = PublishedText(experiment.runtimes);
  stamp.data["runtimes_file"] = experiment.runtimes.filename().string();
}

experiment::Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
  const internal::Facts facts = internal::FactsOf(stamp);
  experiment::Report report = facts.kind == SeamKind::kRates ? internal::RatesReport(facts, records)
                                                             : internal::RunsReport(facts, records);
  const auto failed = std::ranges::count_if(records, internal::Failed);
  if (failed > 0) {
    report.notes.push_back(fmt::format(
        "{} of {} cases crashed or timed out; they count as not found, not followed or not stopped "
        "in time, and where on the line their edges lay is not known",
        failed, records.size()));
  }
  return report;
}

}  // namespace rangegrasp::seam_task
