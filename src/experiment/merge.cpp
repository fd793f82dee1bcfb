#include "experiment/merge.h"

#include <sys/resource.h>

#include <queue>

#include "base/error.h"
#include "experiment/store.h"

namespace rangegrasp::experiment {
namespace {

// A shard that is being read, and its next record.
struct Source {
  Store store;
  Store::Cursor cursor;
  Record next;
};

// The smallest id first; of equal ones that of the shard that was named first.
struct Later {
  const std::vector<std::unique_ptr<Source>>& sources;
  bool operator()(std::size_t a, std::size_t b) const {
    const int order = sources[a]->next.which.id.compare(sources[b]->next.which.id);
    return order != 0 ? order > 0 : a > b;
  }
};

struct Incomplete : std::exception {};

// An SQLite file in use holds up to three file descriptors: a thousand shards want more than the
// usual soft limit.
void AllowManyFiles() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

Merged Merge(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& out,
             bool complete) {
  if (Store::Exists(out)) {
    throw base::InputError(out.string() + ": holds results already; name a new folder");
  }
  AllowManyFiles();
  const Stamp stamp = Store::Open(shards.front()).ReadStamp();
  Merged merged;
  merged.expected = std::stoull(Need(stamp.identity, "cases"));
  std::vector<std::unique_ptr<Source>> sources;
  std::priority_queue<std::size_t, std::vector<std::size_t>, Later> queue(Later{sources});
  for (const auto& folder : shards) {
    Store store = Store::Open(folder);
    CheckSameRun(store.ReadStamp(), stamp, folder.string());
    Store::Cursor cursor(store);
    auto first = cursor.Next();
    if (!first) continue;
    sources.push_back(
        std::make_unique<Source>(std::move(store), std::move(cursor), std::move(*first)));
    queue.push(sources.size() - 1);
  }
  std::string last_id;
  const auto smallest = [&]() -> std::optional<Record> {
    if (queue.empty()) {
      if (complete && merged.cases < merged.expected) throw Incomplete();
      return std::nullopt;
    }
    const std::size_t top = queue.top();
    queue.pop();
    Source& source = *sources[top];
    Record record = std::move(source.next);
    if (record.which.id == last_id) {
      throw base::InputError(source.store.file().parent_path().string() + ": case " + last_id +
                             " is in another of the folders too");
    }
    last_id = record.which.id;
    if (auto next = source.cursor.Next()) {
      source.next = std::move(*next);
      queue.push(top);
    }
    ++merged.cases;
    return record;
  };
  try {
    Store::WriteWhole(out, stamp, smallest);
  } catch (const Incomplete&) {
    // Nothing was written.
  }
  return merged;
}

}  // namespace rangegrasp::experiment
