#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/installation.h"
#include "base/units.h"
#include "base/words.h"
#include "experiment/experiment.h"
#include "external/outside_detector.h"
#include "grasp/features.h"
#include "python/values.h"
#include "sim/render.h"
#include "trial/cell.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::python {
namespace {

using nlohmann::json;

experiment::Experiment Open(const std::string& file, const std::vector<std::string>& set,
                            std::uint64_t seed) {
  auto e = experiment::OpenExperiment(base::FindExperiment(file), {.set = set, .seed = seed});
  trial::CellOf(*e.task);  // throws for another task
  return e;
}

constexpr int kMaxSide_px = 8192;  // of a picture, as of `rangegrasp snapshot`

// A grasp given by Python.
struct Asked {
  base::Pose X_WG;
  double width_m = 0.0;
  Eigen::Vector3d approach_W;
  std::vector<std::int64_t> samples;  // of its object; empty: the samples between the fingers
};

std::string AnswerOf(const Asked& asked) {
  const auto list = [](const Eigen::Vector3d& v) { return json{v.x(), v.y(), v.z()}; };
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) rotation.push_back(list(asked.X_WG.linear().row(row)));
  json answer = {{"grasps",
                  {{{"position_m", list(asked.X_WG.translation())},
                    {"rotation", rotation},
                    {"width_m", asked.width_m},
                    {"approach", list(asked.approach_W)}}}}};
  if (!asked.samples.empty()) answer["objects"] = {{{"samples", asked.samples}}};
  return answer.dump();
}

// Objects that are pushed, tip over or roll go further to the side. Shipped ones that are put down
// in a resting pose, also from 80 mm above it, settle within 0.01 mm.
constexpr double kMaxShift_m = 0.01;

// A line for each pair of objects that are placed into each other.
std::vector<std::string> OverlapsIn(const sim::World& world) {
  std::vector<std::string> lines;
  for (int a = 0; a < world.objects(); ++a) {
    for (int b = a + 1; b < world.objects(); ++b) {
      if (world.ObjectDistance(a, b, 0.0) >= -trial::kMaxPenetration_m) continue;
      lines.push_back(fmt::format("{} and {} overlap at the given poses", world.object_name(a),
                                  world.object_name(b)));
    }
  }
  return lines;
}

// A line for each settled object that is not where it was placed, or where no grasp is looked for.
std::vector<std::string> MisplacedIn(const sim::World& world, const std::vector<base::Pose>& given,
                                     const perception::Workspace& workspace) {
  std::vector<std::string> lines;
  for (int i = 0; i < world.objects(); ++i) {
    const Eigen::Vector3d at_W = world.ObjectPose(i).translation();
    const double shift_m =
        (at_W - given[static_cast<std::size_t>(i)].translation()).head<2>().norm();
    if (!workspace.Contains(world.ObjectCenterOfMass(i))) {
      lines.push_back(
          fmt::format("{} has settled outside the workspace, at x, y = {:.2f}, {:.2f} m",
                      world.object_name(i), at_W.x(), at_W.y()));
    } else if (shift_m > kMaxShift_m) {
      lines.push_back(fmt::format("{} has settled {:.0f} mm to the side of the given pose",
                                  world.object_name(i), shift_m * base::kMmPerM));
    }
  }
  return lines;
}

/// A settled world with its work cell, between two scans or attempts.
class Scene {
 public:
  // Makes the arrangement of an experiment's trial.
  Scene(const std::string& file, const std::vector<std::string>& set, std::uint64_t seed,
        const std::string& target, int index)
      : experiment_(Open(file, set, seed)), cell_(trial::CellOf(*experiment_.task)) {
    trial::TrialSpec spec = trial::SpecOf(experiment_.cases.front());
    if (!target.empty()) {
      const auto& names = cell_.options.objects;
      if (std::ranges::find(names, target) == names.end()) {
        throw base::InputError(fmt::format("target '{}' is not among the experiment's objects {}{}",
                                           target, base::Join(names),
                                           base::Suggestion(target, names)));
      }
      spec.object = target;
    }
    spec.index = index;
    spec.seed = trial::TrialSeed(seed, spec.object, index);
    seed_ = spec.seed;
    const nb::gil_scoped_release others_may_run;
    cell_.sensor->Prepare();
    trial::Redraws redraws;
    auto arranged = trial::ArrangeTrial(cell_, spec, redraws);
    if (!arranged) {
      throw base::RunError(fmt::format("no arrangement of {} came to rest in view: {}", spec.object,
                                       trial::Text(redraws)));
    }
    world_ = std::make_unique<sim::World>(std::move(arranged->world));
    target_ = arranged->target;
  }

