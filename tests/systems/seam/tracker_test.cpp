#include "seam/tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/rng.h"
#include "error_of.h"
#include "seam/decision.h"
#include "temp_folder.h"

namespace rangegrasp::seam {
namespace {

using base::InputError;
using base::Rng;
using testing::HasSubstr;
using testing_support::ErrorOf;
using testing_support::TempFolder;

constexpr float kTrackerNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kTrackerPeriod_s = 0.016;

struct Line {
  double step_m = 0.6e-3;
  double edge = 500.0;  // column
  double tilt = 0.01;
  double noise_m = 0.02e-3;
  double lost = 0.02;
};

Profile TrackerScan(const Line& line, double time_s, Rng& rng) {
  Profile profile;
  profile.time_s = time_s;
  for (int i = 0; i < 1024; ++i) {
    const double z = 1e-3 + line.tilt * i / 12'000.0 + (i >= line.edge ? line.step_m : 0.0) +
                     line.noise_m * rng.Normal();
    profile.height_m.push_back(rng.Uniform() < line.lost ? kTrackerNone : static_cast<float>(z));
  }
  return profile;
}

TrackerOptions With(DecisionMethod method) {
  TrackerOptions options;
  options.method = method;
  return options;
}

class EveryDecision : public testing::TestWithParam<DecisionMethod> {};

INSTANTIATE_TEST_SUITE_P(Methods, EveryDecision,
                         testing::Values(DecisionMethod::kVoting, DecisionMethod::kWeights,
                                         DecisionMethod::kSteps));

TEST(TrackedSteps, FollowsAnEdgeThatWanders) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    EdgeTracker tracker(With(DecisionMethod::kSteps));
    for (int i = 0; i < 60; ++i) {
      Line line;
      line.edge = std::round(500.0 + 60.0 * std::sin(0.05 * i));
      const Reading reading = tracker.Update(TrackerScan(line, kTrackerPeriod_s * i, rng));
      if (i < 3) continue;  // a single first step is not trusted
      ASSERT_EQ(reading.status, ProfileStatus::kEdge) << seed << " " << i;
      // 12 px are 1 mm.
      EXPECT_NEAR(*reading.column, line.edge, 12.0) << seed << " " << i;
      EXPECT_DOUBLE_EQ(reading.x_m, LineGeometry{}.ToMeters(*reading.column));
      EXPECT_NEAR(reading.step_m, line.step_m, 0.15e-3);
    }
  }
}

TEST(TrackedSteps, TellsNoEdgeOnAMatWithoutOne) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    EdgeTracker tracker(With(DecisionMethod::kSteps));
    Line line;
    line.step_m = 0.0;
    for (int i = 0; i < 60; ++i) {
      const Reading reading = tracker.Update(TrackerScan(line, kTrackerPeriod_s * i, rng));
      EXPECT_EQ(reading.status, ProfileStatus::kNoEdge);
      EXPECT_FALSE(reading.column);
    }
  }
}

// With noise of 0.2 mm, the range of heights exceeds the minimal step everywhere.
TEST(TrackedSteps, TellsNoEdgeInHeavyNoise) {
  int told = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    EdgeTracker tracker(With(DecisionMethod::kSteps));
    Line line;
    line.step_m = 0.0;
    line.noise_m = 0.2e-3;
    for (int i = 0; i < 60; ++i) {
      told += tracker.Update(TrackerScan(line, kTrackerPeriod_s * i, rng)).status ==
              ProfileStatus::kNoEdge;
    }
  }
  EXPECT_GE(told, 1188);  // 99 % of 1200
}

struct WeightedPosition {
  double time_s, column;
  float weight;
};

std::optional<double> HighestOf(const std::vector<WeightedPosition>& positions) {
  const auto highest = std::ranges::max_element(positions, {}, &WeightedPosition::weight);
  return highest == positions.end() ? std::nullopt : std::optional(highest->column);
}

