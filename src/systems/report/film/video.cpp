#include "report/film/video.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/file.h"
#include "base/process/feed.h"
#include "base/process/own_folder.h"

namespace rangegrasp::report {
namespace {

/// ffmpeg encodes a picture in hundredths of a second, and ends a film in seconds: what takes
/// longer hangs [s].
constexpr double kLimit_s = 60.0;

std::filesystem::path Ffmpeg() {
  const auto ffmpeg = process::Find("ffmpeg");
  if (ffmpeg) return *ffmpeg;
  throw base::InputError(
      "--video needs the program ffmpeg, which is not installed (Debian package ffmpeg)");
}

// Beside the file, so that it can take its place in one step. ffmpeg tells the format by the
// ending.
std::filesystem::path PartOf(const std::filesystem::path& file) {
  auto part = std::filesystem::absolute(file);
  part.replace_filename("." + file.stem().string() + ".part" + file.extension().string());
  return part;
}

process::Program ProgramOf(const std::vector<std::string>& arguments,
                           const std::filesystem::path& folder) {
  process::Program program;
  program.command = {Ffmpeg().string(), "-loglevel", "error", "-y"};
  program.command.insert(program.command.end(), arguments.begin(), arguments.end());
  program.folder = folder;
  program.limit_s = kLimit_s;
  return program;
}

}  // namespace

Video::Video(const std::filesystem::path& file) : file_(file), part_(PartOf(file)) {
  Ffmpeg();
  base::MakeFolderOf(file);
}

Video::~Video() {
  ffmpeg_.reset();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void Video::Add(const image::Image& picture) {
  if (!ffmpeg_) {
    const std::vector<std::string> arguments = {
        "-f",          "rawvideo",
        "-pix_fmt",    "rgb24",
        "-s",          fmt::format("{}x{}", picture.width, picture.height),
        "-r",          fmt::format("{}", kFrameRate_hz),
        "-i",          "-",
        "-preset",     "veryfast",
        "-pix_fmt",    "yuv420p",
        part_.string()};
    ffmpeg_ =
        std::make_unique<process::Feed>(ProgramOf(arguments, part_.parent_path()), file_.string());
  }
  ffmpeg_->Write(picture.rgb);
}

void Video::Finish() {
  if (!ffmpeg_) throw base::RunError(file_.string() + ": there is nothing to film");
  ffmpeg_->Finish();
  ffmpeg_.reset();
  std::filesystem::rename(part_, file_);
}

void JoinVideos(const std::vector<std::filesystem::path>& files,
                const std::filesystem::path& into) {
  const process::OwnFolder folder;
  std::string list;
  for (std::size_t i = 0; i < files.size(); ++i) {
    // Under names without anything that ffmpeg's list would read in another way.
    const auto link = folder.path() / fmt::format("{}.mp4", i);
    std::filesystem::create_symlink(std::filesystem::absolute(files[i]), link);
    list += fmt::format("file '{}'\n", link.string());
  }
  base::WriteFile(folder.path() / "list", list);
  const auto part = PartOf(into);
  process::Feed(ProgramOf({"-f", "concat", "-safe", "0", "-i", (folder.path() / "list").string(),
                           "-c", "copy", part.string()},
                          folder.path()),
                into.string())
      .Finish();
  std::filesystem::rename(part, into);
}

}  // namespace rangegrasp::report
