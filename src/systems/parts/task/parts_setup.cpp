#include "parts/task/parts_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "base/file.h"
#include "base/words.h"
#include "parts/metrics/human_score.h"
#include "parts/task/parts_report.h"

namespace rangegrasp::parts {

using nlohmann::json;

static void to_json(json& word, Method method) { word = base::Word(method); }
static void from_json(const json& word, Method& method) {
  method = base::FromWord<Method>(word.get<std::string>(), "stamp: methods");
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CloudGrade, points, noise_percent)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ModelClass, name, tune, report)

namespace {

using base::YamlMap;

/// Limits for ids, models per class and ranges, so that a typing error is reported.
constexpr int kMaxId = 1'000'000, kMaxModels = 1'000'000, kMaxRange = 1000;

/// The keys as in the file, except for methods and clouds.
struct Keys {
  std::string data;
  std::vector<std::string> classes;
  std::filesystem::path runtimes;
  int models_per_class = 0;
};

/// Reads a list of numbers within a range.
template <typename Number>
std::vector<Number> ReadNumbers(YamlMap& map, const std::string& key, Number low, Number high,
                                const std::string& doc) {
  std::vector<std::string> words;
  map.Read(key, words, doc);
  std::vector<Number> numbers;
  for (const std::string& word : words) {
    const auto number = base::NumberFrom<Number>(word);
    if (!number || !(*number >= low && *number <= high)) {
      map.Fail(key, fmt::format("'{}' must be a number from {} to {}", word, low, high));
    }
    numbers.push_back(*number);
  }
  return numbers;
}

/// Every combination of number of points and noise.
std::vector<CloudGrade> ReadClouds(YamlMap& map) {
  YamlMap clouds = map.Child("clouds", "clouds sampled from each model, which are also scored");
  const auto points = ReadNumbers(clouds, "points", 100, 10'000'000, "numbers of points");
  const auto noises = ReadNumbers(clouds, "noise_percent", 0.0, 10.0,
                                  "noise of each coordinate: standard deviations in percent of the "
                                  "diagonal of the model's bounding box");
  clouds.Finish();
  std::vector<CloudGrade> grades;
  for (const int count : points) {
    for (const double noise : noises) grades.push_back({count, noise});
  }
  if (map.Has("clouds") && grades.empty()) {
    map.Fail("clouds", "needs both, e.g. clouds: {points: [10000], noise_percent: [0, 0.3]}");
  }
  return grades;
}

Keys ReadKeys(YamlMap& map, PartsSetup& setup) {
  Keys keys;
  const auto all = base::ValuesOf<Method>();
  setup.methods.assign(all.begin(), all.end());
  map.Read("methods", setup.methods, "methods to run on every model");
  setup.clouds = ReadClouds(map);
  map.Require("classes");
  map.Read("classes", keys.classes, "classes of models, in the order of the tables");
  map.Read("models_per_class", keys.models_per_class, 0, kMaxModels,
           "maximum number of models of each class and split; 0: all");
  map.ReadPath("runtimes", keys.runtimes, "published table 6.1 as CSV: method, seconds");
  map.Require("data");
  map.Read("data", keys.data,
           "folder of the benchmark, relative to the file: off/ID.off, seg/ID/ID_K.seg");
  map.Require("models");
  return keys;
}

void CheckMethods(const YamlMap& map, const PartsSetup& setup) {
  for (const Method method : setup.methods) {
    if (setup.clouds.empty() || ReadsClouds(method)) continue;
    map.Fail("clouds", fmt::format("method '{}' cannot segment clouds; mirror and hierarchy can",
                                   base::Word(method)));
  }
}

/// First and last id, from a single id or from a range such as "61-80".
std::optional<std::pair<int, int>> IdRangeFrom(std::string_view word) {
  const std::size_t dash = word.find('-');
  const auto first = base::NumberFrom<int>(word.substr(0, dash));
  const auto last =
      dash == std::string_view::npos ? first : base::NumberFrom<int>(word.substr(dash + 1));
  const bool valid = first && last && *first >= 0 && *last <= kMaxId && *last >= *first &&
                     *last - *first < kMaxRange;
  return valid ? std::optional(std::pair(*first, *last)) : std::nullopt;
}

/// @param folder  ids of a range count only if it contains their models; if empty, all count
std::vector<int> ReadIds(YamlMap& map, Split split, const std::filesystem::path& folder,
                         std::set<int>& seen) {
  const std::string key(base::Word(split));
  std::vector<std::string> words;
  map.Read(key, words,
           split == Split::kTune
               ? "numbers of the models used for tuning"
               : "numbers of the held-out models; 61-80: all available ones in this range");
  std::vector<int> ids;
  for (const std::string& word : words) {
    const auto range = IdRangeFrom(word);
    if (!range) {
      map.Fail(key, fmt::format("'{}' must be a model's number, as in off/<number>.off, or a range "
                                "such as 61-80 of at most {}",
                                word, kMaxRange));
    }
    const bool is_range = range->first != range->second && !folder.empty();
    for (int id = range->first; id <= range->second; ++id) {
      if (is_range && !std::filesystem::exists(ModelFile(folder, id))) continue;
      if (!seen.insert(id).second) map.Fail(key, fmt::format("model {} is given twice", id));
      ids.push_back(id);
    }
  }
  return ids;
}

ModelClass ReadClass(YamlMap& models, const std::string& name, const std::filesystem::path& folder,
                     std::set<int>& seen) {
  YamlMap ids = models.Child(name, "models of one class: tuning and held-out models");
  ModelClass one{name, ReadIds(ids, Split::kTune, folder, seen),
                 ReadIds(ids, Split::kReport, folder, seen)};
  ids.Finish();
  return one;
}

/// A class's name becomes part of the ids of its cases.
bool IsName(const std::string& name) {
  return !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '.';
  });
}

