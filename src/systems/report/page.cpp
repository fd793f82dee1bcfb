#include "report/page.h"

#include <array>
#include <cstdlib>

#include "base/error.h"
#include "base/file.h"
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
    throw base::InputError(std::string(library.file) + ": is not there, but a report needs it; " +
                           "install the Debian package " + library.package);
  }
  std::error_code error;
  const bool is_report = std::filesystem::exists(folder / kData);
  if (std::filesystem::exists(folder) && !is_report &&
      (!std::filesystem::is_directory(folder) || !std::filesystem::is_empty(folder, error))) {
    throw base::InputError(folder.string() +
                           ": holds something that is no report; --out names another folder");
  }
  for (const char* part : {"views", "meshes", "records"}) {
    std::filesystem::remove_all(folder / part, error);
  }
}

void WritePage(const std::filesystem::path& folder) {
  for (const Library& library : kLibraries) {
    base::WriteFile(folder / "lib" / library.name, base::ReadFile(library.file));
  }
  base::WriteFile(folder / "plots.js", internal::kPlotsJs);
  base::WriteFile(folder / "report.css", internal::kReportCss);
  base::WriteFile(folder / "report.js", internal::kReportJs);
  base::WriteFile(folder / "view.js", internal::kViewJs);
  base::WriteFile(folder / kIndex, internal::kIndexHtml);
}

}  // namespace rangegrasp::report
