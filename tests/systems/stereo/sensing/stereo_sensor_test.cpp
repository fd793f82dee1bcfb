#include "stereo/sensing/stereo_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rng.h"
#include "base/statistics.h"
#include "error_of.h"
#include "experiment/experiment.h"
#include "temp_folder.h"
#include "trial/grasping_task.h"
#include "trial/registry.h"
#include "trial/trial.h"

namespace rangegrasp::stereo {
namespace {

using trial::Arrangement;
using trial::ArrangeTrial;
using trial::Cell;
using trial::CellOf;
using trial::kLineScanner;
using trial::MakeLineScanner;
using trial::ReadSensorType;
using trial::Sensed;
using trial::Sensor;
using trial::StageStream;
using trial::TrialSeed;
using trial::TrialSpec;

// The cell's camera with an error-free calibration.
StereoSetup CalibratedSetup(const Cell& cell) {
  StereoSetup setup;
  const sensing::StereoCameraOptions& camera = setup.camera;
  const base::Pose& X_WS = cell.robot.X_WScanner;
  setup.calibration.camera = sensing::LensOf(camera);
  setup.calibration.X_WL = X_WS * sensing::CameraInHead(camera, camera.left_pan_rad);
  setup.calibration.X_WR = X_WS * sensing::CameraInHead(camera, camera.right_pan_rad);
  setup.reconstruct.table_W = cell.TablePlane();
  return setup;
}

// A stereo pair of a single salt box, with an error-free calibration: making a calibration takes
// seconds and is not tested here.
struct SaltBox {
  experiment::Experiment experiment =
      experiment::OpenExperiment(RANGEGRASP_SOURCE_DIR "/experiments/laser_single.yaml", {});
  const Cell& cell = CellOf(*experiment.task);
  TrialSpec spec{"salt_cuboid", 0, TrialSeed(11, "salt_cuboid", 0)};
  Arrangement arranged = *ArrangeTrial(cell, spec);
  StereoSensor sensor{CalibratedSetup(cell), cell.robot.X_WScanner};
  StereoLook look = Look();

  StereoLook Look() const {
    base::Rng rng = StageStream(spec.seed, "scan");
    return sensor.Look(arranged.world, rng);
  }
};

const SaltBox& TheLook() {
  static const SaltBox seen;
  return seen;
}

TEST(StereoSensor, PutsThePrintOfABoxWhereItIs) {
  const auto& look = TheLook().look;
  const auto& view = look.made.view;
  ASSERT_EQ(look.truth.label.size(), view.image.points_C.size());
  std::vector<double> errors_m;
  int seen = 0;
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    if (look.truth.label[i] != 1) continue;
    ++seen;
    if (!(view.noise_m[i] > 0.0F)) continue;
    errors_m.push_back(std::abs((view.image.points_C[i] - view.image.origins_C.front()).norm() -
                                look.truth.true_range_m[i]));
  }
  ASSERT_GT(seen, 500);
  EXPECT_GT(static_cast<double>(errors_m.size()), 0.8 * seen);
  // The pan error moves the whole cloud by a millimetre or two (docs/results.md).
  EXPECT_LT(base::MedianOf(errors_m), 0.005);
}

TEST(StereoSensor, TellsTheTableByItsColour) {
  const auto& look = TheLook().look;
  int on_table = 0, right = 0;
  for (std::size_t i = 0; i < look.made.view.noise_m.size(); ++i) {
    if (look.made.view.noise_m[i] != 0.0F) continue;
    ++on_table;
    right += look.truth.label[i] == 0 ? 1 : 0;
  }
  ASSERT_GT(on_table, 5000);
  EXPECT_GT(static_cast<double>(right), 0.98 * on_table);
}

TEST(StereoSensor, SeesTheSameTwice) {
  const StereoLook again = TheLook().Look();
  const StereoLook& before = TheLook().look;
  EXPECT_EQ(again.shot.photos.left.rgb, before.shot.photos.left.rgb);
  EXPECT_EQ(again.shot.photos.right.rgb, before.shot.photos.right.rgb);
  EXPECT_EQ(again.truth.label, before.truth.label);
}

using ::testing::HasSubstr;

// A single cube, seen by each sensor and by both, with an error-free calibration.
struct Looks {
  explicit Looks(const std::string& object)
      : spec{object, 0, TrialSeed(11, object, 0)}, arranged(*ArrangeTrial(cell, spec)) {}

