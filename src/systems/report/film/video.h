#pragma once

#include <filesystem>
#include <memory>

#include "base/image/image.h"

namespace rangegrasp::process {
class Feed;
}

namespace rangegrasp::report {

/// Of films [frames/s].
inline constexpr int kFrameRate_hz = 25;

/// A film that pictures are added to, encoded by ffmpeg. The file is there when it is whole: what
/// was made of one that failed is removed.
class Video {
 public:
  /// @throws base::InputError if there is no ffmpeg, or the folder cannot be made.
  explicit Video(const std::filesystem::path& file);
  ~Video();
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  /// All pictures have the size of the first one.
  /// @throws base::RunError if ffmpeg has failed (a full disk, a kill) or takes nothing more.
  void Add(const image::Image& picture);
  /// @throws base::RunError likewise, or if there was no picture.
  void Finish();

 private:
  std::filesystem::path file_, part_;
  std::unique_ptr<process::Feed> ffmpeg_;
};

/// One film after the other as one, whose pictures have the same size.
/// @throws base::RunError as Video, InputError if there is no ffmpeg.
void JoinVideos(const std::vector<std::filesystem::path>& files, const std::filesystem::path& into);

}  // namespace rangegrasp::report
