#pragma once

#include <filesystem>

namespace rangegrasp::report {

/// Makes a folder ready for a report: a new one, or that of an earlier report, whose data are
/// removed. @throws base::InputError if something else is in it, or the libraries that the page
/// draws with are not installed.
void PrepareFolder(const std::filesystem::path& folder);

/// Writes the page itself, and beside it in `lib` the libraries with their licences: it opens from
/// disk, on any machine, without a network.
void WritePage(const std::filesystem::path& folder);

}  // namespace rangegrasp::report
