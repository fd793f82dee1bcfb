#include "external/outside_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/process/program.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "geometry/cloud_file.h"
#include "geometry/mesh_file.h"
#include "shipped_cell.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::trial {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// A cell and one scan of a box on its table.
struct Looked {
  experiment::Experiment experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  const Cell& cell = CellOf(*experiment.task);
  TrialSpec spec{"dextrose", 0, TrialSeed(11, "dextrose", 0)};
  Sensed sensed = Look(cell, ArrangeTrial(cell, spec)->world, spec.seed);
};

const Looked& TheLook() {
  static const Looked look;
  return look;
}

class Outside : public ::testing::Test {
 protected:
  Outside() : options_(TheLook().cell.options) { outside_.limit_s = 20.0; }

  /// The result of a detector that is a shell script.
  Detected Ask(const std::string& script, const Turn& turn = {}) {
    outside_.command = {"/bin/sh", "-c", script};
    base::Rng rng(1);
    return external::MakeOutsideDetector(outside_, options_, TheLook().cell.robot)
        ->Detect(TheLook().sensed.observation, rng, turn);
  }
  /// The result of a detector that gives this answer.
  Detected Answer(const json& answer, const Turn& turn = {}) {
    return Ask("cat " + files_.Write("answer", answer.dump()).string(), turn);
  }
  std::string FailureOf(const std::string& script) {
    return testing_support::ErrorOf<DetectorFailed>([&] { Ask(script); });
  }
  std::string FailureOfAnswer(const json& answer) {
    return testing_support::ErrorOf<DetectorFailed>([&] { Answer(answer); });
  }

  /// The samples of the box according to the ground truth.
  static std::vector<std::size_t> SamplesOfTarget() {
    const auto& label = TheLook().sensed.truth.front().label;
    std::vector<std::size_t> samples;
    for (std::size_t i = 0; i < label.size(); ++i) {
      const auto& p = TheLook().sensed.observation.views.front().image.points_C[i];
      if (label[i] == 1 && p.allFinite() && p.z() > 0.006) samples.push_back(i);
    }
    return samples;
  }
  static Eigen::Vector3d MiddleOfTarget() {
    Eigen::AlignedBox3d box;
    for (const auto i : SamplesOfTarget()) {
      box.extend(TheLook().sensed.observation.views.front().image.points_C[i]);
    }
    return box.center();
  }
  /// A grasp from above at the middle of the box.
  static json GraspAtTarget() {
    const Eigen::Vector3d at = MiddleOfTarget();
    return {{"position_m", {at.x(), at.y(), at.z()}},
            {"rotation", {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}},
            {"width_m", 0.06}};
  }

  external::OutsideOptions outside_;
  Options options_;
  testing_support::TempFolder files_;
};

TEST_F(Outside, TheQuestionSaysWhatItNeedsAndNoTruth) {
  const std::string to = files_.path().string();
  Ask("cat > " + to + "/question; cp obs.pcd hand.stl " + to + "; echo '{\"grasps\": []}'");
  const json question = json::parse(base::ReadFile(files_ / "question"));
  std::vector<std::string> keys;
  for (const auto& [key, value] : question.items()) keys.push_back(key);
  EXPECT_THAT(keys, ::testing::ElementsAre("arm", "hand", "images", "noise_m", "observation",
                                           "seed", "views", "workspace"));
  EXPECT_LT(question["seed"].get<double>(), 9007199254740992.0);
  EXPECT_NEAR(question["noise_m"], 0.0005, 0.0005);
  EXPECT_GT(question["noise_m"].get<double>(), 1e-4);
  const auto& view = TheLook().sensed.observation.views.front();
  EXPECT_EQ(question["views"][0]["rows"], view.image.profiles);
  EXPECT_EQ(question["views"][0]["X_WV"][2][3], view.X_CV.translation().z());
  const auto cloud = geometry::ReadCloud(files_ / "obs.pcd");
  ASSERT_EQ(cloud.points.size(), view.image.points_C.size());
  EXPECT_EQ(cloud.height, view.image.profiles);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    ASSERT_EQ(cloud.points[i].allFinite(), view.image.points_C[i].allFinite());
    if (!cloud.points[i].allFinite()) continue;
    // Single precision at 1 m.
    ASSERT_LT((cloud.points[i] - view.image.points_C[i]).norm(), 2e-7);
  }
  const std::string header = base::ReadFile(files_ / "obs.pcd").substr(0, 400);
  EXPECT_THAT(header, HasSubstr("FIELDS x y z\n"));
  EXPECT_GT(geometry::ReadMesh(files_ / "hand.stl").triangles.size(), 100u);
}

