#include "report/data_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "base/words.h"
#include "experiment/grid.h"
#include "geometry/cloud_file.h"
#include "trial/cloud_fields.h"
#include "trial/judge.h"
#include "trial/table.h"

namespace rangegrasp::report {
namespace {

using trial::Arrangement;
using trial::Attempt;
using trial::AttemptOptions;
using trial::Cell;
using trial::Outcome;
using trial::Sensed;
using trial::TrialSpec;

using nlohmann::ordered_json;

ordered_json JsonOf(const base::Pose& X) {
  ordered_json numbers = ordered_json::array();
  const Eigen::Matrix4d& m = X.matrix();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) numbers.push_back(m(row, column));
  }
  return numbers;
}

ordered_json WriteClouds(const Sensed& sensed, const std::string& id,
                         const std::filesystem::path& folder) {
  ordered_json clouds = ordered_json::array();
  for (std::size_t i = 0; i < sensed.observation.views.size(); ++i) {
    const geometry::View& view = sensed.observation.views[i];
    const std::string file =
        i == 0 ? fmt::format("clouds/{}.pcd", id) : fmt::format("clouds/{}_view{}.pcd", id, i + 1);
    geometry::WriteCloud(folder / file, view.image, trial::TruthFields(view, sensed.truth[i]));
    const auto& states = sensed.truth[i].state;
    clouds.push_back(
        {{"file_name", file},
         {"rows", view.image.profiles},
         {"columns", view.image.samples},
         {"X_WV", JsonOf(view.X_CV)},
         {"spacing_m", view.spacing_m},
         {"measured", std::count(states.begin(), states.end(), sensing::SampleState::kMeasured)}});
  }
  return clouds;
}

ordered_json ObjectsOf(const Arrangement& arranged) {
  ordered_json objects = ordered_json::array();
  const sim::World& world = arranged.world;
  for (int i = 0; i < world.objects(); ++i) {
    if (world.parked(i)) continue;
    objects.push_back({{"name", world.object_name(i)},
                       {"label", i + 1},
                       {"target", i == arranged.target},
                       {"surface", world.object_surface(i)},
                       {"mass_kg", world.ObjectMass(i)},
                       {"X_WO", JsonOf(world.ObjectPose(i))}});
  }
  return objects;
}

