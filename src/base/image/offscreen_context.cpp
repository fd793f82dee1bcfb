#include "base/image/offscreen_context.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "base/error.h"
#include "base/image/open_gl.h"
#include "base/installation.h"
#include "base/process/program.h"

namespace rangegrasp::image {
namespace {

constexpr GLint kDepthBits = 24;   // with fewer, close surfaces show through each other
constexpr GLint kStencilBits = 8;  // used by the physics engine's renderer for shadows
constexpr GLint kAccumulationBits = 0;
/// Memory for drawing with shadows, including Mesa itself, which crashes if less is available.
constexpr std::size_t kDrawing_bytes = std::size_t{800} << 20;
constexpr std::size_t kRgba = 4;  // bytes per pixel

// Only the caller's thread draws. A process forked later would lack Mesa's threads and wait for
// them forever; they also end late on a busy machine. The variable, if already set, overrides this.
void DrawInThisThread() { setenv("LP_NUM_THREADS", "0", /*overwrite=*/0); }

OpenGl Load() {
  // RTLD_GLOBAL: MuJoCo looks up the functions among all loaded libraries.
  void* library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_GLOBAL);
  const auto find = [&]<typename Function>(Function*& function, const char* name) {
    function = library ? reinterpret_cast<Function*>(dlsym(library, name)) : nullptr;
    if (!function) {
      throw base::NotInstalled("libosmesa6",
                               fmt::format("it is needed to draw pictures: {}", dlerror()));
    }
  };
  OpenGl gl{};
  find(gl.begin, "glBegin");
  find(gl.blend_func, "glBlendFunc");
  find(gl.clear, "glClear");
  find(gl.clear_color, "glClearColor");
  find(gl.color4f, "glColor4f");
  find(gl.color4fv, "glColor4fv");
  find(gl.depth_mask, "glDepthMask");
  find(gl.enable, "glEnable");
  find(gl.end, "glEnd");
  find(gl.finish, "glFinish");
  find(gl.line_width, "glLineWidth");
  find(gl.load_matrixd, "glLoadMatrixd");
  find(gl.matrix_mode, "glMatrixMode");
  find(gl.point_size, "glPointSize");
  find(gl.scissor, "glScissor");
  find(gl.vertex3dv, "glVertex3dv");
  find(gl.viewport, "glViewport");
  find(gl.create_context, "OSMesaCreateContextExt");
  find(gl.destroy_context, "OSMesaDestroyContext");
  find(gl.make_current, "OSMesaMakeCurrent");
  find(gl.get_current_context, "OSMesaGetCurrentContext");
  return gl;
}

}  // namespace

const OpenGl& Gl() {
  static const OpenGl gl = Load();
  return gl;
}

bool DrawBeforeForking() {
  DrawInThisThread();
  setenv("MESA_SHADER_CACHE_DISABLE", "true", /*overwrite=*/1);  // the disk cache uses a thread
  return std::string_view(std::getenv("LP_NUM_THREADS")) == "0";
}

void OffscreenContext::ContextDeleter::operator()(osmesa_context* context) const {
  if (Gl().get_current_context() == context) {
    Gl().make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  }
  Gl().destroy_context(context);
}

OffscreenContext::OffscreenContext(int width_px, int height_px)
    : width_px_(width_px), height_px_(height_px) {
  if (width_px < 1 || height_px < 1) {
    throw std::invalid_argument("a picture needs a positive size");
  }
  DrawInThisThread();
  process::NeedMemory(kDrawing_bytes);
  rgba_.resize(kRgba * IndexAt(0, height_px, width_px));
  context_.reset(
      Gl().create_context(OSMESA_RGBA, kDepthBits, kStencilBits, kAccumulationBits, nullptr));
  MakeCurrent();
}

void OffscreenContext::MakeCurrent() {
  if (context_ &&
      Gl().make_current(context_.get(), rgba_.data(), GL_UNSIGNED_BYTE, width_px_, height_px_)) {
    return;
  }
  throw base::RunError(
      fmt::format("cannot create an offscreen OpenGL context of {} x {} pixels (OSMesa)", width_px_,
                  height_px_));
}

Image OffscreenContext::Picture(int oversampling) const {
  Image image{width_px_ / oversampling, height_px_ / oversampling, {}};
  image.rgb.reserve(3 * IndexAt(0, image.height, image.width));
  const int parts = oversampling * oversampling;
  Gl().finish();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        int sum = 0;
        for (int part = 0; part < parts; ++part) {
          const int from_y = (image.height - 1 - y) * oversampling + part / oversampling;
          const int from_x = x * oversampling + part % oversampling;
          sum += rgba_[kRgba * IndexAt(from_x, from_y, width_px_) + channel];
        }
        image.rgb.push_back(static_cast<std::uint8_t>(sum / parts));
      }
    }
  }
  return image;
}

}  // namespace rangegrasp::image
