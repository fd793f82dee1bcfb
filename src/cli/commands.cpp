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
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "base/pattern.h"
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

pid_t reporting_process = 0;

// Calls only async-signal-safe functions.
void EndWithReport(int signal) {
  if (getpid() == reporting_process) {
    const std::string_view name = signal == SIGABRT   ? "Aborted"
                                  : signal == SIGSEGV ? "Segmentation fault"
                                                      : "Fatal signal";
    for (const std::string_view part :
         {std::string_view("error: "), name,
          std::string_view(": a library ran out of memory, or the program has a defect: please "
                           "report it\n")}) {
      if (write(STDERR_FILENO, part.data(), part.size()) < 0) break;
    }
    _exit(kRunFailed);
  }
  std::signal(signal, SIG_DFL);  // the runner records how a worker ends
  std::raise(signal);
}

// Arguments become part of messages, files and JSON.
void CheckArguments(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (base::IsUtf8(argv[i])) continue;
    throw base::InputError(
        fmt::format("argument {} is not UTF-8: rename the file, or use a UTF-8 terminal", i));
  }
}

// For errors whose message lacks the context.
std::string CommandOf(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  return base::Join(words, " ");
}

// Only the first of "--set A=1 B=2" or "--set A 1" is a value of the option; the second would count
// as a file.
void CheckEachSet(int argc, char** argv) {
  constexpr std::string_view kSet = "--set=";
  for (int i = 2; i < argc; ++i) {
    std::string set = argv[i - 1];
    if (set.starts_with(kSet)) {
      set.erase(0, kSet.size());
    } else if (std::string_view(argv[i - 2]) != "--set") {
      continue;
    }
    const std::string next = argv[i];
    std::error_code error;
    if (next.starts_with('-') || fs::exists(next, error)) continue;
    if (set.find('=') == std::string::npos) {
      throw base::InputError(
          fmt::format("--set '{0}': must be KEY=VALUE: --set '{0}={1}'", set, next));
    }
    if (base::FindMatch(next, "^[A-Za-z_][A-Za-z0-9_.]*=")) {
      throw base::InputError(
          fmt::format("unexpected '{0}': each KEY=VALUE needs its own --set: --set '{0}'", next));
    }
  }
}

// CLI11 would only report that a command is missing.
void CheckCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    commands.push_back(command->get_name());
  }
  base::CheckBuilt("command", argv[1]);
  throw base::InputError("unknown command '" + std::string(argv[1]) + "' (--help lists all)" +
                         base::Suggestion(argv[1], commands, "; did you mean '{}'?"));
}

// If scripts/rangegrasp started the program, it builds the system or installs the package and
// starts the program again with the same arguments, in place of this process.
int GetOrEnd(const char* variable, const std::string& name, const base::InputError& missing,
             char** argv) {
  if (const char* builder = std::getenv("RANGEGRASP_BUILDER")) {
    setenv(variable, name.c_str(), /*overwrite=*/1);
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
`timestep_ms` below `physics`). A key that is not given has its default value. The unit is part of the key's name. Paths are
relative to the file. An unknown key, a value of the wrong type or out of its range, or a missing file is reported with its line
and the nearest valid word, if one is near. `rangegrasp run FILE --set KEY=VALUE` overrides any key without a change to the file.

This page is generated by `rangegrasp list keys`, with all systems built, from the code that reads the files; a test compares
them.

)";

constexpr const char* kNotBuilt = "not built; scripts/rangegrasp builds it when it is first used";

// The first sentence of an experiment's initial comment ("Fig. 5.2" does not end a sentence).
std::string SummaryOf(const fs::path& experiment) {
  std::string summary;
  for (const std::string& line : base::Split(base::ReadFile(experiment), '\n')) {
    if (!line.starts_with("# ")) break;
    summary += (summary.empty() ? "" : " ") + line.substr(2);
  }
  const auto end = base::FindMatch(summary, "\\. [A-Z]");
  return end ? summary.substr(0, end->begin + 1) : summary;
}

std::vector<ListEntry> Kinds() {
  std::vector<ListEntry> entries;
  for (const auto& kind : experiment::AllKinds()) entries.push_back({kind.name, kind.description});
  for (const std::string& name : base::WordsNotBuilt("task")) entries.push_back({name, kNotBuilt});
  return entries;
}

std::vector<ListEntry> Experiments() {
  std::vector<ListEntry> entries;
  for (const std::string& name : base::ExperimentNames(base::DataFolder())) {
    entries.push_back({name, SummaryOf(base::DataFolder() / "experiments" / (name + ".yaml"))});
  }
  return entries;
}

std::vector<ListEntry> Tables() {
  std::vector<ListEntry> entries;
  for (const auto& table : experiment::PublishedTables()) {
    entries.push_back({table.number, table.title});
  }
  return entries;
}

std::vector<ListEntry> Keys() {
  std::vector<ListEntry> entries;
  for (const auto& [task, keys] : experiment::KeysByTask()) {
    for (const base::KeyDoc& key : keys) {
      entries.push_back(EntryOf(key));
      if (!task.empty()) entries.back().more.emplace_back("task", task);
    }
  }
  return entries;
}

std::vector<Listing>& Listings() {
  static std::vector<Listing> listings = {
      {"kinds", "kinds of experiments", Kinds},
      {"experiments", "experiments installed with the program", Experiments},
      {"tables", "published tables, for `reproduce`", Tables},
      {"keys", "every key of experiment files: the page docs/experiment-file.md", Keys, false,
       [] { return kKeysPage + experiment::KeysAsMarkdown(); }}};
  return listings;
}

