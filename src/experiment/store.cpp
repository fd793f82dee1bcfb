#include "experiment/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

namespace fs = std::filesystem;

// Times have their own table: everything else depends only on the experiment and the case.
constexpr const char* kSchema = R"(
  CREATE TABLE IF NOT EXISTS stamp(part TEXT NOT NULL, name TEXT NOT NULL, value TEXT NOT NULL,
    PRIMARY KEY(part, name)) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS cases(
    id TEXT PRIMARY KEY, position INTEGER NOT NULL, case_group TEXT NOT NULL, seed TEXT NOT NULL, params TEXT NOT NULL,
    outcome TEXT NOT NULL, stage TEXT NOT NULL, detail TEXT NOT NULL, data TEXT NOT NULL) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS seconds(id TEXT NOT NULL, position INTEGER NOT NULL, stage TEXT NOT NULL,
    seconds REAL NOT NULL, PRIMARY KEY(id, position)) WITHOUT ROWID;
)";
constexpr const char* kFile = "results.sqlite";
constexpr const char* kUnfinished = "results.sqlite.unfinished";  // written by WriteWhole
// For a run that writes one row at a time: every page that a row changes goes to the log.
constexpr const char* kGrowing = "PRAGMA journal_mode=WAL";
// Results that are written at once need no log. A row has about 3 KB: with the default page size of
// 4 KB each row would need its own overflow page.
constexpr const char* kWritten = "PRAGMA page_size=32768; PRAGMA journal_mode=OFF";
// Parts of a stamp.
using StampPart = std::map<std::string, std::string> Stamp::*;
constexpr std::array<std::pair<const char*, StampPart>, 3> kStampParts = {
    {{"identity", &Stamp::identity}, {"build", &Stamp::build}, {"data", &Stamp::data}}};
// How long a reader or writer waits for the other's transaction.
constexpr int kBusy_ms = 10000;

// Writes "process 4711 on host", for the message to processes that are refused.
void WriteHolder(int descriptor) {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  const std::string text = fmt::format("process {} on {}", getpid(), host.data());
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, text.data(), text.size(), 0) < 0) return;
}

