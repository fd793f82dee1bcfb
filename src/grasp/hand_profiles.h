#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"
#include "robot/hand_model.h"

namespace rangegrasp::grasp {

/// A regular grid over two coordinates [m].
struct Grid {
  double u0_m = 0.0;
  double v0_m = 0.0;
  double cell_m = 0.002;
  int nu = 0;
  int nv = 0;

  /// The cell that holds (u, v), -1 outside.
  int Cell(double u_m, double v_m) const {
    const double i = (u_m - u0_m) / cell_m;
    const double j = (v_m - v0_m) / cell_m;
    if (i < 0.0 || j < 0.0 || i >= nu || j >= nv) return -1;
    return static_cast<int>(j) * nu + static_cast<int>(i);
  }
};

/// The hand at a pitch as height fields, in its tool frame T: axes as frame G's (x from the fingers
/// to the thumb, z the approach), origin at the open hand's tip tool centre,
///   X_TH = Ry(-pitch) X_HG_tip^-1,
/// so that a positive pitch takes the thumb's tip down, along +z_T.
/// Fields are made when they are first asked for and kept. Not thread-safe.
class HandProfiles {
 public:
  /// The inner side of fingers and thumb over (y_T, z_T). All states of one pitch share one grid.
  struct Inner {
    Grid grid;
    std::vector<float> finger;  ///< max x_T of the fingers [m]; -infinity where there is none
    std::vector<float> thumb;   ///< min x_T of the thumb [m]; +infinity where there is none
    double finger_min_m = 0.0;  ///< of `finger`
    double thumb_max_m = 0.0;   ///< of `thumb`
  };
  /// How far down the hand reaches over (x_T, y_T).
  struct Lower {
    Grid grid;
    std::vector<float> z;  ///< max z_T of all shapes [m]; -infinity where there is none
  };

  /// Keeps a reference to the hand. State k's shape i must be state 0's shape i moved.
  /// @throws std::invalid_argument if the hand has no states, or they differ in their shapes.
  explicit HandProfiles(const robot::HandModel& hand);

  const robot::HandModel& hand() const { return hand_; }
  static base::Pose X_TH(const robot::HandModel& hand, double pitch_rad);

  const Inner& InnerSide(double pitch_rad, std::size_t state);
  const Lower& LowerSide(double pitch_rad, std::size_t state);
  /// The middle of the thumb's and the fingers' pads, in T.
  Eigen::Vector3d PadCenter_T(double pitch_rad, std::size_t state) const;
  /// The published tool centre: of the tips of the thumb and the index finger, or (power) of the
  /// little finger too, in T.
  Eigen::Vector3d ToolCenter_T(double pitch_rad, std::size_t state, bool power) const;
  /// The farthest extent [m] of the hand along a unit direction of T, from T's origin.
  double Extent(double pitch_rad, std::size_t state, const Eigen::Vector3d& direction_T) const;

 private:
  using Key = std::pair<long, std::size_t>;  ///< pitch in microradians, state
  geometry::Points Vertices_T(double pitch_rad, std::size_t state, std::size_t shape) const;
  Grid InnerGrid(double pitch_rad) const;

  const robot::HandModel& hand_;
  std::vector<geometry::TriangleMesh> meshes_;
  std::map<long, Grid> inner_grids_;
  std::map<Key, Inner> inner_;
  std::map<Key, Lower> lower_;
};

}  // namespace rangegrasp::grasp
