#include "report/seam_table.h"

#include <algorithm>
#include <map>
#include <span>
#include <sstream>

#include "report/grid.h"
#include "report/sections.h"

namespace rangegrasp::report {
namespace {

using stitching::DecisionName;
using stitching::Evaluation;
using stitching::EvaluationKind;
using stitching::EvaluationResult;
using stitching::kDecisions;
using stitching::kMethods;
using stitching::kTolerances_px;
using stitching::RunResult;
using stitching::SeamResult;
using stitching::Tally;

// Name -> numbers of a published table, whose first column names the row.
using Published = std::map<std::string, std::vector<double>>;

Published ReadPublished(const std::filesystem::path& file) {
  Published published;
  if (file.empty()) return published;
  for (const auto& [name, numbers] : ReadNamedNumbers(file)) published[name] = numbers;
  return published;
}

// In per cent; "-" of nothing.
std::string ShareCell(int k, int n) { return n > 0 ? Fixed(100.0 * k / n, 2) : "-"; }

Grid NumberGrid(std::vector<std::string> header) {
  Grid grid;
  grid.left.assign(header.size(), false);
  grid.left[0] = true;
  grid.header = std::move(header);
  return grid;
}

using Tallies = std::array<Tally, kMethods>;

Tallies Sum(const std::vector<SeamResult>& seams, Tallies SeamResult::*member) {
  Tallies sum{};
  for (const SeamResult& seam : seams) {
    for (std::size_t m = 0; m < kMethods; ++m) sum[m] += (seam.*member)[m];
  }
  return sum;
}

Section RatesSection(const Evaluation& evaluation, const EvaluationResult& result) {
  const Published published = ReadPublished(evaluation.reference);
  const Tallies sum = Sum(result.seams, &SeamResult::all);
  Section section{"Detection rate in % within a tolerance, " + std::to_string(sum[0].profiles) +
                      " profiles with an edge of " + std::to_string(result.seams.size()) + " seams",
                  NumberGrid({"method"})};
  for (const double tolerance : kTolerances_px) {
    section.grid.header.push_back("+-" + Fixed(tolerance, 0) + " px");
    section.grid.header.push_back("published");
    section.grid.left.insert(section.grid.left.end(), {false, false});
  }
  for (int m = 0; m < kMethods; ++m) {
    const Tally& tally = sum[static_cast<std::size_t>(m)];
    const auto known = published.find(stitching::MethodName(m));
    std::vector<std::string> row = {stitching::MethodName(m)};
    for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
      row.push_back(ShareCell(tally.within[t], tally.profiles));
      const bool there = known != published.end() && t < known->second.size();
      row.push_back(there ? Fixed(known->second[t], 1) : "-");
    }
    section.grid.rows.push_back(row);
  }
  return section;
}

// 1 mm is the largest tolerance that a sensor's pixels allow: 12 px or 18 px.
std::size_t MillimetreTolerance(const Evaluation& evaluation) {
  const double columns = 1e-3 * evaluation.sensor.line.columns_per_m;
  std::size_t best = 0;
  for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
    if (std::abs(kTolerances_px[t] - columns) < std::abs(kTolerances_px[best] - columns)) best = t;
  }
  return best;
}

Section PlacesSection(const Evaluation& evaluation, const EvaluationResult& result) {
  const std::size_t t = MillimetreTolerance(evaluation);
  Section section{"Within 1 mm, in %: where on the line the edge lies",
                  NumberGrid({"method", "all", "centre", "boundary"})};
  const Tallies all = Sum(result.seams, &SeamResult::all);
  const Tallies centre = Sum(result.seams, &SeamResult::centre);
  const Tallies boundary = Sum(result.seams, &SeamResult::boundary);
  for (int m = 0; m < kMethods; ++m) {
    const auto i = static_cast<std::size_t>(m);
    const auto cell = [t](const Tally& tally) {
      return ShareCell(tally.within[t], tally.profiles);
    };
    section.grid.rows.push_back(
        {stitching::MethodName(m), cell(all[i]), cell(centre[i]), cell(boundary[i])});
  }
  for (const auto& [name, numbers] : ReadPublished(evaluation.improvements)) {
    section.grid.rows.push_back(
        {"published: " + name, numbers.empty() ? "-" : Fixed(numbers[0], 2), "", ""});
  }
  return section;
}

