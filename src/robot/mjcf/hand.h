#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"

namespace rangegrasp::mjcf {

/// The part of a name after the last '/'.
std::string_view Suffix(std::string_view name);

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using ModelPtr = std::unique_ptr<mjModel, Deleter>;
using DataPtr = std::unique_ptr<mjData, Deleter>;

/// Memory for loading a scene with its textures, with a margin; with less, the engine may crash.
constexpr std::size_t kEngine_bytes = std::size_t{256} << 20;

/// Number of elements of a type in a model; 0 for types that have no names here.
int CountOf(const mjModel* model, mjtObj type);

/// The first element that is or reaches so far away that the engine and the renderer never finish,
/// as "body \"cup\" at 0 0 1e+300"; empty if there is none.
std::string FarAway(const mjModel& model);

/// A message of the engine about a file, in one line: "arm.xml:33: ..." if it names a line of the
/// file, or of one that it includes or attaches and that has this element there; else "file: ...".
/// Of a file that is not XML at all, it says that in place of the parser's words.
std::string EngineMessage(const std::filesystem::path& file, const std::string& message);

/// The first element of a type with this name after any prefix; -1 if there is none.
int TryFind(const mjModel* model, mjtObj type, std::string_view suffix);
/// @throws base::InputError naming the element and those that exist.
int Find(const mjModel* model, mjtObj type, std::string_view suffix);

/// The elements of a custom tuple.
/// @throws base::InputError if it is missing or holds another type.
std::vector<int> TupleOf(const mjModel* model, mjtObj type, std::string_view suffix);
/// A custom numeric; empty if there is none.
std::vector<double> NumericOf(const mjModel* model, std::string_view suffix);

/// "" for an element without a name.
std::string_view NameOf(const mjModel* model, mjtObj type, int id);

/// True if `body` is `root` or below it.
bool InSubtree(const mjModel* model, int body, int root);
/// Whether a geom takes part in collisions.
bool Collides(const mjModel* model, int geom);

/// nullopt if it is not a convex primitive.
std::optional<geometry::Shape::Kind> KindOf(int geom_type);
/// A mesh, or the convex hull that the engine uses for its collisions (the mesh itself if none).
geometry::TriangleMesh MeshOf(const mjModel* model, int mesh);
geometry::TriangleMesh HullOf(const mjModel* model, int mesh);

/// Vectors and matrices in the engine's arrays, as Eigen maps.
inline Eigen::Map<const Eigen::Vector3d> Vec3(const mjtNum* p) {
  return Eigen::Map<const Eigen::Vector3d>(p);
}
inline Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> Mat3(const mjtNum* p) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(p);
}

/// Poses in W at the last kinematics update.
inline base::Pose BodyPose(const mjData* data, int body) {
  return base::MakePose(Mat3(data->xmat + 9 * body), Vec3(data->xpos + 3 * body));
}
inline base::Pose GeomPose(const mjData* data, int geom) {
  return base::MakePose(Mat3(data->geom_xmat + 9 * geom), Vec3(data->geom_xpos + 3 * geom));
}
inline base::Pose SitePose(const mjData* data, int site) {
  return base::MakePose(Mat3(data->site_xmat + 9 * site), Vec3(data->site_xpos + 3 * site));
}

/// A drive of the hand, and its length (of its joint [rad or m] or its tendon, times its gear) in
/// the open and the closed hand. If both are equal, it holds its joint there.
struct HandMotor {
  int actuator = -1;
  double open = 0.0, closed = 0.0;
  double Travel() const { return closed - open; }
  bool Moves() const { return closed != open; }
};

/// Whether the tuple "hand_motors" states how the hand closes. If not, one geared "hand_motor"
/// closes its hinges ("hand_joints", open at their lower limits).
bool HasMotors(const mjModel* model);

/// "hand_motors" with the numerics "hand_open" and "hand_closed", one value per drive.
/// @throws base::InputError naming what is missing or of another size, or a drive whose force is
/// not linear in command, length and speed.
std::vector<HandMotor> HandMotors(const mjModel* model);

/// The topmost body with a joint on the way from a body to the hand's root: a finger's first body.
int HandBranch(const mjModel* model, int body, int hand);

/// The root body of the thumb: that of the first of "hand_joints", or (HasMotors) the topmost one
/// with a joint above the first of "fingertips".
int ThumbRoot(const mjModel* model);

