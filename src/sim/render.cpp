#include "sim/render.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/image/offscreen_context.h"
#include "base/units.h"
#include "sim/internal/engine.h"
#include "sim/internal/fine_print.h"
#include "sim/internal/names.h"

namespace rangegrasp::sim {
namespace {

constexpr int kMaxGeoms = 20000;         // of a picture, overlay and all; what is more is left out
constexpr double kMinDistance_m = 1e-3;  // of a free camera from what it looks at

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
  camera.distance = std::max(view.norm(), kMinDistance_m);
  camera.azimuth = base::ToDeg(std::atan2(view.y(), view.x()));
  camera.elevation = base::ToDeg(std::asin(std::clamp(view.z() / camera.distance, -1.0, 1.0)));
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

// What a view sees, at the distance of the near plane. Rows count from the top, heights from below.
mjvGLCamera PinholeCamera(const PinholeView& view, const mjvGLCamera& clipping, int width,
                          int height) {
  mjvGLCamera camera = clipping;
  const Eigen::Vector3f position = view.X_WC.translation().cast<float>();
  const Eigen::Vector3f forward = view.X_WC.linear().col(2).cast<float>();
  const Eigen::Vector3f up = -view.X_WC.linear().col(1).cast<float>();
  std::copy_n(position.data(), 3, camera.pos);
  std::copy_n(forward.data(), 3, camera.forward);
  std::copy_n(up.data(), 3, camera.up);
  const double scale = clipping.frustum_near / view.focal_px;
  // The edges of a picture lie half a pixel beyond the middles of its outer pixels.
  const Eigen::Vector2d center = view.center_px + Eigen::Vector2d::Constant(0.5);
  camera.frustum_center = static_cast<float>(scale * (0.5 * width - center.x()));
  camera.frustum_width = static_cast<float>(scale * 0.5 * width);
  camera.frustum_top = static_cast<float>(scale * center.y());
  camera.frustum_bottom = static_cast<float>(scale * (center.y() - height));
  camera.orthographic = 0;
  return camera;
}

internal::TextureSet& PrintedTextures(const World& world,
                                      std::optional<internal::TextureSet>& textures) {
  std::vector<int> bodies;
  std::vector<std::string> surfaces;
  for (int object = 0; object < world.objects(); ++object) {
    bodies.push_back(world.object_body(object));
    surfaces.push_back(world.object_surface(object));
  }
  return textures.emplace(world.model(), bodies, surfaces);
}

// One context serves all renderers of a thread, and stays: what draws a kind of surface is compiled
// once for each context, which takes as long as a picture. A process that is forked has it, too.
// Its own frame buffer is small: the engine draws into one of the wanted size.
std::shared_ptr<image::OffscreenContext> ContextOfThread() {
  thread_local const auto context = std::make_shared<image::OffscreenContext>(16, 16);
  context->MakeCurrent();
  return context;
}

}  // namespace

struct Renderer::Impl {
  std::shared_ptr<image::OffscreenContext> gl = ContextOfThread();
  int width = 0;
  int height = 0;
  mjvScene scene;
  mjvOption option;
  mjrContext context;
  internal::DataPtr data;  // of worlds that must not change

  Impl(const World& world, int width_px, int height_px, const RenderQuality& quality)
      : width(width_px), height(height_px) {
    const mjModel* model = world.model();
    mjv_defaultScene(&scene);
    mjv_defaultOption(&option);
    mjr_defaultContext(&context);
    // The engine takes both from the model, of which it only reads: a copy without its arrays'
    // owner.
    mjModel drawn = *model;
    drawn.vis.quality.offsamples = quality.samples.value_or(drawn.vis.quality.offsamples);
    drawn.vis.quality.shadowsize = quality.shadow_px.value_or(drawn.vis.quality.shadowsize);
    std::optional<internal::TextureSet> printed;
    if (quality.fine_print) PrintedTextures(world, printed).PutInto(drawn);
    internal::CallEngine(nullptr, [&] {
      mjv_makeScene(model, &scene, kMaxGeoms);
      mjr_makeContext(&drawn, &context, mjFONTSCALE_100);
      mjr_resizeOffscreen(width, height, &context);
      mjr_setBuffer(mjFB_OFFSCREEN, &context);
    });
  }
  ~Impl() {
    gl->MakeCurrent();
    mjr_freeContext(&context);
    mjv_freeScene(&scene);
  }

  image::Image Draw() {
    const mjrRect viewport = {0, 0, width, height};
    const std::ptrdiff_t row = std::ptrdiff_t{3} * width;
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(row * height));
    internal::CallEngine(nullptr, [&] {
      mjr_restoreBuffer(&context);  // another renderer's may be the thread's
      mjr_render(viewport, &scene, &context);
      mjr_readPixels(pixels.data(), nullptr, viewport, &context);
    });
    image::Image picture{width, height, {}};
    picture.rgb.reserve(pixels.size());
    for (auto end = pixels.end(); end != pixels.begin(); end -= row) {  // rows from the bottom
      picture.rgb.insert(picture.rgb.end(), end - row, end);
    }
    return picture;
  }
};

Renderer::Renderer(const World& world, int width, int height, const RenderQuality& quality) {
  if (width <= 0 || height <= 0) {
    throw std::invalid_argument("Renderer: width and height must be above 0");
  }
  impl_ = std::make_unique<Impl>(world, width, height, quality);
  if (impl_->context.currentBuffer != mjFB_OFFSCREEN) {
    throw base::RunError("no offscreen buffer for pictures");
  }
}

Renderer::~Renderer() = default;

image::Image Renderer::Render(World& world, const std::string& camera_name,
                              const Overlay& overlay) {
  impl_->gl->MakeCurrent();
  mjvCamera camera = CameraOf(world.model(), camera_name);
  internal::CallEngine(nullptr, [&] {
    mjv_updateScene(world.model(), world.data(), &impl_->option, nullptr, &camera, mjCAT_ALL,
                    &impl_->scene);
    AddOverlay(overlay, impl_->scene);
  });
  return impl_->Draw();
}

image::Image Renderer::Render(const World& world, const PinholeView& view) {
  impl_->gl->MakeCurrent();
  mjvCamera any;
  mjv_defaultCamera(&any);
  // The engine asks for data that it may write to.
  internal::CallEngine(nullptr, [&] {
    if (!impl_->data) impl_->data.reset(mj_makeData(world.model()));
    mj_copyData(impl_->data.get(), world.model(), world.data());
    mjv_updateScene(world.model(), impl_->data.get(), &impl_->option, nullptr, &any, mjCAT_ALL,
                    &impl_->scene);
  });
  const mjvGLCamera camera =
      PinholeCamera(view, impl_->scene.camera[0], impl_->width, impl_->height);
  std::fill(std::begin(impl_->scene.camera), std::end(impl_->scene.camera), camera);
  return impl_->Draw();
}

}  // namespace rangegrasp::sim
