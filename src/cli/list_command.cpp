#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <regex>

#include "base/data_folder.h"
#include "base/file.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/kinds.h"
#include "experiment/published_tables.h"

namespace rangegrasp::cli {
namespace {

constexpr const char* kKeysPage = R"(# Experiment files

An experiment file is YAML: `key: value` lines, with keys below keys where a table says so (`physics.timestep_ms` is
`timestep_ms` below `physics`). What is not given keeps its default. The unit stands in the key's name. Paths are relative
to the file. An unknown key, a value of the wrong type or out of its range, or a file that is missing is told with its line
and the nearest valid word. `rangegrasp run FILE --set KEY=VALUE` changes any key without a change to the file.

This page is made by `rangegrasp list keys` from the code that reads the files; a test compares them.

)";

// The first sentence of the comment that an experiment begins with ("Fig. 5.2" does not end one).
std::string SummaryOf(const std::filesystem::path& experiment) {
  std::string summary;
  for (const std::string& line : base::Split(base::ReadFile(experiment), '\n')) {
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
  for (const auto& kind : experiment::AllKinds()) text += ListingLine(kind.name, kind.description);
  return text;
}

std::string Experiments() {
  std::string text;
  for (const std::string& name : base::ExperimentNames(base::DataFolder())) {
    text += ListingLine(name, SummaryOf(base::DataFolder() / "experiments" / (name + ".yaml")));
  }
  return text;
}

std::string Tables() {
  std::string text;
  for (const auto& table : experiment::PublishedTables())
    text += ListingLine(table.number, table.title);
  return text;
}

std::string Keys() { return kKeysPage + experiment::KeysAsMarkdown(experiment::AllKinds()); }

std::vector<Listing>& Listings() {
  static std::vector<Listing> listings = {
      {"kinds", "kinds of experiments", Kinds},
      {"experiments", "experiments that come with the program", Experiments},
      {"tables", "published tables, for `reproduce`", Tables},
      {"keys", "every key of experiment files: the page docs/experiment-file.md", Keys, false}};
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

void AddListing(const Listing& listing) { Listings().push_back(listing); }

std::string ListingLine(const std::string& name, const std::string& text) {
  return fmt::format("{:<30} {}\n", name, text);
}

std::vector<std::filesystem::path> ShippedFiles(const char* folder, const char* ending) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(base::DataFolder() / folder)) {
    if (entry.path().extension() == ending) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

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
