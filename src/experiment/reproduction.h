#pragma once

#include <string>
#include <vector>

#include "experiment/report.h"
#include "experiment/stamp.h"
#include "experiment/verdict.h"

namespace rangegrasp::experiment {

/// A published table beside what its experiment gave.
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
  bool is_short = false;  ///< few trials: verdicts are weak
  std::vector<ReproducedTable> tables;
  Stamp stamp;  ///< of the program, for the last line
};

/// How many rows of a table have a verdict.
int CountOf(const ReproducedTable& table, Verdict verdict);

/// The page: a summary of the tables, then each with its rows, the tests in words below it.
/// CSV: a line a row of any table.
Report PageOf(const Reproduction& reproduction);

}  // namespace rangegrasp::experiment
