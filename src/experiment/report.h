#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiment/grid.h"
#include "experiment/published.h"

namespace rangegrasp::experiment {

/// A table with its title.
struct Section {
  std::string title;
  Grid grid;
};

/// All that an experiment prints.
struct Report {
  std::vector<Section> sections;
  std::vector<std::string> notes;  ///< lines below the tables, as text and Markdown
  /// JSON object whose keys stand behind "experiment" and "stamp"; empty: "tables" with the
  /// sections, numbers as numbers and null for "-".
  std::string json;
  /// The one table of --format csv; without a header: the sections one after the other.
  Grid csv;
  /// Name and text of files that `run` leaves beside the store: rows, figures.
  std::vector<std::pair<std::string, std::string>> files;
  /// The figures of the published tables that the experiment names, beside the own ones.
  std::vector<PublishedFigure> published;
};

}  // namespace rangegrasp::experiment