TEST_F(Outside, AWrongUnitOrFrameIsNamed) {
  const auto target = SamplesOfTarget();
  json grasp = GraspAtTarget();
  const auto in_unit = [&](double per_m) {
    json wrong = grasp;
    for (json& x : wrong["position_m"]) x = per_m * x.get<double>();
    wrong["width_m"] = per_m * grasp["width_m"].get<double>();
    return wrong;
  };
  EXPECT_THAT(FailureOfAnswer({{"grasps", {in_unit(1000.0)}}}),
              ::testing::AnyOf(HasSubstr("millimetres"), HasSubstr("in metres")));
  EXPECT_THAT(FailureOfAnswer({{"grasps", {in_unit(100.0)}}}), HasSubstr("centimetres"));
  EXPECT_THAT(FailureOfAnswer({{"objects", {{{"samples", target}}}}, {"grasps", {in_unit(100.0)}}}),
              HasSubstr("centimetres"));
  const base::Pose X_VW = TheLook().sensed.observation.views.front().X_CV.inverse();
  const Eigen::Vector3d at = X_VW * MiddleOfTarget();
  const Eigen::Matrix3d R =
      X_VW.linear() * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal().toDenseMatrix();
  json in_sensor = grasp;
  in_sensor["position_m"] = {at.x(), at.y(), at.z()};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) in_sensor["rotation"][row][column] = R(row, column);
  }
  EXPECT_THAT(FailureOfAnswer({{"grasps", {in_sensor}}}), HasSubstr("sensor's frame"));
  EXPECT_TRUE(Answer({{"grasps", {grasp}}}).why_none.empty());
}

TEST_F(Outside, AWidthInMillimetresIsNamedAlthoughThePositionIsRight) {
  json grasp = GraspAtTarget();
  grasp["width_m"] = 45;
  EXPECT_THAT(
      FailureOfAnswer({{"grasps", {GraspAtTarget(), grasp}}}),
      ::testing::AllOf(HasSubstr("width_m of a grasp is 45"), HasSubstr("is it in millimetres?")));
}

// Lengths so far away that they are refused before what they would hold is looked for.
TEST_F(Outside, LengthsBeyondTheirRangeMayBeInMillimetresButNoRotationIs) {
  constexpr const char* kHint = "to 100, in metres; is it in millimetres?";
  const auto failure = [&](const std::string& key, const json& value) {
    json grasp = GraspAtTarget();
    grasp[key] = value;
    return FailureOfAnswer({{"grasps", {grasp}}});
  };
  EXPECT_THAT(failure("position_m", {0.0, -104.2, 0.0}),
              ::testing::AllOf(HasSubstr("grasps[0].position_m[1] is -104.2"), HasSubstr(kHint)));
  EXPECT_THAT(failure("width_m", 145.0), HasSubstr(kHint));
  for (const auto& [key, value] : {std::pair<std::string, json>{"width_m", -0.05},
                                   {"width_m", "45 mm"},
                                   {"approach", {0, 0, -200}},
                                   {"rotation", {{200, 0, 0}, {0, -1, 0}, {0, 0, -1}}}}) {
    EXPECT_THAT(failure(key, value), ::testing::AllOf(HasSubstr("must be a number from"),
                                                      ::testing::Not(HasSubstr("metres"))))
        << key << value;
  }
}

