#include "sim/check/internal/source_lines.h"

#include <algorithm>
#include <pugixml.hpp>
#include <vector>

#include "base/error.h"
#include "base/file.h"

namespace rangegrasp::check::internal {
namespace {

// Files that attach each other in a ring are the engine's to refuse.
constexpr int kMaxDepth = 8;

bool Below(const pugi::xml_node& node, const char* tag) {
  for (pugi::xml_node n = node.parent(); n; n = n.parent()) {
    if (std::string(n.name()) == tag) return true;
  }
  return false;
}

// The kind of an element that has a name of its own; empty for all others.
std::string KindOf(const pugi::xml_node& node) {
  const std::string tag = node.name();
  const std::string parent = node.parent().name();
  if (parent == "actuator" || parent == "sensor") return parent;
  if (tag == "tuple" || tag == "numeric" || tag == "mesh") return tag;
  const bool in_world = Below(node, "worldbody");
  if (in_world && tag == "freejoint") return "joint";
  for (const char* kind : {"body", "joint", "geom", "site", "camera"}) {
    if (in_world && tag == kind) return kind;
  }
  return "";
}

std::string NameOf(const pugi::xml_node& node) {
  const std::string name = node.attribute("name").value();
  const std::string file = node.attribute("file").value();
  if (!name.empty() || std::string(node.name()) != "mesh") return name;
  return std::filesystem::path(file).stem().string();
}

// A joint and those of all bodies that its own hangs on.
int JointsAbove(const pugi::xml_node& joint) {
  int count = 0;
  for (pugi::xml_node n = joint.parent(); n; n = n.parent()) {
    for (const pugi::xml_node& child : n.children("joint")) {
      count += std::string(n.name()) == "body" && child ? 1 : 0;
    }
  }
  return count;
}

std::string Suffix(const std::string& name) { return name.substr(name.find_last_of('/') + 1); }

}  // namespace

struct SourceLines::Reader {
  SourceLines& lines;

  // What one file says of the models that it attaches.
  struct File {
    std::filesystem::path path;
    std::string text;
    std::string prefix;
    int depth;
    bool own;  // not attached
    std::map<std::string, std::filesystem::path> models;

    int LineOf(const pugi::xml_node& node) const {
      const auto end = text.begin() + std::max<std::ptrdiff_t>(0, node.offset_debug());
      return 1 + static_cast<int>(std::count(text.begin(), end, '\n'));
    }
  };

  void Read(const std::filesystem::path& path, const std::string& prefix, int depth, bool own) {
    if (depth > kMaxDepth || !std::filesystem::is_regular_file(path)) return;
    File file{path.lexically_normal(), base::ReadFile(path), prefix, depth, own, {}};
    pugi::xml_document document;
    const auto read = document.load_buffer(file.text.data(), file.text.size());
    if (!read && depth == 0) {
      throw base::InputError(path.string() + ": no XML: " + read.description());
    }
    for (const auto& found : document.select_nodes("//asset/model")) {
      const pugi::xml_node model = found.node();
      const std::filesystem::path of = path.parent_path() / model.attribute("file").value();
      file.models[model.attribute("name").value()] = of;
    }
    Walk(document.root(), file);
  }

  void Walk(const pugi::xml_node& node, File& file) {
    for (const pugi::xml_node& child : node.children()) {
      const std::string tag = child.name();
      if (tag == "include") {
        Read(file.path.parent_path() / child.attribute("file").value(), file.prefix, file.depth + 1,
             file.own);
      } else if (tag == "attach") {
        const auto model = file.models.find(child.attribute("model").value());
        if (model != file.models.end()) {
          Read(model->second, file.prefix + child.attribute("prefix").value(), file.depth + 1,
               false);
        }
      } else {
        Note(child, file);
        Walk(child, file);
      }
    }
  }

  void Note(const pugi::xml_node& node, const File& file) {
    const std::string tag = node.name();
    const bool in_world = Below(node, "worldbody");
    const std::string type = node.attribute("type").value();
    if (tag == "joint" && Below(node, "default")) {
      lines.joint_default_.try_emplace(file.path.string(), file.LineOf(node));
    }
    if (file.own && in_world && (tag == "freejoint" || (tag == "joint" && type == "free"))) {
      lines.seen_.insert("freejoint");
    } else if (file.own && in_world && tag == "joint" && type != "ball") {
      lines.longest_chain_ = std::max(lines.longest_chain_, JointsAbove(node));
    }
    const std::string kind = KindOf(node);
    const std::string name = NameOf(node);
    if (kind.empty() || name.empty()) return;
    if (file.own) lines.seen_.insert(kind + " " + Suffix(name));
    lines.lines_.try_emplace(kind + " " + file.prefix + name,
                             Line{file.path.string(), file.LineOf(node)});
  }
};

SourceLines::SourceLines(const std::filesystem::path& mjcf)
    : root_(mjcf.lexically_normal().string()) {
  if (!std::filesystem::is_regular_file(mjcf)) {
    throw base::InputError(mjcf.string() + ": no such file; an MJCF file is expected");
  }
  Reader{*this}.Read(mjcf, "", 0, true);
}

std::string SourceLines::Of(const std::string& kind, const std::string& name) const {
  const auto found = lines_.find(kind + " " + name);
  if (found == lines_.end()) return root_;
  return found->second.file + ":" + std::to_string(found->second.line);
}

std::string SourceLines::FileOf(const std::string& kind, const std::string& name) const {
  const auto found = lines_.find(kind + " " + name);
  return found == lines_.end() ? root_ : found->second.file;
}

std::string SourceLines::JointDefaultOf(const std::string& file) const {
  const auto found = joint_default_.find(file);
  return found == joint_default_.end() ? "" : file + ":" + std::to_string(found->second);
}

}  // namespace rangegrasp::check::internal
