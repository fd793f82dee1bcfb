#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "report/grid.h"
#include "report/table.h"

namespace rangegrasp::report {

/// A table with its title.
struct Section {
  std::string title;
  Grid grid;
};

/// What an experiment's tables came from: name, versions, hashes, seeds.
class Stamp {
 public:
  /// The experiment's name, this program's version and commit, the hash of the experiment's file.
  Stamp(const std::string& experiment, const std::filesystem::path& file);
  void Add(const std::string& key, const std::string& value);
  void Add(const std::string& key, std::uint64_t value);
  void AddHash(const std::string& key, const std::filesystem::path& file);

 private:
  friend std::string Format(const std::vector<Section>&, const Stamp&, TableFormat);
  struct Item {
    std::string key, value;
    bool number;
  };
  std::vector<Item> items_;
};

/// Tables one after the other, the stamp below them; CSV holds the tables alone, JSON numbers as
/// numbers and null for "-".
std::string Format(const std::vector<Section>& sections, const Stamp& stamp, TableFormat format);

/// The lines of a CSV file below its header, as their first cell and the numbers behind it.
/// @throws core::InputError naming file and line of a cell that is no number.
std::vector<std::pair<std::string, std::vector<double>>> ReadNamedNumbers(
    const std::filesystem::path& file);

}  // namespace rangegrasp::report
