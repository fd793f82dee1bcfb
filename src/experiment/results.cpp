#include "experiment/results.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

#include "base/error.h"
#include "base/number.h"
#include "base/words.h"
#include "experiment/store.h"

namespace rangegrasp::experiment {
namespace {

constexpr std::string_view kSeedPrefix = "seed-";

std::optional<std::uint64_t> SeedOf(const std::filesystem::path& folder) {
  const std::string name = folder.filename().string();
  if (!name.starts_with(kSeedPrefix) || !Store::Exists(folder)) return std::nullopt;
  return base::NumberFrom<std::uint64_t>(name.substr(kSeedPrefix.size()));
}

// Takes over the order of the other's groups, if they are the same.
void OrderGroupsAs(const Stamp& other, Stamp& stamp) {
  const auto sorted = [](const std::string& groups) {
    auto names = base::Split(groups, ',');
    std::ranges::sort(names);
    return names;
  };
  std::string& groups = stamp.identity["groups"];
  const auto wanted = other.identity.find("groups");
  if (wanted != other.identity.end() && sorted(groups) == sorted(wanted->second)) {
    groups = wanted->second;
  }
}

// Seed, number of cases and the order of groups, which hazards draw, are all that runs of several
// seeds may differ in.
void Join(const Stamp& stamp, const std::string& folder, Stamp& pooled) {
  const std::string seeds = Need(pooled.identity, "seed") + "," + Need(stamp.identity, "seed");
  const auto cases =
      std::stoull(Need(pooled.identity, "cases")) + std::stoull(Need(stamp.identity, "cases"));
  Stamp alike = stamp;
  alike.identity["seed"] = pooled.identity.at("seed");
  alike.identity["cases"] = pooled.identity.at("cases");
  OrderGroupsAs(pooled, alike);
  CheckSameRun(alike, pooled, folder);
  pooled.identity["seed"] = seeds;
  pooled.identity["cases"] = std::to_string(cases);
}

}  // namespace

std::filesystem::path SeedFolder(const std::filesystem::path& folder, std::uint64_t seed) {
  return folder / (std::string(kSeedPrefix) + std::to_string(seed));
}

std::vector<std::filesystem::path> StoresIn(const std::filesystem::path& folder) {
  if (Store::Exists(folder) || !std::filesystem::is_directory(folder)) return {folder};
  std::map<std::uint64_t, std::filesystem::path> by_seed;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (const auto seed = SeedOf(entry.path())) by_seed[*seed] = entry.path();
  }
  if (by_seed.empty()) return {folder};
  std::vector<std::filesystem::path> stores;
  for (const auto& [seed, store] : by_seed) stores.push_back(store);
  return stores;
}

Results ReadResults(const std::filesystem::path& folder) {
  Results results;
  for (const auto& path : StoresIn(folder)) {
    const Store store = Store::Open(path);
    const Stamp stamp = store.ReadStamp();
    if (results.stamp.identity.empty()) {
      results.stamp = stamp;
    } else {
      Join(stamp, path.string(), results.stamp);
    }
    auto records = store.ReadAll();
    if (results.records.empty()) {
      results.records = std::move(records);  // a million are 4 GB: not twice
    } else {
      std::move(records.begin(), records.end(), std::back_inserter(results.records));
    }
  }
  return results;
}

}  // namespace rangegrasp::experiment