TEST_F(Outside, GraspsOfAirAreNamed) {
  json grasp = GraspAtTarget();
  grasp["position_m"] = {0.05, 0.05, 0.4};
  EXPECT_THAT(Answer({{"grasps", {grasp, grasp}}}).why_none, HasSubstr("none of the 2 best"));
}

TEST_F(Outside, AFunctionIsUnderstoodLikeAProgram) {
  const json answer = {{"grasps", {GraspAtTarget()}}};
  base::Rng rng(1);
  const auto detector = external::MakeFunctionDetector(
      [&](const external::Question& question) {
        EXPECT_EQ(question.observation.views.size(), 1u);
        EXPECT_GT(question.noise_m, 0.0);
        return answer.dump();
      },
      options_, TheLook().cell.robot);
  const Detected detected = detector->Detect(TheLook().sensed.observation, rng);
  const Detected of_program = Answer(answer);
  ASSERT_EQ(detected.detection.grasps.size(), 1u);
  EXPECT_EQ(detected.detection.objects.front().samples,
            of_program.detection.objects.front().samples);
  EXPECT_EQ(detected.detection.grasps.front().X_CH.matrix(),
            of_program.detection.grasps.front().X_CH.matrix());
  const auto wrong = external::MakeFunctionDetector(
      [](const external::Question&) { return std::string("not json"); }, options_,
      TheLook().cell.robot);
  EXPECT_THAT(testing_support::ErrorOf<DetectorFailed>(
                  [&] { wrong->Detect(TheLook().sensed.observation, rng); }),
              HasSubstr("not JSON"));
}

TEST_F(Outside, ObjectsAndGraspsAreUnderstood) {
  json second = GraspAtTarget();
  second["score"] = 2.0;
  second["approach"] = {0.0, 0.6, -0.8};
  json elsewhere = GraspAtTarget();
  elsewhere["object"] = 1;
  const auto target = SamplesOfTarget();
  const Detected detected = Answer({{"objects", {{{"samples", target}}, {{"samples", {0, 1, 2}}}}},
                                    {"grasps", {GraspAtTarget(), second, elsewhere}}});
  const grasp::Detection& detection = detected.detection;
  ASSERT_EQ(detection.objects.size(), 2u);
  EXPECT_EQ(detection.objects.front().samples.size(), target.size());
  EXPECT_FALSE(detection.objects.front().surface_C.triangles.empty());
  ASSERT_EQ(detection.grasps.size(), 2u) << "those of the first object";
  EXPECT_EQ(detection.grasps[0].score, 2.0) << "best first";
  EXPECT_TRUE(detection.grasps[0].approach_C.isApprox(Eigen::Vector3d(0.0, 0.6, -0.8)));
  EXPECT_TRUE(detection.grasps[1].approach_C.isApprox(Eigen::Vector3d(0.0, 0.0, -1.0)));
  EXPECT_NEAR(detection.table_C.offset_m, 0.0, 0.003);
  const auto verdict =
      JudgeDetection(detection, TheLook().sensed, {1, TheLook().cell.TablePlane(), 0.006});
  EXPECT_TRUE(verdict.right_target && verdict.segmented);
}

TEST_F(Outside, ThePadsCloseAboutThePosition) {
  const auto detection = Answer({{"grasps", {GraspAtTarget()}}}).detection;
  ASSERT_EQ(detection.grasps.size(), 1u);
  const robot::HandModel& hand = TheLook().cell.robot.hand();
  const auto& held = hand.AtGap(0.06);
  const Eigen::Vector3d middle_H = 0.5 * (held.thumb_pad_H + held.finger_pad_H);
  const Eigen::Vector3d thumb = detection.grasps[0].X_CH * held.thumb_pad_H;
  const Eigen::Vector3d fingers = detection.grasps[0].X_CH * held.finger_pad_H;
  EXPECT_NEAR((detection.grasps[0].X_CH * middle_H - MiddleOfTarget()).norm(), 0.0, 1e-9);
  EXPECT_GT((thumb - fingers).x(), 0.03) << "x points from the fingers to the thumb";
}

