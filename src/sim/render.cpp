#include "sim/render.h"

#include <GL/osmesa.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/error.h"
#include "core/units.h"
#include "sim/internal/engine.h"
#include "sim/internal/names.h"

namespace rangegrasp::sim {
namespace {

constexpr int kMaxGeoms = 20000;

struct ContextDeleter {
  void operator()(osmesa_context* context) const { OSMesaDestroyContext(context); }
};

bool ParseFreeView(const std::string& text, Eigen::Vector3d& eye, Eigen::Vector3d& look) {
  int used = 0;
  const int fields = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%n", &eye.x(), &eye.y(),
                                 &eye.z(), &look.x(), &look.y(), &look.z(), &used);
  return fields == 6 && static_cast<std::size_t>(used) == text.size();
}

mjvCamera FreeCamera(const Eigen::Vector3d& eye, const Eigen::Vector3d& look) {
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  const Eigen::Vector3d view = look - eye;
  camera.type = mjCAMERA_FREE;
  std::copy_n(look.data(), 3, camera.lookat);
  camera.distance = std::max(view.norm(), 1e-3);
  camera.azimuth = core::ToDeg(std::atan2(view.y(), view.x()));
  camera.elevation = core::ToDeg(std::asin(std::clamp(view.z() / camera.distance, -1.0, 1.0)));
  return camera;
}

mjvCamera CameraOf(const mjModel* model, const std::string& name) {
  Eigen::Vector3d eye, look;
  if (ParseFreeView(name, eye, look)) return FreeCamera(eye, look);
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = internal::Find(model, mjOBJ_CAMERA, name);
  return camera;
}

mjvGeom* NextGeom(mjvScene& scene) {
  return scene.ngeom < scene.maxgeom ? &scene.geoms[scene.ngeom++] : nullptr;
}

void AddOverlay(const Overlay& overlay, mjvScene& scene) {
  for (const Overlay::Dot& dot : overlay.dots) {
    mjvGeom* geom = NextGeom(scene);
    if (!geom) return;
    const mjtNum size[3] = {dot.radius_m, dot.radius_m, dot.radius_m};
    mjv_initGeom(geom, mjGEOM_SPHERE, size, dot.p_W.data(), nullptr, dot.rgba.data());
    geom->category = mjCAT_DECOR;
  }
  for (const Overlay::Segment& segment : overlay.segments) {
    mjvGeom* geom = NextGeom(scene);
    if (!geom) return;
    mjv_initGeom(geom, mjGEOM_CAPSULE, nullptr, nullptr, nullptr, segment.rgba.data());
    mjv_connector(geom, mjGEOM_CAPSULE, segment.radius_m, segment.a_W.data(), segment.b_W.data());
    geom->category = mjCAT_DECOR;
  }
}

}  // namespace

struct Renderer::Impl {
  std::unique_ptr<osmesa_context, ContextDeleter> gl;
  std::vector<unsigned char> window;
  int width = 0;
  int height = 0;
  mjvScene scene;
  mjvOption option;
  mjrContext context;

  // The window's buffer is small: pictures are made in an offscreen buffer of the wanted size.
  void MakeCurrent() {
    if (!OSMesaMakeCurrent(gl.get(), window.data(), GL_UNSIGNED_BYTE, 16, 16)) {
      throw core::RunError("OSMesa's context cannot be made current");
    }
  }
};

Renderer::Renderer(const World& world, int width, int height) : impl_(std::make_unique<Impl>()) {
  if (width <= 0 || height <= 0)
    throw std::invalid_argument("Renderer: width and height must be above 0");
  impl_->width = width;
  impl_->height = height;
  impl_->gl.reset(OSMesaCreateContextExt(GL_RGBA, 24, 8, 0, nullptr));
  if (!impl_->gl) throw core::RunError("OSMesa makes no context");
  impl_->window.resize(16 * 16 * 4);
  impl_->MakeCurrent();
  mjv_defaultScene(&impl_->scene);
  mjv_defaultOption(&impl_->option);
  mjr_defaultContext(&impl_->context);
  internal::CallEngine(nullptr, [&] {
    mjv_makeScene(world.model(), &impl_->scene, kMaxGeoms);
    mjr_makeContext(world.model(), &impl_->context, mjFONTSCALE_100);
    mjr_resizeOffscreen(width, height, &impl_->context);
    mjr_setBuffer(mjFB_OFFSCREEN, &impl_->context);
  });
  if (impl_->context.currentBuffer != mjFB_OFFSCREEN)
    throw core::RunError("no offscreen buffer for pictures");
}

Renderer::~Renderer() {
  if (!impl_ || !impl_->gl) return;
  OSMesaMakeCurrent(impl_->gl.get(), impl_->window.data(), GL_UNSIGNED_BYTE, 16, 16);
  mjr_freeContext(&impl_->context);
  mjv_freeScene(&impl_->scene);
}

Image Renderer::Render(World& world, const std::string& camera_name, const Overlay& overlay) {
  impl_->MakeCurrent();
  mjvCamera camera = CameraOf(world.model(), camera_name);
  const mjrRect viewport = {0, 0, impl_->width, impl_->height};
  const auto row = static_cast<std::size_t>(impl_->width) * 3;
  std::vector<unsigned char> pixels(row * static_cast<std::size_t>(impl_->height));
  internal::CallEngine(nullptr, [&] {
    mjv_updateScene(world.model(), world.data(), &impl_->option, nullptr, &camera, mjCAT_ALL,
                    &impl_->scene);
    AddOverlay(overlay, impl_->scene);
    mjr_render(viewport, &impl_->scene, &impl_->context);
    mjr_readPixels(pixels.data(), nullptr, viewport, &impl_->context);
  });
  Image image{impl_->width, impl_->height, std::vector<std::uint8_t>(pixels.size())};
  for (int y = 0; y < image.height; ++y) {
    const auto from = static_cast<std::ptrdiff_t>(row) * (image.height - 1 - y);
    std::copy_n(pixels.begin() + from, row,
                image.rgb.begin() + static_cast<std::ptrdiff_t>(row) * y);
  }
  return image;
}

}  // namespace rangegrasp::sim
