#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "parts/shape/clean_shape.h"

namespace rangegrasp::parts {

/// What a method found: one label an element, 0 .. parts-1; with a core, it is 0.
struct Segmentation {
  std::vector<std::int32_t> label;
  int parts = 0;
  bool has_core = false;
  std::string note;  ///< what the user should know (center moved, one part, ...), empty if nothing
};

/// Labels of the input's elements: those left out get the label of the nearest element that was
/// kept.
std::vector<std::int32_t> LabelsOfInput(const Shape& shape, const geometry::TriangleMesh& input,
                                        const Segmentation& segmentation);

/// Far-apart colors, the same for the same label everywhere; 0 (the core) is red as in the
/// chapter, below 0 grey.
std::array<std::uint8_t, 3> PartColor(std::int32_t label);

}  // namespace rangegrasp::parts
