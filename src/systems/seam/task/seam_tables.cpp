#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "base/error.h"
#include "base/file.h"
#include "base/units.h"
#include "base/words.h"
#include "experiment/statistics.h"
#include "seam/task/seam_score.h"

namespace rangegrasp::seam {
namespace {

using experiment::Fixed;
using experiment::PercentText;
using experiment::PublishedFigure;
using experiment::Record;
using experiment::Section;
using experiment::Stamp;
using Cells = std::vector<std::string>;

// ---- what the tables of rates and those of runs have in common ----

// Name -> numbers of a published table, whose first column names the row.
using Published = std::map<std::string, std::vector<std::optional<double>>>;

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

std::optional<double> NumberAt(const Published& published, const std::string& row, std::size_t i) {
  const auto known = published.find(row);
  if (known == published.end() || i >= known->second.size()) return std::nullopt;
  return known->second[i];
}

// Numbers in the stamp.
constexpr const char* kProfilesPerSeam = "profiles_per_seam";
constexpr const char* kColumnsPerMeter = "columns_per_m";
constexpr const char* kWantedLength = "wanted_m";

// Data of the experiment from the stamp.
struct Facts {
  SeamKind kind;
  int profiles_per_seam;
  std::size_t millimeter;  // the tolerance that is nearest to 1 mm: 12 px or 18 px
  double wanted_m;         // length of a run's path to be followed after settling
  Published reference, improvements, runtimes;
};

std::size_t NearestTolerance(double px) {
  const auto best = std::ranges::min_element(
      kTolerances_px, {}, [px](double tolerance) { return std::abs(tolerance - px); });
  return static_cast<std::size_t>(best - kTolerances_px.begin());
}

// A number of the stamp.
template <typename Number>
Number StampNumber(const std::string& text, const char* name) {
  if (const auto number = base::NumberFrom<Number>(text)) return *number;
  throw base::InputError(
      fmt::format("stamp '{}': '{}' must be a number", name, base::Excerpt(text)));
}

Facts FactsOf(const Stamp& stamp) {
  const auto at = [&](const char* name) { return experiment::Need(stamp.data, name); };
  return {base::FromWord<SeamKind>(at("kind"), "kind"),
          StampNumber<int>(at(kProfilesPerSeam), kProfilesPerSeam),
          NearestTolerance(base::kMm * StampNumber<double>(at(kColumnsPerMeter), kColumnsPerMeter)),
          StampNumber<double>(at(kWantedLength), kWantedLength),
          ReadPublished(at("reference"), at("reference_file")),
          ReadPublished(at("improvements"), at("improvements_file")),
          ReadPublished(at("runtimes"), at("runtimes_file"))};
}

bool Failed(const Record& record) {
  return record.result.outcome == experiment::kCrashed ||
         record.result.outcome == experiment::kTimedOut;
}

std::string Text(auto number) { return fmt::format("{}", number); }

// A section without rows; all columns except the name are right-aligned.
Section NumberSection(const std::string& title, const Cells& header) {
  Section section{title, {header, std::vector<bool>(header.size(), false), {}}};
  section.grid.left[0] = true;
  return section;
}

// A part of a whole, from one of several independent samples: a seam's profiles that were found, or
// the part of a run's wanted length that was followed.
struct Part {
  double part, whole;
};

// The standard error of sum(part) / sum(whole) in per cent, from the scatter of the parts about it
// (Cochran 1977, eq. 6.9: the ratio estimator). Profiles of one seam are correlated, seams are not:
// counted by single profiles, the error would be far too small. "-" for fewer than two.
std::string ErrorCell(const std::vector<Part>& parts) {
  double part = 0.0, whole = 0.0;
  for (const Part& p : parts) {
    part += p.part;
    whole += p.whole;
  }
  double squares = 0.0;
  for (const Part& p : parts) squares += std::pow(p.part - part / whole * p.whole, 2);
  const auto n = static_cast<double>(parts.size());
  const double error = 100.0 * (std::sqrt(n / (n - 1.0) * squares) / whole);
  return std::isfinite(error) ? Fixed(error, 2) : "-";
}

// ---- rates of seams ----

// An unfinished seam counts as one with an edge in every profile, found in none.
std::vector<SeamResult> SeamsOf(const Facts& facts, const std::vector<Record>& records) {
  std::vector<SeamResult> seams;
  for (const Record& record : records) {
    const SeamParams params = ParamsFrom(record.which.params);
    if (!Failed(record)) {
      seams.push_back(SeamResultFrom(params, record.result.data));
      continue;
    }
    SeamResult& failed = seams.emplace_back();
    failed.params = params;
    failed.profiles = facts.profiles_per_seam;
    if (params.shape == EdgeShape::kNone) continue;
    for (Tally& tally : failed.all) tally.profiles = failed.profiles;
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

std::string ShareWithin(const Tally& tally, std::size_t tolerance) {
  return PercentText(tally.within[tolerance], tally.profiles, 2);
}

Section RatesSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  const Tallies sum = Sum(seams, &SeamResult::all);
  Cells header = {"method"};
  for (const double tolerance : kTolerances_px) {
    header.push_back("+-" + Fixed(tolerance, 0) + " px");
    header.push_back("published");
  }
  Section section = NumberSection(
      fmt::format("Detection rate in % within a tolerance, for {} with an edge, from {}",
                  base::Counted(sum[0].profiles, "profile"), base::Counted(seams.size(), "seam")),
      std::move(header));
  for (std::size_t m = 0; m < kMethods; ++m) {
    Cells row = {MethodTitle(m)};
    for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
      const auto published = NumberAt(facts.reference, PublishedRow(m), t);
      row.push_back(ShareWithin(sum[m], t));
      row.push_back(published ? Fixed(*published, 1) : "-");
    }
    section.grid.rows.push_back(row);
  }
  return section;
}

Section PlacesSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  Section section = NumberSection("Within 1 mm, in %, by position of the edge on the line",
                                  {"method", "all", "centre", "boundary"});
  for (std::size_t m = 0; m < kMethods; ++m) {
    Cells& row = section.grid.rows.emplace_back(Cells{MethodTitle(m)});
    for (const auto member : {&SeamResult::all, &SeamResult::center, &SeamResult::boundary}) {
      row.push_back(ShareWithin(Sum(seams, member)[m], facts.millimeter));
    }
  }
  for (const auto& [name, numbers] : facts.improvements) {
    const auto share = NumberAt(facts.improvements, name, 0);
    section.grid.rows.push_back({"published: " + name, share ? Fixed(*share, 2) : "-", "", ""});
  }
  return section;
}

Section ShapesSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  Cells header = {"shape", "seams", "profiles"};
  for (std::size_t m = 0; m < kMethods; ++m) header.push_back(MethodTitle(m));
  for (const auto decision : kDecisions) header.push_back("no edge: " + TitleOf(decision));
  Section section =
      NumberSection("By shape of the edge: within 1 mm, in %; reported as having no edge, in %",
                    std::move(header));
  std::set<EdgeShape> shapes;
  for (const SeamResult& seam : seams) shapes.insert(seam.params.shape);
  for (const EdgeShape shape : shapes) {
    std::vector<SeamResult> alike = seams;
    std::erase_if(alike, [shape](const SeamResult& seam) { return seam.params.shape != shape; });
    int profiles = 0;
    std::array<int, kMethods> no_edge{};
    for (const SeamResult& seam : alike) {
      profiles += seam.profiles;
      for (std::size_t m = 0; m < kMethods; ++m) no_edge[m] += seam.no_edge[m];
    }
    Cells& row = section.grid.rows.emplace_back(
        Cells{std::string(base::Word(shape)), Text(alike.size()), Text(profiles)});
    for (const Tally& tally : Sum(alike, &SeamResult::all)) {
      row.push_back(ShareWithin(tally, facts.millimeter));
    }
    for (std::size_t m = kAlone; m < kMethods; ++m) {
      row.push_back(PercentText(no_edge[m], profiles, 2));
    }
  }
  return section;
}

