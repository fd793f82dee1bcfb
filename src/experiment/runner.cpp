#include "experiment/runner.h"

#include <poll.h>

#include <algorithm>
#include <memory>

#include "experiment/internal/worker.h"

namespace rangegrasp::experiment {

using internal::Worker;

std::vector<Case> ShardOf(const std::vector<Case>& cases, int shard, int shards) {
  std::vector<Case> mine;
  for (auto i = static_cast<std::size_t>(shard - 1); i < cases.size();
       i += static_cast<std::size_t>(shards)) {
    mine.push_back(cases[i]);
  }
  return mine;
}

std::vector<Case> Missing(const std::vector<Case>& cases, const Store& store) {
  const auto done = store.Ids();
  std::vector<Case> missing;
  std::copy_if(cases.begin(), cases.end(), std::back_inserter(missing),
               [&](const Case& c) { return !done.contains(c.id); });
  return missing;
}

namespace {

// Waits until a worker has something to say or has used up its time.
std::vector<pollfd> Wait(const std::vector<std::unique_ptr<Worker>>& running) {
  std::vector<pollfd> waits;
  double soonest_s = running.front()->Left();
  for (const auto& worker : running) {
    waits.push_back({worker->pipe(), POLLIN, 0});
    soonest_s = std::min(soonest_s, worker->Left());
  }
  poll(waits.data(), waits.size(), std::max(1, static_cast<int>(soonest_s * 1000.0)));
  return waits;
}

}  // namespace

Result RunApart(const Case& which, double limit_s, const std::function<Result(const Case&)>& run) {
  std::vector<std::unique_ptr<Worker>> one;
  one.push_back(std::make_unique<Worker>(which, limit_s, run));
  Worker& worker = *one.front();
  while (worker.Left() > 0.0) {
    if (Wait(one).front().revents != 0 && worker.Read()) return worker.Finish();
  }
  return worker.TimeOut();
}

void RunCases(const std::vector<Case>& cases, const std::function<Result(const Case&)>& run,
              Store& store, const RunOptions& options, const Progress& progress) {
  RunCases(cases, run, options, [&](int done, int total, const Record& record) {
    store.Write(record);
    if (progress) progress(done, total, record);
  });
}

void RunCases(const std::vector<Case>& cases, const std::function<Result(const Case&)>& run,
              const RunOptions& options, const Progress& done) {
  const int total = static_cast<int>(cases.size());
  std::vector<std::unique_ptr<Worker>> running;
  std::size_t next = 0;
  int ended_cases = 0;
  while (next < cases.size() || !running.empty()) {
    while (next < cases.size() && running.size() < static_cast<std::size_t>(options.jobs)) {
      running.push_back(std::make_unique<Worker>(cases[next++], options.case_limit_s, run));
    }
    const auto waits = Wait(running);
    for (std::size_t i = running.size(); i-- > 0;) {
      const bool ended = waits[i].revents != 0 && running[i]->Read();
      if (!ended && running[i]->Left() > 0.0) continue;
      const Record record{running[i]->which(),
                          ended ? running[i]->Finish() : running[i]->TimeOut()};
      running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
      done(++ended_cases, total, record);
    }
  }
}

}  // namespace rangegrasp::experiment
