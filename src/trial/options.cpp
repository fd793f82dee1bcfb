#include "trial/options.h"

#include <fmt/format.h>

#include "base/read_additions.h"
#include "grasp/read_options.h"
#include "perception/read_options.h"
#include "sim/read_options.h"
#include "trial/objects.h"
#include "trial/registry.h"

namespace rangegrasp::trial {
namespace {

using base::kDeg;
using base::kMm;
using base::YamlMap;

template <typename Switches>
void AddKeys(const std::string& prefix, std::vector<AdditionKey>& keys) {
  for (const auto& row : base::AdditionsTable<Switches>()) {
    keys.push_back({prefix + std::string(row.key), std::string(row.doc)});
  }
}

// A word, or a map whose keys a detector of its own reads.
void ReadDetector(YamlMap& map, Options& o) {
  o.detector = kDissertation;
  const DetectorKind* with_keys = FindDetector(kDetectorWithKeys);
  const bool holds_keys = map.HoldsMap("detector");
  if (with_keys && (holds_keys || !map.Has("detector"))) {
    with_keys->read(map.Child("detector"), o);
  } else if (holds_keys) {
    map.Child("detector").Finish();  // names the system that knows its keys
  }
  if (holds_keys) {
    o.detector = kDetectorWithKeys;
    return;
  }
  map.Read("detector", o.detector, {kDissertation},
           "what finds objects and grasps: a word, or a map with the keys below");
}

}  // namespace

void SetMethod(MethodKind method, Options& options) {
  const bool on = method == MethodKind::kImproved;
  base::SwitchAll<perception::PreprocessAdditions>(on, options.perception.preprocess);
  base::SwitchAll<perception::SegmentAdditions>(on, options.perception.segment);
  options.perception.segment.method =
      on ? perception::SegmentOptions().method : perception::SegmentMethod::kMesh;
  base::SwitchAll<perception::FeatureAdditions>(on, options.perception.features);
  base::SwitchAll<grasp::GraspAdditions>(on, options.grasp);
  options.firm_from_rad = on ? Options().firm_from_rad : base::Deg(90.0);
  options.max_approaches = on ? Options().max_approaches : 1;
  options.method = method;
}

std::vector<AdditionKey> AdditionKeys() {
  std::vector<AdditionKey> keys;
  AddKeys<perception::PreprocessAdditions>("perception.", keys);
  AddKeys<perception::SegmentAdditions>("perception.", keys);
  AddKeys<perception::FeatureAdditions>("perception.", keys);
  AddKeys<grasp::GraspAdditions>("grasp.", keys);
  return keys;
}

Options ReadOptions(YamlMap& map) {
  Options o;
  for (const char* key : {"scene", "sensor", "objects"}) map.Require(key);
  map.ReadPath("scene", o.scene, "MJCF of table, arm, hand, scanner");
  o.arranger = "single";
  map.Read("arrangement", o.arranger, ArrangerWords(), "how the objects of a trial lie");
  map.ReadPath("sensor", o.sensor, "file of the sensor: a line scanner, a stereo camera, or both");
  o.sensor_type = ReadSensorType(o.sensor);
  ReadDetector(map, o);
  map.Read("method", o.method,
           "all switches below that go beyond the dissertation at once: on or off");
  SetMethod(o.method, o);
  map.ReadPath("reference", o.reference, "published table, printed beside the own one");
  o.object_folders = ReadObjectFolders(map);
  map.Read("objects", o.objects, "one row of the table each");
  map.Read("trials_per_object", o.trials_per_object, 1, 100000, "trials of each object");
  map.Read("max_plans", o.max_plans, 1, 200,
           "grasps offered to the mover before the trial is given up");
  map.Read("max_approaches", o.max_approaches, 1, 20,
           "a hand that meets something early comes down elsewhere, so often at most");
  map.ReadScaled("early_mm", o.early_m, kMm, 1.0, 100.0,
                 "it meets something early with more than this left of the approach");
  map.ReadScaled("workspace_margin_mm", o.workspace_margin_m, kMm, 50.0, 1000.0,
                 "points further outside the workspace are not perceived");
  map.ReadScaled("min_tipping_deg", o.min_tipping_rad, kDeg, 0.0, 45.0,
                 "resting poses that tip over at a smaller tilt are left out");
  map.Read("as_drawn", o.as_drawn, "objects stand as their models are drawn, z up");
  ReadClutterOptions(
      map.Child("clutter", "how objects come to lie: scattered, touching, box, pile"), o.clutter);
  map.Read("color", o.color,
           "the sensors see colors, too, which tell known objects apart: line scanners as if their "
           "files said so, of stereo the left picture's");
  sim::ReadPhysicsOptions(map.Child("physics", "the simulation"), o.physics);
  sim::ReadHandOptions(map.Child("hand", "the hand's controller"), o.firm_from_rad, o.hand);
  // A stereo pair's errors are the same over a window of many samples.
  o.perception.stated_noise = FindSensor(o.sensor_type)->states_noise;
  perception::ReadOptions(map.Child("perception", "from the cloud to objects"), o.perception);
  grasp::ReadGraspOptions(map.Child("grasp", "from objects to grasps"), o);
  const bool any_way = o.grasp.approach == grasp::ApproachKind::kAbove;
  if ((o.take != grasp::kAnywhere || !any_way) && o.detector != kDissertation) {
    map.Fail("grasp", "take, approach: a detector that is another program decides that itself");
  }
  if (o.take != grasp::kAnywhere && !any_way) {
    map.Fail("grasp", "approach: `take: " + o.take + "` says where the hand comes from");
  }
  grasp::ReadPlanningOptions(map.Child("planning", "from a grasp to motions"), o.planning,
                             o.obstacles);
  for (const auto& read_keys : KeyReaders()) read_keys(map, o);
  map.Finish();
  return o;
}

}  // namespace rangegrasp::trial
