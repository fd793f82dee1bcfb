#pragma once

#include "experiment/grid.h"

namespace rangegrasp::report {
using experiment::CsvOf;
using experiment::Fixed;
using experiment::Grid;
using experiment::IntervalText;
using experiment::MarkdownOf;
using experiment::TextOf;
}  // namespace rangegrasp::report