  // Places objects at the given poses and lets them settle.
  Scene(const std::string& file, const std::vector<std::string>& set, std::uint64_t seed,
        const std::vector<std::pair<std::string, Matrix4>>& objects)
      : experiment_(Open(file, set, seed)), cell_(trial::CellOf(*experiment_.task)), seed_(seed) {
    std::vector<sim::ObjectModel> models;
    std::vector<base::Pose> poses;
    for (const auto& [name, X_WO] : objects) {
      const auto missing = trial::MissingObject({name}, cell_.options);
      if (!missing.empty()) throw base::InputError(missing);
      models.push_back(trial::ObjectModelOf(cell_.options, name));
      poses.push_back(PoseFrom(X_WO, ("pose of " + name).c_str()));
    }
    const nb::gil_scoped_release others_may_run;
    cell_.sensor->Prepare();
    world_ = std::make_unique<sim::World>(cell_.options.scene, models, cell_.options.physics);
    world_->SetArm(cell_.robot.home);
    for (int i = 0; i < world_->objects(); ++i) {
      world_->PlaceObject(i, poses[static_cast<std::size_t>(i)]);
    }
    base::Rng friction = trial::StageStream(seed, "friction");
    world_->DrawFriction(friction);
    warnings_ = OverlapsIn(*world_);
    world_->Settle();
    std::ranges::move(
        MisplacedIn(*world_, poses,
                    grasp::WorkspaceOf(cell_.robot, cell_.options.workspace_margin_m)),
        std::back_inserter(warnings_));
  }

  nb::dict Scan(std::uint64_t seed) {
    // As a trial of this seed gives them to a detector.
    base::Rng rng = trial::StageStream(seed, "perceive");
    const std::uint64_t detectors_seed = external::DrawSeed(rng);
    {
      const nb::gil_scoped_release others_may_run;
      Home();
      found_.reset();
      sensed_ = std::make_shared<trial::Sensed>(trial::Look(cell_, *world_, seed));
      noise_m_ = MeasureNoise(rng);
    }
    nb::dict scan = DictOf(sensed_->observation);
    scan["seed"] = detectors_seed;
    scan["noise_m"] = noise_m_;
    AddWorkspace(cell_.robot, cell_.options.workspace_margin_m, scan);
    return scan;
  }

  // Perceives in the same way as a trial.
  // @param with_features  adds the features of each grasp, for the dissertation's method
  nb::dict Perceive(std::uint64_t seed, bool with_features) {
    LookOnce();
    std::vector<double> features;
    {
      const nb::gil_scoped_release others_may_run;
      base::Rng rng = trial::StageStream(seed, "perceive");
      const auto describe = [&](const perception::Scene& scene,
                                const std::vector<grasp::Grasp>& grasps,
                                const geometry::Observation& observation) {
        if (scene.objects.empty()) return;
        for (const auto& of_grasp :
             grasp::FeaturesOf(observation, scene, 0, cell_.robot.hand(), grasps)) {
          std::ranges::copy(of_grasp, std::back_inserter(features));
        }
      };
      const auto describing =
          with_features ? trial::MakeDetector(cell_.options, cell_.robot, describe) : nullptr;
      const grasp::Detector& detector = describing ? *describing : *cell_.detector;
      found_ = std::make_shared<const grasp::Detected>(detector.Detect(sensed_->observation, rng));
    }
    const grasp::Detected& detected = *found_;
    nb::list objects, grasps;
    for (const auto& object : detected.detection.objects) {
      geometry::Points points;
      for (const auto& id : object.samples) {
        points.push_back(sensed_->observation.views[id.view].image.points_C[id.sample]);
      }
      objects.append(DictOf(object, points, sensed_->observation));
    }
    for (const auto& grasp : detected.detection.grasps) {
      grasps.append(DictOf(grasp, cell_.robot.hand()));
    }
    nb::dict found;
    found["table_normal"] = ArrayOf(detected.detection.table_C.normal);
    found["table_offset"] = detected.detection.table_C.offset_m;
    found["noise"] = noise_m_;
    const std::size_t names = grasp::FeatureNames().size();
    found["features"] = with_features
                            ? nb::cast(Copied(features.data(), {features.size() / names, names}))
                            : nb::none();
    found["objects"] = objects;
    found["grasps"] = grasps;
    return found;
  }

