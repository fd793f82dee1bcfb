#pragma once

#include <filesystem>
#include <vector>

#include "report/choose_views.h"

namespace rangegrasp::cli {

struct ReportRequest {
  std::vector<std::filesystem::path> folders;  ///< results folders, of several seeds, too
  std::filesystem::path out;
  report::ViewChoice views = report::ViewChoice::kSome;
  int jobs = 1;
};

/// Writes a report of what results folders hold. Cases that can be looked at are run again, so many
/// at the same time; who ends differently from its record is told.
/// @throws base::InputError also where several folders are of different kinds of experiments.
void MakeReport(const ReportRequest& request);

}  // namespace rangegrasp::cli
