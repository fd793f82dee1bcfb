#include "geometry/internal/off.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/number.h"

namespace rangegrasp::geometry::internal {
namespace {

/// Of a line: "0 0 0" with its end, and "3 0 1 2" with its end, which may be absent.
constexpr std::uint64_t kMinVertex_bytes = 6;
constexpr std::uint64_t kMinFace_bytes = 8;

/// The lines of a text with their words; empty ones and comments are left out.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  /// The words of the next line; none at the end.
  const std::vector<std::string_view>& Next() {
    words_.clear();
    while (words_.empty() && at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      Split(text_.substr(at_, end - at_));
      at_ = end + 1;
      ++number_;
    }
    return words_;
  }
  std::size_t number() const { return number_; }

 private:
  void Split(std::string_view line) {
    constexpr const char* kBlank = " \t\r";
    line = line.substr(0, line.find('#'));
    for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
      const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
      words_.push_back(line.substr(begin, end - begin));
      begin = line.find_first_not_of(kBlank, end);
    }
  }

  std::string_view text_;
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
};

}  // namespace

void CheckOff(const std::filesystem::path& file, std::string_view bytes) {
  Lines lines(bytes);
  const auto fail = [&](const std::string& what) {
    throw core::InputError(fmt::format("{}:{}: {}", file.string(), lines.number(), what));
  };
  std::vector<std::string_view> head = lines.Next();
  if (head.empty() || !head.front().ends_with("OFF")) return;  // assimp says what is wrong
  if (head.size() > 1 && head[1] == "BINARY") return;
  head.erase(head.begin());
  if (head.empty()) head = lines.Next();
  const auto count = [&](std::size_t i) {
    const auto n = i < head.size() ? core::NumberFrom<std::uint32_t>(head[i]) : std::nullopt;
    if (!n) fail("the numbers of vertices and faces must stand here, e.g. '8 12 0'");
    return n.value_or(0);
  };
  const std::uint32_t vertices = count(0);
  const std::uint32_t faces = count(1);
  if (kMinVertex_bytes * vertices + kMinFace_bytes * faces > bytes.size()) {
    fail(fmt::format("{} vertices and {} faces are declared; a file of {} bytes cannot hold them",
                     vertices, faces, bytes.size()));
  }
  for (std::uint32_t i = 0; i < vertices; ++i) {
    if (lines.Next().size() < 3) fail(fmt::format("vertex {} must have three coordinates", i));
  }
  for (std::uint32_t i = 0; i < faces; ++i) {
    const auto& words = lines.Next();
    const auto corners =
        words.empty() ? std::nullopt : core::NumberFrom<std::uint32_t>(words.front());
    if (!corners || words.size() <= *corners) {
      fail(fmt::format("face {} of {} must have a number of corners and as many vertices", i,
                       faces));
    }
    for (std::size_t k = 1; k <= *corners; ++k) {
      const auto vertex = core::NumberFrom<std::uint32_t>(words[k]);
      if (vertex && *vertex < vertices) continue;
      fail(fmt::format("face {} names vertex '{}'; there are {}, from 0", i, words[k], vertices));
    }
  }
}

}  // namespace rangegrasp::geometry::internal
