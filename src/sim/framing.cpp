#include "sim/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/internal/engine.h"
#include "sim/internal/kinematics.h"
#include "sim/internal/names.h"

namespace rangegrasp::sim {
namespace {

/// Of the planes that bound what a camera sees to both sides, where they must pass.
struct Bounds {
  double low = std::numeric_limits<double>::infinity();    // A
  double high = -std::numeric_limits<double>::infinity();  // B

  void Add(double across, double k_along) {
    low = std::min(low, across + k_along);
    high = std::max(high, across - k_along);
  }
};

/// From the arm's right, 23 deg down: the direction of the shipped scenes' camera "close".
const Eigen::Vector3d kLooksAlong_W(-0.630, 0.669, -0.394);

void AddCorners(const Eigen::AlignedBox3d& box, const base::Pose& X_WB,
                std::vector<Eigen::Vector3d>& corners_W) {
  for (int i = 0; i < 8; ++i) {
    corners_W.push_back(X_WB * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  }
}

}  // namespace

Eigen::Matrix3d LookingAlong(const Eigen::Vector3d& direction_W) {
  const Eigen::Vector3d z = direction_W.normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ());
  if (!(x.norm() > 1e-6)) throw std::invalid_argument("LookingAlong: must not be vertical");
  Eigen::Matrix3d R_WC;
  R_WC.col(0) = x.normalized();
  R_WC.col(1) = z.cross(R_WC.col(0));
  R_WC.col(2) = z;
  return R_WC;
}

PinholeView FrameAll(std::span<const Eigen::Vector3d> points_W, const Eigen::Matrix3d& R_WC,
                     const FramingOptions& options) {
  if (points_W.empty()) throw std::invalid_argument("FrameAll: needs a point");
  const double half_px = 0.5 * options.height_px;
  const double focal_px = half_px / std::tan(0.5 * options.vertical_view_rad);
  const double share = 1.0 - options.margin;
  const double kx = share * 0.5 * options.width_px / focal_px;
  const double ky = share * half_px / focal_px;
  Bounds x, y;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p_W : points_W) {
    const Eigen::Vector3d q = R_WC.transpose() * p_W;
    x.Add(q.x(), kx * q.z());
    y.Add(q.y(), ky * q.z());
    nearest = std::min(nearest, q.z());
  }
  const double along = std::min({(x.low - x.high) / (2.0 * kx), (y.low - y.high) / (2.0 * ky),
                                 nearest - options.min_distance_m});
  const Eigen::Vector3d c(0.5 * (x.low + x.high), 0.5 * (y.low + y.high), along);
  PinholeView view;
  view.X_WC.linear() = R_WC;
  view.X_WC.translation() = R_WC * c;
  view.focal_px = focal_px;
  view.center_px = {0.5 * (options.width_px - 1), 0.5 * (options.height_px - 1)};
  return view;
}

Eigen::Matrix3d ViewAxes(const World& world) {
  const int camera = internal::TryFind(world.model(), mjOBJ_CAMERA, "close");
  if (camera < 0) return LookingAlong(kLooksAlong_W);
  const Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>> axes_W(
      world.data()->cam_xmat + 9 * std::ptrdiff_t{camera});
  // The engine's cameras have y upward and look along -z.
  return axes_W * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
}

void AddHandCorners(const World& world, std::vector<Eigen::Vector3d>& corners_W) {
  const mjModel* model = world.model();
  const int hand = internal::TryFind(model, mjOBJ_BODY, "hand");
  if (hand < 0) return;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!internal::InSubtree(model, model->geom_bodyid[geom], hand)) continue;
    const base::Pose X_WG = internal::GeomPose(world.data(), geom);
    const Eigen::Map<const Eigen::Vector3d> center(model->geom_aabb + 6 * std::ptrdiff_t{geom});
    const Eigen::Map<const Eigen::Vector3d> half(model->geom_aabb + 6 * std::ptrdiff_t{geom} + 3);
    AddCorners({center - half, center + half}, X_WG, corners_W);
  }
}

void AddObjectCorners(const World& world, int object, std::vector<Eigen::Vector3d>& corners_W) {
  AddCorners(world.ObjectBounds(object), base::Pose::Identity(), corners_W);
}

Eigen::Vector2d PixelOf(const PinholeView& view, const Eigen::Vector3d& point_W) {
  const Eigen::Vector3d q = view.X_WC.inverse() * point_W;
  return view.center_px + view.focal_px * q.head<2>() / q.z();
}

}  // namespace rangegrasp::sim
