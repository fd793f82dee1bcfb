#include "sim/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "base/image/offscreen_context.h"
#include "base/installation.h"
#include "base/units.h"
#include "robot/robot.h"
#include "sim/internal/engine.h"
#include "sim/internal/fine_print.h"
#include "sim/resting_poses.h"

namespace rangegrasp::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kMaxGeoms = 20000;          // per picture; further geoms are left out
constexpr double kMinDistance_m = 1e-3;   // from a free camera to the point that it looks at
constexpr double kMaxDistance_m = 100.0;  // the same; a robot's cell is a dot from there

bool ParseFreeView(const std::string& text, Vector3d& eye, Vector3d& look) {
  int used = 0;
  const int fields = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%n", &eye.x(), &eye.y(),
                                 &eye.z(), &look.x(), &look.y(), &look.z(), &used);
  return fields == 6 && static_cast<std::size_t>(used) == text.size();
}

mjvCamera FreeCamera(const Vector3d& eye, const Vector3d& look) {
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  const Vector3d view = look - eye;
  camera.type = mjCAMERA_FREE;
  std::copy_n(look.data(), 3, camera.lookat);
  camera.distance = std::max(view.norm(), kMinDistance_m);
  camera.azimuth = base::ToDeg(std::atan2(view.y(), view.x()));
  camera.elevation = base::ToDeg(std::asin(std::clamp(view.z() / camera.distance, -1.0, 1.0)));
  return camera;
}

void CheckDistance(const std::string& view, double distance_m) {
  if (distance_m <= kMaxDistance_m) return;
  throw base::InputError(fmt::format(
      "camera '{}': is {:.4g} m from the point that it looks at, {:g} m are the maximum: are its "
      "numbers in metres?",
      view, distance_m, kMaxDistance_m));
}

mjvCamera CameraOf(const mjModel* model, const std::string& name) {
  Vector3d eye, look;
  if (ParseFreeView(name, eye, look)) {
    CheckDistance(name, (look - eye).norm());
    return FreeCamera(eye, look);
  }
  mjvCamera camera;
  mjv_defaultCamera(&camera);
  camera.type = mjCAMERA_FIXED;
  camera.fixedcamid = internal::Find(model, mjOBJ_CAMERA, name);
  return camera;
}

// The view frustum at the near plane. Rows count from the top, heights from the bottom.
mjvGLCamera PinholeCamera(const PinholeView& view, const mjvGLCamera& clipping, int width,
                          int height) {
  mjvGLCamera camera = clipping;
  Eigen::Map<Vector3f>(camera.pos) = view.X_WC.translation().cast<float>();
  Eigen::Map<Vector3f>(camera.forward) = view.X_WC.linear().col(2).cast<float>();
  Eigen::Map<Vector3f>(camera.up) = -view.X_WC.linear().col(1).cast<float>();
  const double scale = clipping.frustum_near / view.focal_px;
  // The edges of a picture lie half a pixel beyond the centers of its outer pixels.
  const Vector2d center = view.center_px + Vector2d::Constant(0.5);
  camera.frustum_center = static_cast<float>(scale * (0.5 * width - center.x()));
  camera.frustum_width = static_cast<float>(scale * 0.5 * width);
  camera.frustum_top = static_cast<float>(scale * center.y());
  camera.frustum_bottom = static_cast<float>(scale * (center.y() - height));
  camera.orthographic = 0;
  return camera;
}

// One context serves all renderers of a thread (and of forked processes). The code that draws a
// kind of surface is compiled once per context, which takes as long as a picture. The context's own
// frame buffer is small: the engine draws into one of the requested size.
std::shared_ptr<image::OffscreenContext> ContextOfThread() {
  thread_local const auto context = std::make_shared<image::OffscreenContext>(16, 16);
  context->MakeCurrent();
  return context;
}

/// Bounds for the two side planes of a camera's field of view: A and B of FrameAll.
struct Bounds {
  double low = std::numeric_limits<double>::infinity();    // A
  double high = -std::numeric_limits<double>::infinity();  // B

  void Add(double across, double k_along) {
    low = std::min(low, across + k_along);
    high = std::max(high, across - k_along);
  }
};

