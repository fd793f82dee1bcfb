#pragma once

#include "robot/mjcf/names.h"

namespace rangegrasp::sim::internal {

using mjcf::Find;
using mjcf::InSubtree;
using mjcf::NumericOf;
using mjcf::Suffix;
using mjcf::TryFind;
using mjcf::TupleOf;

}  // namespace rangegrasp::sim::internal
