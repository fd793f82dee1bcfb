#include "experiment/store.h"

#include <sqlite3.h>

#include <functional>
#include <unordered_map>
#include <utility>

#include "base/error.h"

namespace rangegrasp::experiment {
namespace {

// Times stand in a table of their own: all else depends on the experiment and the case alone.
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
constexpr const char* kUnfinished = "results.sqlite.unfinished";  // of WriteWhole
constexpr const char* kInsertCase = "INSERT OR REPLACE INTO cases VALUES(?,?,?,?,?,?,?,?,?)";
constexpr const char* kInsertSeconds = "INSERT INTO seconds VALUES(?,?,?,?)";
constexpr const char* kSelectCases =
    "SELECT id, case_group, seed, params, position, outcome, stage, detail, data FROM cases ";
// While a run writes a row at a time, every page that a row touches goes to the log.
constexpr const char* kGrowing = "PRAGMA journal_mode=WAL";
// What is written at once needs no log. A row holds about 3 KB: in pages of the default 4 KB each
// would need an overflow page of its own.
constexpr const char* kWritten = "PRAGMA page_size=32768; PRAGMA journal_mode=OFF";
// Parts of a stamp.
constexpr const char* kIdentity = "identity";
constexpr const char* kBuild = "build";
constexpr const char* kData = "data";
// How long a reader or writer waits for the other's transaction.
constexpr int kBusy_ms = 10000;

}  // namespace

struct Store::Impl {
  std::filesystem::path file;
  sqlite3* db = nullptr;

  ~Impl() { sqlite3_close(db); }

  [[noreturn]] void Fail() const {
    throw base::RunError(file.string() + ": " + sqlite3_errmsg(db) +
                         " (is the disk full, or the folder not writable?)");
  }
  void Run(const char* sql) const {
    if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) Fail();
  }
  /// All of what `write` writes, or nothing.
  void Transaction(const std::function<void()>& write) const;
  template <typename... Values>
  void Insert(const char* sql, const Values&... values) const;
};

namespace {

// One prepared statement, finalised at the end of its scope.
class Statement {
 public:
  Statement(sqlite3* db, const char* sql) {
    ok_ = sqlite3_prepare_v2(db, sql, -1, &statement_, nullptr) == SQLITE_OK;
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool ok() const { return ok_; }
  Statement& Bind(const std::string& text) {
    sqlite3_bind_text(statement_, ++bound_, text.c_str(), static_cast<int>(text.size()),
                      SQLITE_TRANSIENT);
    return *this;
  }
  Statement& Bind(int value) {
    sqlite3_bind_int(statement_, ++bound_, value);
    return *this;
  }
  Statement& Bind(double value) {
    sqlite3_bind_double(statement_, ++bound_, value);
    return *this;
  }
  int Step() { return sqlite3_step(statement_); }
  /// To be bound and run again.
  void Reset() {
    sqlite3_reset(statement_);
    bound_ = 0;
  }
  std::string Text(int column) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    if (!text) return "";
    return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }
  int Int(int column) const { return sqlite3_column_int(statement_, column); }
  double Double(int column) const { return sqlite3_column_double(statement_, column); }

 private:
  sqlite3_stmt* statement_ = nullptr;
  int bound_ = 0;
  bool ok_ = false;
};

// A row of kSelectCases, without times.
Record RecordFrom(const Statement& row) {
  return {{row.Text(0), row.Text(1), std::stoull(row.Text(2)), row.Text(3), row.Int(4)},
          {row.Text(5), row.Text(6), row.Text(7), row.Text(8), {}}};
}

std::filesystem::path FileIn(const std::filesystem::path& folder) { return folder / kFile; }

}  // namespace