Section ErrorsSection(const Facts& facts, const std::vector<SeamResult>& seams) {
  Section section = NumberSection("Within 1 mm, in %, with its standard error over seams",
                                  {"method", "within 1 mm", "+-", "profiles", "seams"});
  for (std::size_t m = 0; m < kMethods; ++m) {
    std::vector<Part> parts;
    for (const SeamResult& seam : seams) {
      const Tally& tally = seam.all[m];
      if (tally.profiles == 0) continue;
      parts.push_back({static_cast<double>(tally.within[facts.millimeter]),
                       static_cast<double>(tally.profiles)});
    }
    const Tally sum = Sum(seams, &SeamResult::all)[m];
    section.grid.rows.push_back({MethodTitle(m), ShareWithin(sum, facts.millimeter),
                                 ErrorCell(parts), Text(sum.profiles), Text(parts.size())});
  }
  return section;
}

// ---- the published tables' figures ----

PublishedFigure FigureOf(const std::string& row, double published,
                         const std::vector<SeamResult>& seams, Tallies SeamResult::*member,
                         std::size_t method, std::size_t tolerance) {
  experiment::ClustersEvidence evidence;
  for (const SeamResult& seam : seams) {
    const Tally& tally = (seam.*member)[method];
    evidence.own.push_back({tally.within[tolerance], tally.profiles});
  }
  PublishedFigure figure{
      .row = row, .unit = "%", .digits = 2, .published = published, .evidence = evidence};
  const Tally sum = Sum(seams, member)[method];
  if (sum.profiles > 0) figure.own = 100.0 * sum.within[tolerance] / sum.profiles;
  return figure;
}

