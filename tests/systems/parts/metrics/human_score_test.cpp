#include "parts/metrics/human_score.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/rng.h"
#include "error_of.h"
#include "parts/graphs.h"
#include "parts/shape/segmentation.h"
#include "parts/shape/shape_file.h"
#include "parts/solids.h"
#include "temp_folder.h"

namespace rangegrasp::parts {
namespace {

Labels RandomLabels(std::size_t n, int kinds, base::Rng& rng) {
  Labels labels(n);
  for (auto& label : labels) {
    label = static_cast<std::int32_t>(rng.Index(static_cast<std::size_t>(kinds)));
  }
  return labels;
}

// ---- 1 - Rand index ----

// By definition: the fraction of pairs of elements about which the two labelings disagree.
double RandErrorOfPairs(const Labels& a, const Labels& b) {
  std::size_t differ = 0;
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = i + 1; j < a.size(); ++j, ++pairs) {
      differ += (a[i] == a[j]) != (b[i] == b[j]) ? 1 : 0;
    }
  }
  return static_cast<double>(differ) / static_cast<double>(pairs);
}

TEST(RandError, IsTheShareOfPairsThatDoNotAgree) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    base::Rng rng(seed);
    const std::size_t n = 2 + rng.Index(40);
    const Labels a = RandomLabels(n, 1 + static_cast<int>(rng.Index(6)), rng);
    const Labels b = RandomLabels(n, 1 + static_cast<int>(rng.Index(6)), rng);
    EXPECT_NEAR(RandError(a, b), RandErrorOfPairs(a, b), 1e-12) << seed;
    EXPECT_EQ(RandError(a, b), RandError(b, a)) << seed;
  }
}

TEST(RandError, DependsOnTheSegmentsAndNotOnTheirNames) {
  const Labels a = {0, 0, 1, 1, 2};
  const Labels renamed = {7, 7, -3, -3, 1 << 30};
  EXPECT_EQ(RandError(a, renamed), 0.0);
  EXPECT_EQ(RandError(a, Labels(5, 0)), RandError(renamed, Labels(5, 4)));
}

TEST(RandError, OneSegmentAgainstOneEachIsEveryPair) {
  Labels each(1000);
  for (std::size_t i = 0; i < each.size(); ++i) each[i] = static_cast<std::int32_t>(i);
  EXPECT_EQ(RandError(Labels(1000, 5), each), 1.0);
}

TEST(RandError, CountsOfLargeMeshesDoNotOverflow) {
  // Two halves compared with one whole: N^2 / 4 of N (N - 1) / 2 pairs differ.
  const std::size_t n = 200000;
  Labels halves(n, 0);
  std::fill(halves.begin() + n / 2, halves.end(), 1);
  const double expected = 0.5 * static_cast<double>(n) / static_cast<double>(n - 1);
  EXPECT_NEAR(RandError(Labels(n, 0), halves), expected, 1e-12);
}

// ---- cut discrepancy ----

constexpr std::uint32_t kColumns = 12;
constexpr std::uint32_t kRows = 4;

// A flat strip of unit squares, each split into two faces; square (x, y) consists of faces 2 (y *
// columns + x) and the next one.
Shape Strip(double unit = 1.0) {
  Shape shape;
  for (std::uint32_t y = 0; y <= kRows; ++y) {
    for (std::uint32_t x = 0; x <= kColumns; ++x) shape.points.emplace_back(unit * x, unit * y, 0);
  }
  const auto at = [](std::uint32_t x, std::uint32_t y) { return y * (kColumns + 1) + x; };
  for (std::uint32_t y = 0; y < kRows; ++y) {
    for (std::uint32_t x = 0; x < kColumns; ++x) {
      shape.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
      shape.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
    }
  }
  return shape;
}

// Labels of a strip cut across at column `x`.
Labels CutAt(std::uint32_t x) {
  Labels labels;
  for (std::uint32_t f = 0; f < 2 * kRows * kColumns; ++f) {
    labels.push_back((f / 2) % kColumns < x ? 0 : 1);
  }
  return labels;
}

// Area-weighted mean distance from the faces' centers to the center of the strip.
double StripRadius() {
  double sum = 0.0;
  const Shape strip = Strip();
  for (std::size_t f = 0; f < strip.faces.size(); ++f) {
    const Eigen::Vector3d center = samples::FaceCenter(strip, f);
    sum += (center - Eigen::Vector3d(0.5 * kColumns, 0.5 * kRows, 0.0)).norm();
  }
  return sum / static_cast<double>(strip.faces.size());
}

