#include "geometry/internal/obj.h"

#include <cstdint>
#include <string>
#include <vector>

#include "base/number.h"
#include "geometry/internal/cloud_format.h"

namespace rangegrasp::geometry::internal {
namespace {

using ObjWords = std::vector<std::string_view>;

/// The next line; one that ends with a backslash goes on in the next one, which `joined` holds.
std::optional<std::string_view> NextLine(LineReader& lines, std::string& joined) {
  auto line = lines.Next();
  if (!line || !line->ends_with('\\')) return line;
  joined.clear();
  while (line) {
    const bool goes_on = line->ends_with('\\');
    joined += line->substr(0, line->size() - (goes_on ? 1 : 0));
    if (!goes_on) break;
    joined += ' ';
    line = lines.Next();
  }
  return joined;
}

/// Of "7", "7/1", "7//3", "7/1/3"; counted from 1, below 0 from the last one back.
std::uint32_t VertexOf(const LineReader& lines, std::string_view word, std::size_t vertices) {
  const auto number = base::NumberFrom<std::int64_t>(word.substr(0, word.find('/')));
  const auto n = static_cast<std::int64_t>(vertices);
  if (!number || *number == 0 || *number > n || *number < -n) {
    lines.Fail("a face names vertex {}; there are {} up to here, from 1", Quoted(word), vertices);
  }
  return static_cast<std::uint32_t>(*number > 0 ? *number - 1 : n + *number);
}

}  // namespace

PolygonSoup ReadObj(const std::filesystem::path& file, std::string_view bytes) {
  LineReader lines(bytes, file);
  PolygonSoup soup;
  std::string joined;
  while (const auto line = NextLine(lines, joined)) {
    ObjWords words = Words(line->substr(0, line->find('#')));
    if (words.empty() || (words[0] != "v" && words[0] != "f")) continue;
    const bool vertex = words[0] == "v";
    words.erase(words.begin());
    if (vertex) {
      if (words.size() < 3) lines.Fail("a vertex must have three coordinates");
      soup.points.push_back(PointFrom(lines, words));
      continue;
    }
    for (const std::string_view word : words) {
      soup.corner.push_back(VertexOf(lines, word, soup.points.size()));
    }
    soup.EndPolygon();
  }
  return soup;
}

}  // namespace rangegrasp::geometry::internal