  nb::tuple Grasp(const Matrix4& X_WG, double width_m, const Vector3& approach_W,
                  const std::vector<std::int64_t>& samples, std::uint64_t seed) {
    const Asked asked{PoseFrom(X_WG, "X_WG"), width_m,
                      Eigen::Map<const Eigen::Vector3d>(approach_W.data()), samples};
    LookOnce();
    CheckSamples(asked);
    trial::Attempt attempt;
    {
      const nb::gil_scoped_release others_may_run;
      Home();
      const auto detector = DetectorOf(asked);
      attempt = trial::RunAttempt(
          cell_, *world_, {.seed = seed, .sensed = sensed_.get(), .detector = detector.get()});
    }
    if (attempt.log) Forget();
    nlohmann::ordered_json data = trial::JsonOf(attempt);
    data["target"] = nullptr;
    if (attempt.target) data["target"] = world_->object_name(*attempt.target);
    return nb::make_tuple(std::string(base::Word(attempt.outcome)), attempt.stage, attempt.detail,
                          ObjectOf(data));
  }

  nb::object Render(const std::string& camera, int width, int height) {
    if (std::min(width, height) < 1 || std::max(width, height) > kMaxSide_px) {
      throw base::InputError(fmt::format("width and height must be 1 to {} pixels, not {} and {}",
                                         kMaxSide_px, width, height));
    }
    image::Image image;
    {
      const nb::gil_scoped_release others_may_run;
      image = sim::Renderer(*world_, width, height).Render(*world_, camera);
    }
    return nb::cast(Copied(image.rgb.data(), {static_cast<std::size_t>(image.height),
                                              static_cast<std::size_t>(image.width), 3}));
  }

  // Removes the objects at the delivery place. @return their names
  std::vector<std::string> TakeAway() {
    std::vector<std::string> taken;
    for (int i = 0; i < world_->objects(); ++i) {
      if (world_->parked(i) || !trial::IsAtDelivery(*world_, i)) continue;
      world_->ParkObject(i);
      taken.push_back(world_->object_name(i));
    }
    if (!taken.empty()) Forget();
    return taken;
  }

  nb::dict Truth() const {
    nb::list objects;
    for (int i = 0; i < world_->objects(); ++i) {
      if (world_->parked(i)) continue;
      nb::dict dict;
      dict["name"] = world_->object_name(i);
      dict["label"] = i + 1;
      dict["pose"] = ArrayOf(world_->ObjectPose(i));
      dict["center_of_mass"] = ArrayOf(world_->ObjectCenterOfMass(i));
      dict["delivered"] = trial::IsAtDelivery(*world_, i);
      objects.append(dict);
    }
    nb::list labels;
    if (sensed_) {
      for (std::size_t i = 0; i < sensed_->truth.size(); ++i) {
        const auto& image = sensed_->observation.views[i].image;
        labels.append(Copied(
            sensed_->truth[i].label.data(),
            {static_cast<std::size_t>(image.profiles), static_cast<std::size_t>(image.samples)}));
      }
    }
    nb::dict truth;
    truth["objects"] = objects;
    truth["target"] = target_ ? nb::cast(world_->object_name(*target_)) : nb::none();
    truth["labels"] = labels;
    return truth;
  }

  struct Saved {
    std::shared_ptr<const sim::SavedWorld> world;
    std::shared_ptr<trial::Sensed> sensed;
    std::shared_ptr<const grasp::Detected> found;
    std::uint64_t of = 0;  // the scene's id
  };
  Saved Save() const { return {world_->Save(), sensed_, found_, id_}; }
  void Restore(const Saved& saved) {
    if (saved.of != id_) throw std::invalid_argument("the state is of another scene");
    world_->Restore(*saved.world);
    sensed_ = saved.sensed;
    found_ = saved.found;
  }

