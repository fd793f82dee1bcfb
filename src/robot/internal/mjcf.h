#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/frames.h"
#include "geometry/shape.h"
#include "robot/mjcf/hand.h"
#include "robot/robot.h"

namespace rangegrasp::robot::internal {

/// A compiled MJCF file and its kinematic state. Names are matched by the part after the last '/'.
class Mjcf {
 public:
  /// @throws base::InputError with the file and MuJoCo's own message.
  explicit Mjcf(const std::filesystem::path& file);

  const mjModel& model() const { return *model_; }
  mjData& data() const { return *data_; }

  /// The element's id. @throws base::InputError if there is none, or more than one.
  int Require(mjtObj type, std::string_view name) const;
  /// The first such element; -1 if there is none.
  int FindIfAny(mjtObj type, std::string_view name) const {
    return mjcf::TryFind(&model(), type, name);
  }
  /// Ids of the elements of a tuple. @throws base::InputError if missing, empty or of another type.
  std::vector<int> Tuple(std::string_view name, mjtObj type) const;
  /// The same; empty if there is no such tuple.
  std::vector<int> TupleIfAny(std::string_view name, mjtObj type) const;
  /// A custom numeric. @throws base::InputError if it is missing or of another size.
  Eigen::VectorXd Numeric(std::string_view name, int size) const;

  std::string Name(mjtObj type, int id) const {
    return std::string(mjcf::NameOf(&model(), type, id));
  }
  std::string GeomTitle(int geom) const;  ///< its name, or else its body's
  bool InSubtree(int body, int root) const { return mjcf::InSubtree(&model(), body, root); }
  bool Collides(int geom) const { return mjcf::Collides(&model(), geom); }
  /// The geom as a shape in frame B, at a given pose X_BS.
  geometry::Shape ShapeOf(int geom, const base::Pose& X_BS) const;

  /// Poses in W at the present joint positions.
  base::Pose BodyPose(int body) const { return mjcf::BodyPose(&data(), body); }
  base::Pose GeomPose(int geom) const { return mjcf::GeomPose(&data(), geom); }
  base::Pose SitePose(int site) const { return mjcf::SitePose(&data(), site); }

  [[noreturn]] void Fail(const std::string& what) const;

 private:
  std::filesystem::path file_;
  mjcf::ModelPtr model_;
  mjcf::DataPtr data_;
};

/// Closes the hand below `hand_body` step by step and records its states as a caliper. Joint
/// equalities hold; passive joints are where their springs pull them. Changes mjcf's positions.
HandModel SampleHand(const Mjcf& mjcf, int hand_body);

}  // namespace rangegrasp::robot::internal
