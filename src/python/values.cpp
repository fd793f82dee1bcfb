#include "python/values.h"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/words.h"
#include "grasp/proposals.h"

namespace rangegrasp::python {
namespace {

constexpr double kRotationError = 1e-3;

/// Positions among the samples of all views, one view after the other, as a detector names them.
nb::ndarray<nb::numpy, std::int64_t, nb::c_contig> SamplesOf(
    const std::vector<geometry::SampleId>& samples, const geometry::Observation& observation) {
  std::vector<std::int64_t> first = {0};  // of each view
  for (const geometry::View& view : observation.views) {
    first.push_back(first.back() + static_cast<std::int64_t>(view.image.points_C.size()));
  }
  std::vector<std::int64_t> positions;
  for (const auto& id : samples) positions.push_back(first[id.view] + id.sample);
  return Copied(positions.data(), {positions.size()});
}

using PointsIn = nb::ndarray<const double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using NoiseIn = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using ColorsIn = nb::ndarray<const std::uint8_t, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

geometry::View ViewFrom(const nb::dict& dict) {
  const auto points = nb::cast<PointsIn>(dict["points"]);
  const std::size_t rows = points.shape(0), columns = points.shape(1);
  if (points.shape(2) != 3) throw std::invalid_argument("points must be rows x columns x 3");
  geometry::View view;
  view.X_CV = PoseFrom(nb::cast<Matrix4>(dict["X_WV"]), "X_WV");
  view.image.profiles = static_cast<int>(rows);
  view.image.samples = static_cast<int>(columns);
  view.image.origins_C = {view.X_CV.translation()};
  view.image.points_C.resize(rows * columns);
  std::copy(points.data(), points.data() + points.size(), view.image.points_C.data()->data());
  if (!dict["noise"].is_none()) {
    const auto noise = nb::cast<NoiseIn>(dict["noise"]);
    if (noise.size() != rows * columns) throw std::invalid_argument("noise must be rows x columns");
    view.noise_m.assign(noise.data(), noise.data() + noise.size());
  }
  if (!dict["colors"].is_none()) {
    const auto colors = nb::cast<ColorsIn>(dict["colors"]);
    if (colors.size() != 3 * rows * columns) {
      throw std::invalid_argument("colors must be rows x columns x 3");
    }
    view.colors.resize(rows * columns);
    std::copy(colors.data(), colors.data() + colors.size(),
              reinterpret_cast<std::uint8_t*>(view.colors.data()));
  }
  view.spacing_m = geometry::MedianSpacing(view.image);
  return view;
}

}  // namespace

Array ArrayOf(const base::Pose& X) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = X.matrix();
  return Copied(rows.data(), {4, 4});
}

Array ArrayOf(const Eigen::Vector3d& v) { return Copied(v.data(), {3}); }

Array ArrayOf(const geometry::Points& points) {
  return Copied(points.empty() ? nullptr : points.data()->data(), {points.size(), 3});
}

base::Pose PoseFrom(const Matrix4& X, const char* name) {
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(X.data());
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const bool rigid = matrix.allFinite() && error < kRotationError && R.determinant() > 0.0 &&
                     (matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).isZero(1e-9);
  if (!rigid) {
    throw std::invalid_argument(fmt::format(
        "{} must be a 4 x 4 rigid motion: a rotation (R^T R differs from the identity by {:.3g}), "
        "a translation, and the last row 0 0 0 1",
        name, error));
  }
  return base::MakePose(Eigen::Quaterniond(R).normalized().toRotationMatrix(),
                        matrix.topRightCorner<3, 1>());
}

nb::object ObjectOf(const nlohmann::ordered_json& json) {
  return nb::module_::import_("json").attr("loads")(json.dump());
}

nb::dict DictOf(const geometry::Observation& observation) {
  nb::list views;
  for (const geometry::View& view : observation.views) {
    const auto rows = static_cast<std::size_t>(view.image.profiles);
    const auto columns = static_cast<std::size_t>(view.image.samples);
    nb::dict dict;
    dict["points"] = Copied(view.image.points_C.data()->data(), {rows, columns, 3});
    dict["noise"] =
        view.noise_m.empty() ? nb::none() : nb::cast(Copied(view.noise_m.data(), {rows, columns}));
    dict["colors"] =
        view.colors.empty()
            ? nb::none()
            : nb::cast(Copied(reinterpret_cast<const std::uint8_t*>(view.colors.data()),
                              {rows, columns, 3}));
    dict["X_WV"] = ArrayOf(view.X_CV);
    views.append(dict);
  }
  nb::dict dict;
  dict["views"] = views;
  return dict;
}

geometry::Observation ObservationFrom(const nb::dict& scan) {
  geometry::Observation observation;
  for (const nb::handle view : nb::cast<nb::list>(scan["views"])) {
    observation.views.push_back(ViewFrom(nb::cast<nb::dict>(view)));
  }
  return observation;
}

base::Pose ProposedPose(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand) {
  const grasp::Proposal proposal{.width_m = grasp.width_m};
  return grasp.X_CH * grasp::PlaceHand(proposal, hand, {}).X_CH.inverse();
}

nb::dict DictOf(const grasp::DetectedObject& object, const geometry::Points& points,
                const geometry::Observation& observation) {
  nb::dict dict;
  dict["points"] = ArrayOf(points);
  dict["samples"] = SamplesOf(object.samples, observation);
  dict["rotational"] = object.rotational;
  dict["open"] = object.open;
  dict["center"] = ArrayOf(object.center_C);
  dict["size"] = ArrayOf(object.size_m);
  return dict;
}

nb::dict DictOf(const grasp::DetectedGrasp& grasp, const robot::HandModel& hand) {
  nb::dict dict;
  dict["X_WG"] = ArrayOf(ProposedPose(grasp, hand));
  dict["width"] = grasp.width_m;
  dict["approach"] = ArrayOf(grasp.approach_C);
  dict["score"] = grasp.probability.value_or(grasp.score);
  dict["probability"] = grasp.probability;
  dict["opening"] = grasp.opening_m;
  dict["object"] = grasp.object;
  dict["type"] = nb::str(std::string(base::Word(grasp.type)).c_str());
  dict["collides"] = grasp.collides;
  dict["contact_angle"] = grasp.contact_angle_rad;
  return dict;
}

void AddWorkspace(const robot::Robot& robot, double margin_m, nb::dict& scan) {
  scan["center"] = ArrayOf(Eigen::Vector3d(robot.X_WWorkspace.translation()));
  scan["radius"] = robot.workspace_radius_m + margin_m;
  scan["max_opening"] = robot.hand().MaxGap();
}

}  // namespace rangegrasp::python
