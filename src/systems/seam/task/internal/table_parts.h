#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/grid.h"
#include "experiment/task.h"
#include "seam/task/seam_score.h"

// What the tables of rates and those of runs have in common.
namespace rangegrasp::seam_task::internal {

using Cells = std::vector<std::string>;

/// Name -> numbers of a published table, whose first column names the row.
using Published = std::map<std::string, std::vector<std::optional<double>>>;

/// @throws base::InputError that names the file if it is no table.
Published ReadPublished(const std::string& csv, const std::string& name);

/// What the stamp tells of the experiment.
struct Facts {
  SeamKind kind;
  std::vector<stitching::EdgeShape> shapes;  ///< each once, in their order
  int profiles_per_seam;
  double columns_per_m;
  double wanted_m;  ///< of a run's path: what is to be followed after the head has settled
  double beside_corners_m = 0.0;  ///< of it, of a half circle
  Published reference, improvements, runtimes;
};

Facts FactsOf(const experiment::Stamp& stamp);

/// Crashed or timed out.
bool Failed(const experiment::Record& record);

/// In per cent; "-" of nothing.
std::string ShareCell(int k, int n);

/// Without rows; what is not a name stands to the right.
experiment::Grid NumberGrid(Cells header);

/// A part of a whole, one of several that were drawn independently: of a seam's profiles those that
/// were found, of a run's wanted length what was followed.
struct Part {
  double part, whole;
};

/// The standard error of sum(part) / sum(whole) in per cent, from how much the parts scatter about
/// it (Cochran 1977, eq. 6.9: the ratio estimator). Profiles of one seam resemble each other, seams
/// do not: counted as single profiles the error would come out far too small. "-" of fewer than
/// two.
std::string ErrorCell(const std::vector<Part>& parts);

}  // namespace rangegrasp::seam_task::internal