  std::uint64_t seed() const { return seed_; }
  // What makes the given poses doubtful.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void Home() {
    if (!world_->ArmPositions().isApprox(cell_.robot.home, 1e-12)) trial::GoHome(cell_, *world_);
  }
  // On the table of the last scan; 0 if no table is found.
  double MeasureNoise(base::Rng& rng) const {
    try {
      const auto& options = cell_.options;
      return perception::PerceiveTable(sensed_->observation, options.perception, rng,
                                       grasp::WorkspaceOf(cell_.robot, options.workspace_margin_m))
          .sampling.noise_m;
    } catch (const base::InputError&) {
      return 0.0;
    }
  }

  // A grasp that was perceived keeps its own samples, so nobody else reads these.
  void CheckSamples(const Asked& asked) const {
    std::size_t count = 0;
    for (const auto& view : sensed_->observation.views) count += view.image.points_C.size();
    for (const std::int64_t sample : asked.samples) {
      if (sample >= 0 && static_cast<std::size_t>(sample) < count) continue;
      throw base::InputError(fmt::format(
          "samples of the grasp: {} must be 0 to {}, a position among the samples of the scan",
          sample, count - 1));
    }
  }

  void LookOnce() {
    if (!sensed_) Scan(seed_);
  }
  // Discards the scan and the detection of an earlier state of the scene.
  void Forget() {
    sensed_.reset();
    found_.reset();
  }
  // A perceived grasp keeps all its data. Any other is checked like that of an external detector.
  std::unique_ptr<grasp::Detector> DetectorOf(const Asked& asked) const {
    const auto is_asked = [&](const grasp::DetectedGrasp& grasp) {
      return grasp.width_m == asked.width_m &&
             ProposedPose(grasp, cell_.robot.hand()).isApprox(asked.X_WG, 1e-9);
    };
    if (found_) {
      const auto& grasps = found_->detection.grasps;
      const auto chosen = std::ranges::find_if(grasps, is_asked);
      if (chosen != grasps.end()) {
        grasp::Detected only = *found_;
        only.detection.grasps = {*chosen};
        only.seconds.clear();
        return std::make_unique<trial::FixedDetector>(std::move(only));
      }
    }
    return external::MakeFunctionDetector(
        [&asked](const external::Question&) { return AnswerOf(asked); }, cell_.options,
        cell_.robot);
  }

  // No two scenes of a process share one: an address would be used again after a scene's end.
  static inline std::atomic<std::uint64_t> last_id_ = 0;

  std::uint64_t id_ = ++last_id_;
  experiment::Experiment experiment_;
  const trial::Cell& cell_;
  std::uint64_t seed_ = 0;
  double noise_m_ = 0.0;  // of the last scan
  std::vector<std::string> warnings_;
  std::unique_ptr<sim::World> world_;
  std::optional<int> target_;
  std::shared_ptr<trial::Sensed> sensed_;         // null after anything moved
  std::shared_ptr<const grasp::Detected> found_;  // detection in that scan
};

}  // namespace

void AddScene(nb::module_& m) {
  m.def("feature_names", [] {
    const auto names = grasp::FeatureNames();
    return std::vector<std::string>(names.begin(), names.end());
  });
  m.def(
      "objects",
      [](const std::string& file, const std::vector<std::string>& set) {
        return trial::CellOf(*Open(file, set, 1).task).options.objects;
      },
      nb::arg("experiment"), nb::arg("set"));
  nb::class_<Scene::Saved>(m, "SavedScene");
  nb::class_<Scene>(m, "Scene")
      .def(nb::init<const std::string&, const std::vector<std::string>&, std::uint64_t,
                    const std::string&, int>(),
           nb::arg("experiment"), nb::arg("set"), nb::arg("seed"), nb::arg("target"),
           nb::arg("index"))
      .def(nb::init<const std::string&, const std::vector<std::string>&, std::uint64_t,
                    const std::vector<std::pair<std::string, Matrix4>>&>(),
           nb::arg("experiment"), nb::arg("set"), nb::arg("seed"), nb::arg("objects"))
      .def("scan", &Scene::Scan, nb::arg("seed"))
      .def("perceive", &Scene::Perceive, nb::arg("seed"), nb::arg("features"))
      .def("grasp", &Scene::Grasp, nb::arg("X_WG"), nb::arg("width"), nb::arg("approach"),
           nb::arg("samples"), nb::arg("seed"))
      .def("render", &Scene::Render, nb::arg("camera"), nb::arg("width"), nb::arg("height"))
      .def("take_away", &Scene::TakeAway)
      .def("truth", &Scene::Truth)
      .def("save", &Scene::Save)
      .def("restore", &Scene::Restore, nb::arg("state"))
      .def_prop_ro("seed", &Scene::seed)
      .def_prop_ro("warnings", &Scene::warnings);
}

}  // namespace rangegrasp::python