// Eq. 3.17: the position with the highest weight of all that were detected in 100 ms. A reading
// takes those of the last 100 ms, a packet those since the last packet. The edge moves, so each
// profile has another position; every sixth profile and the last 20 show none.
TEST(EdgeTracker, WeightsReportTheHighestOfAPeriod) {
  Rng rng(12);
  EdgeTracker tracker(With(DecisionMethod::kWeights));
  std::vector<WeightedPosition> last, since_packet;
  int of_another = 0;
  int packets = 0;
  for (int i = 0; i < 60; ++i) {
    const bool edge = i < 40 && i % 6 != 5;
    const Line line{.step_m = edge ? 0.6e-3 : 0.0, .edge = 500.0 + i};
    const Reading reading = tracker.Update(TrackerScan(line, kTrackerPeriod_s * i, rng));
    const auto& weight = tracker.weight();
    const auto best = std::ranges::max_element(weight);
    const auto column = static_cast<int>(best - weight.begin());
    const bool step = StepHeight(tracker.prepared().height_m, column) >= 0.3e-3;
    EXPECT_EQ(step, edge) << i;
    if (step) {
      last.push_back({reading.time_s, static_cast<double>(column), *best});
      since_packet.push_back(last.back());
    }
    std::erase_if(last, [&](const auto& p) { return p.time_s < reading.time_s - 0.1; });
    EXPECT_EQ(reading.column, HighestOf(last)) << i;
    // Six periods of 16 ms are 96 ms.
    EXPECT_EQ(reading.status == ProfileStatus::kEdge, i <= 39 + 6) << i;
    if (reading.column) {
      EXPECT_EQ(reading.goes_on, step) << i;
      of_another += *reading.column == column ? 0 : 1;
    }
    if (const auto packet = tracker.TakePacket()) {
      EXPECT_EQ(packet->column, HighestOf(since_packet)) << i;
      since_packet.clear();
      ++packets;
    }
  }
  // At least the profiles that show no edge.
  EXPECT_GE(of_another, 6);
  EXPECT_GE(packets, 8);
}

// Section 3.4 demands no height of a vote; section 3.5.3 does, for weights.
TEST(EdgeTracker, VotesCountAtAnyHeightAndWeightsAt03Mm) {
  Rng rng(13);
  EdgeTracker voting(With(DecisionMethod::kVoting));
  EdgeTracker weights(With(DecisionMethod::kWeights));
  const Line low{.step_m = 0.15e-3, .noise_m = 0.01e-3};
  for (int i = 0; i < 20; ++i) {
    const Profile profile = TrackerScan(low, kTrackerPeriod_s * i, rng);
    const Reading reading = voting.Update(profile);
    ASSERT_EQ(reading.status, ProfileStatus::kEdge) << i;
    EXPECT_NEAR(*reading.column, low.edge, 12.0) << i;
    EXPECT_LT(reading.step_m, 0.3e-3) << i;
    EXPECT_EQ(weights.Update(profile).status, ProfileStatus::kNoEdge) << i;
  }
}

// Readings of voting for an edge at each of these columns, within one period.
std::vector<Reading> VotingReadingsOf(const std::vector<double>& edges) {
  Rng rng(14);
  EdgeTracker tracker(With(DecisionMethod::kVoting));
  std::vector<Reading> readings;
  for (const double edge : edges) {
    const double time_s = kTrackerPeriod_s * static_cast<double>(readings.size());
    readings.push_back(tracker.Update(TrackerScan({.edge = edge}, time_s, rng)));
  }
  return readings;
}

// 16 columns per profile are 1000 per second. Section 3.4 states no limit.
TEST(EdgeTracker, ALineOfVotesMayBeSteep) {
  const auto readings = VotingReadingsOf({500.0, 516.0, 532.0, 548.0, 564.0, 200.0});
  ASSERT_TRUE(readings.back().column);
  EXPECT_NEAR(*readings.back().column, 580.0, 12.0);
}

// The line of the first three votes is at column 1300 in the fourth profile.
TEST(EdgeTracker, ALineThatLeavesTheProfileIsNoEdge) {
  const auto readings = VotingReadingsOf({100.0, 500.0, 900.0, 50.0});
  EXPECT_TRUE(readings[2].column);
  EXPECT_FALSE(readings[3].column);
}

