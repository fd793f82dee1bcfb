#pragma once

#include <functional>

namespace rangegrasp::core {

/// Calls task(0) .. task(count - 1) on `jobs` threads, in any order; `done` (may be empty) is
/// called after each with how many are done, one call at a time. Tasks must not share what they
/// write.
/// @throws what the first failing task (by number) threw, after the others that had begun are done.
void ForEach(int count, int jobs, const std::function<void(int done, int total)>& done,
             const std::function<void(int)>& task);

}  // namespace rangegrasp::core