// Rows of table 3.5 and the rates that they state. Fig. 3.35 (b) shows the places for the improved
// method.
constexpr std::array<std::tuple<const char*, DecisionMethod, Tallies SeamResult::*>, 4>
    kImprovements = {
        {{"three-lines combined result within 1 mm (original voting)", DecisionMethod::kVoting,
          &SeamResult::all},
         {"three-lines with sum of weights and historic edge positions", DecisionMethod::kWeights,
          &SeamResult::all},
         {"edge in the centre of the scan line", DecisionMethod::kWeights, &SeamResult::center},
         {"edge at the boundary of the scan line", DecisionMethod::kWeights,
          &SeamResult::boundary}}};

std::vector<PublishedFigure> FiguresOf(const Facts& facts, const std::vector<SeamResult>& seams) {
  std::vector<PublishedFigure> figures;
  for (std::size_t m = 0; m < kMethods; ++m) {
    for (std::size_t t = 0; t < kTolerances_px.size(); ++t) {
      const auto published = NumberAt(facts.reference, PublishedRow(m), t);
      if (!published) continue;
      figures.push_back(FigureOf(fmt::format("{}, +-{:.0f} px", PublishedRow(m), kTolerances_px[t]),
                                 *published, seams, &SeamResult::all, m, t));
    }
  }
  for (const auto& [name, decision, where] : kImprovements) {
    const auto published = NumberAt(facts.improvements, name, 0);
    if (!published) continue;
    figures.push_back(FigureOf(name, *published, seams, where,
                               kAlone + static_cast<std::size_t>(decision), facts.millimeter));
    figures.back().key = "improvements";
  }
  return figures;
}

// Table 3.1: time of a step per profile, on average over all profiles.
std::vector<PublishedFigure> TimesOf(const Facts& facts, const std::vector<Record>& records,
                                     const std::vector<SeamResult>& seams) {
  std::vector<PublishedFigure> figures;
  for (const char* step : kTimedSteps) {
    const auto published = NumberAt(facts.runtimes, step, 1);  // the second number is the average
    if (!published) continue;
    double seconds = 0.0;
    int profiles = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
      for (const auto& [name, s] : records[i].result.seconds) {
        if (name != step) continue;
        seconds += s;
        profiles += seams[i].profiles;
      }
    }
    figures.push_back({.row = fmt::format("{}, average", step),
                       .unit = "ms",
                       .digits = 4,
                       .lower_is_better = true,
                       .published = *published,
                       .evidence = experiment::TimesEvidence{profiles},
                       .key = "runtimes"});
    if (profiles > 0) figures.back().own = 1e3 * seconds / profiles;
  }
  return figures;
}

experiment::Report RatesReport(const Facts& facts, const std::vector<Record>& records) {
  const auto seams = SeamsOf(facts, records);
  experiment::Report report;
  report.sections = {RatesSection(facts, seams), PlacesSection(facts, seams),
                     ShapesSection(facts, seams), ErrorsSection(facts, seams)};
  report.notes.emplace_back(
      "'as published' uses only the dissertation's rules. The sensor's noise was fitted to the "
      "published rates of the three single methods, so their agreement is not independent "
      "evidence");
  report.published = FiguresOf(facts, seams);
  std::ranges::move(TimesOf(facts, records, seams), std::back_inserter(report.published));
  return report;
}

// ---- closed loops and hazards ----

// In an unfinished run nothing was followed, or the head did not stop for the hazard.
std::vector<RunResult> RunsOf(const std::vector<Record>& records) {
  std::vector<RunResult> runs;
  for (const Record& record : records) {
    const SeamParams params = ParamsFrom(record.which.params);
    if (!Failed(record)) {
      runs.push_back(RunResultFrom(params, record.result.data));
      continue;
    }
    RunResult& failed = runs.emplace_back();
    failed.params = params;
    failed.end = TrackEnd::kLost;
    failed.reached_hazard = params.hazard != Hazard::kNone;
    failed.stopped_early = !failed.reached_hazard;
  }
  return runs;
}

// The runs of each decision method that controlled any.
std::map<DecisionMethod, std::vector<RunResult>> ByMethod(const std::vector<RunResult>& runs) {
  std::map<DecisionMethod, std::vector<RunResult>> by_method;
  for (const RunResult& run : runs) by_method[run.params.method.value()].push_back(run);
  return by_method;
}