TEST(CutDiscrepancy, OfParallelCutsIsTheirDistanceOverTheRadius) {
  // Each vertex of one cut is three edges away from the other cut, along its own row.
  const auto value = CutMeasure(Strip()).Discrepancy(CutAt(4), CutAt(7));
  ASSERT_TRUE(value);
  EXPECT_NEAR(*value, 3.0 / StripRadius(), 1e-12);
}

TEST(CutDiscrepancy, IsZeroOfEqualCutsHoweverTheyAreNamed) {
  Labels other = CutAt(4);
  for (auto& label : other) label = 9 - label;
  EXPECT_EQ(CutMeasure(Strip()).Discrepancy(CutAt(4), other).value(), 0.0);
}

TEST(CutDiscrepancy, DoesNotDependOnScale) {
  const double one = CutMeasure(Strip()).Discrepancy(CutAt(2), CutAt(9)).value();
  EXPECT_NEAR(CutMeasure(Strip(1e-3)).Discrepancy(CutAt(2), CutAt(9)).value(), one, 1e-12 * one);
}

TEST(CutDiscrepancy, IsUndefinedWithoutACut) {
  const Labels whole(2 * kRows * kColumns, 0);
  EXPECT_FALSE(CutMeasure(Strip()).Discrepancy(whole, CutAt(4)));
  EXPECT_FALSE(CutMeasure(Strip()).Discrepancy(CutAt(4), whole));
  EXPECT_FALSE(CutMeasure(Strip()).Discrepancy(whole, whole));
}

TEST(CutDiscrepancy, AcrossPiecesTheStraightDistanceCounts) {
  // Two strips one above the other, with no edge between them: each labeling cuts only one of them.
  Shape both = Strip();
  const auto n = static_cast<std::uint32_t>(both.points.size());
  const Shape one = Strip();
  for (const auto& p : one.points) both.points.emplace_back(p + Eigen::Vector3d(0, 0, 5));
  for (const auto& [a, b, c] : one.faces) both.faces.push_back({a + n, b + n, c + n});
  Labels below = CutAt(4), above(CutAt(4).size(), 0);
  const Labels cut = CutAt(4);
  below.insert(below.end(), cut.size(), 0);
  above.insert(above.end(), cut.begin(), cut.end());
  double sum = 0.0;
  for (std::size_t f = 0; f < both.faces.size(); ++f) {
    sum += (samples::FaceCenter(both, f) - Eigen::Vector3d(6, 2, 2.5)).norm();
  }
  const double radius = sum / static_cast<double>(both.faces.size());
  EXPECT_NEAR(CutMeasure(both).Discrepancy(below, above).value(), 5.0 / radius, 1e-12);
}

// The definition, using all distances between all vertices.
std::optional<double> DiscrepancyOfAllPairs(const Shape& mesh, const Labels& a, const Labels& b) {
  const std::size_t n = mesh.points.size();
  Eigen::MatrixXd distance =
      Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n), 1e30);
  std::set<std::uint32_t> cut[2];
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t u = mesh.faces[f][static_cast<std::size_t>(i)];
      const std::uint32_t v = mesh.faces[f][static_cast<std::size_t>((i + 1) % 3)];
      distance(u, v) = distance(v, u) = (mesh.points[u] - mesh.points[v]).norm();
      distance(u, u) = distance(v, v) = 0.0;
      for (std::size_t g = 0; g < mesh.faces.size(); ++g) {
        const auto& other = mesh.faces[g];
        if (std::count(other.begin(), other.end(), u) + std::count(other.begin(), other.end(), v) <
            2) {
          continue;
        }
        if (a[f] != a[g]) cut[0].insert({u, v});
        if (b[f] != b[g]) cut[1].insert({u, v});
      }
    }
  }
  samples::Shorten(distance);
  if (cut[0].empty() || cut[1].empty()) return std::nullopt;
  double sum = 0.0;
  for (const int way : {0, 1}) {
    for (const std::uint32_t from : cut[way]) {
      double nearest = 1e30;
      for (const std::uint32_t to : cut[1 - way]) nearest = std::min(nearest, distance(from, to));
      sum += nearest;
    }
  }
  double area = 0.0, moment = 0.0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (const bool second : {false, true}) {
    for (const auto& [i, j, k] : mesh.faces) {
      const auto& p = mesh.points;
      const double one = 0.5 * (p[j] - p[i]).cross(p[k] - p[i]).norm();
      const Eigen::Vector3d center = (p[i] + p[j] + p[k]) / 3.0;
      if (second) {
        moment += one * (center - centroid / area).norm();
      } else {
        area += one;
        centroid += one * center;
      }
    }
  }
  return sum / static_cast<double>(cut[0].size() + cut[1].size()) / (moment / area);
}

