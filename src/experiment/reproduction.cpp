#include "experiment/reproduction.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

// Columns: number, title, experiment, key, cases, trials, short trials; group, is_of_times,
// is_drawn.
std::vector<PublishedTable> MakeTables() {
  const std::string reference = kReferenceKey;
  const std::string runtimes = "runtimes";
  std::vector<PublishedTable> tables = {
      // 13 seams cover all shapes once.
      {"3.1", "Times of the edge detection", "seam_base", runtimes, 78, 78, 13},
      {"3.2", "Edges found, base sensor", "seam_base", reference, 78, 78, 13},
      {"3.3", "Edges found, three-lines sensor", "seam_three_lines", reference, 78, 78, 13},
      {"3.5", "Improvements of the edge detection", "seam_three_lines", "improvements", 78, 78, 13},
      {"4.1", "Problems of the live demo", "cylinder_demo", reference, 50, 50, 5},
      {"4.2", "Times of the cylinder detection", "cylinder_demo", runtimes, 50, 50, 5},
      {"4.3", "Fits of a cylinder at five resolutions", "cylinder_resolution", reference, 250, 50,
       5, "perfect"},
      {"4.4", "Fits of two cylinders", "cylinder_iterations", reference, 40, 20, 2, "perfect"},
      {"5.1", "Times of the calculation steps", "stage_times", reference, 20, 10, 1, "", true},
      {"5.2", "Objects alone", "laser_single", reference, 120, 10, 1},
      {"5.3", "Touching objects", "laser_touching", reference, 120, 10, 1},
      {"5.4", "Objects in a box", "laser_box", reference, 120, 10, 1},
      {"5.5", "Objects in a pile", "laser_pile", reference, 120, 10, 1},
      {"5.6", "Objects in a pile, dense stereo", "stereo_pile", reference, 60, 5, 1},
      {"5.8", "Times of the segmentations (figures 5.8 and 5.9)", "segmentation_times", reference,
       10, 5, 1, "", true},
      // Trials are counted per class and split.
      {"6.1", "Times of segmenting objects into parts", "parts_psb", runtimes, 200, 2, 1, "", false,
       false}};
  for (const char* number : {"5.2", "5.3", "5.4", "5.5", "5.6"}) {
    const auto improved = std::ranges::find(tables, number, &PublishedTable::number);
    PublishedTable published = *improved;
    published.number += "-as-published";
    published.title += ", method as published";
    published.experiment += "_as_published";
    tables.insert(improved + 1, published);
  }
  return tables;
}

bool IsChosen(const PublishedTable& table, const std::string& number) {
  return table.number == number || table.number.starts_with(number + ".");
}

}  // namespace

std::span<const PublishedTable> PublishedTables() {
  static const std::vector<PublishedTable> tables = MakeTables();
  return tables;
}

std::vector<PublishedTable> ChosenTables(const std::vector<std::string>& numbers) {
  const auto all = PublishedTables();
  std::vector<std::string> known;
  std::ranges::transform(all, std::back_inserter(known), &PublishedTable::number);
  for (const std::string& number : numbers) {
    if (std::ranges::any_of(all, [&](const auto& one) { return IsChosen(one, number); })) continue;
    throw base::InputError("table " + base::MustBeOneOf(number, known) +
                           "; a chapter (3 to 6) means all of its tables");
  }
  std::vector<PublishedTable> chosen;
  std::ranges::copy_if(all, std::back_inserter(chosen), [&](const PublishedTable& table) {
    const auto is_named = [&](const std::string& number) { return IsChosen(table, number); };
    return numbers.empty() || std::ranges::any_of(numbers, is_named);
  });
  return chosen;
}