std::string HolderIn(int descriptor) {
  std::array<char, 512> text{};
  const auto size = pread(descriptor, text.data(), text.size(), 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "another process";
}

struct Database {
  fs::path file;
  sqlite3* handle = nullptr;

  Database() = default;
  ~Database() { sqlite3_close(handle); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  // Whether the file is damaged, or has other tables than this program's.
  bool IsNoStore() const {
    const int code = sqlite3_errcode(handle);
    return code == SQLITE_CORRUPT || code == SQLITE_NOTADB || code == SQLITE_ERROR;
  }
  [[noreturn]] void Fail() const {
    const std::string what = file.string() + ": " + sqlite3_errmsg(handle);
    if (IsNoStore()) {
      throw base::InputError(what +
                             " (the file is damaged, or contains no results of this program)");
    }
    throw base::RunError(what + (sqlite3_errcode(handle) == SQLITE_BUSY
                                     ? " (another program is using the file)"
                                     : " (is the disk full, or the folder not writable?)"));
  }
  void Run(const char* sql) const {
    if (sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) != SQLITE_OK) Fail();
  }
  // The file may be untrusted: its triggers, and views in place of tables, are disabled, and
  // damaged pages are detected.
  void Distrust() const {
    sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_exec(handle, "PRAGMA cell_size_check=ON", nullptr, nullptr, nullptr);
  }
  // Opens the file for reading. Next to the file of a killed run, SQLite creates auxiliary files,
  // unless it reads the file unchanged and without a log (`as_it_is`).
  bool Reads(bool as_it_is) {
    sqlite3_close(handle);
    std::string name = "file:";  // a URI, in which some characters are special
    for (const char c : file.string())
      name += std::strchr("%?#", c) ? fmt::format("%{:02x}", c) : std::string(1, c);
    if (as_it_is) name += "?immutable=1";
    if (sqlite3_open_v2(name.c_str(), &handle, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr) !=
        SQLITE_OK) {
      return false;
    }
    Distrust();
    return sqlite3_exec(handle, "SELECT id FROM cases LIMIT 1", nullptr, nullptr, nullptr) ==
           SQLITE_OK;
  }
  // Runs `write` in a transaction: all of its changes are written, or none.
  void Transaction(const std::function<void()>& write) const {
    Run("BEGIN IMMEDIATE");
    try {
      write();
      Run("COMMIT");
    } catch (...) {
      sqlite3_exec(handle, "ROLLBACK", nullptr, nullptr, nullptr);
      throw;
    }
  }
};

// A prepared statement. Errors throw as Database::Fail does.
class Statement {
 public:
  Statement(const Database& database, const std::string& sql) : database_(database) {
    if (sqlite3_prepare_v2(database.handle, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) {
      database.Fail();
    }
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Goes to the next row. @return whether there is one
  bool Step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) database_.Fail();
    return code == SQLITE_ROW;
  }
  std::string Text(int column) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    if (!text) return "";
    return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }
  int Int(int column) const { return sqlite3_column_int(statement_, column); }
  double Double(int column) const { return sqlite3_column_double(statement_, column); }

  // Runs the statement with these values; may be called again.
  template <typename... Values>
  void Run(const Values&... values) {
    sqlite3_reset(statement_);
    int position = 0;
    (Bind(++position, values), ...);
    Step();
  }

  void Bind(int position, const std::string& text) {
    sqlite3_bind_text(statement_, position, text.c_str(), static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
  }

 private:
  void Bind(int position, int value) { sqlite3_bind_int(statement_, position, value); }
  void Bind(int position, double value) { sqlite3_bind_double(statement_, position, value); }

  const Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

// Writes records, one after the other.
class RecordWriter {
 public:
  explicit RecordWriter(const Database& database)
      : case_(database, "INSERT OR REPLACE INTO cases VALUES(?,?,?,?,?,?,?,?,?)"),
        seconds_(database, "INSERT INTO seconds VALUES(?,?,?,?)") {}

  void Write(const Record& record) {
    const auto& [c, r] = record;
    case_.Run(c.id, c.position, c.group, std::to_string(c.seed), ToJson(c.params), r.outcome,
              r.stage, r.detail, r.data);
    for (std::size_t i = 0; i < r.seconds.size(); ++i) {
      seconds_.Run(c.id, static_cast<int>(i), r.seconds[i].first, r.seconds[i].second);
    }
  }

 private:
  Statement case_, seconds_;
};

fs::path FileIn(const fs::path& folder) { return folder / kFile; }

std::optional<std::uint64_t> SeedOf(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (!name.starts_with(kSeedPrefix) || !Store::Exists(folder)) return std::nullopt;
  return base::NumberFrom<std::uint64_t>(name.substr(kSeedPrefix.size()));
}

// Adopts the order of the other stamp's groups, if the groups are the same.
void OrderGroupsAs(const Stamp& other, Stamp& stamp) {
  const auto sorted = [](const std::string& groups) {
    auto names = base::Split(groups, ',');
    std::ranges::sort(names);
    return names;
  };
  std::string& groups = stamp.identity["groups"];
  const std::string wanted = ValueOr(other.identity, "groups", groups);
  if (sorted(groups) == sorted(wanted)) groups = wanted;
}

// Fails, with the stamp's own folder, if it lacks what is joined.
void CheckJoins(const Stamp& stamp, const fs::path& folder) {
  InFolder(folder, [&] { Need(stamp.identity, "seed"); });
  CasesOf(stamp, folder.string());
}

// Runs of several seeds may differ only in the seed, the number of cases, and the order of groups,
// which hazards draw at random.
void Join(const Stamp& stamp, const std::string& folder, Stamp& pooled) {
  const std::string seeds = Need(pooled.identity, "seed") + "," + Need(stamp.identity, "seed");
  const auto cases = CasesOf(pooled, folder) + CasesOf(stamp, folder);
  Stamp alike = stamp;
  alike.identity["seed"] = pooled.identity.at("seed");
  alike.identity["cases"] = pooled.identity.at("cases");
  OrderGroupsAs(pooled, alike);
  CheckSameRun(alike, pooled, folder, "only runs that differ in their seeds have a common table");
  pooled.identity["seed"] = seeds;
  pooled.identity["cases"] = std::to_string(cases);
  const auto of = [&](const char* name) { return ValueOr(stamp.build, name, ""); };
  for (const std::string& commit : base::Split(of("commit") + "," + of("resumed_with"), ',')) {
    AddCommit(commit, pooled);
  }
}

// A shard that is being read, and its next record.
struct Source {
  explicit Source(const fs::path& folder) : store(Store::Open(folder)), cursor(store) {}

  Store store;
  Store::Cursor cursor;
  std::optional<Record> next = {};
};

// An SQLite file in use has up to three descriptors: a thousand shards exceed the usual soft limit.
void AllowManyFiles() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

// A folder without its own results may hold the folders of several seeds.
[[noreturn]] void FailWithoutResults(const fs::path& folder) {
  const auto stores = StoresIn(folder);
  std::vector<std::string> seeds;
  for (const auto& store : stores) seeds.push_back(store.string());
  throw base::InputError(folder.string() + ": no results here (no results.sqlite); give " +
                         (stores.front() == folder
                              ? "the results folder of `run`"
                              : "the folder of one seed: " + base::Join(seeds, " or ")));
}

void RefuseResultsIn(const fs::path& folder) {
  if (!Store::Exists(folder)) return;
  throw base::InputError(folder.string() + ": already contains results; name a new folder");
}

}  // namespace

struct Store::Impl : Database {
  bool grows = false;

  // Turns the results of a run into one file that can be read from a read-only place, without the
  // log and its index. A process that is reading at this moment keeps those files.
  ~Impl() { BecomeOneFile(); }
  int BecomeOneFile() {
    if (!std::exchange(grows, false)) return SQLITE_OK;
    sqlite3_busy_timeout(handle, 0);
    return sqlite3_exec(handle, "PRAGMA journal_mode=DELETE", nullptr, nullptr, nullptr);
  }
};

FolderLock::FolderLock(const fs::path& folder) : file_(folder / kFile), owner_(getpid()) {
  std::error_code error;
  fs::create_directories(folder, error);
  for (;;) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno != EMFILE && errno != ENFILE && errno != ENOMEM) {
      return;  // Store::Create reports the problem of the folder
    }
    if (descriptor_ < 0) {
      throw base::RunError(file_.string() + ": cannot be opened: " + std::strerror(errno));
    }
    struct flock lock {};
    lock.l_type = F_WRLCK;
    if (fcntl(descriptor_, F_SETLK, &lock) != 0) {
      const int why = errno;
      const std::string holder = HolderIn(descriptor_);
      close(descriptor_);
      if (why != EACCES && why != EAGAIN) {
        throw base::RunError(file_.string() + ": cannot be locked: " + std::strerror(why));
      }
      throw base::InputError(folder.string() + ": is being written to by " + holder +
                             "; wait for it, or choose another folder (--out DIR)");
    }
    // The previous holder may have removed the file between opening and locking.
    struct stat opened {};
    struct stat named {};
    fstat(descriptor_, &opened);
    if (stat(file_.c_str(), &named) == 0 && named.st_ino == opened.st_ino) break;
    close(descriptor_);
  }
  WriteHolder(descriptor_);
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  if (getpid() == owner_) unlink(file_.c_str());
  close(descriptor_);
}

