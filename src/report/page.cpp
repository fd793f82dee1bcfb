#include "report/page.h"

#include <array>
#include <cstdlib>

#include "core/error.h"
#include "core/file.h"
#include "page_files.h"

namespace rangegrasp::report {
namespace {

constexpr const char* kIndex = "index.html";
// What marks a folder as a report's.
constexpr const char* kData = "data.js";

struct Library {
  const char* package;  // of Debian
  const char* file;
  const char* name;  // in the report
};
// Both are plain scripts: a page that is opened from disk may not load modules.
constexpr std::array kLibraries = {
    Library{"libjs-chart.js", "/usr/share/javascript/chart.js/chart.min.js", "chart.min.js"},
    Library{"libjs-chart.js", "/usr/share/doc/libjs-chart.js/copyright", "chart.copyright.txt"},
    Library{"libjs-three", "/usr/share/javascript/three/three.min.js", "three.min.js"},
    Library{"libjs-three", "/usr/share/javascript/three/examples/js/controls/OrbitControls.js",
            "OrbitControls.js"},
    Library{"libjs-three", "/usr/share/doc/libjs-three/copyright", "three.copyright.txt"}};

}  // namespace

void PrepareFolder(const std::filesystem::path& folder) {
  for (const Library& library : kLibraries) {
    if (std::filesystem::exists(library.file)) continue;
    throw core::InputError(std::string(library.file) + ": is not there, but a report needs it; " +
                           "install the Debian package " + library.package);
  }
  std::error_code error;
  const bool is_report = std::filesystem::exists(folder / kData);
  if (std::filesystem::exists(folder) && !is_report &&
      (!std::filesystem::is_directory(folder) || !std::filesystem::is_empty(folder, error))) {
    throw core::InputError(folder.string() +
                           ": holds something that is no report; --out names another folder");
  }
  for (const char* part : {"views", "meshes", "records"}) {
    std::filesystem::remove_all(folder / part, error);
  }
}

void WritePage(const std::filesystem::path& folder) {
  for (const Library& library : kLibraries) {
    core::WriteFile(folder / "lib" / library.name, core::ReadFile(library.file));
  }
  core::WriteFile(folder / "plots.js", internal::kPlotsJs);
  core::WriteFile(folder / "report.css", internal::kReportCss);
  core::WriteFile(folder / "report.js", internal::kReportJs);
  core::WriteFile(folder / "view.js", internal::kViewJs);
  core::WriteFile(folder / kIndex, internal::kIndexHtml);
}

}  // namespace rangegrasp::report
