#include "external/outside_detector.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/process/program.h"
#include "base/stopwatch.h"
#include "external/internal/detector_message.h"
#include "geometry/kd_tree.h"
#include "geometry/mesh_file.h"
#include "grasp/obstacles.h"
#include "grasp/proposals.h"
#include "grasp/surface.h"
#include "perception/perceive.h"

namespace rangegrasp::external {
namespace {

namespace fs = std::filesystem;
using base::YamlMap;
using grasp::Detected;
using grasp::Detector;
using grasp::DetectorFailed;
using grasp::SceneObserver;
using grasp::Turn;
using internal::Answer;
using internal::AnsweredObject;
using perception::Scene;

// Why a command's first word, a name or a path, is not an executable program, and the cure.
std::string WhyNoProgram(const std::string& word, const fs::path& folder) {
  std::error_code ignored;  // for words that cannot be file names
  if (word.find('/') == std::string::npos && fs::exists(folder / word, ignored)) {
    return fmt::format("'{0}' would be a program on the PATH; give ./{0}", word);
  }
  if (fs::is_regular_file(word, ignored)) {
    return fmt::format(
        "{0} is not executable: run `chmod +x {0}`, or name its interpreter first (python3 {0})",
        word);
  }
  return fmt::format(
      "no executable program '{}' (a name is searched in PATH, a path from the experiment's "
      "folder)",
      word);
}

// Whether a program is a text that does not name its interpreter, so that it cannot be started.
bool LacksInterpreter(const fs::path& program) {
  std::array<char, 256> head{};  // what the kernel looks at; compiled programs have zeros in it
  std::ifstream in(program, std::ios::binary);
  if (!in) return false;  // an executable file may be unreadable
  in.read(head.data(), head.size());
  const std::string_view begin(head.data(), static_cast<std::size_t>(in.gcount()));
  return !begin.starts_with("#!") && begin.find('\0') == std::string_view::npos;
}

void ResolveCommand(const YamlMap& map, OutsideOptions& options) {
  auto& command = options.command;
  const auto folder = std::filesystem::absolute(map.file()).parent_path();
  for (std::string& word : command) {
    const bool is_name = &word == &command.front() && word.find('/') == std::string::npos;
    const auto beside = (folder / word).lexically_normal();
    std::error_code ignored;  // for words that cannot be file names
    if (is_name || word.empty() || !fs::exists(beside, ignored)) {
      if (!is_name && word.ends_with(".py")) {
        map.Fail("command", fmt::format("no file {}", beside.string()));
      }
      continue;
    }
    word = beside.string();
    options.files.push_back(beside);
  }
  const auto program = process::Find(command.front());
  if (!program) map.Fail("command", WhyNoProgram(command.front(), folder));
  if (LacksInterpreter(*program)) {
    map.Fail("command",
             fmt::format("{0} does not name its interpreter: begin it with a line such as "
                         "#!/usr/bin/env python3, or name the interpreter first (python3 {0})",
                         program->string()));
  }
  command.front() = program->string();
}

// Maximum length of a recorded error message about an answer.
constexpr std::size_t kDetail = 600;
constexpr double kMega_bytes = 1024.0 * 1024.0;
// Larger surfaces are refused. The surface of an object in a scan has ten times fewer triangles,
// and computing hulls and collision trees of larger ones takes longer than a trial.
constexpr std::uintmax_t kMaxSurface_bytes = 64 * 1024 * 1024;
constexpr std::size_t kMaxTriangles = 100'000;
// Maximum number of grasps that are considered, best first: each costs a collision check.
constexpr std::size_t kMaxChecked = 200;

process::Program ProgramOf(const OutsideOptions& options, const fs::path& folder) {
  process::Program program;
  program.command = options.command;
  program.folder = folder;
  program.limit_s = options.limit_s;
  program.max_memory_bytes = static_cast<std::uint64_t>(options.memory_mb * kMega_bytes);
  program.max_file_bytes = static_cast<std::uint64_t>(options.file_mb * kMega_bytes);
  program.environment = {{"TMPDIR", folder.string()}};
  // Parallel trials use all cores already, and another summation order changes the results.
  for (const char* threads : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"}) {
    if (!std::getenv(threads)) program.environment.emplace_back(threads, "1");
  }
  if (!options.sandbox) return program;
  process::Box box{folder, options.hidden, {}};
  box.hidden.push_back(fs::absolute("results"));
  for (const fs::path& file : options.files) {
    if (!fs::is_directory(file)) box.shown.push_back(file.parent_path());
    box.shown.push_back(file);
  }
  program.command = process::InSandbox(options.command, box);
  return program;
}

// Reads a surface from the detector's folder. The file is not trusted, like the answer itself.
geometry::TriangleMesh ReadSurface(const std::string& name, const fs::path& folder) {
  const auto fail = [&](const std::string& why) {
    throw DetectorFailed(fmt::format("answer: surface '{}' {}", name, why));
  };
  std::error_code error;
  const fs::path file = fs::canonical(folder / name, error);
  if (error) fail("does not exist");
  if (file.parent_path() != folder) fail("lies outside the detector's folder");
  if (!fs::is_regular_file(file)) fail("is not a file");
  if (fs::file_size(file) > kMaxSurface_bytes) fail("is larger than 64 MB");
  // Other formats may refer to other files.
  const std::string ending = base::EndingOf(file);
  if (ending != ".ply" && ending != ".stl") fail("must be a .ply or .stl");
  geometry::TriangleMesh mesh;
  try {
    mesh = geometry::ReadMesh(file);
  } catch (const base::InputError& e) {
    fail(e.what());
  }
  if (mesh.triangles.size() > kMaxTriangles) fail("has more than 100,000 triangles");
  for (const Eigen::Vector3d& p : mesh.vertices) {
    if (!(p.norm() < 100.0)) fail("has a vertex that is far from the table");
  }
  return mesh;
}

// The positions in the scene's cloud of these samples (ascending), without those near the table.
geometry::Indices InCloud(const std::vector<geometry::SampleId>& samples, const Scene& scene) {
  return geometry::PositionsWhere(scene.source, [&](std::uint32_t point) {
    return std::ranges::binary_search(samples, scene.samples[point]);
  });
}

// Region growing: the positions of all points of a cloud that are connected with the seeds.
geometry::Indices GrownFrom(const geometry::Indices& seeds, geometry::PointSpan points_C,
                            double link_m) {
  std::vector<char> is_seed(points_C.size(), 0);
  for (const auto i : seeds) is_seed[i] = 1;
  const geometry::KdTree tree(points_C);
  geometry::Indices grown;
  for (const auto& group : geometry::GroupsWithin(points_C, tree, link_m)) {
    if (std::ranges::none_of(group, [&](auto i) { return is_seed[i] != 0; })) continue;
    grown.insert(grown.end(), group.begin(), group.end());
  }
  std::ranges::sort(grown);
  return grown;
}

// Number of best grasps that are enough to detect a wrong unit or frame.
constexpr std::size_t kJudged = 20;
constexpr double kWorkCell_m = 2.0;
// No hand opens so far: a width above this is in another unit.
constexpr double kWidest_m = 1.0;

// A common mistake of detectors.
struct Mistake {
  const char* words = "";
  double unit_m = 1.0;                       // of all lengths
  base::Pose X_CA = base::Pose::Identity();  // A: the frame of the grasps
};

// An answer to a question, or why there is none.
struct Answered {
  std::unique_ptr<process::OwnFolder> folder;  // contains the files that it names
  std::optional<std::string> text;
  std::string failure;
  std::string words;  // other output, "; stderr: ..."
};

// A detector that answers in JSON: a program or a function.
class AnsweringDetector : public Detector {
 public:
  AnsweringDetector(std::function<Answered(const Question&)> ask,
                    const grasp::DetectorOptions& options, const robot::Robot& robot,
                    SceneObserver observer)
      : ask_(std::move(ask)), options_(options), robot_(robot), observer_(std::move(observer)) {}

