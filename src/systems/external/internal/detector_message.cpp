#include "external/internal/detector_message.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "geometry/cloud_file.h"
#include "geometry/mesh_file.h"
#include "geometry/view_images.h"
#include "grasp/detector.h"

namespace rangegrasp::external::internal {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

// Names of the files in the detector's folder.
constexpr const char* kCloudFile = "obs.pcd";
constexpr const char* kHandFile = "hand.stl";
// Limits for an answer. A valid answer is nested 5 deep (grasps, one, its rotation, a row).
constexpr int kMaxDepth = 8;
constexpr std::size_t kMaxObjects = 1000;
constexpr std::size_t kMaxGrasps = 10'000;
// Larger numbers are neither positions on a table [m] nor sizes of hands.
constexpr double kMax_m = 100.0;
// What a message about a larger number adds if it is a length.
constexpr const char* kInMetres = ", in metres; is it in millimetres?";
constexpr double kMaxScore = 1e12;
// Tolerance for a rotation printed with four digits.
constexpr double kRotationError = 1e-3;
// Maximum number of characters that are shown of an invalid value.
constexpr std::size_t kShown = 60;

ordered_json JsonOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json JsonOf(const base::Pose& X) {
  const auto row = [&](int i) -> ordered_json { return {X(i, 0), X(i, 1), X(i, 2), X(i, 3)}; };
  return {row(0), row(1), row(2), row(3)};
}

geometry::TriangleMesh OpenHand(const robot::HandModel& hand) {
  geometry::TriangleMesh mesh_H;
  for (const auto& shape : hand.states.front().shapes) {
    geometry::Append(geometry::Tessellate(shape), mesh_H);
  }
  return mesh_H;
}

/// All samples, view by view; organized if there is one view.
geometry::RangeImage WholeCloud(const geometry::Observation& observation) {
  if (observation.views.size() == 1) return observation.views.front().image;
  geometry::RangeImage cloud{.profiles = 1, .samples = 0, .points_C = {}, .origins_C = {}};
  for (const auto& view : observation.views) {
    const auto& points_C = view.image.points_C;
    cloud.points_C.insert(cloud.points_C.end(), points_C.begin(), points_C.end());
  }
  cloud.samples = static_cast<int>(cloud.points_C.size());
  cloud.origins_C = {observation.views.front().X_CV.translation()};
  return cloud;
}

/// A value of the answer and its path, for error messages.
struct Place {
  const json& value;
  std::string path;

  [[noreturn]] void Fail(const std::string& what) const {
    std::string shown = value.dump(-1, ' ', true, json::error_handler_t::replace);
    if (shown.size() > kShown) shown = shown.substr(0, kShown) + "...";
    throw grasp::DetectorFailed(fmt::format("answer: {} is {}: {}", path, shown, what));
  }
  bool Has(const std::string& key) const { return value.contains(key); }
  Place At(const std::string& key) const {
    const auto found = value.find(key);
    if (found != value.end()) return {*found, path.empty() ? key : path + "." + key};
    throw grasp::DetectorFailed(
        fmt::format("answer: {}'{}' is missing", path.empty() ? std::string() : path + ": ", key));
  }
  Place At(std::size_t i) const { return {value[i], fmt::format("{}[{}]", path, i)}; }

