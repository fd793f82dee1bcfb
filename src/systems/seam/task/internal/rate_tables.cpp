#include "seam/task/internal/rate_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "base/csv.h"
#include "base/units.h"
#include "experiment/statistics.h"
#include "seam/task/seam_json.h"
#include "seam/task/seam_times.h"

namespace rangegrasp::seam_task::internal {
namespace {

using experiment::Fixed;
using experiment::Record;
using experiment::Section;
using stitching::EdgeShape;

// A seam that was not finished: an edge in every profile, found in none.
SeamResult FailedSeam(const SeamParams& params, int profiles) {
  SeamResult result;
  result.seam = params.number;
  result.shape = params.shape;
  result.height_m = std::nan("");
  result.profiles = profiles;
  if (params.shape != EdgeShape::kNone) {
    for (Tally& tally : result.all) tally.profiles = profiles;
  }
  return result;
}

std::vector<SeamResult> SeamsOf(const Facts& facts, const std::vector<Record>& records) {
  std::vector<SeamResult> seams;
  for (const Record& record : records) {
    const SeamParams params = ParamsFrom(record.which.params);
    seams.push_back(Failed(record) ? FailedSeam(params, facts.profiles_per_seam)
                                   : SeamResultFrom(params, record.result.data));
  }
  return seams;
}

Tallies Sum(const std::vector<SeamResult>& seams, Tallies SeamResult::*member) {
  Tallies sum{};
  for (const SeamResult& seam : seams) {
    for (std::size_t m = 0; m < kMethods; ++m) sum[m] += (seam.*member)[m];
  }
  return sum;
}

Section RatesSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  const Tallies sum = Sum(seams, &SeamResult::all);
  Cells header = {"method"};
  for (const double tolerance : kTolerances_px) {
    header.push_back("+-" + Fixed(tolerance, 0) + " px");
    header.push_back("published");
  }
  Section section{fmt::format("Detection rate in % within a tolerance, {} profiles with an edge of "
                              "{} seams",
                              sum[0].profiles, seams.size()),
                  NumberGrid(std::move(header))};
  for (std::size_t m = 0; m < kMethods; ++m) {
    const auto known = facts.reference.find(MethodTitle(m));
    Cells row = {MethodTitle(m)};
    for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
      row.push_back(ShareCell(sum[m].within[t], sum[m].profiles));
      const bool there =
          known != facts.reference.end() && t < known->second.size() && known->second[t];
      row.push_back(there ? Fixed(*known->second[t], 1) : "-");
    }
    section.grid.rows.push_back(row);
  }
  return section;
}

// The tolerance that is nearest to 1 mm: 12 px or 18 px.
std::size_t MillimeterTolerance(const Facts& facts) {
  const double columns = base::kMm * facts.columns_per_m;
  const auto distance = [&](double px) { return std::abs(px - columns); };
  const auto best = std::ranges::min_element(kTolerances_px, {}, distance);
  return static_cast<std::size_t>(best - kTolerances_px.begin());
}

Section PlacesSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  const std::size_t t = MillimeterTolerance(facts);
  Section section{"Within 1 mm, in %: where on the line the edge lies",
                  NumberGrid({"method", "all", "centre", "boundary"})};
  const Tallies all = Sum(seams, &SeamResult::all);
  const Tallies center = Sum(seams, &SeamResult::center);
  const Tallies boundary = Sum(seams, &SeamResult::boundary);
  const auto cell = [t](const Tally& tally) { return ShareCell(tally.within[t], tally.profiles); };
  for (std::size_t m = 0; m < kMethods; ++m) {
    section.grid.rows.push_back({MethodTitle(m), cell(all[m]), cell(center[m]), cell(boundary[m])});
  }
  for (const auto& [name, numbers] : facts.improvements) {
    const bool there = !numbers.empty() && numbers[0];
    section.grid.rows.push_back(
        {"published: " + name, there ? Fixed(*numbers[0], 2) : "-", "", ""});
  }
  return section;
}