Section ShapesSection(const Evaluation& evaluation, const EvaluationResult& result) {
  const std::size_t t = MillimetreTolerance(evaluation);
  Section section{"Every shape of edge: within 1 mm, in %; told to have no edge, in %",
                  NumberGrid({"shape", "seams", "profiles"})};
  for (int m = 0; m < kMethods; ++m) section.grid.header.push_back(stitching::MethodName(m));
  for (const auto decision : kDecisions) {
    section.grid.header.push_back(std::string("no edge: ") + DecisionName(decision));
  }
  section.grid.left.resize(section.grid.header.size(), false);
  std::vector<stitching::EdgeShape> shapes = evaluation.shapes;
  std::ranges::sort(shapes);
  shapes.erase(std::unique(shapes.begin(), shapes.end()), shapes.end());
  for (const stitching::EdgeShape shape : shapes) {
    std::vector<SeamResult> seams;
    std::ranges::copy_if(result.seams, std::back_inserter(seams),
                         [shape](const SeamResult& seam) { return seam.shape == shape; });
    const Tallies sum = Sum(seams, &SeamResult::all);
    int profiles = 0;
    std::array<int, kDecisions.size()> no_edge{};
    for (const SeamResult& seam : seams) {
      profiles += seam.profiles;
      for (std::size_t d = 0; d < kDecisions.size(); ++d) no_edge[d] += seam.no_edge[d];
    }
    std::vector<std::string> row = {stitching::Name(shape), std::to_string(seams.size()),
                                    std::to_string(profiles)};
    for (const Tally& tally : sum) {
      row.push_back(ShareCell(tally.within[t], tally.profiles));
    }
    for (const int count : no_edge) row.push_back(ShareCell(count, profiles));
    section.grid.rows.push_back(row);
  }
  return section;
}

// Means over the length of all runs; the largest error of all.
Section TracksSection(const EvaluationResult& result) {
  Section section{"Closed loop after the first 100 mm: error of the seam's distance to the edge",
                  NumberGrid({"method", "runs", "to the end", "stopped early", "mean mm", "95 % mm",
                              "max mm", "within 1 mm, % of the length"})};
  for (const auto method : std::span(kDecisions).first<stitching::kLoopDecisions>()) {
    int runs = 0;
    int done = 0;
    int early = 0;
    double mean = 0.0;
    double p95 = 0.0;
    double largest = 0.0;
    double within = 0.0;
    double length = 0.0;
    for (const RunResult& run : result.runs) {
      if (run.method != method) continue;
      ++runs;
      done += run.end == stitching::TrackEnd::kDone ? 1 : 0;
      early += run.stopped_early ? 1 : 0;
      length += run.settled_m;
      mean += run.settled_m * run.mean_error_m;
      p95 += run.settled_m * run.p95_error_m;
      largest = std::max(largest, run.max_error_m);
      within += run.settled_m * run.share_within_1mm;
    }
    const double n = std::max(1e-9, length);
    section.grid.rows.push_back({DecisionName(method), std::to_string(runs), std::to_string(done),
                                 std::to_string(early), Fixed(mean / n * 1e3, 3),
                                 Fixed(p95 / n * 1e3, 3), Fixed(largest * 1e3, 3),
                                 Fixed(within / n * 100.0, 2)});
  }
  return section;
}

