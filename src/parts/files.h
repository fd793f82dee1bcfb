#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "parts/shape.h"

namespace rangegrasp::parts {

/// .seg: line i is the label of element i. @throws core::InputError naming file and line (also if
/// there are not `elements`).
std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file, std::size_t elements);
/// The same, as many elements as there are lines.
std::vector<std::int32_t> ReadLabels(const std::filesystem::path& file);
/// @throws core::RunError if it cannot be written whole.
void WriteLabels(const std::filesystem::path& file, std::span<const std::int32_t> labels);
/// Binary PLY with a colour a face (mesh) or a point (cloud). @throws core::RunError;
/// std::invalid_argument if there is not one label an element.
void WriteColoredShape(const std::filesystem::path& file, const geometry::TriangleMesh& input,
                       std::span<const std::int32_t> labels);
/// Far-apart colours, the same for the same label everywhere; 0 (the core) is red as in the
/// chapter, below 0 grey.
std::array<std::uint8_t, 3> PartColor(std::int32_t label);

}  // namespace rangegrasp::parts
