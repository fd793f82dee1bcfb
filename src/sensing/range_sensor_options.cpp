#include "sensing/range_sensor_options.h"

#include <stdexcept>

namespace rangegrasp::sensing {
namespace {

constexpr char kDropoutsDoNotBegin[] = "dropout_begin_deg must be less than dropout_end_deg";

bool DropoutsBegin(const RangeSensorOptions& options) {
  return options.dropout_begin_rad < options.dropout_end_rad;
}

}  // namespace

void FinishShared(const base::YamlMap& map, const RangeSensorOptions& options) {
  map.Finish();
  if (DropoutsBegin(options)) return;
  map.Fail(map.Has("dropout_begin_deg") ? "dropout_begin_deg" : "dropout_end_deg",
           kDropoutsDoNotBegin);
}

void CheckShared(const std::string& what, const RangeSensorOptions& options) {
  if (!DropoutsBegin(options)) throw std::invalid_argument(what + ": " + kDropoutsDoNotBegin);
}

}  // namespace rangegrasp::sensing