Store::Store(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Store::~Store() = default;
Store::Store(Store&&) noexcept = default;

const std::filesystem::path& Store::file() const { return impl_->file; }

bool Store::Exists(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::exists(FileIn(folder), error);
}

Store Store::Create(const std::filesystem::path& folder) {
  return CreateFile(folder, kFile, kGrowing);
}

Store Store::CreateFile(const std::filesystem::path& folder, const char* name,
                        const char* pragmas) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw base::InputError(folder.string() +
                           ": the output folder cannot be made: " + error.message());
  }
  auto impl = std::make_unique<Impl>();
  impl->file = folder / name;
  if (sqlite3_open(impl->file.c_str(), &impl->db) != SQLITE_OK) {
    throw base::InputError(impl->file.string() +
                           ": cannot be written: " + sqlite3_errmsg(impl->db));
  }
  sqlite3_busy_timeout(impl->db, kBusy_ms);
  for (const char* sql : {pragmas, "PRAGMA synchronous=NORMAL", kSchema}) {
    if (sqlite3_exec(impl->db, sql, nullptr, nullptr, nullptr) == SQLITE_OK) continue;
    throw base::InputError(impl->file.string() + ": " + sqlite3_errmsg(impl->db) +
                           " (a writable folder with free space is needed)");
  }
  return Store(std::move(impl));
}

Store Store::Open(const std::filesystem::path& folder) {
  if (!Exists(folder)) {
    throw base::InputError(folder.string() + ": no results here (no results.sqlite); " +
                           "give the folder that `run` wrote");
  }
  auto impl = std::make_unique<Impl>();
  impl->file = FileIn(folder);
  if (sqlite3_open_v2(impl->file.c_str(), &impl->db, SQLITE_OPEN_READONLY, nullptr) != SQLITE_OK ||
      !Statement(impl->db, "SELECT COUNT(*) FROM cases").ok()) {
    throw base::InputError(impl->file.string() +
                           ": no results can be read: " + sqlite3_errmsg(impl->db));
  }
  return Store(std::move(impl));
}

void Store::Remove(const std::filesystem::path& folder) {
  for (const char* ending : {"", "-wal", "-shm"}) {
    std::filesystem::remove(folder / (std::string(kFile) + ending));
  }
}

namespace {

void BindCase(const Record& record, Statement& insert) {
  const auto& [c, r] = record;
  insert.Bind(c.id).Bind(c.position).Bind(c.group).Bind(std::to_string(c.seed)).Bind(c.params);
  insert.Bind(r.outcome).Bind(r.stage).Bind(r.detail).Bind(r.data);
}

}  // namespace

