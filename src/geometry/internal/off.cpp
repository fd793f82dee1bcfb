#include "geometry/internal/off.h"

#include <cstdint>
#include <vector>

#include "base/number.h"
#include "geometry/internal/cloud_format.h"

namespace rangegrasp::geometry::internal {
namespace {

/// Of a line: "0 0 0" with its end, and "3 0 1 2" with its end, which may be absent.
constexpr std::uint64_t kMinVertex_bytes = 6;
constexpr std::uint64_t kMinFace_bytes = 8;

using OffWords = std::vector<std::string_view>;

/// The words of the next line that has some, without its comment; none at the end.
OffWords NextWords(LineReader& lines) {
  while (const auto line = lines.Next()) {
    OffWords words = Words(line->substr(0, line->find('#')));
    if (!words.empty()) return words;
  }
  return {};
}

struct Counts {
  std::uint32_t vertices = 0, faces = 0;
};

Counts ReadCounts(LineReader& lines, std::size_t bytes) {
  OffWords head = NextWords(lines);
  if (head.empty() || !head.front().ends_with("OFF") || head.front().find_first_of("4n") == 0) {
    lines.Fail("{} is none of OFF, COFF, NOFF, STOFF", head.empty() ? "\"\"" : Quoted(head[0]));
  }
  if (head.size() > 1 && head[1] == "BINARY") lines.Fail("a binary OFF is not read; text is");
  head.erase(head.begin());
  if (head.empty()) head = NextWords(lines);
  const auto count = [&](std::size_t i) {
    const auto n = i < head.size() ? base::NumberFrom<std::uint32_t>(head[i]) : std::nullopt;
    if (!n) lines.Fail("the numbers of vertices and faces must stand here, e.g. '8 12 0'");
    return *n;
  };
  const Counts counts{count(0), count(1)};
  if (kMinVertex_bytes * counts.vertices + kMinFace_bytes * counts.faces > bytes) {
    lines.Fail("{} vertices and {} faces are declared; a file of {} bytes cannot hold them",
               counts.vertices, counts.faces, bytes);
  }
  return counts;
}

}  // namespace

PolygonSoup ReadOff(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  const Counts counts = ReadCounts(lines, bytes.size());
  PolygonSoup soup;
  soup.points.resize(counts.vertices);
  for (std::size_t i = 0; i < counts.vertices; ++i) {
    const OffWords words = NextWords(lines);
    if (words.size() < 3) lines.Fail("vertex {} must have three coordinates", i);
    soup.points[i] = PointFrom(lines, words);
  }
  for (std::uint32_t i = 0; i < counts.faces; ++i) {
    const OffWords words = NextWords(lines);
    const auto corners =
        words.empty() ? std::nullopt : base::NumberFrom<std::uint32_t>(words.front());
    if (!corners || words.size() <= *corners) {
      lines.Fail("face {} of {} must have a number of corners and as many vertices", i,
                 counts.faces);
    }
    for (std::size_t k = 1; k <= *corners; ++k) {
      const auto vertex = base::NumberFrom<std::uint32_t>(words[k]);
      if (!vertex || *vertex >= counts.vertices) {
        lines.Fail("face {} names vertex '{}'; there are {}, from 0", i, words[k], counts.vertices);
      }
      soup.corner.push_back(*vertex);
    }
    soup.EndPolygon();
  }
  return soup;
}

}  // namespace rangegrasp::geometry::internal
