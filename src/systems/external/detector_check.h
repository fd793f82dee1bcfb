#pragma once

#include <string>

#include "trial/cell.h"

namespace rangegrasp::external {

/// Asks the cell's detector, which is another program, about the first arrangement of up to three
/// objects, says what of its answers was understood, and the first thing that is wrong with its
/// cure; then whether a sandbox can be made here, whether the detector works in it, and whether it
/// gives the same answer to the same question.
/// @param text  receives it; ends with an end of line
/// @return whether the detector can be used
bool CheckAnswers(const trial::Cell& cell, std::string& text);

}  // namespace rangegrasp::external
