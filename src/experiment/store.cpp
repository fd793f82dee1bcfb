#include "experiment/store.h"

#include <sqlite3.h>

#include "core/error.h"

namespace rangegrasp::experiment {
namespace {

constexpr const char* kSchema = R"(
  CREATE TABLE IF NOT EXISTS stamp(name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS trials(
    id TEXT PRIMARY KEY, object TEXT NOT NULL, trial INTEGER NOT NULL, seed TEXT NOT NULL, pose_class TEXT NOT NULL,
    redraws INTEGER NOT NULL, scan_points INTEGER NOT NULL, object_points INTEGER NOT NULL, segments INTEGER NOT NULL,
    objects INTEGER NOT NULL, candidates INTEGER NOT NULL, free_candidates INTEGER NOT NULL, plans INTEGER NOT NULL,
    grasp_type TEXT NOT NULL, detected INTEGER NOT NULL, outcome TEXT NOT NULL, stage TEXT NOT NULL, detail TEXT NOT NULL,
    log TEXT NOT NULL) WITHOUT ROWID;
  CREATE TABLE IF NOT EXISTS seconds(id TEXT NOT NULL, position INTEGER NOT NULL, stage TEXT NOT NULL,
    seconds REAL NOT NULL, PRIMARY KEY(id, position)) WITHOUT ROWID;
)";

}  // namespace

struct Store::Impl {
  std::filesystem::path file;
  sqlite3* db = nullptr;

  ~Impl() { sqlite3_close(db); }

  [[noreturn]] void Fail() const {
    throw core::RunError(file.string() + ": " + sqlite3_errmsg(db) +
                         " (is the disk full, or the folder not writable?)");
  }
  void Run(const char* sql) const {
    if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) Fail();
  }
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

std::filesystem::path FileIn(const std::filesystem::path& folder) {
  return folder / "results.sqlite";
}

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
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw core::InputError(folder.string() +
                           ": the output folder cannot be made: " + error.message());
  }
  auto impl = std::make_unique<Impl>();
  impl->file = FileIn(folder);
  if (sqlite3_open(impl->file.c_str(), &impl->db) != SQLITE_OK) {
    throw core::InputError(impl->file.string() +
                           ": cannot be written: " + sqlite3_errmsg(impl->db));
  }
  sqlite3_busy_timeout(impl->db, 10000);
  for (const char* sql : {"PRAGMA journal_mode=WAL", "PRAGMA synchronous=NORMAL", kSchema}) {
    if (sqlite3_exec(impl->db, sql, nullptr, nullptr, nullptr) == SQLITE_OK) continue;
    throw core::InputError(impl->file.string() + ": " + sqlite3_errmsg(impl->db) +
                           " (a writable folder with free space is needed)");
  }
  return Store(std::move(impl));
}

Store Store::Open(const std::filesystem::path& folder) {
  if (!Exists(folder)) {
    throw core::InputError(folder.string() + ": no results here (no results.sqlite); " +
                           "give the folder that `run` wrote");
  }
  auto impl = std::make_unique<Impl>();
  impl->file = FileIn(folder);
  if (sqlite3_open_v2(impl->file.c_str(), &impl->db, SQLITE_OPEN_READONLY, nullptr) != SQLITE_OK ||
      !Statement(impl->db, "SELECT COUNT(*) FROM trials").ok()) {
    throw core::InputError(impl->file.string() +
                           ": no results can be read: " + sqlite3_errmsg(impl->db));
  }
  return Store(std::move(impl));
}

void Store::WriteStamp(const std::map<std::string, std::string>& stamp) {
  impl_->Run("BEGIN IMMEDIATE");
  for (const auto& [name, value] : stamp) {
    Statement insert(impl_->db, "INSERT OR REPLACE INTO stamp VALUES(?, ?)");
    if (!insert.ok() || insert.Bind(name).Bind(value).Step() != SQLITE_DONE) impl_->Fail();
  }
  impl_->Run("COMMIT");
}