std::vector<ModelClass> ReadClasses(YamlMap& map, const std::vector<std::string>& names,
                                    const std::filesystem::path& folder) {
  YamlMap models = map.Child("models", "models of each class");
  std::vector<ModelClass> classes;
  std::set<int> seen;
  for (const std::string& name : names) {
    if (!IsName(name)) {
      map.Fail("classes",
               fmt::format("'{}' must consist of letters, digits, '_', '-' and '.'", name));
    }
    if (!models.Has(name)) {
      map.Fail("models", fmt::format("has no models of class '{}', e.g. {}: {{tune: [21, 22], "
                                     "report: [23, 24]}}",
                                     name, name));
    }
    classes.push_back(ReadClass(models, name, folder, seen));
    if (classes.back().tune.empty() && classes.back().report.empty()) {
      models.Fail(name, "must list models under 'tune', 'report' or both");
    }
  }
  models.Finish();
  return classes;
}

void CheckFolder(const YamlMap& map, const std::filesystem::path& folder) {
  for (const char* part : {"off", "seg"}) {
    std::error_code error;
    if (std::filesystem::is_directory(folder / part, error)) continue;
    map.Fail("data", fmt::format("'{}' has no folder '{}'; the benchmark's files are off/ID.off "
                                 "and seg/ID/ID_K.seg; choose another folder with --set data=DIR",
                                 folder.string(), part));
  }
}

/// Hash of the names and bytes of all files that the results depend on. A missing file counts as
/// empty, since its rows report it.
std::string HashOfModels(const PartsSetup& setup) {
  std::string all;
  const auto add = [&](const std::filesystem::path& file) {
    std::error_code error;
    const bool is_there = std::filesystem::is_regular_file(file, error);
    const std::string bytes = is_there ? base::ReadFile(file) : "";
    all += fmt::format("{} {}\n", file.filename().string(), base::Hex(base::Fnv1a(bytes)));
  };
  for (const ModelClass& one : setup.classes) {
    for (const auto* ids : {&one.tune, &one.report}) {
      for (const int id : *ids) {
        add(ModelFile(setup.folder, id));
        for (const auto& human : HumanFiles(setup.folder, id)) add(human);
      }
    }
  }
  return base::Hex(base::Fnv1a(all));
}

}  // namespace

PartsSetup ReadPartsSetup(YamlMap& map) {
  PartsSetup setup;
  const Keys keys = ReadKeys(map, setup);
  CheckMethods(map, setup);
  setup.folder = (map.file().parent_path() / keys.data).lexically_normal();
  setup.classes = ReadClasses(map, keys.classes, setup.folder);
  map.Finish();
  CheckFolder(map, setup.folder);
  if (!keys.runtimes.empty()) {
    setup.published = experiment::PublishedText(keys.runtimes);
    PublishedSeconds(setup.published, keys.runtimes.string());  // reports a broken table
  }
  const bool counts = std::ranges::count(setup.methods, Method::kKMeans) > 0;
  for (ModelClass& one : setup.classes) {
    std::vector<int> ids = one.tune;
    ids.insert(ids.end(), one.report.begin(), one.report.end());
    if (counts) one.human_segments = MeanHumanSegments(setup.folder, ids);
    for (auto* split : {&one.tune, &one.report}) {
      const auto limit = static_cast<std::size_t>(keys.models_per_class);
      if (limit > 0) split->resize(std::min(split->size(), limit));
    }
  }
  return setup;
}

void ReadPartsKeys(YamlMap& map) {
  PartsSetup setup;
  ReadKeys(map, setup);
  YamlMap models = map.Child("models", "models of each class");
  std::set<int> seen;
  ReadClass(models, "<class>", {}, seen);
}

void AddTo(experiment::Stamp& stamp, const PartsSetup& setup) {
  stamp.identity["models_hash"] = HashOfModels(setup);
  json parts = {{"classes", setup.classes}, {"methods", setup.methods}};
  if (!setup.clouds.empty()) parts["clouds"] = setup.clouds;
  stamp.data["parts"] = parts.dump();
  stamp.data["published_table_6.1"] = setup.published;
}

PartsSetup PartsSetupOf(const experiment::Stamp& stamp) {
  PartsSetup setup;
  const json data = json::parse(experiment::Need(stamp.data, "parts"));
  data.at("classes").get_to(setup.classes);
  data.at("methods").get_to(setup.methods);
  data.value("clouds", json::array()).get_to(setup.clouds);
  setup.published = experiment::Need(stamp.data, "published_table_6.1");
  return setup;
}

}  // namespace rangegrasp::parts