Cells ShapeRow(EdgeShape shape, const std::vector<SeamResult>& seams, std::size_t tolerance) {
  int profiles = 0;
  std::array<int, kMethods> no_edge{};
  for (const SeamResult& seam : seams) {
    profiles += seam.profiles;
    for (std::size_t m = 0; m < kMethods; ++m) no_edge[m] += seam.no_edge[m];
  }
  Cells row = {std::string(base::Word(shape)), fmt::format("{}", seams.size()),
               fmt::format("{}", profiles)};
  for (const Tally& tally : Sum(seams, &SeamResult::all)) {
    row.push_back(ShareCell(tally.within[tolerance], tally.profiles));
  }
  for (std::size_t m = kAlone; m < kMethods; ++m) {
    row.push_back(ShareCell(no_edge[m], profiles));
  }
  return row;
}

Section ShapesSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  Cells header = {"shape", "seams", "profiles"};
  for (std::size_t m = 0; m < kMethods; ++m) header.push_back(MethodTitle(m));
  for (const auto decision : kDecisions) header.push_back("no edge: " + TitleOf(decision));
  Section section{"Every shape of edge: within 1 mm, in %; told to have no edge, in %",
                  NumberGrid(std::move(header))};
  for (const EdgeShape shape : facts.shapes) {
    std::vector<SeamResult> alike;
    std::ranges::copy_if(seams, std::back_inserter(alike),
                         [shape](const SeamResult& seam) { return seam.shape == shape; });
    section.grid.rows.push_back(ShapeRow(shape, alike, MillimeterTolerance(facts)));
  }
  return section;
}

Section ErrorsSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  const std::size_t t = MillimeterTolerance(facts);
  Section section{"Within 1 mm, in %, with its standard error over seams",
                  NumberGrid({"method", "within 1 mm", "+-", "profiles", "seams"})};
  for (std::size_t m = 0; m < kMethods; ++m) {
    std::vector<Part> parts;
    for (const SeamResult& seam : seams) {
      const Tally& tally = seam.all[m];
      if (tally.profiles == 0) continue;
      parts.push_back({static_cast<double>(tally.within[t]), static_cast<double>(tally.profiles)});
    }
    const Tally sum = Sum(seams, &SeamResult::all)[m];
    section.grid.rows.push_back({MethodTitle(m), ShareCell(sum.within[t], sum.profiles),
                                 ErrorCell(parts), fmt::format("{}", sum.profiles),
                                 fmt::format("{}", parts.size())});
  }
  return section;
}

// ---- the published tables' figures ----

std::vector<experiment::Cluster> ClustersOf(const std::vector<SeamResult>& seams,
                                            Tallies SeamResult::*member, std::size_t method,
                                            std::size_t tolerance) {
  std::vector<experiment::Cluster> clusters;
  for (const SeamResult& seam : seams) {
    const Tally& tally = (seam.*member)[method];
    clusters.push_back({tally.within[tolerance], tally.profiles});
  }
  return clusters;
}

experiment::PublishedFigure FigureOf(const std::string& row, double published,
                                     const std::vector<experiment::Cluster>& clusters) {
  experiment::PublishedFigure figure{.row = row, .unit = "%", .digits = 2, .published = published};
  int found = 0;
  int profiles = 0;
  for (const experiment::Cluster& cluster : clusters) {
    found += cluster.k;
    profiles += cluster.n;
  }
  if (profiles > 0) figure.own = 100.0 * found / profiles;
  figure.evidence = experiment::ClustersEvidence{clusters};
  return figure;
}

// A row of table 3.5: what it is of.
struct Improvement {
  const char* name;  // in the published table
  seam::DecisionMethod decision;
  Tallies SeamResult::*where;
};
// Fig. 3.35 (b) shows the places for the improved method.
constexpr std::array<Improvement, 4> kImprovements = {
    {{"three-lines combined result within 1 mm (original voting)", seam::DecisionMethod::kVoting,
      &SeamResult::all},
     {"three-lines with sum of weights and historic edge positions", seam::DecisionMethod::kWeights,
      &SeamResult::all},
     {"edge in the centre of the scan line", seam::DecisionMethod::kWeights, &SeamResult::center},
     {"edge at the boundary of the scan line", seam::DecisionMethod::kWeights,
      &SeamResult::boundary}}};