  Detected Detect(const geometry::Observation& observation, base::Rng& rng,
                  const Turn& turn) const override {
    Detected detected;
    base::Stopwatch watch;
    const std::uint64_t seed = DrawSeed(rng);
    const auto workspace = grasp::WorkspaceOf(robot_, options_.workspace_margin_m);
    Scene scene = perception::PerceiveTable(observation, options_.perception, rng, workspace);
    detected.seconds.emplace_back("table", watch.Restart());
    Answered answered;
    try {
      answered =
          ask_({observation, robot_, scene.sampling.noise_m, options_.workspace_margin_m, seed});
      detected.seconds.emplace_back("detector", watch.Restart());
      if (!answered.text) throw DetectorFailed(answered.failure);
      const Answer answer = internal::ParseAnswer(*answered.text, observation);
      Understand(answer, answered.folder->path(), observation, turn, scene, detected);
    } catch (const DetectorFailed& e) {
      throw DetectorFailed(process::LastWords(e.what(), kDetail) + answered.words);
    }
    detected.seconds.emplace_back("grasp", watch.Restart());
    return detected;
  }

 private:
  void Understand(const Answer& answer, const fs::path& folder,
                  const geometry::Observation& observation, const Turn& turn, Scene& scene,
                  Detected& detected) const {
    detected.kept = scene.cloud.size();
    detected.answered = answer.grasps.size();
    if (!answer.grasps.empty() && HoldSomething(answer, scene, {}) == 0) {
      RefuseMistakes(answer, observation, scene);
      detected.why_none = fmt::format(
          "none of the {} best grasps has a measured point between its fingers", Judged(answer));
    }
    RefuseWidths(answer);
    const auto first = answer.objects ? FirstOfObjects(answer, folder, turn, scene, detected)
                                      : FirstOfGrasps(answer, turn, scene, detected);
    std::vector<grasp::Grasp> grasps;
    std::vector<Eigen::Vector3d> approaches_C;
    if (first && !scene.objects.front().points.empty()) {
      for (const auto& one : answer.grasps) {
        if (answer.objects && one.object != *first) continue;
        if (grasps.size() == kMaxChecked) break;
        grasps.push_back(Placed(one.proposal));
        approaches_C.push_back(one.proposal.approach_C);
      }
      detected.detection.obstacles =
          grasp::ObstaclesOfViews(scene, 0, observation, options_.obstacles);
      grasp::CheckProposals(scene, 0, robot_.hand(), options_.grasp,
                            detected.detection.obstacles.measured_C, grasps);
    }
    if (observer_) observer_(scene, grasps, observation);
    grasp::Detection made = grasp::DetectionFrom(scene, grasps);
    for (std::size_t i = 0; i < grasps.size(); ++i) made.grasps[i].approach_C = approaches_C[i];
    // Detection is scored with all samples that the detector names, also those near the table.
    for (std::size_t i = 0; i < made.objects.size(); ++i) {
      made.objects[i].samples = std::move(detected.detection.objects[i].samples);
      made.objects[i].whole = detected.detection.objects[i].whole;
    }
    made.obstacles = std::move(detected.detection.obstacles);
    detected.detection = std::move(made);
    detected.segments = static_cast<int>(scene.objects.size());
  }

