#pragma once

#include <span>
#include <string>
#include <vector>

#include "experiment/published.h"

namespace rangegrasp::experiment {

/// A published table of the dissertation and the experiment that gives its figures.
struct PublishedTable {
  std::string number = {};  ///< as it is chosen by: "5.2", "5.2-as-published"
  std::string title = {};
  std::string experiment = {};                  ///< its name
  std::string key = experiment::kReferenceKey;  ///< of PublishedFigure
  std::vector<std::string> groups = {};         ///< only their cases; empty: all
  int cases = 0;                                ///< of the whole experiment's groups
  int trials = 0;                               ///< in the experiment's file, as --trials counts
  int short_trials = 0;  ///< a tenth, and more where one round of what is drawn in turn needs it
  double case_s = 1.0;   ///< what a case takes one core, about: for the time left
  bool is_of_times = false;  ///< its cases are run one at a time
  bool is_drawn = true;      ///< its cases depend on a seed

  int Cases(bool is_short) const { return is_short ? cases * short_trials / trials : cases; }
};

/// All tables of chapters 3 to 6, in their order. Tables of one experiment have the same groups and
/// trials, so that one run serves both.
std::span<const PublishedTable> PublishedTables();

/// Those of the numbers, in the order of the dissertation; all where there is no number. A chapter
/// ("5") stands for its tables.
/// @throws base::InputError naming the nearest number.
std::vector<PublishedTable> ChosenTables(const std::vector<std::string>& numbers);

}  // namespace rangegrasp::experiment
