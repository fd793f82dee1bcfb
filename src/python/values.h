#pragma once

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "base/frames.h"
#include "geometry/observation.h"
#include "geometry/point_cloud.h"
#include "grasp/detector.h"

namespace rangegrasp::python {

namespace nb = nanobind;

using Array = nb::ndarray<nb::numpy, double, nb::c_contig>;
using Matrix4 = nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig, nb::device::cpu>;
using Vector3 = nb::ndarray<const double, nb::shape<3>, nb::c_contig, nb::device::cpu>;

/// A new array with a copy of these values.
template <typename T>
nb::ndarray<nb::numpy, T, nb::c_contig> Copied(const T* values, std::vector<std::size_t> shape) {
  std::size_t count = 1;
  for (const std::size_t n : shape) count *= n;
  auto* copy = new T[count];
  std::copy(values, values + count, copy);
  nb::capsule owner(copy, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return {copy, shape.size(), shape.data(), owner};
}

Array ArrayOf(const base::Pose& X);             ///< 4 x 4
Array ArrayOf(const Eigen::Vector3d& v);        ///< 3
Array ArrayOf(const geometry::Points& points);  ///< n x 3

/// @throws std::invalid_argument (ValueError) naming the argument unless it is a rigid motion
base::Pose PoseFrom(const Matrix4& X, const char* name);

/// JSON as Python objects. A number that is not finite becomes None, as in records.
nb::object ObjectOf(const nlohmann::ordered_json& json);

/// A scan without ground truth: {"views": [{"points", "noise", "colors", "X_WV"}]}.
nb::dict DictOf(const geometry::Observation& observation);

/// The observation in such a dictionary. Copies the points.
/// @throws std::invalid_argument naming the error in an array
geometry::Observation ObservationFrom(const nb::dict& scan);

/// An object and its points as a dictionary for the package's class Object.
nb::dict DictOf(const grasp::DetectedObject& object, const geometry::Points& points,
                const geometry::Observation& observation);

/// A grasp as a dictionary for the package's class Grasp. Its score is what the order of grasps
/// goes by: the predicted probability of delivery or, without one, the score by rules.
nb::dict DictOf(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand);

/// Frame G of the proposal that gives the grasp's hand pose, including pitch and centering.
base::Pose ProposedPose(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand);

/// Adds the work cell's data to a scan: "center", "radius", "max_opening".
void AddWorkspace(const robot::Robot& robot, double margin_m, nb::dict& scan);

// Each adds the definitions of one source file to the module.
void AddScene(nb::module_& m);
void AddPerceive(nb::module_& m);
void AddRun(nb::module_& m);

}  // namespace rangegrasp::python
