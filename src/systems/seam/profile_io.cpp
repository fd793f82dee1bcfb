#include "seam/profile_io.h"

#include <algorithm>
#include <deque>
#include <fstream>
#include <iterator>

#include "base/error.h"
#include "base/file.h"
#include "seam/internal/image_rows.h"
#include "seam/internal/profile_bytes.h"
#include "seam/internal/row_finish.h"
#include "seam/internal/width_rows.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;

// Whole rows with x that tell how far the grid reaches, and how many rows are read for them.
constexpr std::size_t kRowsOfGrid = 3;
constexpr std::size_t kMaxHeld = 16;

std::ifstream Open(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    throw InputError(file.string() + ": is a folder, not a file of profiles");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file.string() + ": cannot be read");
  return in;
}

std::optional<ProfileGrid> GridFor(const RowFinish& finish) {
  if (!finish.grid()) return std::nullopt;
  return ProfileGrid{1.0 / finish.grid()->pitch_m, finish.grid()->CenterX()};
}

std::vector<RawRow> RowsOfText(std::istream& in, const ProfileFileOptions& options) {
  WidthRows text(in, options);
  std::vector<RawRow> rows;
  while (auto row = text.Next()) rows.push_back(std::move(*row));
  return rows;
}

std::vector<RawRow> RowsOf(const std::filesystem::path& file, const ProfileFileOptions& options) {
  const std::string ending = base::EndingOf(file);
  const bool text = ending == ".csv" || ending == ".txt";
  if (!text && !IsImageEnding(ending)) throw InputError(UnknownEnding(ending));
  std::ifstream in = Open(file);
  if (text) return RowsOfText(in, options);
  return RowsOfImage(std::string{std::istreambuf_iterator<char>(in), {}}, ending, options);
}

}  // namespace

struct ProfileStream::Impl {
  Impl(std::istream& in, const ProfileFileOptions& options) : rows(in, options), finish(options) {}

  void Hold();

  WidthRows rows;
  RowFinish finish;
  std::deque<RawRow> held;  // read while the grid was unknown
  bool begun = false;
};

ProfileStream::ProfileStream(std::istream& in, const ProfileFileOptions& options) {
  CheckOptions(options);
  impl_ = std::make_unique<Impl>(in, options);
}
ProfileStream::~ProfileStream() = default;

// The first row; where it has x, those that the grid is made of.
void ProfileStream::Impl::Hold() {
  std::vector<RawRow> first;
  std::size_t with_x = 0;
  while (first.size() < kMaxHeld && with_x < kRowsOfGrid) {
    auto row = rows.Next();
    if (!row) break;
    first.push_back(std::move(*row));
    const bool whole = first.back().fault.empty();
    with_x += whole && !first.back().x_m.empty() ? 1 : 0;
    begun = begun || whole;
    if (with_x == 0) break;
  }
  finish.FixGrid(first);
  if (with_x > 0) begun = finish.grid().has_value();
  std::ranges::move(first, std::back_inserter(held));
}

std::optional<ProfileRow> ProfileStream::Next() {
  Impl& stream = *impl_;
  if (!stream.begun && stream.held.empty()) stream.Hold();
  std::optional<RawRow> row;
  if (stream.held.empty()) {
    row = stream.rows.Next();
  } else {
    row = std::move(stream.held.front());
    stream.held.pop_front();
  }
  if (!row) return std::nullopt;
  return stream.finish(std::move(*row));
}

std::optional<ProfileGrid> ProfileStream::grid() const { return GridFor(impl_->finish); }

ProfileFile ReadProfileFile(const std::filesystem::path& file, const ProfileFileOptions& options) {
  CheckOptions(options);
  try {
    std::vector<RawRow> rows = RowsOf(file, options);
    for (const RawRow& row : rows) {
      if (!row.fault.empty()) throw InputError(row.fault);
    }
    RowFinish finish(options);
    finish.FixGrid(rows);
    ProfileFile read;
    for (RawRow& row : rows) {
      read.rows.push_back(finish(std::move(row)));
      if (!read.rows.back().fault.empty()) throw InputError(read.rows.back().fault);
    }
    if (read.rows.empty()) throw InputError("holds no profile");
    read.grid = GridFor(finish);
    return read;
  } catch (const InputError& error) {
    const std::string what = error.what();
    if (what.starts_with(file.string() + ": ")) throw;
    throw InputError(file.string() + ": " + what);
  }
}

std::vector<Profile> ReadProfiles(const std::filesystem::path& file,
                                  const ProfileFileOptions& options) {
  std::vector<Profile> profiles;
  for (ProfileRow& row : ReadProfileFile(file, options).rows) {
    profiles.push_back(std::move(row.profile));
  }
  return profiles;
}

void WriteProfiles(const std::vector<Profile>& profiles, const std::filesystem::path& file,
                   const ProfileFileOptions& options) {
  CheckOptions(options);
  std::string bytes;
  try {
    bytes = BytesOf(profiles, base::EndingOf(file), options);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  base::WriteFile(file, bytes);
}

}  // namespace rangegrasp::seam