TEST(TrackedSteps, OneDisturbedProfileMovesNothing) {
  Rng rng(1);
  EdgeTracker tracker(With(DecisionMethod::kSteps));
  const Line line;
  for (int i = 0; i < 20; ++i) {
    Profile profile = TrackerScan(line, kTrackerPeriod_s * i, rng);
    if (i == 12) {
      for (std::size_t k = 200; k < 500; ++k) profile.height_m[k] += 2e-3F;
    }
    const Reading reading = tracker.Update(profile);
    if (i < 3) continue;
    if (reading.column) {
      EXPECT_NEAR(*reading.column, line.edge, 12.0) << i;
    } else {
      EXPECT_EQ(i, 12);
    }
  }
}

TEST_P(EveryDecision, AMirroredProfileHasItsEdgeMirrored) {
  TrackerOptions mirrored = With(GetParam());
  mirrored.positive_edge = false;
  EdgeTracker tracker(With(GetParam()));
  EdgeTracker other(mirrored);
  Rng rng(2);
  for (int i = 0; i < 30; ++i) {
    Profile profile = TrackerScan({}, kTrackerPeriod_s * i, rng);
    const Reading reading = tracker.Update(profile);
    std::reverse(profile.height_m.begin(), profile.height_m.end());
    const Reading back = other.Update(profile);
    ASSERT_EQ(reading.status, back.status);
    ASSERT_EQ(reading.column.has_value(), back.column.has_value());
    if (reading.column) {
      EXPECT_DOUBLE_EQ(*back.column, 1023.0 - *reading.column);
    }
    const auto packet = tracker.TakePacket();
    const auto packet_back = other.TakePacket();
    ASSERT_EQ(packet.has_value(), packet_back.has_value());
    if (packet && packet->column) {
      EXPECT_DOUBLE_EQ(*packet_back->column, 1023.0 - *packet->column);
    }
  }
}

TEST(TrackedSteps, SendsAPacketEveryPeriodWithAPositionOfIt) {
  Rng rng(3);
  EdgeTracker tracker(With(DecisionMethod::kSteps));
  std::vector<EdgePacket> packets;
  std::vector<Reading> readings;
  for (int i = 0; i <= 100; ++i) {
    readings.push_back(tracker.Update(TrackerScan({}, 0.01 * i, rng)));
    if (auto packet = tracker.TakePacket()) packets.push_back(*packet);
    EXPECT_FALSE(tracker.TakePacket());  // taken
  }
  ASSERT_EQ(packets.size(), 10U);
  for (const EdgePacket& packet : packets) {
    ASSERT_TRUE(packet.column);
    const auto same = std::find_if(readings.begin(), readings.end(), [&](const Reading& r) {
      return r.time_s == packet.time_s && r.column == packet.column;
    });
    EXPECT_NE(same, readings.end());
  }
}

TEST_P(EveryDecision, ProfilesWithoutPointsAreUnusableAndDoNotEndIt) {
  Rng rng(4);
  EdgeTracker tracker(With(GetParam()));
  for (int i = 0; i < 40; ++i) {
    Profile profile = TrackerScan({}, kTrackerPeriod_s * i, rng);
    const bool empty = i % 4 == 3;
    if (empty) profile.height_m.assign(1024, kTrackerNone);
    const Reading reading = tracker.Update(profile);
    if (empty) {
      EXPECT_EQ(reading.status, ProfileStatus::kUnusable);
    }
    if (!empty && i > 8) {
      EXPECT_EQ(reading.status, ProfileStatus::kEdge) << i;
    }
  }
}

