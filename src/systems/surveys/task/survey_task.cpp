#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/words.h"
#include "experiment/experiment.h"
#include "stereo/sensing/stereo_sensor.h"
#include "surveys/separation.h"
#include "surveys/task/measures.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"

namespace rangegrasp::surveys {
namespace {

using experiment::Case;
using nlohmann::ordered_json;

enum class Quantity { kSeparation, kRotation, kReconstruction };
constexpr std::array<std::string_view, 3> WordsOf(Quantity) {
  return {"separation", "rotation", "reconstruction"};
}

/// Functions of each quantity, in the order of Quantity.
struct Survey {
  ordered_json (*measure)(const trial::Cell&, const trial::Arrangement&, std::uint64_t, Seconds&);
  experiment::Section (*table)(const std::vector<Measured>&);
};
constexpr std::array<Survey, 3> kSurveys = {{{MeasureSeparation, SeparationTable},
                                             {MeasureRotation, RotationTable},
                                             {MeasureReconstruction, ReconstructionTable}}};
const Survey& SurveyOf(Quantity quantity) { return kSurveys[static_cast<std::size_t>(quantity)]; }

/// Key of Stamp::data.
constexpr const char* kMeasure = "measure";
constexpr const char* kMeasured = "measured";  ///< the outcome
constexpr const char* kTrialsPerObject = "trials_per_object";

std::pair<Quantity, std::filesystem::path> ReadMeasure(base::YamlMap& map) {
  Quantity quantity{};
  std::filesystem::path clouds;
  map.Read(kMeasure, quantity,
           "separation of touching objects, detection of rotational objects, or reconstruction by "
           "a stereo camera");
  map.ReadPath("clouds", clouds,
               "separation: folder of recorded PCD clouds in the camera's frame (z forwards), "
               "metres, with a field `label` (0 nothing measured, 1 to 9 table, objects from 20), "
               "instead of simulated scenes");
  return {quantity, clouds};
}

/// A case is the scan of a trial; the arm does not move.
class SurveyTask : public trial::SceneTask {
 public:
  SurveyTask(trial::Options options, Quantity quantity, std::uint64_t seed)
      : cell_(std::move(options)), quantity_(quantity), seed_(seed) {}

  std::vector<Case> Cases() const override { return trial::TrialsOf(cell_.options, seed_); }

  void Prepare() const override { cell_.sensor->Prepare(); }

  experiment::Result Run(const Case& which) const override {
    trial::Redraws redraws;
    const auto scene = Arrange(which, redraws);
    if (!scene) return trial::NoArrangement(redraws);
    experiment::Result result{kMeasured, "perceive", "", "{}", {}};
    result.data = SurveyOf(quantity_).measure(cell_, *scene, which.seed, result.seconds).dump();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    trial::AddModelsTo(cell_.options, stamp);
    stamp.data[kMeasure] = base::Word(quantity_);
  }

  const trial::Cell& cell() const override { return cell_; }

 private:
  trial::Cell cell_;
  Quantity quantity_;
  std::uint64_t seed_;
};

/// A recorded cloud of a depth camera. Without objects, any segmentation would count as right.
geometry::CloudFile ReadLabelled(const std::filesystem::path& file) {
  geometry::CloudFile cloud = geometry::ReadCloud(file);
  const auto refuse = [&file](const std::string& why) {
    throw base::InputError(file.string() + ": " + why);
  };
  if (cloud.labels.empty()) refuse("has no field `label`");
  if (std::ranges::none_of(cloud.labels, [](auto label) { return label >= kFirstObject; })) {
    refuse(fmt::format("no point has a label of {} or more (objects)", kFirstObject));
  }
  const double origin_z_m = cloud.sensor_origin.value_or(Eigen::Vector3d::Zero()).z();
  for (const Eigen::Vector3d& p : cloud.points) {
    if (!p.allFinite() || p.z() > origin_z_m) continue;
    refuse(
        fmt::format("is not in the camera's frame (z must be positive): a point has z {:.3g} m, "
                    "the camera {:g}",
                    p.z(), origin_z_m));
  }
  return cloud;
}

/// A case is a recorded cloud; its group is the file's name.
class CloudSurvey : public experiment::Task {
 public:
  CloudSurvey(const std::filesystem::path& folder, perception::PerceptionOptions options)
      : options_(std::move(options)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".pcd") files_.push_back(entry.path());
    }
    std::ranges::sort(files_);
    if (files_.empty()) throw base::InputError(folder.string() + ": contains no *.pcd");
    // A wrong one is refused before the first case.
    for (const auto& file : files_) ReadLabelled(file);
  }

