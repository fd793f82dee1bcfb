#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <regex>

#include "cli/commands.h"
#include "cli/output.h"
#include "cli/seam_profile_file.h"
#include "core/data_folder.h"
#include "core/file.h"
#include "core/words.h"
#include "experiment/experiment.h"
#include "sim/info.h"
#include "sim/surfaces.h"
#include "tasks/grasping/options.h"
#include "tasks/kinds.h"
#include "tasks/published_tables.h"

namespace rangegrasp::cli {
namespace {

constexpr const char* kKeysPage = R"(# Experiment files

An experiment file is YAML: `key: value` lines, with keys below keys where a table says so (`physics.timestep_ms` is
`timestep_ms` below `physics`). What is not given keeps its default. The unit stands in the key's name. Paths are relative
to the file. An unknown key, a value of the wrong type or out of its range, or a file that is missing is told with its line
and the nearest valid word. `rangegrasp run FILE --set KEY=VALUE` changes any key without a change to the file.

This page is made by `rangegrasp list keys` from the code that reads the files; a test compares them.

)";

/// What can be listed, by the word for it.
struct Listing {
  std::string word;
  std::string description;  ///< for --help, and the heading of the overview
  std::string (*text)();
  bool in_overview = true;
};

std::string Line(const std::string& name, const std::string& text) {
  return fmt::format("{:<30} {}\n", name, text);
}

// Those files in a folder of what the program comes with that have the ending; their names without.
std::vector<std::filesystem::path> Shipped(const char* folder, const char* ending) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(core::DataFolder() / folder)) {
    if (entry.path().extension() == ending) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The first sentence of the comment that an experiment begins with ("Fig. 5.2" does not end one).
std::string SummaryOf(const std::filesystem::path& experiment) {
  std::string summary;
  for (const std::string& line : core::Split(core::ReadFile(experiment), '\n')) {
    if (!line.starts_with("# ")) break;
    summary += (summary.empty() ? "" : " ") + line.substr(2);
  }
  std::smatch end;
  return std::regex_search(summary, end, std::regex("\\. [A-Z]"))
             ? summary.substr(0, static_cast<std::size_t>(end.position()) + 1)
             : summary;
}

std::string Kinds() {
  std::string text;
  for (const auto& kind : tasks::AllKinds()) text += Line(kind.name, kind.description);
  return text;
}

std::string Experiments() {
  std::string text;
  for (const std::string& name : core::ExperimentNames(core::DataFolder())) {
    text += Line(name, SummaryOf(core::DataFolder() / "experiments" / (name + ".yaml")));
  }
  return text;
}

std::string Tables() {
  std::string text;
  for (const auto& table : tasks::PublishedTables()) text += Line(table.number, table.title);
  return text;
}

std::string Objects() {
  std::string text;
  for (const auto& file : Shipped("models/objects", ".xml")) {
    const std::string name = file.stem().string();
    if (file.parent_path().filename() == name) {
      text += Line(name, sim::ObjectTitle({name, file}));
    }
  }
  return text;
}

std::string Surfaces() {
  std::string text;
  for (const auto& surface : sim::ReadSurfaces(sim::ShippedSurfaces())) {
    text += Line(surface.name, fmt::format("friction of the glove {:.2f} to {:.2f}",
                                           surface.glove.low, surface.glove.high));
  }
  return text;
}

std::string Scenes() {
  std::string text;
  for (const auto& file : Shipped("scenes", ".xml")) text += file.stem().string() + "\n";
  return text;
}

std::string Sensors() {
  std::string text;
  for (const auto& file : Shipped("models/sensors", ".yaml")) text += file.stem().string() + "\n";
  return text;
}

std::string Additions() {
  std::string text;
  for (const auto& key : tasks::grasping::AdditionKeys()) text += Line(key.path, key.doc);
  return text;
}

std::string Keys() { return kKeysPage + experiment::KeysAsMarkdown(tasks::AllKinds()); }

const std::vector<Listing>& Listings() {
  static const std::vector<Listing> listings = {
      {"kinds", "kinds of experiments", Kinds},
      {"experiments", "experiments that come with the program", Experiments},
      {"tables", "published tables, for `reproduce`", Tables},
      {"objects", "objects", Objects},
      {"surfaces", "kinds of surfaces", Surfaces},
      {"scenes", "scenes", Scenes},
      {"sensors", "sensors", Sensors},
      {"additions", "keys of grasping experiments that go beyond the dissertation", Additions,
       false},
      {"keys", "every key of experiment files: the page docs/experiment-file.md", Keys, false},
      {"formats", "every key of formats of profiles: the page docs/profile-formats.md",
       ProfileKeysPage, false}};
  return listings;
}

std::string TextOf(const std::string& word) {
  std::string text;
  for (const Listing& listing : Listings()) {
    if (listing.word == word) return listing.text();
    if (word.empty() && listing.in_overview) {
      text += listing.description + ":\n" + listing.text() + "\n";
    }
  }
  return text;
}

}  // namespace

void AddListCommand(CLI::App& app) {
  auto* command = app.add_subcommand("list", "What there is: experiments, objects, keys, ...");
  auto what = std::make_shared<std::string>();
  std::vector<std::string> words;
  std::string footer = "Example: rangegrasp list objects";
  for (const Listing& listing : Listings()) {
    words.push_back(listing.word);
    footer += fmt::format("\n  {:<12} {}", listing.word, listing.description);
  }
  command->add_option("what", *what, "one of the words below; without it an overview")
      ->check(CLI::IsMember(words));
  command->footer(footer);
  command->callback([what] { WriteTables(TextOf(*what)); });
}

}  // namespace rangegrasp::cli