TEST(EdgeTracker, VotingIsTheLineThroughTheVotesOfAPeriod) {
  Rng rng(6);
  TrackerOptions options = With(DecisionMethod::kVoting);
  EdgeTracker tracker(options);
  std::vector<TimedColumn> votes;
  for (int i = 0; i < 6; ++i) {  // within one period, so nothing has been sent yet
    Line line;
    line.edge = 500.0 + i;
    const Reading reading = tracker.Update(TrackerScan(line, kTrackerPeriod_s * i, rng));
    const auto vote = VoteTwoOfThree(reading.detected, 12.0);
    ASSERT_TRUE(vote);
    votes.push_back({reading.time_s, *vote});
    const auto line_fit = PredictByLine(votes, reading.time_s, options.inlier_columns);
    EXPECT_DOUBLE_EQ(*reading.column, *line_fit);
  }
}

TEST(EdgeTracker, WeightsAreThoseOfEquation320) {
  Rng rng(7);
  const TrackerOptions options = With(DecisionMethod::kWeights);
  EdgeTracker tracker(options);
  std::vector<double> history;
  for (int i = 0; i < 30; ++i) {
    // The edge moves because the mean of equal positions does not show how many there are.
    tracker.Update(TrackerScan({.edge = 500.0 + i}, kTrackerPeriod_s * i, rng));
    auto expected = SumOfWeights(tracker.results());
    WeightByHistory(expected, history, options.history_sigma_columns);
    EXPECT_EQ(tracker.weight(), expected);
    const auto best = std::max_element(expected.begin(), expected.end()) - expected.begin();
    if (StepHeight(tracker.prepared().height_m, static_cast<int>(best)) < 0.3e-3) continue;
    history.push_back(static_cast<double>(best));
    if (history.size() > 10) history.erase(history.begin());
  }
  EXPECT_EQ(history.size(), 10U);
}

TEST_P(EveryDecision, APeriodWithoutAnEdgeSendsNone) {
  Rng rng(9);
  EdgeTracker tracker(With(GetParam()));
  for (int i = 0; i <= 20; ++i) tracker.Update(TrackerScan({}, 0.01 * i, rng));
  ASSERT_TRUE(tracker.TakePacket()->column);
  std::optional<EdgePacket> packet;
  for (int i = 21; i <= 30; ++i) {
    tracker.Update({.height_m = std::vector<float>(1024, kTrackerNone), .time_s = 0.01 * i});
    if (auto one = tracker.TakePacket()) packet = one;
  }
  ASSERT_TRUE(packet);
  EXPECT_FALSE(packet->column);
}

// Columns outside the measured part do not belong to the profile, but columns are counted over the
// whole line.
TEST_P(EveryDecision, ColumnsAreThoseOfTheLineThoughItsBeginningIsMissing) {
  Rng rng(10);
  EdgeTracker tracker(With(GetParam()));
  for (int i = 0; i < 10; ++i) {
    Profile profile = TrackerScan({}, kTrackerPeriod_s * i, rng);
    std::fill_n(profile.height_m.begin(), 200, kTrackerNone);
    const Reading reading = tracker.Update(profile);
    std::vector<std::optional<int>> detected(reading.detected.begin(), reading.detected.end());
    if (GetParam() == DecisionMethod::kSteps) detected = {reading.local_step};
    for (const auto& column : detected) {
      ASSERT_TRUE(column);
      EXPECT_NEAR(*column, 500, 12);
    }
    if (i < 3) continue;
    ASSERT_TRUE(reading.column);
    EXPECT_NEAR(*reading.column, 500.0, 12.0);
  }
}

// Profiles do not coincide with the ends of periods: six of 16 ms take 96 ms, seven take 112 ms.
TEST_P(EveryDecision, PacketsKeepTheirPeriodOnTheAverage) {
  Rng rng(1);
  EdgeTracker tracker(With(GetParam()));
  int packets = 0;
  constexpr int kTrackedProfiles = 625;  // 10 s
  for (int i = 0; i < kTrackedProfiles; ++i) {
    tracker.Update(TrackerScan({}, kTrackerPeriod_s * i, rng));
    packets += tracker.TakePacket() ? 1 : 0;
  }
  EXPECT_EQ(packets, 99);
}

