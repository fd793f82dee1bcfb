#pragma once

#include <span>
#include <string>

namespace rangegrasp::report::internal {

/// Bytes as RFC 4648 writes them, padded: what a browser's atob reads.
std::string Base64(std::span<const unsigned char> bytes);

}  // namespace rangegrasp::report::internal