Store::Store(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Store::~Store() = default;
Store::Store(Store&&) noexcept = default;

const fs::path& Store::file() const { return impl_->file; }

bool Store::Exists(const fs::path& folder) {
  std::error_code error;
  return fs::exists(FileIn(folder), error);
}

Store Store::Create(const fs::path& folder) {
  Store store = CreateFile(folder, kFile, kGrowing);
  store.impl_->grows = true;
  return store;
}

Store Store::CreateFile(const fs::path& folder, const char* name, const char* pragmas) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw base::InputError(folder.string() +
                           ": the output folder cannot be created: " + error.message());
  }
  auto impl = std::make_unique<Impl>();
  impl->file = folder / name;
  const auto refuse = [&] {
    const int code = sqlite3_errcode(impl->handle) & 0xff;
    const bool has_errno = code == SQLITE_CANTOPEN || code == SQLITE_IOERR;
    const int why = has_errno ? sqlite3_system_errno(impl->handle) : 0;
    throw base::InputError(
        impl->file.string() + ": " + sqlite3_errmsg(impl->handle) + " (" +
        (why != 0 ? std::strerror(why) : "a writable folder with free space is needed") + ")");
  };
  if (sqlite3_open(impl->file.c_str(), &impl->handle) != SQLITE_OK) refuse();
  sqlite3_busy_timeout(impl->handle, kBusy_ms);
  impl->Distrust();
  for (const char* sql : {pragmas, "PRAGMA synchronous=NORMAL", kSchema}) {
    if (sqlite3_exec(impl->handle, sql, nullptr, nullptr, nullptr) != SQLITE_OK) refuse();
  }
  return Store(std::move(impl));
}

