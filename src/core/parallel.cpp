#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace rangegrasp::core {

void ForEach(int count, int jobs, const std::function<void(int, int)>& done,
             const std::function<void(int)>& task) {
  std::atomic<int> next{0};
  std::mutex mutex;
  int finished = 0;
  int failed = count;
  std::exception_ptr error;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      std::exception_ptr caught;
      try {
        task(i);
      } catch (...) {
        caught = std::current_exception();
      }
      const std::scoped_lock lock(mutex);
      if (caught) {
        next = count;
        if (i < failed) {
          failed = i;
          error = caught;
        }
      } else if (done) {
        done(++finished, count);
      }
    }
  };
  std::vector<std::jthread> threads;
  for (int t = 1; t < std::min(jobs, count); ++t) threads.emplace_back(work);
  work();
  threads.clear();
  if (error) std::rethrow_exception(error);
}

}  // namespace rangegrasp::core
