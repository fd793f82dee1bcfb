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

/// Call at program start; --help lists commands in this order.
void AddCommand(CommandAdder adder);

void AddResultsCommands(CLI::App& app);  ///< table, trial, compare, merge
void AddRunCommand(CLI::App& app);       ///< run
void AddShellCommands(CLI::App& app);    ///< completion
void AddSlurmCommands(CLI::App& app);    ///< submit, status

/// A line of a listing.
struct ListEntry {
  std::string name, text;
  std::vector<std::pair<std::string, std::string>> more = {};  ///< for --json: name -> value
};
/// The entry of a key of a file, with its default and its values.
ListEntry EntryOf(const base::KeyDoc& key);
/// A listing of the command `list`, selected by its word.
struct Listing {
  std::string word;
  std::string description;  ///< for --help, and the heading of the overview
  std::vector<ListEntry> (*entries)() = nullptr;
  bool in_overview = true;
  std::string (*page)() = nullptr;  ///< text printed in place of the entries; may be null
};
void AddListing(const Listing& listing);
/// The files with an extension in a folder of the data that ships with the program, sorted.
std::vector<std::filesystem::path> ShippedFiles(const char* folder, const char* ending);

/// Adds a library and its version to the output of `version`.
void AddLibrary(const std::string& name, const std::string& version);

/// Writes the report pages of a run's results, for `run --report`; null if the system `report` is
/// not built.
/// @param run_detector  as in experiment::OpenAgain
using ReportMaker = void (*)(const std::filesystem::path& results, int jobs, bool run_detector);
ReportMaker& MakeReportFor();

/// From now on this process, but none that it forks, exits with a message and code 1 if it would
/// crash: libraries abort or write to address 0 if they run out of memory.
void ReportCrashes();

/// The program: reads the arguments, runs the command. @return the exit code
int RunProgram(int argc, char** argv);

}  // namespace rangegrasp::cli