Store Store::Open(const fs::path& folder) {
  if (!Exists(folder)) FailWithoutResults(folder);
  const auto why = base::WhyUnfit(FileIn(folder));
  if (!why.empty()) throw base::InputError(FileIn(folder).string() + ": " + why);
  auto impl = std::make_unique<Impl>();
  impl->file = FileIn(folder);
  std::error_code error;
  const bool has_log = fs::file_size(folder / (std::string(kFile) + "-wal"), error) > 0 && !error;
  if (!impl->Reads(/*as_it_is=*/false) && (has_log || !impl->Reads(/*as_it_is=*/true))) {
    if (impl->IsNoStore()) impl->Fail();
    throw base::InputError(
        impl->file.string() + ": the results cannot be read: " + sqlite3_errmsg(impl->handle) +
        (has_log ? "; the run was killed, or is still running: copy the folder to a writable place"
                 : ""));
  }
  return Store(std::move(impl));
}

void Store::Remove(const fs::path& folder) {
  for (const char* ending : {"", "-wal", "-shm"}) {
    fs::remove(folder / (std::string(kFile) + ending));
  }
}

void Store::WriteStamp(const Stamp& stamp) {
  impl_->Transaction([&] {
    impl_->Run("DELETE FROM stamp");
    Statement insert(*impl_, "INSERT INTO stamp VALUES(?, ?, ?)");
    for (const auto& [word, part] : kStampParts) {
      for (const auto& [name, value] : stamp.*part) insert.Run(std::string(word), name, value);
    }
  });
}

Stamp Store::ReadStamp() const {
  Stamp stamp;
  Statement select(*impl_, "SELECT part, name, value FROM stamp");
  while (select.Step()) {
    for (const auto& [word, part] : kStampParts) {
      if (select.Text(0) == word) (stamp.*part)[select.Text(1)] = select.Text(2);
    }
  }
  return stamp;
}

void Store::Write(const Record& record) {
  impl_->Transaction([&] {
    Statement(*impl_, "DELETE FROM seconds WHERE id = ?").Run(record.which.id);
    RecordWriter(*impl_).Write(record);
  });
}

std::vector<Record> Store::ReadAll() const {
  std::vector<Record> records;
  Cursor cursor(*this);
  while (auto record = cursor.Next()) records.push_back(std::move(*record));
  std::ranges::stable_sort(records, {}, [](const Record& record) { return record.which.position; });
  return records;
}

void Store::Finish() {
  const int code = impl_->BecomeOneFile();
  if (code != SQLITE_OK && code != SQLITE_BUSY && code != SQLITE_LOCKED) impl_->Fail();
}

int Store::Count() const {
  Statement select(*impl_, "SELECT COUNT(*) FROM cases");
  select.Step();
  return select.Int(0);
}

std::unordered_set<std::string> Store::Ids(const std::string& but) const {
  std::unordered_set<std::string> ids;
  Statement select(*impl_, "SELECT id FROM cases WHERE outcome <> ?");
  select.Bind(1, but);
  while (select.Step()) ids.insert(select.Text(0));
  return ids;
}

struct Store::Cursor::Impl {
  fs::path file;
  Statement times, cases;
  bool times_left;

  explicit Impl(const Database& database)
      : file(database.file),
        times(database, "SELECT id, stage, seconds FROM seconds ORDER BY id, position"),
        cases(database,
              "SELECT id, case_group, seed, params, position, outcome, stage, detail, data, "
              "json_valid(data) AND substr(data, 1, 1) = '{' FROM cases ORDER BY id"),
        times_left(times.Step()) {}
};

Store::Cursor::Cursor(const Store& store) : impl_(std::make_unique<Impl>(*store.impl_)) {}
Store::Cursor::~Cursor() = default;
Store::Cursor::Cursor(Cursor&&) noexcept = default;

std::optional<Record> Store::Cursor::Next() {
  auto& [file, times, cases, times_left] = *impl_;
  if (!cases.Step()) return std::nullopt;
  const auto fail = [&](const std::string& what) {
    throw base::InputError(fmt::format("{}: case {}: {}", file.string(), cases.Text(0), what));
  };
  const auto seed = base::NumberFrom<std::uint64_t>(cases.Text(2));
  if (!seed) fail("its seed '" + base::Excerpt(cases.Text(2)) + "' is not a whole number");
  Params params;
  try {
    params = Params::FromJson(cases.Text(3));
  } catch (const base::InputError& e) {
    fail(e.what());
  }
  // The database accepts numbers that no double can hold.
  const bool is_json = cases.Int(9) != 0 && nlohmann::json::accept(cases.Text(8));
  if (!is_json) {
    fail("its data are damaged: no JSON object: '" + base::Excerpt(cases.Text(8)) + "'");
  }
  Record record{{cases.Text(0), cases.Text(1), *seed, std::move(params), cases.Int(4)},
                {cases.Text(5), cases.Text(6), cases.Text(7), cases.Text(8), {}}};
  // A run in progress may have added a case since the first row was read.
  while (times_left && times.Text(0) <= record.which.id) {
    if (times.Text(0) == record.which.id) {
      record.result.seconds.emplace_back(times.Text(1), times.Double(2));
    }
    times_left = times.Step();
  }
  return record;
}