  static std::size_t Judged(const Answer& answer) {
    return std::min(answer.grasps.size(), kJudged);
  }
  // Number of the best grasps that, corrected, have a measured point above the table between their
  // fingers. Only coordinates larger than a work cell are in another unit.
  std::size_t HoldSomething(const Answer& answer, const Scene& scene,
                            const Mistake& mistake) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < Judged(answer); ++i) {
      grasp::Proposal proposal = answer.grasps[i].proposal;
      const bool far = proposal.X_CG.translation().norm() > kWorkCell_m;
      if (mistake.unit_m != 1.0 && !far) continue;
      proposal.X_CG.translation() *= mistake.unit_m;
      proposal.width_m *= mistake.unit_m;
      proposal.X_CG = mistake.X_CA * proposal.X_CG;
      const auto placed = grasp::PlaceHand(proposal, robot_.hand(), options_.grasp);
      count += BetweenFingers(placed, robot_.hand(), scene.cloud.points).empty() ? 0 : 1;
    }
    return count;
  }
  // @throws DetectorFailed naming the mistake that explains why most grasps close on nothing
  void RefuseMistakes(const Answer& answer, const geometry::Observation& observation,
                      const Scene& scene) const {
    // Centimetres first: read as millimetres, all would be near the origin, perhaps at an object.
    const Mistake mistakes[] = {{.words = "centimetres, not metres", .unit_m = 1e-2},
                                {.words = "millimetres, not metres", .unit_m = 1e-3},
                                {.words = "the sensor's frame, not the cloud's, W",
                                 .X_CA = observation.views.front().X_CV}};
    for (const Mistake& mistake : mistakes) {
      const std::size_t count = HoldSomething(answer, scene, mistake);
      if (2 * count < Judged(answer)) continue;
      throw DetectorFailed(
          fmt::format("answer: seems to be in {}; none of the {} best grasps has a measured point "
                      "between its fingers, {} of them would otherwise",
                      mistake.words, Judged(answer), count));
    }
  }

