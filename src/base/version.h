#pragma once

#include <string>

namespace rangegrasp::base {

/// The version of the source, e.g. "0.1.0".
std::string Version();
/// The commit it was built from, with "+" if files were changed; "unknown" outside a checkout.
std::string Commit();

}  // namespace rangegrasp::base