std::map<std::string, std::string> Store::ReadStamp() const {
  std::map<std::string, std::string> stamp;
  Statement select(impl_->db, "SELECT name, value FROM stamp");
  if (!select.ok()) impl_->Fail();
  while (select.Step() == SQLITE_ROW) stamp[select.Text(0)] = select.Text(1);
  return stamp;
}

void Store::Write(const TrialResult& r) {
  impl_->Run("BEGIN IMMEDIATE");
  try {
    Statement insert(impl_->db,
                     "INSERT OR REPLACE INTO trials VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
    if (!insert.ok()) impl_->Fail();
    insert.Bind(r.id).Bind(r.object).Bind(r.index).Bind(std::to_string(r.seed)).Bind(r.pose_class);
    insert.Bind(r.redraws).Bind(r.scan_points).Bind(r.object_points).Bind(r.segments);
    insert.Bind(r.objects).Bind(r.candidates).Bind(r.free_candidates).Bind(r.plans);
    insert.Bind(r.grasp_type).Bind(r.detected ? 1 : 0).Bind(std::string(Name(r.outcome)));
    insert.Bind(r.stage).Bind(r.detail).Bind(r.log);
    if (insert.Step() != SQLITE_DONE) impl_->Fail();
    Statement clear(impl_->db, "DELETE FROM seconds WHERE id = ?");
    if (!clear.ok() || clear.Bind(r.id).Step() != SQLITE_DONE) impl_->Fail();
    for (std::size_t i = 0; i < r.seconds.size(); ++i) {
      Statement time(impl_->db, "INSERT INTO seconds VALUES(?,?,?,?)");
      if (!time.ok()) impl_->Fail();
      time.Bind(r.id).Bind(static_cast<int>(i)).Bind(r.seconds[i].first).Bind(r.seconds[i].second);
      if (time.Step() != SQLITE_DONE) impl_->Fail();
    }
    impl_->Run("COMMIT");
  } catch (const core::RunError&) {
    sqlite3_exec(impl_->db, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

std::vector<TrialResult> Store::ReadAll() const {
  std::map<std::string, TrialResult> by_id;
  Statement select(impl_->db, "SELECT * FROM trials ORDER BY id");
  if (!select.ok()) impl_->Fail();
  int code = SQLITE_DONE;
  while ((code = select.Step()) == SQLITE_ROW) {
    TrialResult r;
    int column = 0;
    r.id = select.Text(column++);
    r.object = select.Text(column++);
    r.index = select.Int(column++);
    r.seed = std::stoull(select.Text(column++));
    r.pose_class = select.Text(column++);
    r.redraws = select.Int(column++);
    r.scan_points = select.Int(column++);
    r.object_points = select.Int(column++);
    r.segments = select.Int(column++);
    r.objects = select.Int(column++);
    r.candidates = select.Int(column++);
    r.free_candidates = select.Int(column++);
    r.plans = select.Int(column++);
    r.grasp_type = select.Text(column++);
    r.detected = select.Int(column++) != 0;
    r.outcome = OutcomeFrom(select.Text(column++));
    r.stage = select.Text(column++);
    r.detail = select.Text(column++);
    r.log = select.Text(column++);
    by_id[r.id] = std::move(r);
  }
  if (code != SQLITE_DONE) impl_->Fail();
  Statement times(impl_->db, "SELECT id, stage, seconds FROM seconds ORDER BY id, position");
  if (!times.ok()) impl_->Fail();
  while (times.Step() == SQLITE_ROW) {
    // A run that is under way may have added a trial since the rows were read.
    const auto found = by_id.find(times.Text(0));
    if (found != by_id.end()) {
      found->second.seconds.emplace_back(times.Text(1), times.Double(2));
    }
  }
  std::vector<TrialResult> results;
  results.reserve(by_id.size());
  for (auto& [id, result] : by_id) results.push_back(std::move(result));
  return results;
}

}  // namespace rangegrasp::experiment
