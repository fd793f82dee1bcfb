#pragma once

#include <cstdint>
#include <span>

namespace rangegrasp::parts {

/// 1 - Rand index of two labellings of the same elements, unweighted (Chen et al. 2009):
/// (sum_i C(n_i, 2) + sum_j C(m_j, 2) - 2 sum_ij C(n_ij, 2)) / C(N, 2) with the sizes of the
/// segments of one, of the other, and of their intersections. O(n log n).
/// @throws std::invalid_argument if the lengths differ or are below 2.
double RandError(std::span<const std::int32_t> a, std::span<const std::int32_t> b);

}  // namespace rangegrasp::parts
