// Lower bounds of the headline results: with separate seeds, 24 trials must reach the rate measured
// on many more trials (docs/results.md) minus three standard deviations of a share of 24. A bound
// detects what breaks, not what gets slightly worse.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "experiment/store.h"

namespace rangegrasp {
namespace {

using testing_support::RunProgram;
using testing_support::TempFolder;

constexpr const char* kSeed = "20001";  // used nowhere else

/// The smallest allowed count in n trials for a rate.
double Floor(double rate, int n) { return n * (rate - 3.0 * std::sqrt(rate * (1.0 - rate) / n)); }

struct Rates {
  const char* experiment;
  int trials;  ///< per object, of twelve objects
  double detection;
  double grasping;  ///< rate among the detected objects
};

nlohmann::json Overall(const std::string& experiment, const std::vector<std::string>& more) {
  const TempFolder folder;
  std::vector<std::string> arguments = {
      "run",    RANGEGRASP_SOURCE_DIR "/experiments/" + experiment + ".yaml",
      "--seed", kSeed,
      "--out",  folder / "out",
      "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return nlohmann::json::parse(Succeeded(RunProgram(arguments)).out)["overall"];
}

void ExpectReached(const Rates& rates) {
  const auto overall = Overall(rates.experiment, {"--trials", std::to_string(rates.trials)});
  const int trials = overall["trials"], detected = overall["detected"],
            delivered = overall["delivered"];
  ASSERT_EQ(trials, 12 * rates.trials);
  EXPECT_GE(detected, Floor(rates.detection, trials)) << overall;
  EXPECT_GE(delivered, Floor(rates.grasping, detected)) << overall;
}

// Rates from docs/results.md.
TEST(Floors, ObjectsAlone) { ExpectReached({"laser_single", 2, 0.997, 0.940}); }
TEST(Floors, TouchingObjects) { ExpectReached({"laser_touching", 2, 0.950, 0.813}); }
TEST(Floors, ObjectsInABox) { ExpectReached({"laser_box", 2, 0.892, 0.766}); }
TEST(Floors, ObjectsInAPile) { ExpectReached({"laser_pile", 2, 0.950, 0.816}); }
TEST(Floors, ObjectsInAPileSeenByStereo) { ExpectReached({"stereo_pile", 1, 0.786, 0.707}); }

// The bound is high enough: the published method finds three of ten touching objects.
TEST(FloorsAreHigh, WithoutTheAdditionsTouchingObjectsStayBelow) {
  const auto overall = Overall("laser_touching", {"--trials", "2", "--set", "method=published"});
  EXPECT_LT(overall["detected"].get<int>(), Floor(0.950, 24)) << overall;
}

std::vector<experiment::Record> Records(const std::string& experiment, const std::string& trials) {
  const TempFolder folder;
  const std::string out = folder / "out";
  Succeeded(RunProgram({"run", RANGEGRASP_SOURCE_DIR "/experiments/" + experiment + ".yaml",
                        "--seed", kSeed, "--trials", trials, "--out", out}));
  return experiment::Store::Open(out).ReadAll();
}

int HandedOver(const std::vector<experiment::Record>& records) {
  return static_cast<int>(std::ranges::count_if(
      records, [](const auto& record) { return record.result.outcome == "handed_over"; }));
}

// Rate from docs/cylinders.md: 397 of 400 runs.
TEST(FloorsOfTheDemo, CylindersAreHandedOver) {
  const auto records = Records("cylinder_demo", "24");
  ASSERT_EQ(records.size(), 24u);
  EXPECT_GE(HandedOver(records), Floor(0.992, 24));
}

// Rate from docs/known-objects.md: 97.8 % of 180 runs among touching objects.
TEST(FloorsOfBring, ObjectsAreHandedOver) {
  const auto records = Records("bring", "1");
  ASSERT_EQ(records.size(), 12u);
  EXPECT_GE(HandedOver(records), Floor(0.978, 12));
}

// Two piles of twelve; the rate is 90.0 % of the objects of 100 piles.
TEST(FloorsOfClearing, ObjectsOfPilesAreDelivered) {
  const auto records = Records("clear_pile", "2");
  ASSERT_EQ(records.size(), 2u);
  int delivered = 0;
  for (const auto& record : records) {
    delivered += nlohmann::json::parse(record.result.data)["delivered"].get<int>();
  }
  EXPECT_GE(delivered, Floor(0.900, 24));
}

}  // namespace
}  // namespace rangegrasp
