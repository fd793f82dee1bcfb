#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiment/report.h"
#include "experiment/task.h"
#include "parts/method.h"

namespace rangegrasp::parts_task {

/// The tables of an experiment with parts: both metrics with their standard errors, by class and
/// overall, for the models apart from those of tuning and for all; computation times beside
/// published table 6.1; what failed. Files: the rows, figures 6.19 to 6.22 as CSV and SVG.
experiment::Report PartsReport(const experiment::Stamp& stamp,
                               const std::vector<experiment::Record>& records);

/// Published table 6.1 from CSV text "method,seconds"; empty text has none.
/// @throws base::InputError naming `name` and the line.
std::map<parts::Method, double> PublishedSeconds(const std::string& csv, const std::string& name);

}  // namespace rangegrasp::parts_task
