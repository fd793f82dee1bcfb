#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/words.h"

namespace rangegrasp::base {

/// Documentation of a key of a file; the documentation is generated from the code.
struct KeyDoc {
  std::string path;           ///< "physics.timestep_ms"
  std::string type;           ///< "number", "whole number", "text", "path", "list", ...
  std::string default_value;  ///< as written in a file; empty if there is none
  std::string range;          ///< "0.1 to 4", "one of a, b", or empty
  std::string doc;            ///< one sentence
  bool required = false;
};

/// A YAML mapping that is read key by key. A key that was not read before Finish is an error, which
/// names the nearest valid key. An absent key leaves its default value unchanged. Every read
/// describes its key: the documentation is generated from the code that reads the keys.
///
///   auto map = YamlMap::FromFile("experiment.yaml");
///   map.Read("seed", seed, "what all random streams are derived from");
///   auto physics = map.Child("physics", "the simulation");
///   physics.ReadScaled("timestep_ms", timestep_s, kMm, 0.1, 4.0, "step of the engine");
///   physics.Finish();
///   map.Finish();
///
/// Every method throws InputError as "file:line: key 'x': what is wrong, what is expected".
class YamlMap {
 public:
  /// @param overrides  each "key.inner=value" (YAML on one line) replaces the file's value
  static YamlMap FromFile(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides = {});
  /// @param file  named in errors; paths are relative to its folder
  static YamlMap FromText(const std::string& text, const std::filesystem::path& file,
                          const std::vector<std::string>& overrides = {});
  void Override(const std::string& one);
  /// A mapping without keys. Code that reads from it records its keys in Keys.
  static YamlMap ForDocumentation();
  ~YamlMap();
  YamlMap(YamlMap&&) noexcept;

  const std::filesystem::path& file() const;
  bool Has(const std::string& key) const;
  bool HoldsMap(const std::string& key) const;
  /// The keys that are present, in the order of the file.
  std::vector<std::string> Names() const;
  /// All values by their key's path ("physics.timestep_ms"), as text on one line; a mapping below
  /// three levels of keys counts as a value.
  std::map<std::string, std::string> Values() const;
  /// The mapping under a key; an empty one if the key is absent.
  YamlMap Child(const std::string& key, const std::string& doc = "");

  void Read(const std::string& key, std::string& value, const std::string& doc = "");
  void Read(const std::string& key, bool& value, const std::string& doc = "");
  void Read(const std::string& key, std::uint64_t& value, const std::string& doc = "");
  void Read(const std::string& key, std::vector<std::string>& value, const std::string& doc = "");
  void Read(const std::string& key, int& value, int low, int high, const std::string& doc = "");
  /// value = number in the file * unit; the range is in the file's unit.
  void ReadScaled(const std::string& key, double& value, double unit, double low, double high,
                  const std::string& doc = "");
  void Read(const std::string& key, double& value, double low, double high,
            const std::string& doc = "") {
    ReadScaled(key, value, 1.0, low, high, doc);
  }
  void Read(const std::string& key, std::optional<double>& value, double low, double high,
            const std::string& doc = "");
  /// Reads one of the words.
  void Read(const std::string& key, std::string& value, const std::vector<std::string>& words,
            const std::string& doc);
  /// Reads one of an enum's words.
  template <HasWords Enum>
  void Read(const std::string& key, Enum& value, const std::string& doc = "") {
    auto position = static_cast<std::size_t>(value);
    ReadWord(key, position, WordList<Enum>(), doc);
    value = static_cast<Enum>(position);
  }
  /// Reads a list of at least one of an enum's words.
  template <HasWords Enum>
  void Read(const std::string& key, std::vector<Enum>& values, const std::string& doc = "") {
    std::vector<std::string> words;
    words.reserve(values.size());
    for (const Enum value : values) words.emplace_back(Word(value));
    ReadWords(key, words, WordList<Enum>(), doc);
    values.clear();
    for (const std::string& word : words) values.push_back(FromWord<Enum>(word, key));
  }
  /// Reads a path, which must exist. A relative path is relative to the file's folder.
  void ReadPath(const std::string& key, std::filesystem::path& value, const std::string& doc = "");
  void Require(const std::string& key);

  /// Throws if a key is present that was never read.
  void Finish() const;
  /// Throws an InputError for a key's value, with file and line.
  [[noreturn]] void Fail(const std::string& key, const std::string& what) const;
  /// Where a key is given, for a warning: "file:line", or "--set key"; nullopt if it is absent.
  std::optional<std::string> PlaceOf(const std::string& key) const;
  /// Like Child, for Fail and PlaceOf after the keys were read: records no key.
  YamlMap Inner(const std::string& key) const;

  /// All keys of the document read so far, in that order.
  const std::vector<KeyDoc>& Keys() const;

 private:
  struct Impl;
  explicit YamlMap(std::unique_ptr<Impl> impl);
  void ReadWord(const std::string& key, std::size_t& position,
                const std::vector<std::string>& words, const std::string& doc);
  void ReadWords(const std::string& key, std::vector<std::string>& values,
                 const std::vector<std::string>& words, const std::string& doc);
  std::unique_ptr<Impl> impl_;
};

template <typename Switches>
void ReadAdditions(YamlMap& map, Switches& switches) {
  for (const auto& row : AdditionsTable<Switches>()) {
    map.Read(std::string(row.key), switches.*row.on, std::string(row.doc));
  }
}

/// Replaces a YamlMap in a function that reads options key by key: checks options set in code
/// against the same ranges. Throws std::invalid_argument as "what: key: 70 is out of range, must be
/// from 0.1 to 50", in the key's unit.
class RangeCheck {
 public:
  explicit RangeCheck(std::string what) : what_(std::move(what)) {}

  void Read(const std::string&, bool) const {}
  void Read(const std::string& key, int value, int low, int high) const;
  void ReadScaled(const std::string& key, double value, double unit, double low, double high) const;
  void Read(const std::string& key, double value, double low, double high) const {
    ReadScaled(key, value, 1.0, low, high);
  }

 private:
  [[noreturn]] void Fail(const std::string& key, double value, double low, double high) const;

  std::string what_;
};

}  // namespace rangegrasp::base