void Store::WriteWhole(const fs::path& folder, const Stamp& stamp,
                       const std::function<std::optional<Record>()>& next) {
  std::optional<FolderLock> lock(std::in_place, folder);
  RefuseResultsIn(folder);
  const auto unfinished = folder / kUnfinished;
  std::error_code error;
  fs::remove(unfinished, error);  // left by a killed program
  try {
    Store store = CreateFile(folder, kUnfinished, kWritten);
    store.WriteStamp(stamp);
    store.impl_->Run("BEGIN");
    RecordWriter writer(*store.impl_);
    while (const auto record = next()) writer.Write(*record);
    store.impl_->Run("COMMIT");
    fs::rename(unfinished, FileIn(folder), error);
    if (error) {
      throw base::RunError(FileIn(folder).string() + ": cannot be written: " + error.message());
    }
  } catch (...) {
    fs::remove(unfinished, error);
    lock.reset();
    fs::remove(folder, error);  // only if it is empty
    throw;
  }
}

fs::path SeedFolder(const fs::path& folder, std::uint64_t seed) {
  return folder / (std::string(kSeedPrefix) + std::to_string(seed));
}

std::vector<fs::path> StoresIn(const fs::path& folder) {
  if (Store::Exists(folder) || !fs::is_directory(folder)) return {folder};
  std::map<std::uint64_t, fs::path> by_seed;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (const auto seed = SeedOf(entry.path())) by_seed[*seed] = entry.path();
  }
  if (by_seed.empty()) return {folder};
  const auto stores = std::views::values(by_seed);
  return {stores.begin(), stores.end()};
}

Results ReadResults(const fs::path& folder) {
  Results results;
  const auto stores = StoresIn(folder);
  for (const auto& path : stores) {
    const Store store = Store::Open(path);
    results.folder = folder;
    const Stamp stamp = store.ReadStamp();
    if (stores.size() > 1) CheckJoins(stamp, path);
    if (results.stamp.identity.empty()) {
      results.stamp = stamp;
    } else {
      Join(stamp, path.string(), results.stamp);
    }
    auto records = store.ReadAll();
    if (results.records.empty()) {
      results.records = std::move(records);  // no copy: a million records take 4 GB
    } else {
      std::move(records.begin(), records.end(), std::back_inserter(results.records));
    }
  }
  return results;
}

Merged Merge(const std::vector<fs::path>& shards, const fs::path& out, bool complete) {
  RefuseResultsIn(out);  // before anything is read
  AllowManyFiles();
  const Stamp stamp = Store::Open(shards.front()).ReadStamp();
  Merged merged{.cases = 0, .expected = CasesOf(stamp, shards.front().string())};
  std::vector<Source> sources;
  for (const auto& folder : shards) {
    const Store& store = sources.emplace_back(folder).store;
    CheckSameRun(store.ReadStamp(), stamp, folder.string(),
                 "`merge` joins shards of one run; for runs of several seeds, give `table` the "
                 "folder that contains theirs");
    merged.cases += static_cast<std::size_t>(store.Count());
  }
  if (complete && merged.cases < merged.expected) return merged;
  std::map<std::string, Source*> by_next_id;
  const auto read_next = [&](Source& source) {
    source.next = source.cursor.Next();
    if (!source.next) return;
    const auto [other, is_new] = by_next_id.try_emplace(source.next->which.id, &source);
    if (is_new) return;
    const Source& later = *std::max(other->second, &source);
    throw base::InputError(later.store.file().parent_path().string() + ": case " + other->first +
                           " is also in another of the folders");
  };
  for (Source& source : sources) read_next(source);
  Store::WriteWhole(out, stamp, [&]() -> std::optional<Record> {
    if (by_next_id.empty()) return std::nullopt;
    Source& source = *by_next_id.extract(by_next_id.begin()).mapped();
    Record record = std::move(*source.next);
    read_next(source);
    return record;
  });
  return merged;
}

}  // namespace rangegrasp::experiment
