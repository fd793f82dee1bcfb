#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace rangegrasp::experiment {

/// Figures beside each other, one a label and series; how they are drawn is up to what draws them.
struct Chart {
  struct Value {
    std::optional<double> value;                     ///< absent: nothing was counted
    std::optional<std::pair<double, double>> range;  ///< low and high end; with a value only
    std::string of;                                  ///< what it is made from: "3 of 10"
  };
  struct Series {
    std::string name;
    std::vector<Value> values;  ///< one a label
  };
  std::string title;
  std::string unit;   ///< "%", "s", "trials"
  std::string along;  ///< what the labels are: "object"
  std::string note;   ///< a sentence below it; may be empty
  /// Values of a label add up and are drawn as one bar; if not, each is a mark with its range.
  bool stacked = false;
  std::vector<std::string> labels;
  std::vector<Series> series;
};

/// k of n.
struct Count {
  int k = 0;
  int n = 0;
};
/// In per cent, with Wilson's 95 % interval; no value for n = 0.
Chart::Value PercentOf(const Count& count);

}  // namespace rangegrasp::experiment
