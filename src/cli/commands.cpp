#include "cli/commands.h"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "base/words.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/reproduction.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kRunFailed = 1;
constexpr int kBadInput = 2;

// Messages go to stderr, results to stdout.
void SetUpLog() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("rangegrasp"));
  spdlog::set_pattern("%^%l%$: %v");
}

// What is typed becomes text of messages, files and JSON.
void CheckArguments(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (base::IsUtf8(argv[i])) continue;
    throw base::InputError(
        fmt::format("argument {} is not UTF-8: rename the file, or use a terminal with UTF-8", i));
  }
}

// For errors that do not say what they are about.
std::string CommandOf(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  return base::Join(words, " ");
}

// CLI11 would only say that a command is missing.
void CheckCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    commands.push_back(command->get_name());
  }
  base::CheckBuilt("command", argv[1]);
  throw base::InputError("unknown command '" + std::string(argv[1]) + "'; did you mean '" +
                         base::NearestWord(argv[1], commands) + "'? --help lists all");
}

// scripts/rangegrasp, where it started the program, builds the system and starts the program again
// with the same arguments, in the place of this one.
int BuildOrEnd(const base::NotBuilt& missing, char** argv) {
  if (const char* builder = std::getenv("RANGEGRASP_BUILDER")) {
    setenv("RANGEGRASP_MISSING_SYSTEM", missing.system().c_str(), /*overwrite=*/1);
    execv(builder, argv);
  }
  spdlog::error(missing.what());
  return kBadInput;
}

std::vector<CommandAdder>& Adders() {
  static std::vector<CommandAdder> adders;
  return adders;
}

std::vector<std::pair<std::string, std::string>>& Libraries() {
  static std::vector<std::pair<std::string, std::string>> libraries;
  return libraries;
}

constexpr const char* kKeysPage = R"(# Experiment files

An experiment file is YAML: `key: value` lines, with keys below keys where a table says so (`physics.timestep_ms` is
`timestep_ms` below `physics`). What is not given keeps its default. The unit stands in the key's name. Paths are relative
to the file. An unknown key, a value of the wrong type or out of its range, or a file that is missing is reported with its line
and the nearest valid word. `rangegrasp run FILE --set KEY=VALUE` changes any key without a change to the file.

This page is made by `rangegrasp list keys` from the code that reads the files; a test compares them.

)";

// The first sentence of the comment that an experiment begins with ("Fig. 5.2" does not end one).
std::string SummaryOf(const fs::path& experiment) {
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

std::string Keys() { return kKeysPage + experiment::KeysAsMarkdown(); }

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

void AddVersionCommand(CLI::App& app) {
  auto* command = app.add_subcommand("version", "Versions of the program and of its libraries.");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "as JSON");
  command->footer("Example: rangegrasp version --json");
  command->callback([json] {
    nlohmann::ordered_json versions = {{"rangegrasp", base::Version()}, {"commit", base::Commit()}};
    for (const auto& [name, version] : Libraries()) versions[name] = version;
    std::string text;
    for (const auto& [name, version] : versions.items()) {
      text += name + " " + version.get<std::string>() + "\n";
    }
    WriteResult(*json ? versions.dump(2) + "\n" : text);
  });
}

}  // namespace

void AddCommand(CommandAdder adder) { Adders().push_back(adder); }

ReportHooks& Hooks() {
  static ReportHooks hooks;
  return hooks;
}

void AddLibrary(const std::string& name, const std::string& version) {
  for (const auto& [known, of_it] : Libraries()) {
    if (known == name) return;  // of two systems that use it
  }
  Libraries().emplace_back(name, version);
}

void AddListing(const Listing& listing) { Listings().push_back(listing); }

std::string ListingLine(const std::string& name, const std::string& text) {
  return fmt::format("{:<30} {}\n", name, text);
}

std::vector<fs::path> ShippedFiles(const char* folder, const char* ending) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(base::DataFolder() / folder)) {
    if (entry.path().extension() == ending) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

int RunProgram(int argc, char** argv) {
  SetUpLog();
  // A reader that goes away (`| head`) is a failed write, which WriteResult knows.
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{"Grasping unknown objects from single-view range images, in simulation."};
  app.require_subcommand(1);
  app.set_version_flag("--version", "rangegrasp " + base::Version(),
                       "version of the program (the command `version`: of its libraries, too)");
  app.footer(
      "Example: rangegrasp run experiments/laser_single.yaml\nExit codes: 0 done, 1 a run that "
      "failed, 2 bad usage or input.");
  AddRunCommand(app);
  AddResultsCommands(app);
  AddSlurmCommands(app);
  AddListCommand(app);
  for (const CommandAdder add : Adders()) add(app);
  AddShellCommands(app);
  AddVersionCommand(app);
  try {
    CheckArguments(argc, argv);
    CheckCommand(app, argc, argv);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return kBadInput;
  } catch (const base::NotBuilt& e) {
    return BuildOrEnd(e, argv);
  } catch (const base::InputError& e) {
    spdlog::error(e.what());
    return kBadInput;
  } catch (const base::RunError& e) {
    spdlog::error(e.what());
    return kRunFailed;
  } catch (const std::bad_alloc&) {
    spdlog::error("{}: more memory is needed than there is", CommandOf(argc, argv));
    return kRunFailed;
  } catch (const std::exception& e) {  // none that the program should let through
    spdlog::error("{}: an error inside the program, which may be reported as such: {}",
                  CommandOf(argc, argv), e.what());
    return kRunFailed;
  }
}

}  // namespace rangegrasp::cli