void Store::Impl::Transaction(const std::function<void()>& write) const {
  Run("BEGIN IMMEDIATE");
  try {
    write();
    Run("COMMIT");
  } catch (const base::RunError&) {
    sqlite3_exec(db, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

template <typename... Values>
void Store::Impl::Insert(const char* sql, const Values&... values) const {
  Statement statement(db, sql);
  if (!statement.ok()) Fail();
  (statement.Bind(values), ...);
  if (statement.Step() != SQLITE_DONE) Fail();
}

void Store::WriteStamp(const Stamp& stamp) {
  impl_->Transaction([&] {
    impl_->Run("DELETE FROM stamp");
    for (const auto& [part, values] :
         {std::pair{kIdentity, &stamp.identity}, {kBuild, &stamp.build}, {kData, &stamp.data}}) {
      for (const auto& [name, value] : *values) {
        impl_->Insert("INSERT INTO stamp VALUES(?, ?, ?)", std::string(part), name, value);
      }
    }
  });
}

Stamp Store::ReadStamp() const {
  Stamp stamp;
  Statement select(impl_->db, "SELECT part, name, value FROM stamp");
  if (!select.ok()) impl_->Fail();
  while (select.Step() == SQLITE_ROW) {
    const std::string part = select.Text(0);
    auto& values = part == kIdentity ? stamp.identity : part == kBuild ? stamp.build : stamp.data;
    values[select.Text(1)] = select.Text(2);
  }
  return stamp;
}

void Store::Write(const Record& record) {
  const auto& [c, r] = record;
  impl_->Transaction([&] {
    impl_->Insert(kInsertCase, c.id, c.position, c.group, std::to_string(c.seed), c.params,
                  r.outcome, r.stage, r.detail, r.data);
    impl_->Insert("DELETE FROM seconds WHERE id = ?", c.id);
    for (std::size_t i = 0; i < r.seconds.size(); ++i) {
      impl_->Insert(kInsertSeconds, c.id, static_cast<int>(i), r.seconds[i].first,
                    r.seconds[i].second);
    }
  });
}

std::vector<Record> Store::ReadAll() const {
  std::vector<Record> records;
  std::unordered_map<std::string, std::size_t> by_id;
  Statement select(impl_->db, (std::string(kSelectCases) + "ORDER BY position, id").c_str());
  if (!select.ok()) impl_->Fail();
  int code = SQLITE_DONE;
  while ((code = select.Step()) == SQLITE_ROW) {
    by_id.emplace(select.Text(0), records.size());
    records.push_back(RecordFrom(select));
  }
  if (code != SQLITE_DONE) impl_->Fail();
  Statement times(impl_->db, "SELECT id, stage, seconds FROM seconds ORDER BY id, position");
  if (!times.ok()) impl_->Fail();
  while (times.Step() == SQLITE_ROW) {
    // A run that is under way may have added a case since the rows were read.
    const auto found = by_id.find(times.Text(0));
    if (found == by_id.end()) continue;
    records[found->second].result.seconds.emplace_back(times.Text(1), times.Double(2));
  }
  return records;
}

struct Store::Cursor::Impl {
  const Store::Impl& store;
  Statement cases, times;
  bool times_left = false;

  explicit Impl(const Store::Impl& s)
      : store(s),
        cases(s.db, (std::string(kSelectCases) + "ORDER BY id").c_str()),
        times(s.db, "SELECT id, stage, seconds FROM seconds ORDER BY id, position") {
    if (!cases.ok() || !times.ok()) store.Fail();
    times_left = times.Step() == SQLITE_ROW;
  }
};

Store::Cursor::Cursor(const Store& store) : impl_(std::make_unique<Impl>(*store.impl_)) {}
Store::Cursor::~Cursor() = default;
Store::Cursor::Cursor(Cursor&&) noexcept = default;

std::optional<Record> Store::Cursor::Next() {
  auto& [store, cases, times, times_left] = *impl_;
  const int code = cases.Step();
  if (code == SQLITE_DONE) return std::nullopt;
  if (code != SQLITE_ROW) store.Fail();
  Record record = RecordFrom(cases);
  while (times_left && times.Text(0) <= record.which.id) {
    if (times.Text(0) == record.which.id) {
      record.result.seconds.emplace_back(times.Text(1), times.Double(2));
    }
    times_left = times.Step() == SQLITE_ROW;
  }
  return record;
}

void Store::WriteWhole(const std::filesystem::path& folder, const Stamp& stamp,
                       const std::function<std::optional<Record>()>& next) {
  const auto unfinished = folder / kUnfinished;
  try {
    Store store = CreateFile(folder, kUnfinished, kWritten);
    store.WriteStamp(stamp);
    sqlite3* const db = store.impl_->db;
    store.impl_->Run("BEGIN");
    Statement insert_case(db, kInsertCase);
    Statement insert_seconds(db, kInsertSeconds);
    if (!insert_case.ok() || !insert_seconds.ok()) store.impl_->Fail();
    while (const auto record = next()) {
      insert_case.Reset();
      BindCase(*record, insert_case);
      if (insert_case.Step() != SQLITE_DONE) store.impl_->Fail();
      for (std::size_t i = 0; i < record->result.seconds.size(); ++i) {
        const auto& [stage, seconds] = record->result.seconds[i];
        insert_seconds.Reset();
        insert_seconds.Bind(record->which.id).Bind(static_cast<int>(i)).Bind(stage).Bind(seconds);
        if (insert_seconds.Step() != SQLITE_DONE) store.impl_->Fail();
      }
    }
    store.impl_->Run("COMMIT");
  } catch (...) {
    std::error_code error;
    std::filesystem::remove(unfinished, error);
    std::filesystem::remove(folder, error);  // where nothing else is in it
    throw;
  }
  std::filesystem::rename(unfinished, FileIn(folder));
}

int Store::Count() const {
  Statement select(impl_->db, "SELECT COUNT(*) FROM cases");
  if (!select.ok() || select.Step() != SQLITE_ROW) impl_->Fail();
  return select.Int(0);
}

std::unordered_set<std::string> Store::Ids() const {
  std::unordered_set<std::string> ids;
  Statement select(impl_->db, "SELECT id FROM cases");
  if (!select.ok()) impl_->Fail();
  while (select.Step() == SQLITE_ROW) ids.insert(select.Text(0));
  return ids;
}

}  // namespace rangegrasp::experiment
