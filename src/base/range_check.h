#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace rangegrasp::base {

/// Takes the place of a YamlMap where options were not read but made in code: the function that
/// reads them key by key checks them against the same ranges, and changes nothing.
///
///     template <typename Source> void ReadKeys(Source& from, Options& options) {
///       from.ReadScaled("width_mm", options.width_m, kMm, 0.1, 50.0, "width of the line");
///     }
///
/// Every method throws std::invalid_argument as "what: key: 70 is out of range, must be from 0.1 to
/// 50", in the key's unit.
class RangeCheck {
 public:
  explicit RangeCheck(std::string what) : what_(std::move(what)) {}

  void Read(const std::string&, bool, const std::string& = "") const {}
  void Read(const std::string& key, int value, int low, int high, const std::string& = "") const {
    if (value < low || value > high) Fail(key, value, low, high);
  }
  void ReadScaled(const std::string& key, double value, double unit, double low, double high,
                  const std::string& = "") const {
    // A relative slack, for a bound that went to SI units and back.
    const double slack = 1e-9 * std::max(std::abs(low), std::abs(high));
    const double in_unit = value / unit;
    if (!(in_unit >= low - slack && in_unit <= high + slack)) Fail(key, in_unit, low, high);
  }
  void Read(const std::string& key, double value, double low, double high,
            const std::string& doc = "") const {
    ReadScaled(key, value, 1.0, low, high, doc);
  }

 private:
  template <typename Number>
  [[noreturn]] void Fail(const std::string& key, Number value, Number low, Number high) const {
    throw std::invalid_argument(fmt::format(
        "{}: {}: {:g} is out of range, must be from {:g} to {:g}", what_, key,
        static_cast<double>(value), static_cast<double>(low), static_cast<double>(high)));
  }

  std::string what_;
};

}  // namespace rangegrasp::base
