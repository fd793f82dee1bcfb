#include "tasks/seam/seam_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "core/csv.h"
#include "core/file.h"
#include "core/hash.h"
#include "core/units.h"
#include "experiment/grid.h"
#include "experiment/statistics.h"
#include "tasks/seam/seam_json.h"
#include "tasks/seam/seam_score.h"
#include "tasks/seam/seam_times.h"

namespace rangegrasp::tasks::seam_task {
namespace {

using experiment::Fixed;
using experiment::Grid;
using experiment::Record;
using experiment::Section;
using experiment::Stamp;
using stitching::EdgeShape;
using stitching::TrackEnd;
using Cells = std::vector<std::string>;

// Name -> numbers of a published table, whose first column names the row.
using Published = std::map<std::string, std::vector<std::optional<double>>>;

Published ReadPublished(const std::string& csv, const std::string& name) {
  Published published;
  if (csv.empty()) return published;
  const auto table = core::CsvTable::Parse(csv, name);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    auto& numbers = published[table.Cell(row, 0)];
    for (std::size_t c = 1; c < table.header().size(); ++c) {
      numbers.push_back(table.OptionalNumber(row, c));
    }
  }
  return published;
}

// What the stamp tells of the experiment.
struct Facts {
  SeamKind kind;
  std::vector<EdgeShape> shapes;  // each once, in their order
  int profiles_per_seam;
  double columns_per_m;
  double wanted_m;  // of a run's path: what is to be followed after the head has settled
  double beside_corners_m = 0.0;  // of it, of a half circle
  Published reference, improvements, runtimes;
};

Facts FactsOf(const Stamp& stamp) {
  const auto at = [&](const char* name) { return experiment::Need(stamp.data, name); };
  Facts facts{core::FromWord<SeamKind>(at("kind"), "kind"),
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
  for (const std::string& word : core::Split(at("shapes"), ',')) {
    facts.shapes.push_back(core::FromWord<EdgeShape>(word, "shapes"));
  }
  return facts;
}

bool Failed(const Record& record) {
  return record.result.outcome == experiment::kCrashed ||
         record.result.outcome == experiment::kTimedOut;
}

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

// A run that was not finished: nothing followed, or a hazard that was not stopped for.
RunResult FailedRun(const SeamParams& params) {
  RunResult result;
  result.run = params.number;
  result.method = params.method.value();
  result.hazard = params.hazard;
  result.end = TrackEnd::kLost;
  result.reached_hazard = params.hazard != Hazard::kNone;
  result.stopped_early = params.hazard == Hazard::kNone;
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

std::vector<RunResult> RunsOf(const std::vector<Record>& records) {
  std::vector<RunResult> runs;
  for (const Record& record : records) {
    const SeamParams params = ParamsFrom(record.which.params);
    runs.push_back(Failed(record) ? FailedRun(params) : RunResultFrom(params, record.result.data));
  }
  return runs;
}

// In per cent; "-" of nothing.
std::string ShareCell(int k, int n) { return n > 0 ? Fixed(100.0 * k / n, 2) : "-"; }

Grid NumberGrid(Cells header) {
  Grid grid;
  grid.left.assign(header.size(), false);
  grid.left[0] = true;
  grid.header = std::move(header);
  return grid;
}

// ---- rates ----

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
  const double columns = core::kMm * facts.columns_per_m;
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
  Cells row = {std::string(core::Word(shape)), fmt::format("{}", seams.size()),
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

// A part of a whole, one of several that were drawn independently: of a seam's profiles those that
// were found, of a run's wanted length what was followed.
struct Part {
  double part, whole;
};

// Standard error of sum(part) / sum(whole), from how much the parts scatter about it (Cochran 1977,
// eq. 6.9: the ratio estimator). Profiles of one seam resemble each other, seams do not: counted as
// single profiles the error would come out far too small. NaN of fewer than two.
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

std::string ErrorCell(const std::vector<Part>& parts) {
  const double error = 100.0 * StandardError(parts);
  return std::isfinite(error) ? Fixed(error, 2) : "-";
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

// ---- closed loops ----

// The ways to decide that steered any of the runs.
std::vector<seam::DecisionMethod> DecisionsOf(const std::vector<RunResult>& runs) {
  std::vector<seam::DecisionMethod> decisions;
  std::ranges::copy_if(kDecisions, std::back_inserter(decisions), [&](seam::DecisionMethod method) {
    return std::ranges::any_of(runs, [&](const RunResult& run) { return run.method == method; });
  });
  return decisions;
}

// Means over the length of all runs; the largest error of all.
Cells TracksRow(const Facts& facts, const std::vector<RunResult>& all,
                seam::DecisionMethod method) {
  int runs = 0;
  int done = 0;
  int early = 0;
  double mean = 0.0;
  double p95 = 0.0;
  double max = 0.0;
  double within = 0.0;
  double length = 0.0;
  std::vector<Part> parts;
  for (const RunResult& run : all) {
    if (run.method != method) continue;
    ++runs;
    done += run.end == TrackEnd::kDone ? 1 : 0;
    early += run.stopped_early ? 1 : 0;
    length += run.settled_m;
    mean += run.settled_m * run.mean_error_m;
    p95 += run.settled_m * run.p95_error_m;
    max = std::max(max, run.max_error_m);
    within += run.settled_m * run.share_within_1mm;
    parts.push_back({run.settled_m * run.share_within_1mm, facts.wanted_m});
  }
  // So that no length at all gives 0.
  const double n = std::max(1e-9, length);
  const double wanted = runs * facts.wanted_m;
  return {TitleOf(method),
          fmt::format("{}", runs),
          fmt::format("{}", done),
          fmt::format("{}", early),
          Fixed(mean / n * core::kMmPerM, 3),
          Fixed(p95 / n * core::kMmPerM, 3),
          Fixed(max * core::kMmPerM, 3),
          Fixed(within / n * 100.0, 2),
          runs > 0 ? Fixed(within / wanted * 100.0, 2) : "-",
          ErrorCell(parts)};
}

Section TracksSection(const Facts& facts, const std::vector<RunResult>& runs) {
  Section section{
      "Closed loop after the first 100 mm: error of the seam's distance to the edge",
      NumberGrid({"method", "runs", "to the end", "stopped early", "mean mm", "95 % mm", "max mm",
                  "within 1 mm, % of the length", "within 1 mm, % of the wanted length", "+-"})};
  for (const auto method : DecisionsOf(runs)) {
    section.grid.rows.push_back(TracksRow(facts, runs, method));
  }
  return section;
}

// A half circle without its corners, where the edge turns by 90 degrees.
Section CornersSection(const Facts& facts, const std::vector<RunResult>& runs) {
  Section section{
      fmt::format("Half circle: not within {:.0f} mm of its corners", kCorner_m * core::kMmPerM),
      NumberGrid({"method", "runs", "within 1 mm, % of the wanted length", "+-"})};
  for (const auto method : DecisionsOf(runs)) {
    std::vector<Part> parts;
    double good = 0.0;
    for (const RunResult& run : runs) {
      if (run.method != method) continue;
      good += run.good_beside_corners_m;
      parts.push_back({run.good_beside_corners_m, facts.beside_corners_m});
    }
    const double wanted = static_cast<double>(parts.size()) * facts.beside_corners_m;
    section.grid.rows.push_back({TitleOf(method), fmt::format("{}", parts.size()),
                                 parts.empty() ? "-" : Fixed(good / wanted * 100.0, 2),
                                 ErrorCell(parts)});
  }
  return section;
}

Section EarlySection(const std::vector<RunResult>& runs) {
  Section section{"Runs that stopped early",
                  NumberGrid({"run", "method", "hazard", "end", "at rest, mm along the track"})};
  for (const RunResult& run : runs) {
    if (!run.stopped_early) continue;
    section.grid.rows.push_back(
        {fmt::format("{}", run.run), TitleOf(run.method), std::string(core::Word(run.hazard)),
         std::string(core::Word(run.end)), Fixed(run.rest_m * core::kMmPerM, 1)});
  }
  return section;
}

Cells HazardsRow(const std::vector<RunResult>& all, Hazard hazard, seam::DecisionMethod method) {
  int runs = 0;
  int found = 0;
  int other = 0;
  int early = 0;
  for (const RunResult& run : all) {
    if (run.method != method || run.hazard != hazard) continue;
    ++runs;
    early += run.stopped_early ? 1 : 0;
    if (run.reached_hazard || run.end == TrackEnd::kDone || run.stopped_early) continue;
    ++found;
    other += core::Word(hazard) != core::Word(run.end) ? 1 : 0;
  }
  const int seen = runs - early;
  Cells row = {std::string(core::Word(hazard)), TitleOf(method)};
  for (const int count : {runs, early, seen, found, seen - found}) {
    row.push_back(fmt::format("{}", count));
  }
  row.push_back(ShareCell(found, seen));
  row.push_back(fmt::format("{}", other));
  return row;
}

Section HazardsSection(const std::vector<RunResult>& runs) {
  Section section{
      "Hazards: found, and the head at rest, before the needle is there",
      NumberGrid({"hazard", "method", "runs", "at rest before it was in view", "came into view",
                  "found in time", "reached", "in time %", "found as the other"})};
  for (const Hazard hazard : {Hazard::kMatEnd, Hazard::kObstacle}) {
    for (const auto method : DecisionsOf(runs)) {
      section.grid.rows.push_back(HazardsRow(runs, hazard, method));
    }
  }
  return section;
}

// ---- rows.csv ----

std::string SeamRows(const std::vector<SeamResult>& seams) {
  std::string text =
      "seam,shape,height_mm,profiles,method,no_edge,labelled,within_3px,within_10px,within_12px,"
      "within_18px\n";
  for (const SeamResult& seam : seams) {
    const std::string height =
        std::isfinite(seam.height_m) ? Fixed(seam.height_m * core::kMmPerM, 3) : "";
    for (std::size_t m = 0; m < kMethods; ++m) {
      Cells row = {fmt::format("{}", seam.seam),
                   std::string(core::Word(seam.shape)),
                   height,
                   fmt::format("{}", seam.profiles),
                   MethodTitle(m),
                   m >= kAlone ? fmt::format("{}", seam.no_edge[m]) : "",
                   fmt::format("{}", seam.all[m].profiles)};
      for (const int within : seam.all[m].within) row.push_back(fmt::format("{}", within));
      text += core::CsvLine(row);
    }
  }
  return text;
}

std::string RunRows(const std::vector<RunResult>& runs, const std::vector<Record>& records) {
  std::string text =
      "run,method,hazard,end,reached_hazard,stopped_early,settled_mm,mean_error_mm,p95_error_mm,"
      "max_error_mm,share_within_1mm\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunResult& run = runs[i];
    text += core::CsvLine(
        {fmt::format("{}", run.run), TitleOf(run.method), std::string(core::Word(run.hazard)),
         Failed(records[i]) ? records[i].result.outcome : std::string(core::Word(run.end)),
         run.reached_hazard ? "1" : "0", run.stopped_early ? "1" : "0",
         Fixed(run.settled_m * core::kMmPerM, 1), Fixed(run.mean_error_m * core::kMmPerM, 4),
         Fixed(run.p95_error_m * core::kMmPerM, 4), Fixed(run.max_error_m * core::kMmPerM, 4),
         Fixed(run.share_within_1mm, 5)});
  }
  return text;
}

// The text of a published table; empty where there is none. Read once, so that a broken one shows.
std::string PublishedText(const std::filesystem::path& file) {
  if (file.empty()) return "";
  std::string text = core::ReadFile(file);
  ReadPublished(text, file.string());
  return text;
}

std::string ShapeWords(std::vector<EdgeShape> shapes) {
  std::ranges::sort(shapes);
  shapes.erase(std::unique(shapes.begin(), shapes.end()), shapes.end());
  std::vector<std::string> words;
  for (const EdgeShape shape : shapes) words.emplace_back(core::Word(shape));
  return core::Join(words, ",");
}

}  // namespace

void AddTo(Stamp& stamp, const SeamExperiment& experiment) {
  stamp.identity["sensor_hash"] = core::Hex(core::Fnv1a(core::ReadFile(experiment.sensor_file)));
  stamp.data["kind"] = core::Word(experiment.kind);
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
  const Facts facts = FactsOf(stamp);
  experiment::Report report;
  if (facts.kind == SeamKind::kRates) {
    const auto seams = SeamsOf(facts, records);
    report.sections = {RatesSection(facts, seams), PlacesSection(facts, seams),
                       ShapesSection(facts, seams), ErrorsSection(facts, seams)};
    report.files.emplace_back("rows.csv", SeamRows(seams));
    report.published = FiguresOf(facts, seams);
    for (auto& figure : TimesOf(facts, records, seams)) {
      report.published.push_back(std::move(figure));
    }
  } else {
    const auto runs = RunsOf(records);
    report.sections = {facts.kind == SeamKind::kTracks ? TracksSection(facts, runs)
                                                       : HazardsSection(runs)};
    if (facts.beside_corners_m > 0.0) report.sections.push_back(CornersSection(facts, runs));
    if (std::ranges::any_of(runs, &RunResult::stopped_early)) {
      report.sections.push_back(EarlySection(runs));
    }
    report.files.emplace_back("rows.csv", RunRows(runs, records));
  }
  const auto failed = std::ranges::count_if(records, Failed);
  if (failed > 0) {
    report.notes.push_back(fmt::format(
        "{} of {} cases crashed or timed out; they count as not found, not followed or not stopped "
        "in time, and where on the line their edges lay is not known",
        failed, records.size()));
  }
  return report;
}

}  // namespace rangegrasp::tasks::seam_task
