#include "base/installation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "base/words.h"

namespace rangegrasp::base {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariable = "RANGEGRASP_DATA";

bool IsDataFolder(const fs::path& folder) {
  const auto holds = [&](const char* name) { return fs::is_directory(folder / name); };
  return holds("models") && holds("scenes") && holds("experiments");
}

// Whether to search a name among the program's own experiments. A missing path in another folder is
// an error, even if its last part is the name of an experiment.
bool IsName(const fs::path& experiment) {
  const fs::path folder = experiment.parent_path();
  return experiment.has_filename() && (folder.empty() || folder == "experiments");
}

fs::path own_file;  // given to SetProgram
std::vector<WordNotBuilt> words_not_built;

}  // namespace

fs::path DataFolder() {
  const char* variable = std::getenv(kVariable);
  if (!variable || !*variable) {
    return DataFolderOf(own_file.empty() ? fs::read_symlink("/proc/self/exe") : own_file);
  }
  if (!IsDataFolder(variable)) {
    throw InputError(fmt::format(
        "{}: the folder '{}' must contain models/, scenes/ and experiments/", kVariable, variable));
  }
  return variable;
}

void SetProgram(const fs::path& file) { own_file = file; }

fs::path DataFolderOf(const fs::path& program) {
  const fs::path installed = program.parent_path().parent_path() / "share/rangegrasp";
  if (IsDataFolder(installed)) return installed;
  for (fs::path folder = program.parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    if (IsDataFolder(folder)) return folder;
  }
  throw InputError(
      fmt::format("models/, scenes/ and experiments/ are neither in {} nor in a folder above {}; "
                  "set the environment variable {} to their folder",
                  installed.string(), program.string(), kVariable));
}

std::vector<std::string> ExperimentNames(const fs::path& data) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(data / "experiments")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

fs::path FindExperiment(const fs::path& experiment) {
  if (fs::exists(experiment)) return experiment;
  if (!IsName(experiment)) throw InputError(experiment.string() + ": no such file");
  const fs::path data = DataFolder();
  const auto names = ExperimentNames(data);
  const fs::path file = experiment.filename();
  const std::string name = (file.extension() == ".yaml" ? file.stem() : file).string();
  if (std::ranges::find(names, name) == names.end()) {
    throw InputError(
        fmt::format("{}: no such file, nor an experiment in {}{}; `rangegrasp list "
                    "experiments` lists all",
                    experiment.string(), (data / "experiments").string(), Suggestion(name, names)));
  }
  return data / "experiments" / (name + ".yaml");
}

NotBuilt::NotBuilt(const std::string& where, const WordNotBuilt& word)
    : InputError(fmt::format("{}{} '{}' belongs to the system '{}', which this program was built "
                             "without (configure with -DRANGEGRASP_SYSTEMS={} or all)",
                             where, word.kind, word.word, word.system, word.system)),
      system_(word.system) {}

NotInstalled::NotInstalled(const std::string& package, const std::string& what)
    : InputError(fmt::format("Debian's package '{}' is missing; {}", package, what)),
      package_(package) {}

void AddWordNotBuilt(const WordNotBuilt& word) { words_not_built.push_back(word); }

std::vector<std::string> WordsNotBuilt(std::string_view kind) {
  std::vector<std::string> words;
  for (const WordNotBuilt& known : words_not_built) {
    if (known.kind == kind) words.emplace_back(known.word);
  }
  std::ranges::sort(words);
  return words;
}

void CheckBuilt(std::string_view kind, std::string_view word, const std::string& where) {
  for (const WordNotBuilt& known : words_not_built) {
    if (known.kind == kind && known.word == word) throw NotBuilt(where, known);
  }
}

}  // namespace rangegrasp::base