std::vector<experiment::PublishedFigure> FiguresOf(const Facts& facts,
                                                   const std::vector<SeamResult>& seams) {
  std::vector<experiment::PublishedFigure> figures;
  for (std::size_t m = 0; m < kMethods; ++m) {
    const auto known = facts.reference.find(MethodTitle(m));
    if (known == facts.reference.end()) continue;
    for (std::size_t t = 0; t < std::min(kTolerances_px.size(), known->second.size()); ++t) {
      if (!known->second[t]) continue;
      figures.push_back(FigureOf(fmt::format("{}, +-{:.0f} px", MethodTitle(m), kTolerances_px[t]),
                                 *known->second[t], ClustersOf(seams, &SeamResult::all, m, t)));
    }
  }
  for (const Improvement& one : kImprovements) {
    const auto known = facts.improvements.find(one.name);
    if (known == facts.improvements.end() || known->second.empty() || !known->second[0]) continue;
    const std::size_t m = kAlone + static_cast<std::size_t>(one.decision);
    figures.push_back(FigureOf(one.name, *known->second[0],
                               ClustersOf(seams, one.where, m, MillimeterTolerance(facts))));
    figures.back().key = "improvements";
  }
  return figures;
}

// Table 3.1: what a step takes for one profile, on average over all.
std::vector<experiment::PublishedFigure> TimesOf(const Facts& facts,
                                                 const std::vector<Record>& records,
                                                 const std::vector<SeamResult>& seams) {
  constexpr std::size_t kAverage = 1;  // of the columns behind the step's name
  std::vector<experiment::PublishedFigure> figures;
  for (const char* step : kTimedSteps) {
    const auto known = facts.runtimes.find(step);
    if (known == facts.runtimes.end() || known->second.size() <= kAverage) continue;
    double seconds = 0.0;
    int profiles = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
      for (const auto& [name, s] : records[i].result.seconds) {
        if (name != step) continue;
        seconds += s;
        profiles += seams[i].profiles;
      }
    }
    experiment::PublishedFigure figure{.row = fmt::format("{}, average", step),
                                       .unit = "ms",
                                       .digits = 4,
                                       .lower_is_better = true,
                                       .published = known->second[kAverage].value_or(0.0)};
    if (profiles > 0) figure.own = 1e3 * seconds / profiles;
    figure.evidence = experiment::TimesEvidence{profiles};
    figure.key = "runtimes";
    figures.push_back(std::move(figure));
  }
  return figures;
}

std::string SeamRows(const std::vector<SeamResult>& seams) {
  std::string text =
      "seam,shape,height_mm,profiles,method,no_edge,labelled,within_3px,within_10px,within_12px,"
      "within_18px\n";
  for (const SeamResult& seam : seams) {
    const std::string height =
        std::isfinite(seam.height_m) ? Fixed(seam.height_m * base::kMmPerM, 3) : "";
    for (std::size_t m = 0; m < kMethods; ++m) {
      Cells row = {fmt::format("{}", seam.seam),
                   std::string(base::Word(seam.shape)),
                   height,
                   fmt::format("{}", seam.profiles),
                   MethodTitle(m),
                   m >= kAlone ? fmt::format("{}", seam.no_edge[m]) : "",
                   fmt::format("{}", seam.all[m].profiles)};
      for (const int within : seam.all[m].within) row.push_back(fmt::format("{}", within));
      text += base::CsvLine(row);
    }
  }
  return text;
}

}  // namespace

experiment::Report RatesReport(const Facts& facts, const std::vector<Record>& records) {
  const auto seams = SeamsOf(facts, records);
  experiment::Report report;
  report.sections = {RatesSection(facts, seams), PlacesSection(facts, seams),
                     ShapesSection(facts, seams), ErrorsSection(facts, seams)};
  report.files.emplace_back("rows.csv", SeamRows(seams));
  report.published = FiguresOf(facts, seams);
  for (auto& figure : TimesOf(facts, records, seams)) {
    report.published.push_back(std::move(figure));
  }
  return report;
}

}  // namespace rangegrasp::seam_task::internal