  /// Visits the elements of a list. @param max_size  larger lists are refused
  template <typename Visit>
  void ForEach(std::size_t max_size, const Visit& visit) const {
    if (!value.is_array()) Fail("must be a list");
    if (value.size() > max_size) Fail(fmt::format("must not have more than {} elements", max_size));
    for (std::size_t i = 0; i < value.size(); ++i) visit(At(i));
  }
  /// @param hint  what the message about a number of more than `high`, of either sign, adds
  double Number(double low, double high, const char* hint = "") const {
    const double number = value.is_number() ? value.get<double>() : low - 1.0;
    if (number >= low && number <= high) return number;
    const bool large = value.is_number() && std::abs(number) > high;
    Fail(fmt::format("must be a number from {:g} to {:g}{}", low, high, large ? hint : ""));
  }
  std::size_t Index(std::size_t size, const char* what) const {
    if (value.is_number_unsigned() && value.get<std::uint64_t>() < size) return value;
    Fail(fmt::format("must be the position of {}, a whole number from 0 to below {}", what, size));
  }
  /// @param hint  as Number's
  Eigen::Vector3d Vector(const char* hint = "") const {
    if (!value.is_array() || value.size() != 3) Fail("must be three numbers, [x, y, z]");
    const auto element = [&](std::size_t i) { return At(i).Number(-kMax_m, kMax_m, hint); };
    return {element(0), element(1), element(2)};
  }
};

Eigen::Vector3d UnitOf(const Place& place) {
  const Eigen::Vector3d v = place.Vector();
  if (std::abs(v.norm() - 1.0) > kRotationError) place.Fail("must be of length 1");
  return v.normalized();
}

/// The rotation nearest to an approximate rotation matrix.
Eigen::Matrix3d RotationOf(const Place& place) {
  constexpr const char* kRight = "must be a rotation: three rows of three numbers";
  if (!place.value.is_array() || place.value.size() != 3) place.Fail(kRight);
  Eigen::Matrix3d R;
  for (std::size_t row = 0; row < 3; ++row) {
    R.row(static_cast<Eigen::Index>(row)) = place.At(row).Vector();
  }
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationError) {
    place.Fail(fmt::format("{}; R^T R differs from the identity by {:.3g}", kRight, error));
  }
  if (R.determinant() < 0.0) place.Fail("is a reflection (its determinant is -1), not a rotation");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

/// The sample at a position in the cloud, counted view by view; nullopt if it was not measured.
std::optional<geometry::SampleId> SampleAt(std::size_t position,
                                           const geometry::Observation& observation) {
  std::uint32_t view = 0;
  while (position >= observation.views[view].image.points_C.size()) {
    position -= observation.views[view++].image.points_C.size();
  }
  if (!observation.views[view].image.points_C[position].allFinite()) return std::nullopt;
  return geometry::SampleId{view, static_cast<std::uint32_t>(position)};
}

AnsweredObject ObjectOf(const Place& place, std::size_t size,
                        const geometry::Observation& observation) {
  if (!place.value.is_object()) place.Fail("must be {\"samples\": [...]}");
  std::set<std::size_t> positions;
  place.At("samples").ForEach(
      size, [&](const Place& one) { positions.insert(one.Index(size, "a sample")); });
  AnsweredObject object;
  for (const std::size_t position : positions) {
    if (const auto sample = SampleAt(position, observation)) object.samples.push_back(*sample);
  }
  if (place.Has("surface") && !place.value["surface"].is_null()) {
    const Place surface = place.At("surface");
    if (!surface.value.is_string()) surface.Fail("must be the name of a file");
    object.surface = surface.value.get<std::string>();
  }
  return object;
}

AnsweredGrasp GraspOf(const Place& place, const decltype(Answer::objects)& objects) {
  if (!place.value.is_object()) {
    place.Fail("must be {\"position_m\": ..., \"rotation\": ..., \"width_m\": ..., ...}");
  }
  AnsweredGrasp grasp;
  if (objects && place.Has("object")) {
    grasp.object = place.At("object").Index(objects->size(), "an object in the answer");
  } else if (objects && objects->empty()) {
    place.Fail("belongs to no object, since objects is empty; omit objects if there are none");
  }
  grasp::Proposal& proposal = grasp.proposal;
  const Eigen::Matrix3d R_CG = RotationOf(place.At("rotation"));
  proposal.X_CG = base::MakePose(R_CG, place.At("position_m").Vector(kInMetres));
  proposal.width_m = place.At("width_m").Number(0.0, kMax_m, kInMetres);
  proposal.approach_C = place.Has("approach") ? UnitOf(place.At("approach")) : R_CG.col(2);
  if (place.Has("score")) proposal.score = place.At("score").Number(-kMaxScore, kMaxScore);
  return grasp;
}

/// Why a line is not JSON. The common mistakes of programs that are otherwise right come first.
std::string WhyNoJson(const std::string& line, const json::parse_error& e) {
  const std::size_t at = std::max<std::size_t>(e.byte, 1) - 1;  // of the first wrong character
  for (const char* word : {"NaN", "Infinity"}) {
    if (at >= line.size() || !line.substr(at).starts_with(word)) continue;
    const std::size_t from = at - std::min(at, kShown / 2);
    return fmt::format("answer: {} is not JSON; it is at the end of: {}{}", word,
                       line.substr(from, at - from), word);
  }
  if (at >= line.size() && line.starts_with('{')) {
    return fmt::format("answer: not JSON: it must be one line, but its first line ends early: {}",
                       line.substr(0, kShown));
  }
  return fmt::format(
      "answer: not JSON ({}); it begins with: {} (print nothing else on stdout; messages for "
      "people go to stderr)",
      e.what(), line.substr(0, kShown));
}

json ParseLine(const std::string& line) {
  const auto shallow = [](int depth, json::parse_event_t, const json&) {
    if (depth <= kMaxDepth) return true;
    throw grasp::DetectorFailed(fmt::format("answer: nested more than {} deep", kMaxDepth));
  };
  try {
    return json::parse(line, shallow);
  } catch (const json::parse_error& e) {
    throw grasp::DetectorFailed(WhyNoJson(line, e));
  } catch (const json::exception& e) {  // e.g. a number beyond the range of a double
    throw grasp::DetectorFailed(fmt::format("answer: not JSON ({})", e.what()));
  }
}

}  // namespace