Section HazardsSection(const EvaluationResult& result) {
  Section section{
      "Hazards: found, and the head at rest, before the needle is there",
      NumberGrid({"hazard", "method", "runs", "at rest before it was in view", "came into view",
                  "found in time", "reached", "in time %", "found as the other"})};
  for (const char* hazard : {"mat_end", "obstacle"}) {
    for (const auto method : std::span(kDecisions).first<stitching::kLoopDecisions>()) {
      int runs = 0;
      int found = 0;
      int other = 0;
      int early = 0;
      for (const RunResult& run : result.runs) {
        if (run.method != method || run.hazard != hazard) continue;
        ++runs;
        const bool in_time = !run.reached_hazard && run.end != stitching::TrackEnd::kDone;
        found += in_time && !run.stopped_early ? 1 : 0;
        other += in_time && !run.stopped_early && run.hazard != stitching::Name(run.end) ? 1 : 0;
        early += run.stopped_early ? 1 : 0;
      }
      const int seen = runs - early;
      section.grid.rows.push_back({hazard, DecisionName(method), std::to_string(runs),
                                   std::to_string(early), std::to_string(seen),
                                   std::to_string(found), std::to_string(seen - found),
                                   ShareCell(found, seen), std::to_string(other)});
    }
  }
  return section;
}

std::vector<Section> SectionsOf(const Evaluation& evaluation, const EvaluationResult& result) {
  switch (evaluation.kind) {
    case EvaluationKind::kRates:
      return {RatesSection(evaluation, result), PlacesSection(evaluation, result),
              ShapesSection(evaluation, result)};
    case EvaluationKind::kTracks:
      return {TracksSection(result)};
    case EvaluationKind::kHazards:
      return {HazardsSection(result)};
  }
  return {};
}

}  // namespace

std::string FormatSeam(const Evaluation& evaluation, const EvaluationResult& result,
                       TableFormat format) {
  Stamp stamp(evaluation.name, evaluation.file);
  stamp.AddHash("sensor_hash", evaluation.sensor_file);
  stamp.Add("seed", evaluation.seed);
  stamp.Add("seams", static_cast<std::uint64_t>(evaluation.seams));
  return Format(SectionsOf(evaluation, result), stamp, format);
}

std::string SeamRowsCsv(const EvaluationResult& result) {
  std::ostringstream out;
  if (!result.runs.empty()) {
    out << "run,method,hazard,end,reached_hazard,stopped_early,settled_mm,mean_error_mm,p95_error_"
           "mm,"
           "max_error_mm,share_within_1mm\n";
    for (const RunResult& run : result.runs) {
      out << run.run << "," << DecisionName(run.method) << "," << run.hazard << ","
          << stitching::Name(run.end) << "," << run.reached_hazard << "," << run.stopped_early
          << "," << Fixed(run.settled_m * 1e3, 1) << "," << Fixed(run.mean_error_m * 1e3, 4) << ","
          << Fixed(run.p95_error_m * 1e3, 4) << "," << Fixed(run.max_error_m * 1e3, 4) << ","
          << Fixed(run.share_within_1mm, 5) << "\n";
    }
    return out.str();
  }
  out << "seam,shape,height_mm,profiles,method,no_edge,labelled,within_3px,"
         "within_10px,within_12px,within_18px\n";
  for (const SeamResult& seam : result.seams) {
    for (int m = 0; m < kMethods; ++m) {
      const Tally& tally = seam.all[static_cast<std::size_t>(m)];
      out << seam.seam << "," << stitching::Name(seam.shape) << "," << Fixed(seam.height_m * 1e3, 3)
          << "," << seam.profiles << "," << stitching::MethodName(m) << ",";
      if (m >= seam::kDetectors)
        out << seam.no_edge[static_cast<std::size_t>(m - seam::kDetectors)];
      out << "," << tally.profiles;
      for (const int within : tally.within) out << "," << within;
      out << "\n";
    }
  }
  return out.str();
}

}  // namespace rangegrasp::report