  // Checked after the other mistakes, since wrong units of all lengths are named better there.
  // @throws DetectorFailed if a width can only be in another unit
  void RefuseWidths(const Answer& answer) const {
    for (const auto& one : answer.grasps) {
      if (one.proposal.width_m <= kWidest_m) continue;
      throw DetectorFailed(
          fmt::format("answer: the width_m of a grasp is {:g}: far wider than the hand opens "
                      "({:.3g} m); it must be in metres: is it in millimetres?",
                      one.proposal.width_m, robot_.hand().MaxGap()));
    }
  }

  // A grasp far outside the workspace counts as colliding.
  grasp::Grasp Placed(const grasp::Proposal& proposal) const {
    grasp::Grasp placed = grasp::PlaceHand(proposal, robot_.hand(), options_.grasp);
    const auto workspace = grasp::WorkspaceOf(robot_, options_.workspace_margin_m);
    if (!workspace.Contains(proposal.X_CG.translation())) placed.collides = true;
    return placed;
  }

  static void Add(perception::PerceivedObject object, std::vector<geometry::SampleId> samples,
                  bool whole, bool first, Scene& scene, Detected& detected) {
    auto& objects = detected.detection.objects;
    grasp::DetectedObject own{std::move(samples), {}, false, false, whole};
    objects.insert(first ? objects.begin() : objects.end(), std::move(own));
    scene.objects.insert(first ? scene.objects.begin() : scene.objects.end(), std::move(object));
  }

  // Adds the answer's objects, starting with the one whose turn it is.
  // @return its position in the answer
  std::optional<std::size_t> FirstOfObjects(const Answer& answer, const fs::path& folder,
                                            const Turn& turn, Scene& scene,
                                            Detected& detected) const {
    std::optional<std::size_t> first;
    std::optional<int> first_turn;
    for (std::size_t i = 0; i < answer.objects->size(); ++i) {
      const AnsweredObject& answered = (*answer.objects)[i];
      const auto its = turn ? turn(answered.samples) : std::optional<int>(first ? 1 : 0);
      const bool leads = its && (!first_turn || *its < *first_turn);
      if (leads) {
        first = i;
        first_turn = its;
      }
      auto object = grasp::ObjectOfPoints(scene, InCloud(answered.samples, scene));
      if (!answered.surface.empty()) object.surface_C = ReadSurface(answered.surface, folder);
      Add(std::move(object), answered.samples, true, leads, scene, detected);
    }
    detected.has_turn = first.has_value();
    return first;
  }