TEST(TrackedSteps, ASlowSensorFindsTheEdgeToo) {
  for (const double rate_hz : {1.0, 5.0, 9.0}) {
    Rng rng(1);
    EdgeTracker tracker(With(DecisionMethod::kSteps));
    for (int i = 0; i < 12; ++i) {
      const Reading reading = tracker.Update(TrackerScan({}, i / rate_hz, rng));
      if (i < 3) continue;
      ASSERT_EQ(reading.status, ProfileStatus::kEdge) << rate_hz << " " << i;
      EXPECT_NEAR(*reading.column, 500.0, 12.0);
      const auto packet = tracker.TakePacket();
      ASSERT_TRUE(packet && packet->column) << rate_hz << " " << i;
      EXPECT_DOUBLE_EQ(packet->x_m, reading.x_m);
    }
  }
}

TEST_P(EveryDecision, AFastSensorFindsTheEdgeToo) {
  Rng rng(1);
  EdgeTracker tracker(With(GetParam()));
  for (int i = 0; i < 400; ++i) {
    const Reading reading = tracker.Update(TrackerScan({}, i / 2000.0, rng));
    if (i < 3) continue;
    ASSERT_EQ(reading.status, ProfileStatus::kEdge) << i;
    EXPECT_NEAR(*reading.column, 500.0, 12.0);
  }
}

TEST(TrackedSteps, ASingleProfileAnswers) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    const TrackerOptions options = With(DecisionMethod::kSteps);
    const Reading reading = EdgeTracker(options).Update(TrackerScan({}, 0.0, rng));
    ASSERT_EQ(reading.status, ProfileStatus::kEdge) << seed;
    EXPECT_NEAR(*reading.column, 500.0, 12.0);
    Line flat;
    flat.step_m = 0.0;
    EXPECT_EQ(EdgeTracker(options).Update(TrackerScan(flat, 0.0, rng)).status,
              ProfileStatus::kNoEdge);
  }
}

// Columns are wider where the surface is further away.
TEST(TrackedSteps, XIsOfTheHeightWhereTheEdgeIs) {
  Calibration calibration;
  calibration.meters_per_column = {1.0 / 12'000.0, -1.0 / 2'400.0};  // 7.5 % more at -15 mm
  for (const bool positive : {true, false}) {
    Rng rng(1);
    TrackerOptions options = With(DecisionMethod::kSteps);
    options.positive_edge = positive;
    EdgeTracker tracker(options, calibration);
    Line line;
    line.tilt = 0.0;
    line.edge = 860.0;
    for (int i = 0; i < 20; ++i) {
      Profile profile = TrackerScan(line, kTrackerPeriod_s * i, rng);
      for (float& z : profile.height_m) z -= 16e-3F;  // -15 mm, as the line itself adds 1 mm
      if (!positive) std::reverse(profile.height_m.begin(), profile.height_m.end());
      const Reading reading = tracker.Update(profile);
      const auto packet = tracker.TakePacket();
      if (i < 3) continue;
      ASSERT_TRUE(reading.column) << i;
      const double wanted = (*reading.column - 511.5) * 1.075 / 12'000.0;
      // The height may be from either side of the step; its 0.6 mm change the width by 0.3 %.
      EXPECT_NEAR(reading.x_m, wanted, 4e-3 * std::abs(wanted)) << i;
      EXPECT_GT(std::abs(reading.x_m), 30e-3);
      if (packet) {
        EXPECT_NEAR(packet->x_m, wanted, 0.1e-3) << i;
      }
    }
  }
}

// An edge 2 mm wide, seen at different numbers of columns per mm with the noise of one sensor.
TEST(TrackedSteps, ASlantedEdgeIsFoundAtAnyResolution) {
  for (const double columns_per_mm : {6.0, 12.0, 18.0, 40.0, 80.0}) {
    Rng rng(1);
    TrackerOptions options = With(DecisionMethod::kSteps);
    options.line = {.columns = static_cast<int>(60.0 * columns_per_mm),
                    .columns_per_m = 1000.0 * columns_per_mm};
    EdgeTracker tracker(options);
    int found = 0;
    constexpr int kTrackedProfiles = 40;
    for (int i = 0; i < kTrackedProfiles; ++i) {
      Profile profile;
      profile.time_s = kTrackerPeriod_s * i;
      for (int c = 0; c < options.line.columns; ++c) {
        const double x_mm = c / columns_per_mm - 30.0;
        const double share = std::clamp(0.5 + x_mm / 2.0, 0.0, 1.0);
        profile.height_m.push_back(static_cast<float>(0.8e-3 * share + 0.03e-3 * rng.Normal()));
      }
      const Reading reading = tracker.Update(profile);
      found += reading.column && std::abs(*reading.column / columns_per_mm - 30.0) <= 1.0 ? 1 : 0;
    }
    EXPECT_GE(found, kTrackedProfiles - 4) << columns_per_mm;
  }
}