namespace {

// Maximum probability that any verdict of a table is wrong by chance.
constexpr double kSignificance = 0.05;
// A present computer is less than 10 times as fast as the published 2 GHz Core 2 Duo for the same
// program on one core (PassMark's single-thread ratings: about 5000 and 800). A time is better only
// if it is shorter by more than this factor, and worse if it is longer.
constexpr double kComputersFactor = 10.0;

std::string CountsOf(const Count& own, const Count& published, const char* word) {
  return fmt::format("{} {} {}, published {} {} {}", own.k, word, own.n, published.k, word,
                     published.n);
}

// The test of a figure, which depends on its kind of evidence.
struct Test {
  std::optional<double> p;
  std::string counts;
  const char* words;
};

Test TestOf(const TrialsEvidence& e, const PublishedFigure&) {
  return {FisherExact(e.own.k, e.own.n, e.published.k, e.published.n),
          CountsOf(e.own, e.published, "of"),
          "counts of both: Fisher's exact test, two-sided (twice the smaller tail)"};
}

Test TestOf(const ClustersEvidence& e, const PublishedFigure& figure) {
  const double trials = EffectiveTrials(e.own);
  int filled = 0;
  int n = 0;
  for (const Count& cluster : e.own) {
    filled += cluster.n > 0 ? 1 : 0;
    n += cluster.n;
  }
  return {ScoreTest(*figure.own / 100.0, trials, figure.published / 100.0),
          fmt::format("{} in {}, equivalent to {:.0f} independent trials", n,
                      base::Counted(filled, "group"), trials),
          "published rate without counts, taken as exact: two-sided score test with the effective "
          "number of independent trials, from the variation between groups (seams)"};
}

Test TestOf(const EventsEvidence& e, const PublishedFigure&) {
  return {PoissonRatesExact(e.own.k, e.own.n, e.published.k, e.published.n),
          CountsOf(e.own, e.published, "in"),
          "events, several per run possible: exact test of two Poisson rates, two-sided"};
}

Test TestOf(const MeanEvidence& e, const PublishedFigure& figure) {
  const char* words =
      "published mean of unknown variance, taken as exact: Student's t-test of the reproduced "
      "mean, two-sided";
  if (!e.own.standard_error) return {std::nullopt, "one measurement", words};
  return {
      StudentTest(e.own, figure.published),
      fmt::format("{} measured, +- {:.{}f}", e.own.count, *e.own.standard_error, figure.digits + 1),
      words};
}

Test TestOf(const TimesEvidence& e, const PublishedFigure& figure) {
  return {
      std::nullopt,
      fmt::format("{} timed, {:.3g} times as fast", e.measured, figure.published / *figure.own),
      "times of two computers: no test; better if more than 10 times as fast (a present computer "
      "is less than 10 times as fast as the published 2 GHz Core 2 Duo), worse if slower"};
}

// Positive if what is tested is above the published value. For counts this is not always the
// direction of the figures: an overall figure is the mean of rows, its counts are their sums.
double TestedDifference(const PublishedFigure& figure) {
  const auto of_counts = [](const auto& e) {
    return 1.0 * e.own.k * e.published.n - 1.0 * e.published.k * e.own.n;
  };
  if (const auto* trials = std::get_if<TrialsEvidence>(&figure.evidence)) return of_counts(*trials);
  if (const auto* events = std::get_if<EventsEvidence>(&figure.evidence)) return of_counts(*events);
  return *figure.own - figure.published;
}

Verdict VerdictOf(const PublishedFigure& figure, const std::optional<double>& p, double threshold) {
  if (std::holds_alternative<TimesEvidence>(figure.evidence)) {
    if (*figure.own * kComputersFactor < figure.published) return Verdict::kBetter;
    return *figure.own > figure.published ? Verdict::kWorse : Verdict::kSame;
  }
  if (!p || *p >= threshold) return Verdict::kSame;
  // A test that finds a difference in one direction does not support a figure in the other.
  if (TestedDifference(figure) * (*figure.own - figure.published) <= 0.0) return Verdict::kSame;
  return (*figure.own < figure.published) == figure.lower_is_better ? Verdict::kBetter
                                                                    : Verdict::kWorse;
}

}  // namespace

JudgedTable NotJudged(const std::vector<PublishedFigure>& figures) {
  JudgedTable table;
  for (const PublishedFigure& figure : figures) {
    table.rows.push_back({figure, "", std::nullopt, std::nullopt});
  }
  return table;
}

JudgedTable Judge(const std::vector<PublishedFigure>& figures, bool is_whole) {
  JudgedTable table;
  int tests = 0;
  for (const PublishedFigure& figure : figures) {
    Judged row{figure, "no data", std::nullopt, is_whole ? Verdict::kWorse : Verdict::kNoFigure};
    if (figure.own) {
      const auto [p, counts, words] =
          std::visit([&](const auto& e) { return TestOf(e, figure); }, figure.evidence);
      row.p = p;
      row.counts = counts;
      if (std::ranges::find(table.tests, words) == table.tests.end()) table.tests.push_back(words);
    }
    tests += row.p ? 1 : 0;
    table.rows.push_back(std::move(row));
  }
  if (tests > 0) table.threshold = kSignificance / tests;
  for (Judged& row : table.rows) {
    if (row.figure.own) row.verdict = VerdictOf(row.figure, row.p, table.threshold);
  }
  return table;
}

