#include "seam/stitching/correction.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <pugixml.hpp>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "base/error.h"
#include "base/number.h"
#include "base/words.h"

namespace rangegrasp::stitching {
namespace {

[[noreturn]] void Fail(const std::string& what) {
  throw base::InputError("correction packet: " + what);
}

// The shortest text that reads back as the same number.
std::string Text(double value) {
  if (!std::isfinite(value))
    throw std::invalid_argument("correction packet: numbers must be finite");
  std::array<char, 32> text;
  const auto end = std::to_chars(text.begin(), text.end(), value).ptr;
  return {text.begin(), end};
}

void Append(pugi::xml_node root, const char* name, const std::string& text) {
  root.append_child(name).text().set(text.c_str());
}

void CheckElements(const pugi::xml_node& root) {
  constexpr std::array<std::string_view, 6> kNames = {"time_s",      "valid", "edge_x_m",
                                                      "deviation_m", "sure",  "stop"};
  std::array<int, kNames.size()> seen{};
  for (const pugi::xml_node& child : root.children()) {
    if (child.type() != pugi::node_element) Fail("<correction> holds text outside of its elements");
    const auto known = std::find(kNames.begin(), kNames.end(), std::string_view(child.name()));
    if (known == kNames.end()) Fail("unknown element <" + std::string(child.name()) + ">");
    if (++seen[static_cast<std::size_t>(known - kNames.begin())] > 1) {
      Fail("element <" + std::string(child.name()) + "> occurs twice");
    }
  }
}

std::string ReadText(const pugi::xml_node& root, const char* name) {
  const pugi::xml_node element = root.child(name);
  if (!element) Fail("element <" + std::string(name) + "> is missing");
  const pugi::xml_node inside = element.first_child();
  if (inside.next_sibling() || (inside && inside.type() != pugi::node_pcdata)) {
    Fail("element <" + std::string(name) + "> must hold one plain text");
  }
  return element.child_value();
}

double ReadNumber(const pugi::xml_node& root, const char* name) {
  const std::string text = ReadText(root, name);
  const auto value = base::NumberFrom<double>(text);
  if (!value || !std::isfinite(*value)) {
    Fail("<" + std::string(name) + ">: '" + text + "' is not a finite number");
  }
  return *value;
}

bool ReadBool(const pugi::xml_node& root, const char* name) {
  const std::string text = ReadText(root, name);
  if (text != "true" && text != "false") {
    Fail("<" + std::string(name) + ">: '" + text + "' is neither 'true' nor 'false'");
  }
  return text == "true";
}

std::optional<seam::StopReason> ReadStop(const pugi::xml_node& root) {
  if (!root.child("stop")) return std::nullopt;
  const std::string text = ReadText(root, "stop");
  return base::FromWord<seam::StopReason>(text, "correction packet: <stop>");
}

}  // namespace

std::string ToXml(const Correction& correction) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("correction");
  Append(root, "time_s", Text(correction.time_s));
  Append(root, "valid", correction.valid ? "true" : "false");
  Append(root, "edge_x_m", Text(correction.edge_x_m));
  Append(root, "deviation_m", Text(correction.deviation_m));
  if (correction.sure) Append(root, "sure", *correction.sure ? "true" : "false");
  if (correction.stop) Append(root, "stop", std::string(base::Word(*correction.stop)));
  std::ostringstream out;
  // One line a packet, so that a stream of packets can be cut at its line ends.
  document.save(out, "", pugi::format_raw | pugi::format_no_declaration);
  return out.str() + "\n";
}

Correction FromXml(const std::string& xml) {
  pugi::xml_document document;
  constexpr unsigned kOptions =
      pugi::parse_default | pugi::parse_trim_pcdata | pugi::parse_fragment;
  const auto parsed = document.load_buffer(xml.data(), xml.size(), kOptions, pugi::encoding_utf8);
  if (!parsed) {
    Fail(fmt::format("{} at byte {}", parsed.description(), parsed.offset));
  }
  const pugi::xml_node root = document.first_child();
  if (root.type() != pugi::node_element || std::string_view(root.name()) != "correction" ||
      root.next_sibling()) {
    Fail("must be one <correction> element and nothing else");
  }
  CheckElements(root);
  Correction correction;
  correction.time_s = ReadNumber(root, "time_s");
  correction.valid = ReadBool(root, "valid");
  correction.edge_x_m = ReadNumber(root, "edge_x_m");
  correction.deviation_m = ReadNumber(root, "deviation_m");
  if (root.child("sure")) correction.sure = ReadBool(root, "sure");
  correction.stop = ReadStop(root);
  return correction;
}

}  // namespace rangegrasp::stitching