/// From the arm's right, 23 deg downward, as the camera "close" of the shipped scenes.
const Vector3d kLooksAlong_W(-0.630, 0.669, -0.394);

void AddCorners(const AlignedBox3d& box, const base::Pose& X_WB, std::vector<Vector3d>& corners_W) {
  for (int i = 0; i < 8; ++i) {
    corners_W.push_back(X_WB * box.corner(static_cast<AlignedBox3d::CornerType>(i)));
  }
}

// A view from the scanner's side, so far away that an object fills half of the picture.
std::string NearBy(const World& world) {
  const AlignedBox3d box = world.ObjectBounds(0);
  const Vector3d eye =
      box.center() + 1.8 * box.diagonal().norm() * Vector3d(0.55, -0.65, 0.5).normalized();
  return fmt::format("{},{},{},{},{},{}", eye.x(), eye.y(), eye.z(), box.center().x(),
                     box.center().y(), box.center().z());
}

}  // namespace

struct Renderer::Impl {
  std::shared_ptr<image::OffscreenContext> gl = ContextOfThread();
  int width = 0;
  int height = 0;
  mjvScene scene;
  mjvOption option;
  mjrContext context;
  internal::DataPtr data;  // copy of a world that must not change

  Impl(const World& world, int width_px, int height_px, const RenderQuality& quality)
      : width(width_px), height(height_px) {
    const mjModel* model = world.model();
    mjv_defaultScene(&scene);
    mjv_defaultOption(&option);
    mjr_defaultContext(&context);
    mjModel drawn = *model;  // without owning its arrays: the engine only reads it
    drawn.vis.quality.offsamples = quality.samples.value_or(drawn.vis.quality.offsamples);
    drawn.vis.quality.shadowsize = quality.shadow_px.value_or(drawn.vis.quality.shadowsize);
    std::optional<internal::TextureSet> printed;
    if (quality.fine_print) printed.emplace(world).PutInto(drawn);
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

  void Update(const mjModel* model, mjData* state, mjvCamera camera) {
    gl->MakeCurrent();
    internal::CallEngine(nullptr, [&] {
      mjv_updateScene(model, state, &option, nullptr, &camera, mjCAT_ALL, &scene);
    });
  }

  image::Image Draw() {
    const mjrRect viewport = {0, 0, width, height};
    const std::ptrdiff_t row = std::ptrdiff_t{3} * width;
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(row * height));
    internal::CallEngine(nullptr, [&] {
      mjr_restoreBuffer(&context);  // another renderer's may be active
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

image::Image Renderer::Render(World& world, const std::string& camera_name) {
  impl_->Update(world.model(), world.data(), CameraOf(world.model(), camera_name));
  return impl_->Draw();
}

image::Image Renderer::Render(const World& world, const PinholeView& view) {
  // The engine needs data that it may write to.
  internal::CallEngine(nullptr, [&] {
    if (!impl_->data) impl_->data.reset(mj_makeData(world.model()));
    mj_copyData(impl_->data.get(), world.model(), world.data());
  });
  mjvCamera any;
  mjv_defaultCamera(&any);
  impl_->Update(world.model(), impl_->data.get(), any);
  const mjvGLCamera camera =
      PinholeCamera(view, impl_->scene.camera[0], impl_->width, impl_->height);
  std::fill(std::begin(impl_->scene.camera), std::end(impl_->scene.camera), camera);
  return impl_->Draw();
}

Matrix3d LookingAlong(const Vector3d& direction_W) {
  const Vector3d z = direction_W.normalized();
  const Vector3d x = z.cross(Vector3d::UnitZ());
  if (!(x.norm() > 1e-6)) throw std::invalid_argument("LookingAlong: must not be vertical");
  Matrix3d R_WC;
  R_WC.col(0) = x.normalized();
  R_WC.col(1) = z.cross(R_WC.col(0));
  R_WC.col(2) = z;
  return R_WC;
}

PinholeView FrameAll(std::span<const Vector3d> points_W, const Matrix3d& R_WC,
                     const FramingOptions& options) {
  if (points_W.empty()) throw std::invalid_argument("FrameAll: needs a point");
  const double half_px = 0.5 * options.height_px;
  const double focal_px = half_px / std::tan(0.5 * options.vertical_view_rad);
  const double share = 1.0 - options.margin;
  const double kx = share * 0.5 * options.width_px / focal_px;
  const double ky = share * half_px / focal_px;
  Bounds x, y;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector3d& p_W : points_W) {
    const Vector3d q = R_WC.transpose() * p_W;
    x.Add(q.x(), kx * q.z());
    y.Add(q.y(), ky * q.z());
    nearest = std::min(nearest, q.z());
  }
  const double along = std::min({(x.low - x.high) / (2.0 * kx), (y.low - y.high) / (2.0 * ky),
                                 nearest - options.min_distance_m});
  const Vector3d c(0.5 * (x.low + x.high), 0.5 * (y.low + y.high), along);
  PinholeView view;
  view.X_WC.linear() = R_WC;
  view.X_WC.translation() = R_WC * c;
  view.focal_px = focal_px;
  view.center_px = {0.5 * (options.width_px - 1), 0.5 * (options.height_px - 1)};
  return view;
}

Matrix3d ViewAxes(const World& world) {
  const int camera = internal::TryFind(world.model(), mjOBJ_CAMERA, "close");
  if (camera < 0) return LookingAlong(kLooksAlong_W);
  // The engine's cameras have y upward and look along -z.
  return mjcf::Mat3(world.data()->cam_xmat + 9 * camera) * Vector3d(1.0, -1.0, -1.0).asDiagonal();
}

void AddHandCorners(const World& world, std::vector<Vector3d>& corners_W) {
  const mjModel* model = world.model();
  const int hand = internal::TryFind(model, mjOBJ_BODY, "hand");
  if (hand < 0) return;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!internal::InSubtree(model, model->geom_bodyid[geom], hand)) continue;
    const base::Pose X_WG = internal::GeomPose(world.data(), geom);
    const auto center = internal::Vec3(model->geom_aabb + 6 * geom);
    const auto half = internal::Vec3(model->geom_aabb + 6 * geom + 3);
    AddCorners({center - half, center + half}, X_WG, corners_W);
  }
}

void AddObjectCorners(const World& world, int object, std::vector<Vector3d>& corners_W) {
  AddCorners(world.ObjectBounds(object), base::Pose::Identity(), corners_W);
}

Vector2d PixelOf(const PinholeView& view, const Vector3d& point_W) {
  const Vector3d q = view.X_WC.inverse() * point_W;
  return view.center_px + view.focal_px * q.head<2>() / q.z();
}

image::Image DrawObject(const sim::ObjectModel& object, const std::string& camera, int width,
                        int height) {
  const auto scene = base::DataFolder() / "scenes/tabletop.xml";
  sim::World world(scene, {object}, {});
  world.SetArm(robot::Robot::Load(scene).home);
  const auto poses = sim::StableRestingPoses(object, 0.0);
  base::Pose X_WO = base::Pose::Identity();
  if (!poses.empty()) X_WO.linear() = poses.front().faces.front().R_WO.toRotationMatrix();
  world.PlaceObject(0, X_WO);
  X_WO.translation().z() -= world.ObjectBottom(0);
  world.PlaceObject(0, X_WO);
  world.Settle();
  return sim::Renderer(world, width, height).Render(world, camera.empty() ? NearBy(world) : camera);
}

void WriteModelAndState(const World& world, const std::filesystem::path& folder) {
  char error[1000] = "";
  const mjcf::ModelPtr model(mj_embedAssets(world.model(), error, sizeof error));
  if (!model) throw base::RunError(error);
  std::string bytes(static_cast<std::size_t>(mj_sizeModel(model.get())), '\0');
  mj_saveModel(model.get(), nullptr, bytes.data(), static_cast<mjtSize>(bytes.size()));
  base::WriteFile(folder / "model.mjb", bytes);
  std::vector<mjtNum> state(
      static_cast<std::size_t>(mj_stateSize(model.get(), mjSTATE_INTEGRATION)));
  mj_getState(model.get(), world.data(), state.data(), mjSTATE_INTEGRATION);
  base::WriteFile(folder / "state.bin",
                  {reinterpret_cast<const char*>(state.data()), state.size() * sizeof(mjtNum)});
}

}  // namespace rangegrasp::sim
