#pragma once

#include "experiment/statistics.h"

namespace rangegrasp::report {
using experiment::FisherExactLower;
using experiment::McNemarExact;
using experiment::WilsonInterval;
}  // namespace rangegrasp::report
