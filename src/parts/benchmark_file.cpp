#include <algorithm>
#include <charconv>
#include <set>

#include "core/error.h"
#include "core/yaml_map.h"
#include "parts/benchmark.h"

namespace rangegrasp::parts {
namespace {

using core::YamlMap;

constexpr int kLargestId = 1'000'000;

void ReadMethods(YamlMap& map, std::vector<Method>& methods) {
  std::vector<std::string> names;
  for (const Method method : kMethods) names.emplace_back(Name(method));
  std::vector<std::string> words = names;
  map.Read("methods", words);
  for (const std::string& word : words) {
    const auto found = std::find(names.begin(), names.end(), word);
    if (found == names.end()) {
      map.Fail("methods",
               "'" + word + "' is no method; nearest: '" + core::NearestWord(word, names) + "'");
    }
    const Method method = kMethods[static_cast<std::size_t>(found - names.begin())];
    if (std::find(methods.begin(), methods.end(), method) != methods.end()) {
      map.Fail("methods", "'" + word + "' stands twice");
    }
    methods.push_back(method);
  }
}

std::vector<int> ReadIds(YamlMap& map, const std::string& key, std::set<int>& seen) {
  std::vector<std::string> words;
  map.Read(key, words);
  std::vector<int> ids;
  for (const std::string& word : words) {
    int id = -1;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
    if (error != std::errc() || end != word.data() + word.size() || id < 0 || id > kLargestId) {
      map.Fail(key, "'" + word + "' must be a model's number, as in off/<number>.off");
    }
    if (!seen.insert(id).second) map.Fail(key, "model " + word + " stands twice");
    ids.push_back(id);
  }
  return ids;
}

std::vector<BenchmarkClass> ReadClasses(YamlMap& map) {
  map.Require("classes");
  map.Require("models");
  std::vector<std::string> names;
  map.Read("classes", names);
  YamlMap models = map.Child("models");
  std::vector<BenchmarkClass> classes;
  std::set<int> seen;
  for (const std::string& name : names) {
    for (const BenchmarkClass& other : classes) {
      if (other.name == name) map.Fail("classes", "'" + name + "' stands twice");
    }
    // The name becomes a cell of tables and CSV files.
    if (name.find_first_of(",\"\r\n") != std::string::npos) {
      map.Fail("classes", "'" + name + "' must be a name without comma and quote");
    }
    if (!models.Has(name)) {
      map.Fail("models", "has no models of class '" + name + "', e.g. " + name +
                             ": {tune: [21, 22], report: [23, 24]}");
    }
    YamlMap ids = models.Child(name);
    BenchmarkClass one{name, ReadIds(ids, "tune", seen), ReadIds(ids, "report", seen)};
    ids.Finish();
    if (one.tune.empty() && one.report.empty()) {
      models.Fail(name, "must name models under 'tune', 'report' or both");
    }
    classes.push_back(std::move(one));
  }
  models.Finish();
  return classes;
}

void CheckFolder(const std::filesystem::path& folder, const std::string& prefix) {
  for (const char* part : {"off", "seg"}) {
    std::error_code error;
    if (std::filesystem::is_directory(folder / part, error)) continue;
    throw core::InputError(prefix + "'" + folder.string() + "' has no folder '" + part +
                           "'; the data of the benchmark are laid out as off/<id>.off and "
                           "seg/<id>/<id>_<k>.seg; --data DIR names another folder");
  }
}

}  // namespace

BenchmarkOptions ReadBenchmark(const std::filesystem::path& file,
                               const std::filesystem::path& folder) {
  YamlMap map = YamlMap::FromFile(file);
  BenchmarkOptions options;
  options.file = file;
  options.name = file.stem().string();
  map.Read("name", options.name);
  ReadMethods(map, options.methods);
  options.classes = ReadClasses(map);
  map.ReadPath("runtimes", options.runtimes);
  std::string data;
  map.Read("data", data);
  map.Finish();
  options.folder = folder.empty() ? (file.parent_path() / data).lexically_normal() : folder;
  if (folder.empty() && data.empty()) {
    map.Fail("data",
             "is missing; it, or --data on the command line, names the folder of off/ and seg/");
  }
  CheckFolder(options.folder, folder.empty() ? file.string() + ": key 'data': " : "--data ");
  return options;
}

}  // namespace rangegrasp::parts