std::string WriteFiles(const Question& question, const std::filesystem::path& folder) {
  geometry::WriteCloud(folder / kCloudFile, WholeCloud(question.observation));
  geometry::WriteStl(folder / kHandFile, OpenHand(question.robot.hand()));
  auto views = ordered_json::array();
  auto images = ordered_json::array();
  for (const auto& view : question.observation.views) {
    views.push_back({{"X_WV", JsonOf(view.X_CV)},
                     {"rows", view.image.profiles},
                     {"columns", view.image.samples}});
    const std::string stem = fmt::format("view{}", views.size());
    if (const auto written = geometry::WriteImages(view, folder, stem)) {
      images.push_back(written->Described<ordered_json>());
      images.back()["view"] = views.size() - 1;
    }
  }
  const robot::Robot& robot = question.robot;
  const robot::HandModel& hand = robot.hand();
  const ordered_json message = {
      {"observation", kCloudFile},
      {"views", views},
      {"noise_m", question.noise_m},
      {"workspace",
       {{"center_m", JsonOf(robot.X_WWorkspace.translation())},
        {"up", JsonOf(Eigen::Vector3d(robot.X_WWorkspace.linear().col(2)))},
        {"radius_m", robot.workspace_radius_m},
        {"margin_m", question.margin_m}}},
      {"hand",
       {{"opening_m", hand.MaxGap()},
        {"depth_m", hand.depth_m},
        {"mesh", kHandFile},
        {"tcp", JsonOf(hand.X_HG_tip)}}},
      {"arm", {{"base_m", JsonOf(robot.links().front().X_PB.translation())}}},
      {"images", images},
      {"seed", question.seed}};
  return message.dump();
}

Answer ParseAnswer(const std::string& line, const geometry::Observation& observation) {
  const json parsed = ParseLine(line);
  const Place whole{parsed, ""};
  if (!parsed.is_object()) {
    throw grasp::DetectorFailed("answer: must be {\"objects\": [...], \"grasps\": [...]}");
  }
  std::size_t size = 0;
  for (const auto& view : observation.views) size += view.image.points_C.size();
  Answer answer;
  if (whole.Has("objects") && !parsed["objects"].is_null()) {
    auto& objects = answer.objects.emplace();
    whole.At("objects").ForEach(kMaxObjects, [&](const Place& one) {
      objects.push_back(ObjectOf(one, size, observation));
    });
  }
  whole.At("grasps").ForEach(
      kMaxGrasps, [&](const Place& one) { answer.grasps.push_back(GraspOf(one, answer.objects)); });
  std::ranges::stable_sort(answer.grasps, std::ranges::greater(),
                           [](const AnsweredGrasp& grasp) { return grasp.proposal.score; });
  return answer;
}

}  // namespace rangegrasp::external::internal