TEST(CutDiscrepancy, IsThatOfAllPairsOfCutVertices) {
  const Shape ball = samples::Ball(3, [](const Eigen::Vector3d& p) { return 1.0 + 0.5 * p.x(); });
  const CutMeasure measure(ball);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    base::Rng rng(seed);
    // Few labels in stripes, so that cuts are sometimes far apart and sometimes absent.
    const auto Stripes = [&] {
      Labels labels(ball.faces.size(), 0);
      const std::size_t first = rng.Index(labels.size());
      const std::size_t length = rng.Index(12);
      for (std::size_t f = first; f < std::min(first + length, labels.size()); ++f) labels[f] = 1;
      return labels;
    };
    const Labels a = Stripes();
    const Labels b = Stripes();
    const auto fast = measure.Discrepancy(a, b);
    const auto slow = DiscrepancyOfAllPairs(ball, a, b);
    ASSERT_EQ(fast.has_value(), slow.has_value()) << seed;
    if (!fast) continue;
    EXPECT_NEAR(*fast, *slow, 1e-9) << seed;
  }
}

// ---- the benchmark's own numbers ----

struct Published {
  int id;
  double rand_error, cut_discrepancy;
};

TEST(Metrics, AreThoseOfTheBenchmarksEvaluator) {
  const std::filesystem::path folder =
      std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared/data/psb";
  if (!std::filesystem::exists(folder / "off")) {
    GTEST_SKIP() << "no benchmark data in " << folder.lexically_normal();
  }
  for (const auto& [id, rand_error, cut_discrepancy] :
       {Published{61, 0.165133, 0.100326}, Published{21, 0.033997, 0.219850},
        Published{361, 0.103395, 0.102497}}) {
    const std::string name = std::to_string(id);
    const Shape shape = ReadShape(folder / "off" / (name + ".off"));
    const CutMeasure measure(shape);
    const auto seg = folder / "seg" / name;
    const Labels first = ReadLabels(seg / (name + "_0.seg"), shape.Elements());
    double rand = 0.0;
    double cut = 0.0;
    for (int k = 1; k <= 4; ++k) {
      const auto file = seg / (name + "_" + std::to_string(k) + ".seg");
      const Labels other = ReadLabels(file, shape.Elements());
      rand += 0.25 * RandError(first, other);
      cut += 0.25 * measure.Discrepancy(first, other).value();
    }
    // The numbers were printed with six digits.
    EXPECT_NEAR(rand, rand_error, 1e-6) << id;
    EXPECT_NEAR(cut, cut_discrepancy, 1e-6) << id;
  }
}

using testing_support::TempFolder;

// A square pyramid, and a last face without area.
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
  ASSERT_EQ(model.shape.faces.size(), 6U);  // without the face without area
  Segmentation found;
  found.label = {0, 0, 1, 1, 0, 0};
  found.parts = 2;
  const HumanScore score = ScoreAgainstHumans(model, found);
  // The face without area takes the label of the nearest face. This is one of the faces at the edge
  // from 0 to 1, which all have label 0.
  const std::vector<std::int32_t> of_input = {0, 0, 1, 1, 0, 0, 0};
  EXPECT_DOUBLE_EQ(score.rand_error, 0.5 * (RandError(of_input, model.humans[0]) +
                                            RandError(of_input, model.humans[1])));
  // The second labeling has no cut between the faces that were kept.
  ASSERT_TRUE(score.cut_discrepancy);
  EXPECT_DOUBLE_EQ(*score.cut_discrepancy,
                   *CutMeasure(model.shape).Discrepancy(found.label, Labels{5, 5, 1, 1, 5, 1}));
  found.label.assign(6, 0);
  EXPECT_FALSE(ScoreAgainstHumans(model, found).cut_discrepancy);
}

TEST_F(HumanScoreTest, AFlatModelIsRefusedWithItsFile) {
  folder_.Write("off/8.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n");
  EXPECT_THAT(testing_support::ErrorOf([&] { ReadHumanModel(folder_.path(), 8); }),
              ::testing::HasSubstr("8.off: all of its points lie in one plane"));
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
