#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/report.h"

namespace rangegrasp::experiment {

/// A published table of the dissertation and the experiment that reproduces its figures.
struct PublishedTable {
  std::string number;  ///< "5.2", "5.2-as-published"
  std::string title;
  std::string experiment;    ///< name of the experiment
  std::string key;           ///< PublishedFigure::key
  int cases = 0;             ///< number of cases, of all groups of the experiment
  int trials = 0;            ///< number in the experiment's file, as counted by --trials
  int short_trials = 0;      ///< a tenth, or more if a round of the items drawn in turn needs it
  std::string group = {};    ///< only cases of this group; empty: all
  bool is_of_times = false;  ///< table of times: its cases are run one at a time
  bool is_drawn = true;      ///< its cases depend on a seed

  int Cases(bool is_short) const { return is_short ? cases * short_trials / trials : cases; }
};

/// All tables of chapters 3 to 6, in order. Tables of the same experiment share one run.
std::span<const PublishedTable> PublishedTables();

/// The tables with these numbers, in the order of the dissertation; without a number all tables. A
/// chapter ("5") stands for all its tables.
/// @throws base::InputError naming the nearest number.
std::vector<PublishedTable> ChosenTables(const std::vector<std::string>& numbers);

enum class Verdict {
  kBetter,
  kSame,  ///< no significant difference, or not that of the figures; few trials cannot show one
  kWorse,
  kNoFigure,  ///< nothing was counted yet; after a complete run this is kWorse
};
constexpr std::array<std::string_view, 4> WordsOf(Verdict) {
  return {"better", "same", "worse", "no figure"};
}

/// A published figure, the run's own figure, and the verdict on their difference.
struct Judged {
  PublishedFigure figure;
  std::string counts;              ///< what the test compares: "47 of 50, published 9 of 10"
  std::optional<double> p;         ///< two-sided; absent if nothing is tested
  std::optional<Verdict> verdict;  ///< absent in a short run
};

struct JudgedTable {
  std::vector<Judged> rows;
  double threshold = 0.0;  ///< for p: 0.05 / number of tests (Bonferroni); 0 without any test
  std::vector<std::string> tests;  ///< descriptions of the tests behind the rows' verdicts
};

/// The verdict of each row. At most 5 % of tables have any verdict that is wrong by chance.
/// @param is_whole  all cases were run: a missing figure is worse, e.g. an object never detected
JudgedTable Judge(const std::vector<PublishedFigure>& figures, bool is_whole);

/// The same rows without tests and verdicts: with one trial per row against ten published ones, no
/// difference is significant.
JudgedTable NotJudged(const std::vector<PublishedFigure>& figures);

/// A published table and the results of its experiment.
struct ReproducedTable {
  std::string number = {};      ///< "5.2"
  std::string title = {};       ///< "Every object alone on the table"
  std::string experiment = {};  ///< name of the experiment
  std::string left_out = {};    ///< why it was not run; empty if it was
  int done = 0;                 ///< completed cases
  int cases = 0;                ///< all cases of the table
  int crashed = 0;              ///< completed cases that crashed or timed out
  JudgedTable judged = {};
};

/// The reproduced published tables, as written by `rangegrasp reproduce`.
struct Reproduction {
  bool is_short = false;  ///< few trials: only shows that everything runs, without verdicts
  std::vector<ReproducedTable> tables;
};

/// The page: a summary of the tables, then each table with its rows; the tests in words are below.
Report PageOf(const Reproduction& reproduction);

}  // namespace rangegrasp::experiment
