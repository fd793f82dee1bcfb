#include "parts/files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/error.h"

namespace rangegrasp::parts {
namespace {

std::string ReadText(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw core::InputError(file.string() +
                           ": no such file; a file with one label a line is needed");
  }
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) throw core::InputError(file.string() + ": cannot be read");
  return text;
}

std::string_view Trimmed(std::string_view line) {
  const auto first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(" \t\r") - first + 1);
}

std::optional<std::int32_t> ParseLabel(std::string_view word) {
  std::int32_t label = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), label);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return label;
}

void WriteWhole(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) throw core::RunError(file.string() + ": cannot be written");
}

template <class T>
void AppendRaw(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void AppendColor(std::int32_t label, std::string& bytes) {
  for (const std::uint8_t channel : PartColor(label)) AppendRaw(channel, bytes);
}

/// Hue in turns, from red over green and blue.
std::array<std::uint8_t, 3> FromHsv(double hue, double saturation, double value) {
  std::array<std::uint8_t, 3> color{};
  for (int i = 0; i < 3; ++i) {
    const double turn = 6.0 * std::fmod(hue + (i == 0 ? 0.0 : (3.0 - i) / 3.0), 1.0);
    const double ramp = std::clamp(std::abs(turn - 3.0) - 1.0, 0.0, 1.0);
    color[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(std::lround(255.0 * value * (1.0 - saturation * (1.0 - ramp))));
  }
  return color;
}

constexpr const char* kColors = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

}  // namespace

std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file) {
  const std::string text = ReadText(file);
  const std::string_view whole(text.data(), text.find_last_not_of(" \t\r\n") + 1);
  std::vector<std::int32_t> labels;
  for (std::size_t at = 0; at < whole.size();) {
    const std::size_t end = std::min(whole.find('\n', at), whole.size());
    const std::string_view word = Trimmed(whole.substr(at, end - at));
    const auto label = ParseLabel(word);
    if (!label) {
      throw core::InputError(file.string() + ":" + std::to_string(labels.size() + 1) + ": '" +
                             std::string(word.substr(0, 40)) +
                             "' must be a label, one whole number a line");
    }
    labels.push_back(*label);
    at = end + 1;
  }
  return labels;
}

std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file, std::size_t elements) {
  std::vector<std::int32_t> labels = ReadLabels(file);
  if (labels.size() != elements) {
    const std::size_t line = std::min(labels.size(), elements) + 1;
    throw core::InputError(file.string() + ":" + std::to_string(line) + ": has " +
                           std::to_string(labels.size()) + " labels; the shape has " +
                           std::to_string(elements) + " elements");
  }
  return labels;
}

void WriteLabels(const std::filesystem::path& file, std::span<const std::int32_t> labels) {
  std::string text;
  for (const std::int32_t label : labels) text += std::to_string(label) + "\n";
  WriteWhole(file, text);
}

std::array<std::uint8_t, 3> PartColor(std::int32_t label) {
  if (label < 0) return {128, 128, 128};
  if (label == 0) return {214, 32, 32};
  // Hues by the golden section, which fills the circle evenly however many there are, away from the
  // red of the core; every other round is darker or paler.
  constexpr double kGolden = 0.61803398874989485;
  constexpr double kSaturation[] = {0.85, 0.45, 0.90};
  constexpr double kValue[] = {0.95, 0.95, 0.55};
  const int k = label - 1;
  const double hue = 0.09 + 0.82 * std::fmod(0.62 + k * kGolden, 1.0);
  const int round = (k / 7) % 3;
  return FromHsv(hue, kSaturation[round], kValue[round]);
}

void WriteColoredShape(const std::filesystem::path& file, const geometry::TriangleMesh& input,
                       std::span<const std::int32_t> labels) {
  const bool mesh = !input.triangles.empty();
  const std::size_t elements = mesh ? input.triangles.size() : input.vertices.size();
  if (labels.size() != elements) {
    throw std::invalid_argument("WriteColoredShape: " + std::to_string(labels.size()) +
                                " labels for " + std::to_string(elements) + " elements");
  }
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(input.vertices.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\n";
  if (mesh) {
    bytes +=
        "element face " + std::to_string(elements) + "\nproperty list uchar int vertex_indices\n";
  }
  bytes += std::string(kColors) + "end_header\n";
  for (std::size_t i = 0; i < input.vertices.size(); ++i) {
    for (const double x : input.vertices[i]) AppendRaw(static_cast<float>(x), bytes);
    if (!mesh) AppendColor(labels[i], bytes);
  }
  for (std::size_t i = 0; i < input.triangles.size(); ++i) {
    AppendRaw(std::uint8_t{3}, bytes);
    for (const std::uint32_t v : input.triangles[i]) {
      AppendRaw(static_cast<std::int32_t>(v), bytes);
    }
    AppendColor(labels[i], bytes);
  }
  WriteWhole(file, bytes);
}

}  // namespace rangegrasp::parts
