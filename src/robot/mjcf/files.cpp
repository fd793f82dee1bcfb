#include "robot/mjcf/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace rangegrasp::mjcf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 32;  // inside each other; scene, arm and hand are three
constexpr int kMaxLevels = 500;        // of elements; the engine's parser has the same limit
constexpr double kMaxValues = 8192.0 * 8192.0;  // of a texture or height field: 270 MB as floats

/// A file with those that it includes, of which the engine makes one model.
struct Unit {
  fs::path folder;                   // of the first file
  std::set<fs::path> asset_folders;  // where the engine looks for meshes and textures
};

struct SourceFile {
  fs::path path;
  std::string text;
};

[[noreturn]] void Fail(const SourceFile& file, const pugi::xml_node& node,
                       const std::string& what) {
  const auto at = std::max<std::ptrdiff_t>(0, node.offset_debug());
  throw base::InputError(fmt::format("{}:{}: {}", file.path.string(),
                                     LineAt(file.text, static_cast<std::size_t>(at)), what));
}

/// The product of an attribute's numbers; 1 if there are none.
double Product(const pugi::xml_node& node, const char* attribute) {
  std::istringstream numbers(node.attribute(attribute).value());
  double product = 1.0;
  for (double number = 0.0; numbers >> number;) product *= std::max(number, 1.0);
  return product;
}

void CheckSize(const pugi::xml_node& node, const SourceFile& file) {
  const std::string tag = node.name();
  const double values = tag == "hfield"    ? Product(node, "nrow") * Product(node, "ncol")
                        : tag == "texture" ? Product(node, "width") * Product(node, "height")
                                           : 0.0;
  if (values <= kMaxValues) return;
  Fail(file, node,
       fmt::format("<{}>: has {:.3g} values, {:.3g} (8192 x 8192) are the maximum", tag, values,
                   kMaxValues));
}

void CheckAsset(const pugi::xml_node& node, const SourceFile& file, const Unit& unit) {
  for (const pugi::xml_attribute& attribute : node.attributes()) {
    const std::string name = attribute.value();
    if (!std::string_view(attribute.name()).starts_with("file") || name.empty()) continue;
    for (const fs::path& folder : unit.asset_folders) {
      const fs::path path = folder / name;
      std::error_code error;
      // Another of these folders may have a folder of that name.
      const std::string why = fs::is_directory(path, error) ? "" : base::WhyUnfit(path);
      if (!why.empty()) {
        Fail(file, node, fmt::format("{}=\"{}\": {}", attribute.name(), name, why));
      }
    }
  }
}

class FileCheck {
 public:
  void Read(const fs::path& path, Unit& unit) {
    const fs::path same = fs::canonical(path);
    if (!read_.insert(same).second) return;
    open_.push_back(same);
    const SourceFile file{path, base::ReadFile(path)};
    pugi::xml_document document;
    // Of what is not XML, the engine names the line; here, the part before it is read.
    document.load_buffer(file.text.data(), file.text.size());
    unit.asset_folders.insert({unit.folder, path.parent_path()});
    for (const auto& found : document.select_nodes("//compiler")) {
      for (const char* key : {"assetdir", "meshdir", "texturedir"}) {
        unit.asset_folders.insert(unit.folder / found.node().attribute(key).value());
      }
    }
    Walk(document, file, unit, 0);
    open_.pop_back();
  }

 private:
  void Walk(const pugi::xml_node& node, const SourceFile& file, Unit& unit, int level) {
    if (level > kMaxLevels) {
      Fail(file, node, fmt::format("more than {} elements are inside each other", kMaxLevels));
    }
    for (const pugi::xml_node& child : node.children()) {
      const std::string tag = child.name();
      if (tag == "include" || tag == "model") {
        const fs::path path = Named(child, file, unit);
        if (path.empty()) continue;
        Unit attached{path.parent_path(), {}};
        Read(path, tag == "include" ? unit : attached);
        continue;
      }
      CheckSize(child, file);
      CheckAsset(child, file, unit);
      Walk(child, file, unit, level + 1);
    }
  }

  /// The file that <include> or <model> names; empty if there is none, which the engine reports.
  fs::path Named(const pugi::xml_node& node, const SourceFile& file, const Unit& unit) const {
    const std::string name = node.attribute("file").value();
    if (name.empty()) return {};
    const std::string element = fmt::format("<{} file=\"{}\">", node.name(), name);
    fs::path path = (unit.folder / name).lexically_normal();
    std::error_code error;
    // As the engine does.
    if (!fs::exists(path, error)) path = (file.path.parent_path() / name).lexically_normal();
    if (const std::string why = base::WhyUnfit(path); !why.empty()) {
      Fail(file, node, fmt::format("{}: {}", element, why));
    }
    if (!fs::is_regular_file(path, error)) return {};
    if (std::ranges::find(open_, fs::canonical(path)) != open_.end()) {
      Fail(file, node,
           element + " closes a circle of files that include or attach each other; remove it");
    }
    if (open_.size() >= kMaxFiles) {
      Fail(file, node,
           fmt::format("{}: more than {} files include or attach each other", element, kMaxFiles));
    }
    return path;
  }

  std::vector<fs::path> open_;  // canonical paths from the first file to this one
  std::set<fs::path> read_;     // the same of all that were read
};

}  // namespace

int LineAt(std::string_view text, std::size_t at) {
  return 1 + static_cast<int>(std::ranges::count(text.substr(0, at), '\n'));
}

void CheckFiles(const std::filesystem::path& mjcf) {
  base::CheckReadable(mjcf);
  if (!std::filesystem::is_regular_file(mjcf)) return;  // e.g. a pipe, which is read only once
  Unit unit{mjcf.parent_path(), {}};
  FileCheck().Read(mjcf, unit);
}

}  // namespace rangegrasp::mjcf
