#include "parts/metrics/human_score.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "parts/metrics/rand_error.h"
#include "parts/shape/shape_file.h"
#include "temp_folder.h"

namespace rangegrasp::parts {
namespace {

using testing_support::TempFolder;

// A square pyramid, and a last face that has no area.
class HumanScoreTest : public ::testing::Test {
 protected:
  HumanScoreTest() {
    folder_.Write("off/7.off",
                  "OFF\n5 7 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n"
                  "3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n3 2 1 0\n3 3 2 0\n3 1 1 0\n");
    folder_.Write("seg/7/7_9.seg", "5\n5\n1\n1\n5\n1\n5\n");
    folder_.Write("seg/7/7_10.seg", "0\n0\n0\n0\n0\n0\n1\n");
    folder_.Write("seg/7/70_1.seg", "not one of model 7");
    folder_.Write("seg/7/7_1.txt", "no segmentation");
  }
  TempFolder folder_;
};

TEST_F(HumanScoreTest, SegmentationsStandInTheOrderOfTheirNumbers) {
  const auto files = HumanFiles(folder_.path(), 7);
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files[0].filename(), "7_9.seg");
  EXPECT_EQ(files[1].filename(), "7_10.seg");
  EXPECT_TRUE(HumanFiles(folder_.path(), 8).empty());
}

TEST_F(HumanScoreTest, IsTheMeanOverTheHumansWhereItIsDefined) {
  const HumanModel model = ReadHumanModel(folder_.path(), 7);
  ASSERT_EQ(model.shape.faces.size(), 6U);  // without that of no area
  EXPECT_EQ(model.humans_of_shape[0], (std::vector<std::int32_t>{5, 5, 1, 1, 5, 1}));
  Segmentation found;
  found.label = {0, 0, 1, 1, 0, 0};
  found.parts = 2;
  const HumanScore score = ScoreAgainstHumans(model, found);
  // The face without area takes the label of the nearest face, one of those at the edge from 0 to
  // 1, which are all 0.
  const std::vector<std::int32_t> of_input = {0, 0, 1, 1, 0, 0, 0};
  EXPECT_DOUBLE_EQ(score.rand_error, 0.5 * (RandError(of_input, model.humans[0]) +
                                            RandError(of_input, model.humans[1])));
  // The second sees no cut between the faces that were kept.
  ASSERT_TRUE(score.cut_discrepancy);
  EXPECT_DOUBLE_EQ(*score.cut_discrepancy,
                   *CutDiscrepancy(model.shape, found.label, model.humans_of_shape[0]));
  found.label.assign(6, 0);
  EXPECT_FALSE(ScoreAgainstHumans(model, found).cut_discrepancy);
}

TEST_F(HumanScoreTest, TheMeanNumberOfSegmentsLeavesOutWhatCannotBeRead) {
  EXPECT_EQ(MeanHumanSegments(folder_.path(), std::vector{7}), 2);
  folder_.Write("seg/8/8_0.seg", "0\n1\n2\n3\n4\n5\n6\n");  // 2, 2 and 7 segments
  folder_.Write("seg/8/8_1.seg", "rubbish\n");
  EXPECT_EQ(MeanHumanSegments(folder_.path(), std::vector{7, 8}), 4);
  EXPECT_EQ(MeanHumanSegments(folder_.path(), std::vector{9}), 1);
}

}  // namespace
}  // namespace rangegrasp::parts