TEST_F(Outside, WithoutObjectsTheObjectIsWhatLiesBetweenTheFingers) {
  json far = GraspAtTarget();
  far["position_m"][1] = far["position_m"][1].get<double>() + 0.2;
  far["score"] = -1.0;
  const auto detection = Answer({{"grasps", {far, GraspAtTarget()}}}).detection;
  ASSERT_EQ(detection.objects.size(), 1u);
  EXPECT_FALSE(detection.objects.front().whole);
  const auto& samples = detection.objects.front().samples;
  EXPECT_GT(samples.size(), 20u);
  const auto target = SamplesOfTarget();
  const auto hits = std::ranges::count_if(samples, [&](const geometry::SampleId& id) {
    return std::ranges::binary_search(target, id.sample);
  });
  EXPECT_GT(static_cast<double>(hits), 0.9 * static_cast<double>(samples.size()));
  const auto verdict =
      JudgeDetection(detection, TheLook().sensed, {1, TheLook().cell.TablePlane(), 0.006});
  EXPECT_TRUE(verdict.right_target && verdict.segmented);
  // A grasp in the air holds no object.
  EXPECT_TRUE(Answer({{"grasps", {far}}}).detection.objects.empty());
  EXPECT_TRUE(Answer({{"grasps", json::array()}}).detection.objects.empty());
}

// Otherwise a table on which nothing may be grasped would look empty (task: clearing).
TEST_F(Outside, WithoutObjectsAnObjectWithoutATurnIsStillPerceived) {
  const json answer = {{"grasps", {GraspAtTarget()}}};
  const Detected first = Answer(answer, [](const auto&) { return std::optional<int>(1); });
  EXPECT_TRUE(first.has_turn);
  EXPECT_EQ(first.detection.grasps.size(), 1u);
  const Detected passed = Answer(answer, [](const auto&) { return std::nullopt; });
  EXPECT_FALSE(passed.has_turn);
  ASSERT_EQ(passed.detection.objects.size(), 1u);
  EXPECT_EQ(passed.detection.objects.front().samples, first.detection.objects.front().samples);
  EXPECT_TRUE(passed.detection.grasps.empty());
}

TEST_F(Outside, AGraspThatCannotBeCountsAsColliding) {
  json wide = GraspAtTarget();
  wide["width_m"] = 0.5;
  json in_table = GraspAtTarget();
  in_table["position_m"][2] = -0.05;
  json away = GraspAtTarget();
  away["position_m"] = {3, 0, 0.1};
  const auto detection =
      Answer({{"objects", {{{"samples", SamplesOfTarget()}}}}, {"grasps", {wide, in_table, away}}})
          .detection;
  ASSERT_EQ(detection.grasps.size(), 3u);
  for (const auto& grasp : detection.grasps) EXPECT_TRUE(grasp.collides);
}

TEST_F(Outside, TheTurnDecidesWhichObjectIsFirst) {
  const auto target = SamplesOfTarget();
  const json answer = {{"objects", {{{"samples", {0}}}, {{"samples", target}}}},
                       {"grasps", {GraspAtTarget()}}};
  const Turn large_only = [](const std::vector<geometry::SampleId>& samples) {
    return samples.size() > 10 ? std::optional<int>(0) : std::nullopt;
  };
  const Detected detected = Answer(answer, large_only);
  EXPECT_TRUE(detected.has_turn);
  EXPECT_EQ(detected.detection.objects.front().samples.size(), target.size());
  EXPECT_TRUE(detected.detection.grasps.empty()) << "they were for the other";
  EXPECT_FALSE(Answer(answer, [](const auto&) { return std::nullopt; }).has_turn);
}

