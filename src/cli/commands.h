#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace rangegrasp::base {
struct KeyDoc;
}  // namespace rangegrasp::base

namespace rangegrasp::cli {

/// Adds one or several commands to the program; a command's callback does the work and throws
/// base::InputError or base::RunError.
using CommandAdder = void (*)(CLI::App& app);

/// When the program starts; --help lists commands in this order, after those below.
void AddCommand(CommandAdder adder);

void AddResultsCommands(CLI::App& app);  ///< table, trial, compare, merge
void AddRunCommand(CLI::App& app);       ///< run
void AddShellCommands(CLI::App& app);    ///< completion, man
void AddSlurmCommands(CLI::App& app);    ///< submit, status

/// A line of a listing.
struct ListEntry {
  std::string name, text;
  std::vector<std::pair<std::string, std::string>> more = {};  ///< for --json: name -> value
};
/// Of a key of a file, with its default and its values.
ListEntry EntryOf(const base::KeyDoc& key);
/// What `list` can list, by the word for it.
struct Listing {
  std::string word;
  std::string description;  ///< for --help, and the heading of the overview
  std::vector<ListEntry> (*entries)() = nullptr;
  bool in_overview = true;
  std::string (*page)() = nullptr;  ///< what is printed in place of the entries; may be null
};
void AddListing(const Listing& listing);
/// Those files in a folder of what the program comes with that have the ending, sorted.
std::vector<std::filesystem::path> ShippedFiles(const char* folder, const char* ending);

/// A library that `version` names, with its version.
void AddLibrary(const std::string& name, const std::string& version);

/// What the system `report` does for other commands; null where it is not built.
struct ReportHooks {
  /// Joins the films of several trials to one.
  void (*join_films)(const std::vector<std::filesystem::path>& films,
                     const std::filesystem::path& into) = nullptr;
  /// What a run does with its results when `run --report` asks for pages.
  /// @param run_detector  as in experiment::OpenAgain
  void (*make_report)(const std::filesystem::path& results, int jobs, bool run_detector) = nullptr;
};
ReportHooks& Hooks();

/// From here on this process, but none that it forks, ends with a message and exit code 1 where it
/// would crash: libraries abort or write to address 0 where there is no memory.
void ReportCrashes();

/// The program: reads the arguments, runs the command. @return the exit code
int RunProgram(int argc, char** argv);

}  // namespace rangegrasp::cli
