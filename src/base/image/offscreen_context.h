#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/image/image.h"

struct osmesa_context;  // defined by OSMesa

namespace rangegrasp::image {

/// Call this before the first context in a process that draws and then forks. Mesa then starts no
/// thread, which a forked process would lack, and uses no shader cache on disk.
/// @return false if the variable LP_NUM_THREADS asks for threads; the process must then not draw.
bool DrawBeforeForking();

/// An in-memory frame buffer for OpenGL (OSMesa: no display, no GPU) with depth and stencil. One
/// context is current per thread; a destroyed context is no longer current.
class OffscreenContext {
 public:
  /// Makes the context current. @throws base::RunError if it cannot be created; base::NotInstalled
  /// without OSMesa; std::invalid_argument for a size that is not positive.
  OffscreenContext(int width_px, int height_px);

  /// Directs all further drawing to this context. @throws base::RunError if OSMesa fails.
  void MakeCurrent();

  /// The drawn image; each pixel is the mean of `oversampling` >= 1 drawn ones in each direction.
  Image Picture(int oversampling = 1) const;

 private:
  struct ContextDeleter {
    void operator()(osmesa_context* context) const;
  };
  int width_px_;
  int height_px_;
  std::vector<std::uint8_t> rgba_;  // bottom row first
  std::unique_ptr<osmesa_context, ContextDeleter> context_;
};

}  // namespace rangegrasp::image
