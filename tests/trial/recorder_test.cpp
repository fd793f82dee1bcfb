#include "trial/recorder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "experiment/experiment.h"

namespace rangegrasp::trial {
namespace {

using experiment::View;

class ViewTest : public testing::Test {
 protected:
  experiment::Result Replayed(const std::string& id, View& view) const {
    return experiment_.task->Replay(CaseOf(experiment_, id), {.view = &view});
  }

  const experiment::Experiment experiment_ = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {.seed = 11});
};

double Travel(const View::Body& body) {
  double travel = 0.0;
  for (const base::Pose& X : body.X_WB) {
    travel = std::max(travel, (X.translation() - body.X_WB.front().translation()).norm());
  }
  return travel;
}

TEST_F(ViewTest, LookingOnChangesNothing) {
  for (const char* id : {"dextrose-0000", "sweets_prism-0000"}) {
    const experiment::Case& which = CaseOf(experiment_, id);
    View view;
    const experiment::Result seen = Replayed(id, view);
    EXPECT_TRUE(experiment::SameButTimes({which, seen}, {which, experiment_.task->Run(which)}))
        << id;
  }
}

TEST_F(ViewTest, HoldsWhatWasPerceivedAndWhatMoved) {
  View view;
  ASSERT_EQ(Replayed("dextrose-0000", view).outcome, "delivered");
  std::set<std::string> layers;
  for (const auto& points : view.points) layers.insert(points.layer);
  for (const auto& line : view.lines) layers.insert(line.layer);
  for (const auto& surface : view.surfaces) layers.insert(surface.layer);
  for (const char* layer :
       {"table", "objects", "completed surfaces", "free grasps", "chosen grasp"}) {
    EXPECT_TRUE(layers.contains(layer)) << layer;
  }
  ASSERT_GT(view.frames.size(), 50u);
  std::vector<std::string> moments;
  for (const View::Frame& frame : view.frames) {
    if (!frame.moment.empty()) moments.push_back(frame.moment);
  }
  EXPECT_EQ(moments, (std::vector<std::string>{"start", "pregrasp", "closed", "lifted", "delivered",
                                               "end"}));
  double of_object = 0.0;
  double of_rest = 0.0;
  for (const View::Body& body : view.bodies) {
    ASSERT_EQ(body.X_WB.size(), view.frames.size()) << body.name;
    double& furthest = body.layer == "objects as simulated" ? of_object : of_rest;
    furthest = std::max(furthest, Travel(body));
  }
  // The object is lifted by at least 100 mm and carried to another place.
  EXPECT_GT(of_object, 0.1);
  EXPECT_GT(of_rest, 0.1);
  const auto held = std::ranges::find(view.frames, std::string("lifted"), &View::Frame::moment);
  EXPECT_GE(held->forces.size(), 2u) << "a hand that holds presses from two sides";
}

}  // namespace
}  // namespace rangegrasp::trial
