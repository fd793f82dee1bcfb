#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/image/image.h"

struct osmesa_context;  // OSMesa's

namespace rangegrasp::image {

/// To be called before the first context of a process that draws and then forks: Mesa then starts
/// no thread, which the forked process would not have, and no cache of shaders on disk.
/// @return false where the variable LP_NUM_THREADS asks for threads: then it must not draw.
bool DrawBeforeForking();

/// A frame buffer in memory that OpenGL draws to (OSMesa: no display, no GPU), with depth and
/// stencil. One is current in a thread at a time; it is not once it is gone.
class OffscreenContext {
 public:
  /// Makes it current. @throws base::RunError if there is no such context; base::NotInstalled
  /// without OSMesa; std::invalid_argument for a size that is not positive.
  OffscreenContext(int width_px, int height_px);
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// What is drawn from now on goes here. @throws base::RunError if OSMesa refuses.
  void MakeCurrent();

  /// What was drawn; each pixel is the mean of `oversampling` >= 1 drawn ones in both directions,
  /// which smooths edges without multisampling.
  Image Picture(int oversampling = 1) const;

 private:
  struct ContextDeleter {
    void operator()(osmesa_context* context) const;
  };
  int width_px_;
  int height_px_;
  std::vector<std::uint8_t> rgba_;  // rows from the bottom
  std::unique_ptr<osmesa_context, ContextDeleter> context_;
};

}  // namespace rangegrasp::image