  std::vector<Case> Cases() const override {
    std::vector<Case> cases;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const std::string name = files_[i].stem().string();
      cases.push_back({name, name, 0, {{"cloud", static_cast<std::int64_t>(i)}}});
    }
    return cases;
  }

  experiment::Result Run(const Case& which) const override {
    const auto& file = files_.at(static_cast<std::size_t>(which.params.Int("cloud")));
    const auto cloud = ReadLabelled(file);
    experiment::Result result{kMeasured, "perceive", "", "{}", {}};
    result.data = MeasureSeparation(cloud, options_, result.seconds).dump();
    return result;
  }

  void AddTo(experiment::Stamp& stamp) const override {
    stamp.data[kMeasure] = base::Word(Quantity::kSeparation);
    std::uint64_t hash = 0;
    for (const auto& file : files_) hash = base::Fnv1a(base::ReadFile(file), hash);
    stamp.identity["clouds_hash"] = base::Hex(hash);
  }

 private:
  std::vector<std::filesystem::path> files_;
  perception::PerceptionOptions options_;
};

std::unique_ptr<experiment::Task> Read(base::YamlMap& map, const experiment::Common& common) {
  const auto [quantity, clouds] = ReadMeasure(map);
  map.Require(kMeasure);
  if (!clouds.empty()) {
    if (quantity != Quantity::kSeparation) map.Fail("clouds", "only for `measure: separation`");
    if (map.Has(kTrialsPerObject)) {
      map.Fail(kTrialsPerObject, "--trials: not with `clouds`, each of which is one case");
    }
    perception::PerceptionOptions options;
    perception::ReadOptions(map.Child("perception", ""), options);
    map.Finish();
    return std::make_unique<CloudSurvey>(clouds, std::move(options));
  }
  trial::Options options = trial::ReadOptions(map, common.seed);
  if (quantity == Quantity::kReconstruction && options.sensor_type != stereo::kStereoCamera) {
    map.Fail(kMeasure,
             "reconstruction needs a stereo camera as `sensor`, not a " + options.sensor_type);
  }
  if (!trial::ModelsPass(map, options, common)) return nullptr;
  trial::RequireOwnDetector(map, options);
  return std::make_unique<SurveyTask>(std::move(options), quantity, common.seed);
}

experiment::Report ReportOf(const experiment::Stamp& stamp,
                            const std::vector<experiment::Record>& records) {
  std::vector<Measured> scans;
  std::map<std::string, int> failed;
  for (const auto& record : records) {
    if (record.result.outcome == kMeasured) {
      scans.push_back({&record, ordered_json::parse(record.result.data)});
    } else {
      ++failed[record.result.outcome];
    }
  }
  const auto quantity = base::FromWord<Quantity>(experiment::Need(stamp.data, kMeasure), kMeasure);
  experiment::Report report;
  report.sections.push_back(SurveyOf(quantity).table(scans));
  report.csv = report.sections.front().grid;
  if (!failed.empty()) {
    report.notes.push_back("scenes without a scan: " + experiment::CountsText(failed));
  }
  return report;
}

}  // namespace
}  // namespace rangegrasp::surveys

namespace rangegrasp {

void RegisterSurveys() {
  experiment::AddKind(
      {.name = "survey",
       .description = "Surveys of perception: scenes are arranged and scanned, the arm does not "
                      "move. Besides the keys below it has all keys of `task: grasping`.",
       .trials_key = surveys::kTrialsPerObject,
       .uses_seed = true,
       .success = {},
       .read = surveys::Read,
       .read_keys = [](base::YamlMap& map) { surveys::ReadMeasure(map); },
       .report = surveys::ReportOf});
}

}  // namespace rangegrasp
