#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "experiment/grid.h"
#include "experiment/record.h"

namespace rangegrasp::trial {

/// Trials of one object whose static friction was within a bin.
struct FrictionBin {
  int detected = 0;
  int delivered = 0;
};
/// Width of a bin of the coefficient; a bin's number is its lower end over the width.
inline constexpr double kFrictionBin = 0.05;
/// By object, then by bin. Trials in which the target was not detected are left out: the hand never
/// touched it.
using FrictionCurve = std::map<std::string, std::map<int, FrictionBin>>;

FrictionCurve FrictionCurveOf(const std::vector<experiment::Record>& records);

/// Delivered of detected by bins, a row an object in the given order and one for all; without rows
/// if all trials are in one bin each (friction was not drawn).
experiment::Grid GridOf(const FrictionCurve& curve, const std::vector<std::string>& objects);

/// JSON array of {"object", "bins": [{"low", "high", "detected", "delivered"}]}.
nlohmann::ordered_json JsonOf(const FrictionCurve& curve, const std::vector<std::string>& objects);

}  // namespace rangegrasp::trial