std::string TextOf(const Listing& listing) {
  if (listing.page) return listing.page();
  std::string text;
  for (const ListEntry& entry : listing.entries()) {
    text +=
        entry.text.empty() ? entry.name + "\n" : fmt::format("{:<30} {}\n", entry.name, entry.text);
  }
  return text;
}

nlohmann::ordered_json JsonOf(const Listing& listing) {
  auto json = nlohmann::ordered_json::array();
  for (const ListEntry& entry : listing.entries()) {
    auto& one = json.emplace_back();
    one["name"] = entry.name;
    if (!entry.text.empty()) one["text"] = entry.text;
    for (const auto& [name, value] : entry.more) one[name] = value;
  }
  return json;
}

// Without a word, all listings of the overview.
std::string ListingOf(const std::string& word, bool as_json) {
  std::string text;
  nlohmann::ordered_json json;
  for (const Listing& listing : Listings()) {
    if (word.empty() ? !listing.in_overview : listing.word != word) continue;
    if (as_json) {
      json[listing.word] = JsonOf(listing);
    } else {
      text += word.empty() ? listing.description + ":\n" + TextOf(listing) + "\n" : TextOf(listing);
    }
  }
  return as_json ? json.dump(2) + "\n" : text;
}

void AddListCommand(CLI::App& app) {
  auto* command = app.add_subcommand("list", "List experiments, objects, keys, ...");
  auto what = std::make_shared<std::string>();
  std::vector<std::string> words;
  std::string footer = "Example: rangegrasp list objects";
  for (const Listing& listing : Listings()) {
    words.push_back(listing.word);
    footer += fmt::format("\n  {:<12} {}", listing.word, listing.description);
  }
  command->add_option("what", *what, "one of the words below; default: an overview")
      ->check(CLI::IsMember(words));
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "print as JSON");
  command->footer(footer);
  command->callback([what, json] { WriteResult(ListingOf(*what, *json)); });
}

void AddVersionCommand(CLI::App& app) {
  auto* command = app.add_subcommand("version", "Versions of the program and of its libraries.");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "print as JSON");
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

ReportMaker& MakeReportFor() {
  static ReportMaker maker = nullptr;
  return maker;
}

void AddLibrary(const std::string& name, const std::string& version) {
  for (const auto& [known, of_it] : Libraries()) {
    if (known == name) return;  // two systems use it
  }
  Libraries().emplace_back(name, version);
}

void AddListing(const Listing& listing) { Listings().push_back(listing); }

ListEntry EntryOf(const base::KeyDoc& key) {
  ListEntry entry{key.path, key.doc, {{"type", key.type}}};
  if (!key.range.empty()) entry.more.emplace_back("values", key.range);
  if (!key.default_value.empty()) entry.more.emplace_back("default", key.default_value);
  if (key.required) entry.more.emplace_back("needed", "true");
  return entry;
}

std::vector<fs::path> ShippedFiles(const char* folder, const char* ending) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(base::DataFolder() / folder)) {
    if (entry.path().extension() == ending) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

void ReportCrashes() {
  reporting_process = getpid();
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) {
    const auto before = std::signal(signal, EndWithReport);
    if (before != SIG_DFL) std::signal(signal, before);  // keeps a sanitizer's handler
  }
}

int RunProgram(int argc, char** argv) {
  SetUpLog();
  // If the reader goes away (`| head`), the write fails, which WriteResult handles.
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app{"Grasping unknown objects from single-view range images, in simulation."};
  app.require_subcommand(1);
  app.set_version_flag("--version", "rangegrasp " + base::Version(),
                       "version of the program (the command `version` also lists its libraries)");
  const auto missing = base::WordsNotBuilt("command");
  const std::string more =
      missing.empty() ? "" : "Commands " + base::Join(missing) + ": " + kNotBuilt + ".\n";
  app.footer(more +
             "Example: rangegrasp run experiments/laser_single.yaml\nExit codes: 0 done, 1 failed "
             "run, 2 wrong usage or input.");
  try {
    AddRunCommand(app);
    AddResultsCommands(app);
    AddSlurmCommands(app);
    AddListCommand(app);
    for (const CommandAdder add : Adders()) add(app);
    AddShellCommands(app);
    AddVersionCommand(app);
    CheckArguments(argc, argv);
    CheckCommand(app, argc, argv);
    CheckEachSet(argc, argv);
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ExtrasError&) {
    // In their order; the library's own message reverses it.
    spdlog::error("unexpected: {}; --help lists the options",
                  base::Join(app.remaining(/*recurse=*/true), " "));
    return kBadInput;
  } catch (const CLI::ParseError& e) {
    spdlog::error("{}; --help lists the options", e.what());
    return kBadInput;
  } catch (const base::NotBuilt& e) {
    return GetOrEnd("RANGEGRASP_MISSING_SYSTEM", e.system(), e, argv);
  } catch (const base::NotInstalled& e) {
    return GetOrEnd("RANGEGRASP_MISSING_PACKAGE", e.package(), e, argv);
  } catch (const base::InputError& e) {
    spdlog::error(e.what());
    return kBadInput;
  } catch (const base::RunError& e) {
    spdlog::error(e.what());
    return kRunFailed;
  } catch (const fs::filesystem_error& e) {  // e.g. a link to itself, a folder without permission
    spdlog::error(base::TextOf(e));
    return kBadInput;
  } catch (const std::bad_alloc&) {
    spdlog::error("{}: out of memory", CommandOf(argc, argv));
    return kRunFailed;
  } catch (const std::exception& e) {  // should not reach this place
    spdlog::error("{}: internal error, please report it: {}", CommandOf(argc, argv), e.what());
    return kRunFailed;
  }
}

}  // namespace rangegrasp::cli
