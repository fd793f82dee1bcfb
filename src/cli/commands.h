#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace rangegrasp::cli {

/// Adds one or several commands to the program; a command's callback does the work and throws
/// base::InputError or base::RunError.
using CommandAdder = void (*)(CLI::App& app);

/// When the program starts; --help lists commands in this order, after those below.
void AddCommand(CommandAdder adder);
const std::vector<CommandAdder>& AddedCommands();

// Each stands in the source of its name (AddRunCommand in run_command.cpp).
void AddListCommand(CLI::App& app);      ///< list
void AddResultsCommands(CLI::App& app);  ///< table, trial, compare, merge
void AddRunCommand(CLI::App& app);       ///< run
void AddShellCommands(CLI::App& app);    ///< completion, man
void AddSlurmCommands(CLI::App& app);    ///< submit, status
void AddVersionCommand(CLI::App& app);   ///< version

/// What `list` can list, by the word for it.
struct Listing {
  std::string word;
  std::string description;  ///< for --help, and the heading of the overview
  std::string (*text)() = nullptr;
  bool in_overview = true;
};
void AddListing(const Listing& listing);
/// A line of a listing.
std::string ListingLine(const std::string& name, const std::string& text);
/// Those files in a folder of what the program comes with that have the ending, sorted.
std::vector<std::filesystem::path> ShippedFiles(const char* folder, const char* ending);

/// A library that `version` names, with its version.
void AddLibrary(const std::string& name, const std::string& version);

/// What joins the films of several trials to one.
using FilmJoiner = void (*)(const std::vector<std::filesystem::path>& films,
                            const std::filesystem::path& into);
void SetFilmJoiner(FilmJoiner joiner);

/// What a run does with its results when `run --report` asks for pages.
using ReportMaker = void (*)(const std::filesystem::path& results, int jobs);
void SetReportMaker(ReportMaker maker);
/// @throws base::NotBuilt without one.
ReportMaker GetReportMaker();

/// The program: reads the arguments, runs the command. @return the exit code
int RunProgram(int argc, char** argv);

}  // namespace rangegrasp::cli