TEST(EdgeTracker, RefusesProfilesThatAreNotTheSensors) {
  EdgeTracker tracker({});
  EXPECT_THROW(tracker.Update({.height_m = std::vector<float>(1000, 0.0F), .time_s = 0.0}),
               InputError);
  tracker.Update({.height_m = std::vector<float>(1024, 0.0F), .time_s = 1.0});
  EXPECT_THROW(tracker.Update({.height_m = std::vector<float>(1024, 0.0F), .time_s = 0.5}),
               InputError);
  EXPECT_THROW(tracker.Update({.height_m = std::vector<float>(1024, 0.0F),
                               .time_s = std::numeric_limits<double>::quiet_NaN()}),
               InputError);
}

TEST(EdgeTracker, AnyFiniteOrInfiniteHeightsAreTaken) {
  for (const auto method : {DecisionMethod::kVoting, DecisionMethod::kWeights}) {
    EdgeTracker tracker(With(method));
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      Rng rng(seed);
      Profile profile = TrackerScan({}, static_cast<double>(seed), rng);
      for (float& z : profile.height_m) {
        const double kind = rng.Uniform();
        if (kind < 0.1) z = std::numeric_limits<float>::infinity();
        if (kind > 0.9) z = -std::numeric_limits<float>::infinity();
        if (kind > 0.4 && kind < 0.4 + 1e-3 * static_cast<double>(seed)) z = 1e30F;
      }
      const Reading reading = tracker.Update(profile);
      if (reading.column) {
        EXPECT_TRUE(std::isfinite(*reading.column));
      }
    }
  }
}

TrackerOptions OptionsIn(const std::filesystem::path& file) {
  TrackerOptions options;
  auto map = base::YamlMap::FromFile(file);
  ReadTrackerOptions(map, options);
  map.Finish();
  return options;
}

TEST(TrackerOptionsFile, ReadsEveryKeyAndNamesABadOne) {
  const TempFolder folder;
  const auto file = folder.Write("t.yaml",
                                 "method: weights\n"
                                 "columns_per_mm: 18\n"
                                 "step_track:\n  min_step_mm: 0.5\n");
  const auto options = OptionsIn(file);
  EXPECT_EQ(options.method, DecisionMethod::kWeights);
  EXPECT_DOUBLE_EQ(options.line.columns_per_m, 18'000.0);
  EXPECT_DOUBLE_EQ(options.step_track.min_step_m, 0.5e-3);
  for (const auto& [text, says] : std::vector<std::pair<std::string, std::string>>{
           {"methud: weights\n", "methud"},
           {"method: accumulated\n", "voting, weights, steps"},
           {"step_track:\n  min_step_mm: -1\n", "min_step_mm"},
           {"packet_period_ms: many\n", "packet_period_ms"}}) {
    folder.Write("t.yaml", text);
    EXPECT_THAT(ErrorOf([&] { OptionsIn(file); }),
                testing::AllOf(HasSubstr(file.string() + ":"), HasSubstr(says)))
        << text;
  }
}

TEST(EdgeTracker, RefusesALineThatIsTooCoarseForTrackedSteps) {
  TrackerOptions options = With(DecisionMethod::kSteps);
  options.line.columns_per_m = 1000.0;  // the narrowest window would have three columns per side
  EXPECT_THROW(EdgeTracker{options}, std::invalid_argument);
}

}  // namespace
}  // namespace rangegrasp::seam
