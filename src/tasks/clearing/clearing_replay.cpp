#include "tasks/clearing/clearing_replay.h"

#include <fmt/format.h>

#include <algorithm>

#include "image/png.h"
#include "tasks/grasping/recorder.h"

namespace rangegrasp::tasks::clearing {
namespace {

// Of the row: each picture shrunk by so much [px a px], so many beside each other.
constexpr int kShrink = 4;
constexpr int kColumns = 5;

// Means of squares of kShrink pixels.
image::Image Shrunk(const image::Image& large) {
  image::Image small{large.width / kShrink, large.height / kShrink, {}};
  small.rgb.reserve(3 * static_cast<std::size_t>(small.width) *
                    static_cast<std::size_t>(small.height));
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int i = 0; i < kShrink * kShrink; ++i) {
          sum += large.At(kShrink * x + i % kShrink, kShrink * y + i / kShrink)[channel];
        }
        small.rgb.push_back(static_cast<std::uint8_t>(sum / (kShrink * kShrink)));
      }
    }
  }
  return small;
}

// All of one size, in rows from the left.
image::Image Tiled(const std::vector<image::Image>& tiles) {
  const int columns = std::min(kColumns, static_cast<int>(tiles.size()));
  const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
  const int width = tiles.front().width;
  const int height = tiles.front().height;
  image::Image all{columns * width, rows * height, {}};
  all.rgb.assign(3 * static_cast<std::size_t>(all.width) * static_cast<std::size_t>(all.height),
                 255);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const int left = static_cast<int>(i) % columns * width;
    const int top = static_cast<int>(i) / columns * height;
    for (int y = 0; y < height; ++y) {
      std::copy_n(
          tiles[i].At(0, y), 3 * width,
          all.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(all.width) * (top + y) + left));
    }
  }
  return all;
}

}  // namespace

experiment::Result ReplayClearing(
    const grasping::Cell& cell, const std::string& id, const experiment::ReplayOptions& options,
    const std::function<experiment::Result(const ClearingObserver&)>& run) {
  grasping::Recorder recorder(cell, id, options);
  std::vector<image::Image> row;
  recorder.KeepMoments([](const std::string& moment) {
    return moment == "start" || moment == "lifted" || moment == "end";
  });
  recorder.OnPicture([&](const std::string& what, const image::Image& image) {
    if (what == "lifted" || what == "end") row.push_back(Shrunk(image));
  });
  ClearingObserver observer;
  observer.detector = &recorder.detector();
  observer.execution = recorder.Observer();
  if (observer.execution.on_moment) {
    // The end of a grasp is the start of the next one, after the attendant.
    observer.execution.on_moment = [then = observer.execution.on_moment](const std::string& moment,
                                                                         sim::World& world) {
      if (moment != "end") then(moment, world);
    };
  }
  observer.on_attempt = [&](int attempt) {
    recorder.SetPrefix(fmt::format("{}_{:02}", id, attempt));
  };
  observer.on_end = [&](sim::World& world) {
    recorder.SetPrefix(id);
    recorder.Take("end", world);
  };
  const auto result = run(observer);
  recorder.Finish();
  if (!row.empty()) {
    image::WritePng(options.folder / (id + "_row.png"), Tiled(row));
  }
  return result;
}

}  // namespace rangegrasp::tasks::clearing
