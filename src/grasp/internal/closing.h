#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"
#include "grasp/grasp.h"
#include "robot/robot.h"

namespace rangegrasp::grasp::internal {

// For all sources of this folder.
using base::Pose;
using Eigen::Vector3d;
using geometry::TriangleMesh;
using robot::HandModel;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A regular grid over two coordinates [m].
struct Grid {
  double u0_m = 0.0;
  double v0_m = 0.0;
  double cell_m = 0.002;
  int nu = 0;
  int nv = 0;

  /// The cell that contains (u, v), or -1 outside the grid.
  int Cell(double u_m, double v_m) const {
    const double i = (u_m - u0_m) / cell_m;
    const double j = (v_m - v0_m) / cell_m;
    if (i < 0.0 || j < 0.0 || i >= nu || j >= nv) return -1;
    return static_cast<int>(j) * nu + static_cast<int>(i);
  }
};

/// Height fields of the hand at a pitch, in its tool frame T. T has the axes of frame G (x from the
/// fingers to the thumb, z the approach) and its origin at the open hand's tip tool centre,
///   X_TH = Ry(-pitch) X_HG_tip^-1,
/// so that a positive pitch moves the thumb's tip down, along +z_T.
/// Fields are computed on first use and kept. Not thread-safe.
class HandProfiles {
 public:
  /// The inner side of fingers and thumb over (y_T, z_T). All states of one pitch share one grid.
  struct Inner {
    Grid grid;
    std::vector<float> finger;        ///< max x_T of the fingers [m]; -infinity if there is none
    std::vector<float> thumb;         ///< min x_T of the thumb [m]; +infinity if there is none
    double finger_min_m = kInfinity;  ///< minimum of `finger`
    double thumb_max_m = -kInfinity;  ///< maximum of `thumb`
  };
  /// How far down the hand reaches over (x_T, y_T).
  struct Lower {
    Grid grid;
    std::vector<float> z;  ///< max z_T of all shapes [m]; -infinity if there is none
  };

  /// Keeps a reference to the hand.
  explicit HandProfiles(const HandModel& hand);

  const HandModel& hand() const { return hand_; }
  static Pose X_TH(const HandModel& hand, double pitch_rad);

  const Inner& InnerSide(double pitch_rad, std::size_t state);
  const Lower& LowerSide(double pitch_rad, std::size_t state);
  /// The middle of the thumb's and the fingers' pads, in T.
  Vector3d PadCenter_T(double pitch_rad, std::size_t state) const;
  /// The published tool centre in T: between the tips of the thumb and the index finger or (power)
  /// the middle of the index and the little finger.
  Vector3d ToolCenter_T(double pitch_rad, std::size_t state, bool power) const;
  /// The farthest extent [m] of the hand along a unit direction of T, from T's origin.
  double Extent(double pitch_rad, std::size_t state, const Vector3d& direction_T) const;

 private:
  using Key = std::pair<long, std::size_t>;  ///< pitch in microradians, state
  geometry::Points Vertices_T(double pitch_rad, std::size_t state, std::size_t shape) const;
  Grid InnerGrid(double pitch_rad) const;

  const HandModel& hand_;
  std::vector<TriangleMesh> meshes_;
  std::map<long, Grid> inner_grids_;
  std::map<Key, Inner> inner_;
  std::map<Key, Lower> lower_;
};

/// The contacts of the hand when it closes on a surface.
struct Closing {
  std::size_t state = 0;    ///< of the hand, nearest to where both sides touch
  double gap_m = 0.0;       ///< gap of the pads when both sides touch
  double drag_m = 0.0;      ///< how far the first side to touch pushes the object, along x_T
  Vector3d finger_T;        ///< middle of the fingers' contact
  Vector3d thumb_T;         ///< middle of the thumb's contact
  Vector3d finger_out_T;    ///< unit normal of the surface there, towards the fingers
  Vector3d thumb_out_T;     ///< the same, towards the thumb
  double contact_m2 = 0.0;  ///< area of the surface within 3 mm of the fingers or the thumb
};

/// Closes the hand model on surface samples, like a caliper whose two sides move together. In each
/// state the object can be shifted by a to b along x, where
///   a = max(finger(y, z) - x), b = min(thumb(y, z) - x)
/// over the samples between the open jaws (not the far wall of a cup). Both sides touch where a and
/// b meet (bisection over the states, then linear between two), which is then the object's shift.
/// @param points_A, normals_A  samples in a frame A whose axes are T's
/// @param origin_A  T's origin in A [m]
/// @param open_state  state before closing
/// @return nullopt if one side meets nothing, or the open jaws do not clear the object.
/// O(log(states) n).
std::optional<Closing> CloseOn(HandProfiles& hand, double pitch_rad, std::size_t open_state,
                               std::span<const Vector3d> points_A,
                               std::span<const Vector3d> normals_A, double sample_area_m2,
                               const Vector3d& origin_A);

/// The antipodal angles of two contacts with their outward unit normals.
AntipodalAngles Antipodal(const Vector3d& finger, const Vector3d& finger_out, const Vector3d& thumb,
                          const Vector3d& thumb_out);

}  // namespace rangegrasp::grasp::internal