namespace {

std::string StateOf(const ReproducedTable& table) {
  if (!table.left_out.empty()) return "left out";
  if (table.done == 0) return "not run yet";
  return table.done >= table.cases ? "done"
                                   : fmt::format("{} of {} cases", table.done, table.cases);
}

Section SummaryOf(const Reproduction& all) {
  const auto counted = [](const ReproducedTable& table, auto count) {
    return table.done > 0 ? std::optional<std::int64_t>(count) : std::nullopt;
  };
  std::vector<Column<ReproducedTable>> columns = {
      {"table", "", &ReproducedTable::number, kLeft},
      {"title", "", &ReproducedTable::title, kLeft},
      {"experiment", "", &ReproducedTable::experiment, kLeft},
      {"state", "", StateOf, kLeft},
      {"trials", "", [=](const ReproducedTable& t) { return counted(t, t.done); }},
      {"figures", "", [=](const ReproducedTable& t) { return counted(t, t.judged.rows.size()); }}};
  for (const Verdict verdict : base::ValuesOf<Verdict>()) {
    if (all.is_short) break;
    columns.push_back({std::string(base::Word(verdict)), "", [=](const ReproducedTable& t) {
                         return counted(
                             t, std::ranges::count(t.judged.rows, verdict, &Judged::verdict));
                       }});
  }
  return {all.is_short ? "Published tables, short run: shows only that everything runs"
                       : "Published tables",
          GridOf(columns, all.tables)};
}

std::optional<std::string> VerdictText(const Judged& row) {
  return row.verdict ? std::optional(std::string(base::Word(*row.verdict))) : std::nullopt;
}

std::string PText(const std::optional<double>& p) {
  if (!p) return "-";
  return *p < 1e-4 ? "< 0.0001" : Fixed(*p, 4);
}

Section SectionOf(const Reproduction& all, const ReproducedTable& table) {
  std::vector<Column<Judged>> columns = {
      {"row", "", [](const Judged& row) { return row.figure.row; }, kLeft},
      {"published", "",
       [](const Judged& row) { return Fixed(row.figure.published, row.figure.digits); }},
      {"reproduced", "",
       [](const Judged& row) {
         return row.figure.own ? Fixed(*row.figure.own, row.figure.digits) : "-";
       }},
      {"unit", "", [](const Judged& row) { return row.figure.unit; }, kLeft},
      {"better is", "",
       [](const Judged& row) { return row.figure.lower_is_better ? "lower" : "higher"; }, kLeft}};
  if (!all.is_short) {
    columns.push_back({"compared", "", &Judged::counts, kLeft});
    columns.push_back({"p", "", [](const Judged& row) { return PText(row.p); }});
    columns.push_back({"verdict", "", VerdictText, kLeft});
  }
  return {fmt::format("Table {}: {} ({})", table.number, table.title, table.experiment),
          GridOf(columns, table.judged.rows)};
}

// The tests behind the verdicts, each with the tables in which it is used.
std::vector<std::string> TestNotes(const Reproduction& all) {
  std::vector<std::pair<std::string, std::vector<std::string>>> tests;
  std::vector<std::string> thresholds;
  for (const ReproducedTable& table : all.tables) {
    for (const std::string& test : table.judged.tests) {
      auto found = std::ranges::find(tests, test, [](const auto& one) { return one.first; });
      if (found == tests.end()) found = tests.insert(tests.end(), {test, {}});
      found->second.push_back(table.number);
    }
    if (table.judged.threshold > 0.0) {
      thresholds.push_back(fmt::format("{} in {}", PText(table.judged.threshold), table.number));
    }
  }
  std::vector<std::string> notes;
  for (const auto& [test, numbers] : tests) {
    notes.push_back(fmt::format("{} ({})", test, base::Join(numbers)));
  }
  if (!thresholds.empty()) {
    notes.push_back(
        "a verdict is better or worse if p is below 0.05 divided by the number of the table's "
        "tests, and the tested counts or means differ in the same direction as the figures: " +
        base::Join(thresholds));
  }
  return notes;
}

std::vector<std::string> NotesOf(const Reproduction& all) {
  std::vector<std::string> notes;
  if (all.is_short) {
    notes.emplace_back(
        "a short run shows only that everything runs: its few trials cannot show significant "
        "differences from published figures, so there are no verdicts (run it without --short)");
  } else {
    notes.emplace_back(
        "same: no significant difference was found; this does not prove that there is none, "
        "especially with few trials");
    notes.emplace_back(
        "worse without p: all cases were run, but nothing could be counted, e.g. grasps of an "
        "object that was never detected");
  }
  std::ranges::copy(TestNotes(all), std::back_inserter(notes));
  for (const ReproducedTable& table : all.tables) {
    if (!table.left_out.empty()) {
      notes.push_back(fmt::format("{} is left out: {}", table.number, table.left_out));
    }
    if (table.crashed > 0) {
      notes.push_back(fmt::format("{}: {} of {} cases crashed or timed out; they count as failures",
                                  table.number, table.crashed, table.done));
    }
  }
  return notes;
}

}  // namespace

Report PageOf(const Reproduction& reproduction) {
  Report page;
  page.sections.push_back(SummaryOf(reproduction));
  for (const ReproducedTable& table : reproduction.tables) {
    if (!table.judged.rows.empty()) page.sections.push_back(SectionOf(reproduction, table));
  }
  page.notes = NotesOf(reproduction);
  return page;
}

}  // namespace rangegrasp::experiment