  std::unique_ptr<Sensor> Laser() const { return MakeLineScanner(cell); }
  std::unique_ptr<Sensor> Stereo() const {
    return std::make_unique<StereoSensor>(CalibratedSetup(cell), cell.robot.X_WScanner);
  }
  Sensed By(const Sensor& sensor) const {
    base::Rng rng = StageStream(spec.seed, "scan");
    return sensor.Sense(arranged.world, rng);
  }
  Sensed ByBoth() const { return By(*MakeLaserAndStereo(Laser(), Stereo())); }

  experiment::Experiment experiment = experiment::OpenExperiment(
      RANGEGRASP_SOURCE_DIR "/experiments/laser_and_stereo_single.yaml", {});
  const Cell& cell = CellOf(*experiment.task);
  TrialSpec spec;
  Arrangement arranged;
};

// The number of samples of the cube in a view that are clear of the table.
int OfCube(const Sensed& sensed, std::size_t view) {
  int count = 0;
  const auto& points = sensed.observation.views[view].image.points_C;
  for (std::size_t i = 0; i < points.size(); ++i) {
    count += sensed.truth[view].label[i] == 1 && points[i].z() > 0.01 ? 1 : 0;
  }
  return count;
}

TEST(LaserAndStereo, ABlackCubeIsSeenByStereoAlone) {
  const Looks looks("black_cube");
  EXPECT_EQ(OfCube(looks.By(*looks.Laser()), 0), 0);
  const int stereo = OfCube(looks.By(*looks.Stereo()), 0);
  EXPECT_GT(stereo, 300);  // a face of 60 mm at 2 mm per sample has 900
  const Sensed both = looks.ByBoth();
  ASSERT_EQ(both.observation.views.size(), 2U);
  EXPECT_EQ(OfCube(both, 0), 0);
  EXPECT_GT(OfCube(both, 1), stereo / 2);  // a border of one gap around it is left out
  EXPECT_LE(OfCube(both, 1), stereo);
}

TEST(LaserAndStereo, OfAWhiteCubeTheLasersSamplesOutweigh) {
  const Looks looks("white_cube");
  const int laser = OfCube(looks.By(*looks.Laser()), 0);
  EXPECT_GT(laser, 500);
  const Sensed both = looks.ByBoth();
  EXPECT_EQ(OfCube(both, 0), laser);
  EXPECT_LT(OfCube(both, 1), laser / 2);
}

TEST(LaserAndStereo, EachLooksAsItWouldAlone) {
  const Looks looks("black_cube");
  const Sensed laser = looks.By(*looks.Laser()), stereo = looks.By(*looks.Stereo());
  const Sensed both = looks.ByBoth();
  const auto same = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return a == b || (!a.allFinite() && !b.allFinite());
  };
  const auto& filled = both.observation.views[1].image.points_C;
  const auto& alone = stereo.observation.views[0].image.points_C;
  for (std::size_t i = 0; i < filled.size(); ++i) {
    EXPECT_TRUE(!filled[i].allFinite() || filled[i] == alone[i]) << i;
  }
  EXPECT_TRUE(std::ranges::equal(both.observation.views[0].image.points_C,
                                 laser.observation.views[0].image.points_C, same));
}

TEST(SensorFiles, OfBothAreNamedInItsFile) {
  const std::filesystem::path sensors = RANGEGRASP_SOURCE_DIR "/models/sensors";
  EXPECT_EQ(ReadSensorType(sensors / "laser_and_stereo.yaml"), "laser_and_stereo");
  EXPECT_EQ(ReadSensorType(sensors / "stereo_camera.yaml"), "stereo_camera");
  EXPECT_EQ(ReadSensorType(sensors / "line_scanner.yaml"), kLineScanner);
  const BothFiles both = ReadBoth(sensors / "laser_and_stereo.yaml");
  EXPECT_EQ(both.laser, sensors / "line_scanner.yaml");
  EXPECT_EQ(both.stereo, sensors / "stereo_camera.yaml");
  const testing_support::TempFolder folder;
  const auto file = folder.Write("a.yaml", "type: laser_and_stereo\nlaser: b.yaml\n");
  EXPECT_THAT(testing_support::ErrorOf([&] { ReadBoth(file); }), HasSubstr("stereo"));
}