TEST_F(Outside, WhatIsNoAnswerIsSaidWithItsReason) {
  EXPECT_EQ(FailureOf("echo dying >&2; exit 7"),
            "ended with code 7 without an answer; stderr: dying");
  EXPECT_THAT(FailureOf("kill -SEGV $$"), HasSubstr("Segmentation fault"));
  EXPECT_THAT(FailureOf("echo loading model; echo '{}'"), HasSubstr("begins with: loading model"));
  EXPECT_THAT(FailureOf("printf '\\377\\376\\n'"), HasSubstr("not JSON"));
  EXPECT_THAT(FailureOf("echo '{\"grasps\": [{\"width_m\": NaN}]}'"),
              HasSubstr("NaN is not JSON; it is at the end of: {\"grasps\": [{\"width_m\": NaN"));
  EXPECT_THAT(FailureOf("echo '{\"grasps\": [{\"score\": -Infinity}]}'"),
              HasSubstr("Infinity is not JSON"));
  EXPECT_THAT(FailureOf("printf '{\\n \"grasps\": []\\n}\\n'"), HasSubstr("must be one line"));
  EXPECT_THAT(FailureOf("echo '{\"grasps\": [1e999]}'"), HasSubstr("not JSON"));
  EXPECT_THAT(FailureOf("echo '{}'"), HasSubstr("'grasps' is missing"));
  EXPECT_THAT(FailureOf("echo '[]'"), HasSubstr("must be {\"objects\""));
  EXPECT_THAT(FailureOf("head -c 8000000 /dev/zero | tr '\\0' '['"), HasSubstr("nested"));
  // 1 GB of JSON.
  EXPECT_THAT(FailureOf("printf '{\"grasps\": ['; yes '1,' | tr -d '\\n' | head -c 1000000000"),
              HasSubstr("more than 16777216 bytes"));
  outside_.limit_s = 0.3;
  EXPECT_EQ(FailureOf("sleep 100"), "no answer within 0.3 s");
}