// Means over the length of all runs, and the maximum error of all runs.
Cells TracksRow(const Facts& facts, const std::vector<RunResult>& runs, DecisionMethod method) {
  double mean = 0.0, max = 0.0, within = 0.0, length = 0.0;
  std::vector<Part> parts;
  for (const RunResult& run : runs) {
    length += run.settled_m;
    mean += run.settled_m * run.mean_error_m;
    max = std::max(max, run.max_error_m);
    within += run.settled_m * run.share_within_1mm;
    parts.push_back({run.settled_m * run.share_within_1mm, facts.wanted_m});
  }
  const double wanted = static_cast<int>(runs.size()) * facts.wanted_m;
  return {TitleOf(method),
          Text(runs.size()),
          Text(std::ranges::count(runs, TrackEnd::kDone, &RunResult::end)),
          Text(std::ranges::count(runs, true, &RunResult::stopped_early)),
          Fixed(mean / std::max(1e-9, length) * base::kMmPerM, 3),  // zero length gives 0
          Fixed(max * base::kMmPerM, 3),
          Fixed(within / wanted * 100.0, 2),
          ErrorCell(parts)};
}

Section TracksSection(const Facts& facts, const std::vector<RunResult>& runs) {
  Section section =
      NumberSection("Closed loop after the first 100 mm: error of the seam's distance to the edge",
                    {"method", "runs", "to the end", "stopped early", "mean mm", "max mm",
                     "within 1 mm, % of the wanted length", "+-"});
  for (const auto& [method, its_runs] : ByMethod(runs)) {
    section.grid.rows.push_back(TracksRow(facts, its_runs, method));
  }
  return section;
}

Cells HazardsRow(std::vector<RunResult> runs, Hazard hazard, DecisionMethod method) {
  std::erase_if(runs, [hazard](const RunResult& run) { return run.params.hazard != hazard; });
  const auto early = static_cast<int>(std::ranges::count(runs, true, &RunResult::stopped_early));
  const auto found = static_cast<int>(std::ranges::count_if(runs, [](const RunResult& run) {
    return !run.reached_hazard && run.end != TrackEnd::kDone && !run.stopped_early;
  }));
  const int seen = static_cast<int>(runs.size()) - early;
  Cells row = {std::string(base::Word(hazard)), TitleOf(method), Text(runs.size())};
  for (const int count : {early, seen, found, seen - found}) row.push_back(Text(count));
  row.push_back(PercentText(found, seen, 2));
  return row;
}

Section HazardsSection(const std::vector<RunResult>& runs) {
  Section section =
      NumberSection("Hazards: detected, with the head stopped before the needle reached them",
                    {"hazard", "method", "runs", "at rest before it was in view", "came into view",
                     "found in time", "reached", "in time %"});
  for (const Hazard hazard : {Hazard::kMatEnd, Hazard::kObstacle}) {
    for (const auto& [method, its_runs] : ByMethod(runs)) {
      section.grid.rows.push_back(HazardsRow(its_runs, hazard, method));
    }
  }
  return section;
}

// ---- the stamp ----

// A published table is also parsed here, so that an invalid one is found before the run.
void AddPublished(const std::string& name, const std::filesystem::path& file, Stamp& stamp) {
  const std::string text = file.empty() ? "" : experiment::PublishedText(file);
  ReadPublished(text, file.string());
  stamp.data[name] = text;
  stamp.data[name + "_file"] = file.filename().string();
}

}  // namespace

void AddTo(Stamp& stamp, const SeamExperiment& experiment) {
  stamp.identity["sensor_hash"] = base::Hex(base::Fnv1a(base::ReadFile(experiment.sensor_file)));
  stamp.data["kind"] = base::Word(experiment.kind);
  stamp.data[kProfilesPerSeam] = Text(experiment.record.profiles);
  stamp.data[kColumnsPerMeter] = Text(experiment.sensor.line.columns_per_m);
  stamp.data[kWantedLength] = Text(experiment.track.length_m - kSettle_m);
  AddPublished("reference", experiment.reference, stamp);
  AddPublished("improvements", experiment.improvements, stamp);
  AddPublished("runtimes", experiment.runtimes, stamp);
}

experiment::Report ReportOf(const Stamp& stamp, const std::vector<Record>& records) {
  const Facts facts = FactsOf(stamp);
  experiment::Report report;
  if (facts.kind == SeamKind::kRates) report = RatesReport(facts, records);
  if (facts.kind == SeamKind::kTracks) report.sections = {TracksSection(facts, RunsOf(records))};
  if (facts.kind == SeamKind::kHazards) report.sections = {HazardsSection(RunsOf(records))};
  const auto failed = std::ranges::count_if(records, Failed);
  if (failed > 0) {
    report.notes.push_back(
        fmt::format("{} of {} cases crashed or timed out; they count as not found, not followed or "
                    "not stopped in time, and the positions of their edges on the line are unknown",
                    failed, records.size()));
  }
  return report;
}

}  // namespace rangegrasp::seam