// Before its calibration, which takes seconds.
TEST(SensorFiles, ACameraThatTakesNoPairIsNamed) {
  const std::string file = RANGEGRASP_SOURCE_DIR "/models/sensors/wrist_camera.yaml";
  EXPECT_THAT(testing_support::ErrorOf([&] { StereoOf(TheLook().cell, file); }),
              HasSubstr(file + ": its right picture is taken"));
}

constexpr double kStep_m = 0.004;
constexpr int kSide = 60;

/// A view from above of a table of 240 mm, sampled in rows. Samples with blind(p) are not measured.
template <typename Blind>
geometry::View Seen(const Eigen::Vector3d& from, Blind blind) {
  geometry::View view;
  view.image.profiles = view.image.samples = kSide;
  view.image.origins_C = {from};
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      Eigen::Vector3d p(i * kStep_m, j * kStep_m, 0.0);
      if (blind(p)) p.setConstant(std::numeric_limits<double>::quiet_NaN());
      view.image.points_C.push_back(p);
    }
  }
  return view;
}

bool InPatch(const Eigen::Vector3d& p) {
  return p.x() > 0.08 && p.x() < 0.14 && p.y() > 0.08 && p.y() < 0.14;
}
bool Nowhere(const Eigen::Vector3d&) { return false; }

const Eigen::Vector3d kLaserEye(0.1, 0.1, 0.9);
const Eigen::Vector3d kCameraEye(0.2, 0.1, 0.9);

TEST(FillsAbsorbed, WhatNoRayOfTheLaserThatCameBackPassesBy) {
  const geometry::View stereo = Seen(kCameraEye, Nowhere);
  const auto kept = FillsAbsorbed(Seen(kLaserEye, InPatch), stereo);
  ASSERT_EQ(kept.size(), stereo.image.points_C.size());
  int inside = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Eigen::Vector3d& p = stereo.image.points_C[i];
    EXPECT_TRUE(!kept[i] || InPatch(p)) << p.transpose();
    // A border of one step may be left out, because returned rays pass close to it.
    const bool deep = p.x() > 0.086 && p.x() < 0.134 && p.y() > 0.086 && p.y() < 0.134;
    EXPECT_TRUE(!deep || kept[i]) << p.transpose();
    inside += kept[i] ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

TEST(FillsAbsorbed, NothingBehindOrInFrontOfWhatTheLaserSees) {
  for (const double height : {-0.05, 0.05}) {
    geometry::View stereo = Seen(kCameraEye, Nowhere);
    for (Eigen::Vector3d& p : stereo.image.points_C) p.z() = height;
    const auto kept = FillsAbsorbed(Seen(kLaserEye, Nowhere), stereo);
    // Only samples outside the laser's view, next to the table's rim, are kept.
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const Eigen::Vector3d p =
          kLaserEye + (stereo.image.points_C[i] - kLaserEye) * 0.9 / (0.9 - height);
      const bool in_view = p.head<2>().minCoeff() > 0.0 && p.head<2>().maxCoeff() < 0.236;
      EXPECT_FALSE(in_view && kept[i]) << p.transpose();
    }
  }
}

TEST(FillsAbsorbed, NoStraysOfTheStereoPair) {
  geometry::View stereo = Seen(kCameraEye, [](const Eigen::Vector3d& p) { return !InPatch(p); });
  const std::size_t corner = stereo.image.Index(0, 0);
  const Eigen::Vector3d middle(0.11, 0.11, 0.0);
  stereo.image.points_C[corner] = kLaserEye + 0.8 * (middle - kLaserEye);
  const auto kept = FillsAbsorbed(Seen(kLaserEye, InPatch), stereo);
  EXPECT_FALSE(kept[corner]);
  EXPECT_GT(std::count(kept.begin(), kept.end(), true), 100);
}

TEST(FillsAbsorbed, AllWhereTheLaserIsBlindEverywhere) {
  const auto everywhere = [](const Eigen::Vector3d&) { return true; };
  const auto kept = FillsAbsorbed(Seen(kLaserEye, everywhere), Seen(kCameraEye, Nowhere));
  EXPECT_EQ(std::count(kept.begin(), kept.end(), true), kSide * kSide);
}

}  // namespace
}  // namespace rangegrasp::stereo