  // Adds the object between the fingers of the best grasp of an object whose turn it is, otherwise
  // of the best grasp: it is perceived, but may not be grasped.
  std::optional<std::size_t> FirstOfGrasps(const Answer& answer, const Turn& turn, Scene& scene,
                                           Detected& detected) const {
    geometry::Indices best;
    std::optional<int> best_turn;
    const std::size_t looked_at = std::min(answer.grasps.size(), kMaxChecked);
    for (std::size_t i = 0; i < looked_at && (turn || best.empty()); ++i) {
      auto between = grasp::BetweenFingers(Placed(answer.grasps[i].proposal), robot_.hand(),
                                           scene.cloud.points);
      if (between.empty()) continue;
      const auto its = turn ? turn(SamplesOf(between, scene)) : std::optional<int>(0);
      if (!best.empty() && (!its || (best_turn && *its >= *best_turn))) continue;
      best = std::move(between);
      best_turn = its;
    }
    detected.has_turn = best_turn.has_value();
    if (best.empty()) return std::nullopt;
    const double link_m = options_.obstacles.link_gaps * scene.sampling.gap_m;
    Add(grasp::ObjectOfPoints(scene, GrownFrom(best, scene.cloud.points, link_m)),
        SamplesOf(best, scene), false, true, scene, detected);
    return detected.has_turn ? std::optional<std::size_t>(0) : std::nullopt;
  }

  static std::vector<geometry::SampleId> SamplesOf(const geometry::Indices& points,
                                                   const Scene& scene) {
    std::vector<geometry::SampleId> samples;
    for (const auto i : points) samples.push_back(scene.SampleOf(i));
    return samples;
  }

  std::function<Answered(const Question&)> ask_;
  const grasp::DetectorOptions& options_;
  const robot::Robot& robot_;
  SceneObserver observer_;
};

}  // namespace

std::uint64_t DrawSeed(base::Rng& rng) {
  constexpr int kUnused = 11;  // below 2^53, seeds are exact in every language's floating point
  return rng.Next() >> kUnused;
}

void ReadOutside(YamlMap map, OutsideOptions& options) {
  if (!map.Names().empty()) map.Require("command");
  map.Read("command", options.command,
           "your own program with its arguments, e.g. [python3, my_detector.py]; relative paths "
           "are relative to the experiment's folder");
  map.Read("time_limit_s", options.limit_s, 0.1, 86400.0,
           "time limit from its start to its answer; less than trial_limit_s");
  map.Read("sandbox", options.sandbox,
           "run it without network, with write access only to its own folder, and without access "
           "to results (bubblewrap)");
  map.Read("memory_mb", options.memory_mb, 0, 10'000'000,
           "maximum address space of each of its processes; 0: no limit");
  map.Read("file_mb", options.file_mb, 0, 10'000'000,
           "maximum size of each file that it writes; 0: no limit");
  map.Finish();
  if (!options.command.empty()) ResolveCommand(map, options);
}

std::unique_ptr<Detector> MakeOutsideDetector(const OutsideOptions& outside,
                                              const grasp::DetectorOptions& options,
                                              const robot::Robot& robot, SceneObserver observer) {
  const auto ask = [outside](const Question& question) -> Answered {
    auto folder = std::make_unique<process::OwnFolder>();
    const std::string line = internal::WriteFiles(question, folder->path());
    process::Reply reply = process::Ask(ProgramOf(outside, folder->path()), line);
    return {std::move(folder), std::move(reply.line), std::move(reply.failure),
            reply.last_words.empty() ? "" : "; stderr: " + reply.last_words};
  };
  return std::make_unique<AnsweringDetector>(ask, options, robot, std::move(observer));
}

std::unique_ptr<Detector> MakeFunctionDetector(AnswerFunction answer,
                                               const grasp::DetectorOptions& options,
                                               const robot::Robot& robot, SceneObserver observer) {
  const auto ask = [answer = std::move(answer)](const Question& question) {
    return Answered{std::make_unique<process::OwnFolder>(), answer(question), {}, {}};
  };
  return std::make_unique<AnsweringDetector>(ask, options, robot, std::move(observer));
}

}  // namespace rangegrasp::external