TEST_F(Outside, WhatIsWrongInAnAnswerIsNamed) {
  const auto with = [](const std::string& key, const json& value) {
    json grasp = GraspAtTarget();
    grasp[key] = value;
    return json{{"grasps", {GraspAtTarget(), grasp}}};
  };
  EXPECT_THAT(FailureOfAnswer(with("rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 2}})),
              HasSubstr("grasps[1].rotation is [[1,0,0],[0,1,0],[0,0,2]]: must be a rotation"));
  EXPECT_THAT(FailureOfAnswer(with("rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}})),
              HasSubstr("reflection"));
  EXPECT_THAT(FailureOfAnswer(with("rotation", {1, 0, 0})), HasSubstr("must be three numbers"));
  EXPECT_THAT(FailureOfAnswer(with("rotation", {1, 0, 0, 0})), HasSubstr("must be a rotation"));
  EXPECT_THAT(FailureOfAnswer(with("width_m", -0.01)), HasSubstr("from 0 to 100"));
  EXPECT_THAT(FailureOfAnswer(with("width_m", "wide")), HasSubstr("is \"wide\""));
  EXPECT_THAT(FailureOfAnswer(with("position_m", {0, 0, 1e30})),
              HasSubstr("position_m[2] is 1e+30"));
  EXPECT_THAT(FailureOfAnswer(with("approach", {0, 0, -3})), HasSubstr("must be of length 1"));
  EXPECT_THAT(FailureOfAnswer(with("score", json::object())), HasSubstr("grasps[1].score is {}"));
  EXPECT_THAT(FailureOfAnswer(json{{"grasps", 3}}), HasSubstr("grasps is 3: must be a list"));
  EXPECT_THAT(FailureOfAnswer(json{{"grasps", {3}}}), HasSubstr("grasps[0] is 3"));
  const auto objects = [](const json& object) {
    return json{{"objects", {object}}, {"grasps", json::array()}};
  };
  for (const json& sample : {json(10'000'000), json(-1), json(1.5), json("1"), json()}) {
    EXPECT_THAT(FailureOfAnswer(objects({{"samples", {sample}}})),
                HasSubstr("objects[0].samples[0] is "));
  }
  EXPECT_THAT(FailureOfAnswer(objects(json::object())), HasSubstr("'samples' is missing"));
  json grasp = GraspAtTarget();
  grasp["object"] = 1;
  EXPECT_THAT(FailureOfAnswer(json{{"objects", {{{"samples", {0}}}}}, {"grasps", {grasp}}}),
              HasSubstr("from 0 to below 1"));
}

TEST_F(Outside, ASurfaceComesFromTheDetectorsFolderAlone) {
  const auto cube =
      files_.Write("cube.ply",
                   "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                   "property float y\nproperty float z\nelement face 4\nproperty list "
                   "uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
                   "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
  const auto answer = [&](const std::string& name) {
    json object = {{"samples", SamplesOfTarget()}, {"surface", name}};
    return "cat " +
           files_.Write("answer", json{{"objects", {object}}, {"grasps", json::array()}}.dump())
               .string();
  };
  const std::string copy = "cp " + cube.string() + " own.ply; ";
  EXPECT_EQ(Ask(copy + answer("own.ply")).detection.objects.front().surface_C.triangles.size(), 4u);
  EXPECT_THAT(FailureOf(answer("own.ply")), HasSubstr("does not exist"));
  EXPECT_THAT(FailureOf(answer(cube.string())), HasSubstr("outside the detector's folder"));
  EXPECT_THAT(
      FailureOf("mkdir a; " + answer("a/../../" + files_.path().filename().string() + "/cube.ply")),
      HasSubstr("outside the detector's folder"));
  EXPECT_THAT(FailureOf("ln -s " + cube.string() + " own.ply; " + answer("own.ply")),
              HasSubstr("outside the detector's folder"));
  EXPECT_THAT(FailureOf("mkfifo own.ply; " + answer("own.ply")), HasSubstr("is not a file"));
  EXPECT_THAT(FailureOf("echo garbage > own.ply; " + answer("own.ply")), HasSubstr("own.ply"));
  EXPECT_THAT(FailureOf("echo > own.obj; " + answer("own.obj")), HasSubstr(".ply or .stl"));
}

TEST_F(Outside, AFailureIsAnOutcomeWithItsReason) {
  outside_.command = {"/bin/sh", "-c", "echo last words >&2; exit 1"};
  const auto detector = external::MakeOutsideDetector(outside_, options_, TheLook().cell.robot);
  const auto result = RunTrial(TheLook().cell, TheLook().spec, detector.get());
  EXPECT_EQ(result.outcome, "detector_failed");
  EXPECT_EQ(result.stage, "perceive");
  EXPECT_THAT(result.detail, HasSubstr("stderr: last words"));
}

TEST_F(Outside, ItsSeedIsTheTrials) {
  const std::string to = files_.path().string();
  const std::string script = "cat >> " + to + "/questions; echo '{\"grasps\": []}'";
  Ask(script);
  Ask(script);
  const std::string both = base::ReadFile(files_ / "questions");
  EXPECT_EQ(both.substr(0, both.size() / 2), both.substr(both.size() / 2));
}

TEST_F(Outside, FilesAreFoundFromTheExperimentAndWrongOnesSaid) {
  const auto open = [](const std::string& detector) {
    return testing_support::MessageOf<base::InputError>([&] {
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml",
                                 {.set = {"detector=" + detector}});
    });
  };
  EXPECT_EQ(open("{command: [sh, ../examples/detectors/antipodal.py]}"), "");
  EXPECT_THAT(open("{command: [no-such-program]}"),
              HasSubstr("no executable program 'no-such-program'"));
  EXPECT_THAT(open("{command: [sh, missing.py]}"), HasSubstr("--set detector.command: "));
  EXPECT_THAT(open("{command: [sh, missing.py]}"), HasSubstr("experiments/missing.py"));
  EXPECT_THAT(open("{time_limit_s: 3}"), HasSubstr("key 'command': is missing"));
  EXPECT_THAT(open("{command: [sh], time_limit_s: 60}"), HasSubstr("less than trial_limit_s"));
  EXPECT_THAT(open("{command: [sh], sandbocks: true}"), HasSubstr("sandbox"));
  EXPECT_THAT(open("outside"), HasSubstr("dissertation"));
}

TEST_F(Outside, AFileThatCannotBeStartedIsNamedWithItsCure) {
  const auto file = files_.Write("detector.py", "#!/usr/bin/env python3\n").string();
  const auto open = [&](const std::string& command) {
    const auto experiment = files_.Write(
        "e.yaml", std::string("name: demo\n") + testing_support::kShippedCell +
                      "objects: [coffee_cup]\ndetector: {command: [" + command + "]}\n");
    return testing_support::MessageOf<base::InputError>(
        [&] { experiment::OpenExperiment(experiment); });
  };
  const std::string cure = "run `chmod +x " + file + "`, or name its interpreter first";
  EXPECT_THAT(open("./detector.py"), HasSubstr("e.yaml:6: key 'command': " + file));
  EXPECT_THAT(open("./detector.py"), HasSubstr(cure + " (python3 " + file + ")"));
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  EXPECT_EQ(open("./detector.py"), "");
  EXPECT_THAT(open("detector.py"), HasSubstr("give ./detector.py"));
  files_.Write("detector.py", "import json\n");
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  EXPECT_THAT(open("./detector.py"), HasSubstr("begin it with a line such as #!/usr/bin/env"));
  EXPECT_EQ(open("sh, detector.py"), "");
}

/// What `check --detector` reports of a detector that is a shell script.
struct CheckedAnswers {
  std::string text;
  bool failed = false;
};
CheckedAnswers CheckAnswersOf(const std::string& script, const std::string& set = "seed=1") {
  const auto e = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml",
      {.set = {"detector={command: [sh, -c, " + json(script).dump() + "]}", set}});
  CheckedAnswers checked;
  const auto* kind = trial::FindDetector(trial::kDetectorWithKeys);
  checked.failed = !kind->check_answers(CellOf(*e.task), checked.text);
  return checked;
}

TEST_F(Outside, TheCheckTellsWhatItUnderstood) {
  const auto empty = CheckAnswersOf("echo '{\"objects\": [], \"grasps\": []}'");
  EXPECT_TRUE(empty.failed);
  EXPECT_THAT(empty.text, HasSubstr("no answer has a grasp"));
  EXPECT_THAT(empty.text, HasSubstr("salt_cylinder: 0 grasps in the answer; 0 objects; 0 grasps"));
  EXPECT_THAT(empty.text, testing::Not(HasSubstr("`rotation`")));
  EXPECT_THAT(empty.text, HasSubstr("sandbox: "));
  if (!process::WhyNoSandbox()) {
    EXPECT_THAT(empty.text, HasSubstr("the same answer"));
  }
  const json grasp = {{"position_m", {0.4, 0.4, 0.9}},
                      {"rotation", {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}},
                      {"width_m", 0.05}};
  const auto in_air =
      CheckAnswersOf("echo '" + json{{"grasps", json::array({grasp})}}.dump() + "'");
  EXPECT_TRUE(in_air.failed);
  EXPECT_THAT(in_air.text, HasSubstr("salt_cylinder: 1 grasp in the answer; 0 objects"));
  const auto broken = CheckAnswersOf("echo '{}'");
  EXPECT_TRUE(broken.failed);
  EXPECT_THAT(broken.text, HasSubstr("'grasps' is missing"));
}

TEST_F(Outside, TheCheckWarnsOfAnApproachAgainstTheHand) {
  const auto check = [](json grasp, double approach_z) {
    grasp["approach"] = {0, 0, approach_z};
    const std::string answer = json{{"grasps", json::array({grasp})}}.dump();
    return CheckAnswersOf("echo '" + answer + "'", "objects=[dextrose]").text;
  };
  EXPECT_THAT(check(GraspAtTarget(), 1.0),
              HasSubstr("dextrose: warning: `approach` of a grasp points against z of its "
                        "`rotation` (180 deg)"));
  EXPECT_THAT(check(GraspAtTarget(), -1.0), testing::Not(HasSubstr("`approach`")));
}

}  // namespace
}  // namespace rangegrasp::trial