/// The outermost geoms of "fingertips", by side: they close on an object.
struct LastSegments {
  std::vector<int> thumb, fingers;  ///< geoms
};
LastSegments LastSegmentsOf(const mjModel* model);
/// The same for a file that has no such tuple yet.
/// @param tips  geoms
/// @param thumb  the root body of the thumb
LastSegments LastSegmentsOf(const mjModel* model, const std::vector<int>& tips, int thumb);

/// Smallest distance between the two sides [m], at most kFarApart_m; negative: overlap.
double GapOf(const mjModel* model, mjData* data, const LastSegments& tips);
constexpr double kFarApart_m = 1.0;  ///< no hand opens that far

/// From the present joint positions (the engine's own lengths are of the last kinematics); for
/// tendons around sites and geoms, the engine's values.
double DriveLength(const mjModel* model, const mjData* data, int actuator);
double DriveSpeed(const mjModel* model, const mjData* data, int actuator);

/// The force of an actuator: gain * command + bias[0] + bias[1] * length + bias[2] * speed, clamped
/// to its range.
struct AffineDrive {
  double gain = 1.0;
  double bias[3] = {0.0, 0.0, 0.0};
  double weakest = 0.0, strongest = 0.0;  ///< infinite if the file has no range
};
AffineDrive AffineOf(const mjModel* model, int actuator);

/// The hand closing on nothing, all drives together: at share s each is at open + s (closed -
/// open), and undriven joints (followers, linkages, springs) are where the model moves them.
struct HandClosing {
  struct Point {
    double share = 0.0;  ///< 0 .. 1
    double gap_m = 0.0;  ///< smallest distance of the two sides' last segments; negative: overlap
    std::vector<double> positions;  ///< of `joints`
  };
  std::vector<int> joints;    ///< all joints of the hand
  std::vector<Point> points;  ///< ascending, evenly spaced, the first at 0, the last at 1

  // How well the model followed, for checks.
  double equality_m = 0.0;   ///< largest error of an equality [rad or m]
  int equality = -1;         ///< its number
  double behind = 0.0;       ///< share of its travel by which a drive stopped short of its end
  int behind_actuator = -1;  ///< its number

  /// The rate at which the gap narrows at a share [m per full travel].
  double NarrowingAt(double share) const;
  /// The share at which the sides first touch; 1 if they never do.
  double Touching() const { return ShareAtGap(0.0); }
  /// The largest share up to which the gap is at least gap_m; 0 if it never is.
  double ShareAtGap(double gap_m) const;
  /// Moves the hand's joints to a share; the caller updates the kinematics.
  void Pose(const mjModel* model, mjData* data, double share) const;
};

/// Closes a copy of the hand step by step, without gravity or contacts. Every drive is a stiff
/// servo without limits; all else is as in qpos0. Takes a few thousand steps, 20 to 60 ms.
/// @param motors  may have other ends of their travel than the file's HandMotors()
/// @throws base::InputError if the hand does not stay finite.
HandClosing CloseOnNothing(const mjModel* model, const std::vector<HandMotor>& motors);
/// The same for a file that does not name its parts yet.
/// @param tips  the sides that close
/// @param hand  the hand's root body
HandClosing CloseOnNothing(const mjModel* model, const std::vector<HandMotor>& motors,
                           const LastSegments& tips, int hand);
inline HandClosing CloseOnNothing(const mjModel* model) {
  return CloseOnNothing(model, HandMotors(model));
}

/// The force [N or Nm] of each drive with which the thumb's last segments press with a total of 1 N
/// against those of the fingers, along the unit vector x_W (from the fingers to the thumb). It
/// follows from the equilibrium of the hand's joints,
///   R^T tau + A^T lambda = J^T f,
/// with the drives' moments R, the equalities' Jacobian A and their forces lambda, and the Jacobian
/// J of the segments' middles, which press with f. If several solutions exist, it is the smallest
/// one. A single drive needs no equilibrium: tau = -d(gap)/d(length), by virtual work.
/// @param data  after mj_forward or mj_step
std::vector<double> GripForces(const mjModel* model, const mjData* data,
                               const std::vector<HandMotor>& motors, const HandClosing& closing,
                               double share, const Eigen::Vector3d& x_W);

}  // namespace rangegrasp::mjcf
