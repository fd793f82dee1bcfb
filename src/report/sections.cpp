#include "report/sections.h"

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.h"
#include "core/file.h"
#include "core/hash.h"
#include "core/version.h"

namespace rangegrasp::report {
namespace {

using nlohmann::ordered_json;

// A cell as JSON: a number where it is one, null where nothing was counted.
ordered_json CellJson(const std::string& cell) {
  if (cell == "-" || cell.empty()) return nullptr;
  char* end = nullptr;
  const double number = std::strtod(cell.c_str(), &end);
  return *end == '\0' ? ordered_json(number) : ordered_json(cell);
}

ordered_json TableJson(const Section& section) {
  ordered_json rows = ordered_json::array();
  for (const auto& row : section.grid.rows) {
    ordered_json cells = ordered_json::array();
    for (const std::string& cell : row) cells.push_back(CellJson(cell));
    rows.push_back(cells);
  }
  return {{"title", section.title}, {"columns", section.grid.header}, {"rows", rows}};
}

}  // namespace

Stamp::Stamp(const std::string& experiment, const std::filesystem::path& file) {
  Add("experiment", experiment);
  Add("version", core::Version());
  Add("commit", core::Commit());
  AddHash("experiment_hash", file);
}

void Stamp::Add(const std::string& key, const std::string& value) {
  items_.push_back({key, value, false});
}

void Stamp::Add(const std::string& key, std::uint64_t value) {
  items_.push_back({key, std::to_string(value), true});
}

void Stamp::AddHash(const std::string& key, const std::filesystem::path& file) {
  Add(key, core::Hex(core::Fnv1a(core::ReadNonEmptyFile(file))));
}

std::string Format(const std::vector<Section>& sections, const Stamp& stamp, TableFormat format) {
  if (format == TableFormat::kJson) {
    ordered_json json;
    json["experiment"] = stamp.items_.front().value;
    for (const auto& item : stamp.items_) {
      json["stamp"][item.key] =
          item.number ? ordered_json::parse(item.value) : ordered_json(item.value);
    }
    json["tables"] = ordered_json::array();
    for (const Section& section : sections) json["tables"].push_back(TableJson(section));
    return json.dump(2) + "\n";
  }
  std::string text;
  for (const Section& section : sections) {
    if (format == TableFormat::kCsv) {
      text += CsvOf(section.grid) + "\n";
    } else if (format == TableFormat::kMarkdown) {
      text += section.title + ":\n\n" + MarkdownOf(section.grid) + "\n";
    } else {
      text += section.title + "\n\n" + TextOf(section.grid) + "\n";
    }
  }
  if (format == TableFormat::kCsv) return text;
  std::string line;
  for (const auto& item : stamp.items_) {
    line += (line.empty() ? "" : ", ") + item.key + " " + item.value;
  }
  return text + line + "\n";
}

std::vector<std::pair<std::string, std::vector<double>>> ReadNamedNumbers(
    const std::filesystem::path& file) {
  std::vector<std::pair<std::string, std::vector<double>>> rows;
  std::istringstream in(core::ReadNonEmptyFile(file));
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.ends_with('\r')) line.pop_back();
    if (++number == 1 || line.empty()) continue;
    std::istringstream cells(line);
    auto& [name, numbers] = rows.emplace_back();
    std::getline(cells, name, ',');
    for (std::string cell; std::getline(cells, cell, ',');) {
      char* end = nullptr;
      numbers.push_back(std::strtod(cell.c_str(), &end));
      if (!cell.empty() && *end == '\0') continue;
      throw core::InputError(file.string() + ":" + std::to_string(number) + ": '" + cell +
                             "' must be a number");
    }
  }
  return rows;
}

}  // namespace rangegrasp::report