// The label that most samples of a perceived object bear; 0: the scene's.
int LabelOf(const grasp::DetectedObject& object, const Sensed& sensed) {
  const auto votes = trial::ObjectVotes(object.samples, sensed);
  const auto most = std::max_element(
      votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == votes.end() ? 0 : most->first + 1;
}

// Candidates that the hand did not try have no outcome.
ordered_json GraspsOf(const Attempt& attempt, const Sensed& sensed) {
  const grasp::Detection& detection = attempt.detected.detection;
  std::map<std::size_t, std::string> outcomes;
  for (const std::size_t tried : attempt.executed) outcomes[tried] = "withdrawn";
  if (!attempt.executed.empty()) {
    outcomes[attempt.executed.back()] = std::string(base::Word(attempt.outcome));
  }
  ordered_json grasps = ordered_json::array();
  for (std::size_t i = 0; i < detection.grasps.size(); ++i) {
    const grasp::DetectedGrasp& g = detection.grasps[i];
    const auto outcome = outcomes.find(i);
    grasps.push_back(
        {{"label", LabelOf(detection.objects.at(g.object), sensed)},
         {"type", base::Word(g.type)},
         {"X_WH", JsonOf(g.X_CH)},
         {"opening_m", g.opening_m},
         {"width_m", g.width_m},
         {"pitch_rad", g.pitch_rad},
         {"contact_angle_rad", g.contact_angle_rad},
         {"score", g.score},
         {"collides", g.collides},
         {"outcome", outcome == outcomes.end() ? ordered_json() : ordered_json(outcome->second)}});
  }
  return grasps;
}

// COCO's ids: positions in the list, over all clouds of a data set.
class Annotations {
 public:
  explicit Annotations(const experiment::Stamp& stamp) {
    json_["info"] = {{"description", "trials of " + experiment::Need(stamp.identity, "experiment")},
                     {"stamp", experiment::LineOf(stamp)},
                     {"units", "metres, radians, kilograms"},
                     {"frame", "W: origin on the table top at the middle of the workspace, z up"},
                     {"poses", "4 x 4, row by row; X_WO takes points of O to W"}};
    for (const auto& [name, value] : stamp.data) {
      const std::string prefix = experiment::kTitlePrefix;
      if (name.starts_with(prefix)) titles_[name.substr(prefix.size())] = value;
    }
    for (const char* list : {"categories", "clouds", "annotations", "grasps"}) {
      json_[list] = ordered_json::array();
    }
  }

  void Add(const experiment::Record& record) {
    auto data = ordered_json::parse(record.result.data);
    const std::size_t first_cloud = json_["clouds"].size();
    for (auto& cloud : data["clouds"]) {
      cloud["case"] = record.which.id;
      cloud["outcome"] = record.result.outcome;
      Append("clouds", cloud);
    }
    std::map<int, std::size_t> annotation_of;
    for (auto& object : data["objects"]) {
      object["cloud_id"] = first_cloud;
      object["category_id"] = CategoryOf(object["name"]);
      annotation_of[object["label"]] = Append("annotations", object);
    }
    for (auto& grasp : data["grasps"]) {
      grasp["cloud_id"] = first_cloud;
      const auto found = annotation_of.find(grasp["label"]);
      grasp["annotation_id"] =
          found == annotation_of.end() ? ordered_json() : ordered_json(found->second);
      grasp.erase("label");
      Append("grasps", grasp);
    }
  }

  std::string Text() const { return json_.dump(1) + "\n"; }

 private:
  std::size_t Append(const char* list, const ordered_json& item) {
    const std::size_t id = json_[list].size();
    ordered_json with_id = {{"id", id}};
    with_id.update(item);
    json_[list].push_back(std::move(with_id));
    return id;
  }
  std::size_t CategoryOf(const std::string& name) {
    const auto [found, fresh] = categories_.try_emplace(name, categories_.size());
    if (fresh) {
      const auto title = titles_.find(name);
      Append("categories",
             {{"name", name}, {"title", title == titles_.end() ? name : title->second}});
    }
    return found->second;
  }

  ordered_json json_;
  std::map<std::string, std::string> titles_;
  std::map<std::string, std::size_t> categories_;
};

}  // namespace

experiment::Result ExportTrial(const Cell& cell, const TrialSpec& spec,
                               const std::filesystem::path& folder) {
  auto arranged = trial::ArrangeTrial(cell, spec);
  if (!arranged) {
    return {std::string(base::Word(Outcome::kCrashed)), "arrange", "no arrangement", "{}", {}};
  }
  ordered_json data = {{"clouds", {}}, {"objects", ObjectsOf(*arranged)}};
  Sensed sensed;
  AttemptOptions options;
  options.seed = spec.seed;
  options.target = arranged->target;
  options.on_sensed = [&](const Sensed& all) {
    sensed = all;
    data["clouds"] = WriteClouds(sensed, trial::TrialId(spec), folder);
  };
  const Attempt attempt = trial::RunAttempt(cell, arranged->world, options);
  data["grasps"] = GraspsOf(attempt, sensed);
  return {std::string(base::Word(attempt.outcome)), attempt.stage, attempt.detail, data.dump(), {}};
}

std::string AnnotationsOf(const experiment::Stamp& stamp,
                          const std::vector<experiment::Record>& exported) {
  Annotations annotations(stamp);
  for (const experiment::Record& record : exported) {
    if (record.result.data != "{}") annotations.Add(record);
  }
  return annotations.Text();
}

}  // namespace rangegrasp::report
