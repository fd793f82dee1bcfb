#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace rangegrasp::core {

/// A YAML mapping that is read key by key and knows which keys there are: what is left over at
/// Finish is an error that names the file, the line and the nearest valid key. Values that are
/// absent leave their default untouched.
///
///   auto map = YamlMap::FromFile("experiment.yaml");
///   map.Read("seed", seed);
///   auto physics = map.Child("physics");
///   physics.ReadScaled("timestep_ms", timestep_s, 1e-3, 1e-4, 4e-3);
///   physics.Finish();
///   map.Finish();
///
/// Every method throws core::InputError as "file:line: key 'x': what is wrong, what would be
/// right".
class YamlMap {
 public:
  static YamlMap FromFile(const std::filesystem::path& file);
  ~YamlMap();
  YamlMap(YamlMap&&) noexcept;

  bool Has(const std::string& key) const;
  /// The mapping under a key; an empty one if the key is absent.
  YamlMap Child(const std::string& key);

  void Read(const std::string& key, std::string& value);
  void Read(const std::string& key, bool& value);
  void Read(const std::string& key, std::uint64_t& value);
  void Read(const std::string& key, std::vector<std::string>& value);
  void Read(const std::string& key, int& value, int low, int high);
  /// value = number in the file * unit; the range is in the file's unit.
  void ReadScaled(const std::string& key, double& value, double unit, double low, double high);
  void Read(const std::string& key, double& value, double low, double high) {
    ReadScaled(key, value, 1.0, low, high);
  }
  void Read(const std::string& key, std::optional<double>& value, double low, double high);
  /// One of a few words; `value` becomes its position.
  template <typename Enum>
  void ReadEnum(const std::string& key, Enum& value, const std::vector<std::string>& names) {
    int position = static_cast<int>(value);
    ReadWord(key, position, names);
    value = static_cast<Enum>(position);
  }
  /// A path, relative to the file's folder if it is not absolute; it must exist.
  void ReadPath(const std::string& key, std::filesystem::path& value);
  /// Throws if the key is absent.
  void Require(const std::string& key) const;

  /// Throws if a key was never asked for.
  void Finish() const;
  /// Throws an InputError for a key's value, with file and line.
  [[noreturn]] void Fail(const std::string& key, const std::string& what) const;

 private:
  struct Impl;
  explicit YamlMap(std::unique_ptr<Impl> impl);
  void ReadWord(const std::string& key, int& position, const std::vector<std::string>& names);
  std::unique_ptr<Impl> impl_;
};

/// The word nearest to `word` by edit distance, empty if there is none.
std::string NearestWord(const std::string& word, const std::vector<std::string>& words);

}  // namespace rangegrasp::core
