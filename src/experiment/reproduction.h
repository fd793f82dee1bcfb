#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/report.h"

namespace rangegrasp::experiment {

/// A published table of the dissertation and the experiment that gives its figures.
struct PublishedTable {
  std::string number;  ///< "5.2", "5.2-as-published"
  std::string title;
  std::string experiment;  ///< its name
  std::string key;         ///< of PublishedFigure
  int cases = 0;           ///< of the whole experiment's groups
  int trials = 0;          ///< in the experiment's file, as --trials counts
  int short_trials = 0;    ///< a tenth, and more where one round of what is drawn in turn needs it
  /// About what a case takes on one core: `rangegrasp reproduce --short --jobs 1`.
  double case_s = 1.0;
  std::string group = {};    ///< only its cases; empty: all
  bool is_of_times = false;  ///< its cases are run one at a time
  bool is_drawn = true;      ///< its cases depend on a seed

  int Cases(bool is_short) const { return is_short ? cases * short_trials / trials : cases; }
};

/// All tables of chapters 3 to 6, in their order. Those of one experiment share one run.
std::span<const PublishedTable> PublishedTables();

/// Those of the numbers, in the order of the dissertation; without a number all. A chapter ("5")
/// stands for its tables.
/// @throws base::InputError naming the nearest number.
std::vector<PublishedTable> ChosenTables(const std::vector<std::string>& numbers);

enum class Verdict {
  kBetter,
  kSame,  ///< no difference is shown: few trials show none
  kWorse,
  kNoFigure,  ///< nothing was counted yet; what a whole run does not count is worse
};
constexpr std::array<std::string_view, 4> WordsOf(Verdict) {
  return {"better", "same", "worse", "no figure"};
}

/// A published figure and the own one, and what the difference means.
struct Judged {
  PublishedFigure figure;
  std::string counts;              ///< what the test compares: "47 of 50, published 9 of 10"
  std::optional<double> p;         ///< two-sided; absent where nothing is tested
  std::optional<Verdict> verdict;  ///< absent in a short run
};

struct JudgedTable {
  std::vector<Judged> rows;
  double threshold = 0.0;  ///< of p: 0.05 over the number of tests (Bonferroni); 0 without any
  std::vector<std::string> tests;  ///< the tests that the rows' verdicts rest on, in words
};

/// The verdict of each row; all rows together are wrong by chance in 5 % of tables at most.
/// @param is_whole  all cases were run: a figure that is missing is worse, e.g. no grasp of an
/// object that was never detected
JudgedTable Judge(const std::vector<PublishedFigure>& figures, bool is_whole);

/// The same rows without tests and verdicts: no difference is significant in one trial a row
/// against ten published ones.
JudgedTable NotJudged(const std::vector<PublishedFigure>& figures);

/// A published table and what its experiment gave.
struct ReproducedTable {
  std::string number = {};      ///< "5.2"
  std::string title = {};       ///< "Every object alone on the table"
  std::string experiment = {};  ///< its name
  std::string left_out = {};    ///< why it was not run; empty if it was
  int done = 0;                 ///< cases that are there
  int cases = 0;                ///< that the table is of
  int crashed = 0;              ///< of those that are there, or timed out
  JudgedTable judged = {};
  std::string seeds = {};  ///< of the run
};

/// Published tables, reproduced: what `rangegrasp reproduce` writes.
struct Reproduction {
  bool is_short = false;  ///< few trials: shows that everything runs, and has no verdicts
  std::vector<ReproducedTable> tables;
  Stamp stamp;  ///< of the program, for the last line
};

/// The page: a summary of the tables, then each with its rows, the tests in words below it.
/// CSV: a line a row of any table.
Report PageOf(const Reproduction& reproduction);

}  // namespace rangegrasp::experiment
