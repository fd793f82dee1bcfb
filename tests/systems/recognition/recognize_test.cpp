#include "recognition/recognize.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "base/units.h"
#include "perception/perceive.h"
#include "perception/raster_scan.h"

namespace rangegrasp::recognition {
namespace {

using Eigen::Vector3d;
using geometry::TriangleMesh;

/// Meshes centered at the origin.
std::vector<KnownObject> Objects() {
  return {
      MakeKnownObject("box", "Box", synthetic::BoxMesh(0.09, 0.06, 0.135)),
      MakeKnownObject("small_box", "Small", synthetic::BoxMesh(0.075, 0.045, 0.12)),
      MakeKnownObject("can", "Can", synthetic::CylinderMesh(0.035, 0.115)),
      MakeKnownObject("mug", "Mug", synthetic::MugMesh()),
      MakeKnownObject("prism", "Prism", synthetic::Extrude(synthetic::Regular(3, 0.035), 0.16))};
}

const Library& Shelf() {
  static const Library library(Objects());
  return library;
}

struct Looked {
  geometry::Observation observation;
  perception::Scene scene;
};

Looked LookAt(const std::vector<TriangleMesh>& meshes_W, std::uint64_t seed,
              const Vector3d& sensor_W = synthetic::RasterOptions().sensor_W) {
  synthetic::RasterOptions options;
  options.sensor_W = sensor_W;
  options.seed = seed;
  const auto scan = synthetic::MakeRasterScan(meshes_W, options);
  geometry::RangeImage image;
  image.profiles = 1;
  image.samples = static_cast<int>(scan.points_W.size());
  image.points_C = scan.points_W;
  image.origins_C = {options.sensor_W};
  Looked looked{geometry::ObservationOf(std::move(image)), {}};
  looked.observation.views.front().X_CV.translation() = options.sensor_W;
  base::Rng rng(seed);
  looked.scene = perception::Perceive(looked.observation, {}, rng);
  return looked;
}

std::vector<FoundObject> Find(const Looked& looked, const Library& library) {
  return Recognize(looked.observation, looked.scene, library, {});
}

struct Placed {
  std::string name;
  base::Pose X_WB;
};

class SeededRecognition : public testing::TestWithParam<int> {
 protected:
  // A place for one of each object, at a random yaw; the mug's handle is on the visible side.
  std::vector<Placed> Places() const {
    base::Rng rng(static_cast<std::uint64_t>(GetParam()));
    const auto yaw = [&] { return rng.Uniform(0.0, 2.0 * base::kPi); };
    const auto at = [&](double height) {
      const double x = rng.Uniform(-0.04, 0.04);
      return Vector3d(x, rng.Uniform(-0.04, 0.04), height);
    };
    std::vector<Placed> placed;
    placed.push_back({"box", synthetic::Standing(yaw(), at(0.0675))});
    placed.push_back({"box", synthetic::Lying(yaw(), at(0.03))});
    placed.push_back({"small_box", synthetic::Standing(yaw(), at(0.06))});
    placed.push_back({"can", synthetic::Standing(yaw(), at(0.0575))});
    placed.push_back({"can", synthetic::Lying(yaw(), at(0.035))});
    placed.push_back({"mug", synthetic::Standing(rng.Uniform(-1.2, 1.2), at(0.0))});
    return placed;
  }
};

// Noise is 0.4 mm and the smallest face has about 300 samples, which gives the pose to fractions of
// a millimetre. Where only a silhouette determines it, the accuracy is a pixel (1.8 mm).
TEST_P(SeededRecognition, TellsAnObjectAloneAndItsPose) {
  for (const Placed& placed : Places()) {
    const KnownObject& known = Shelf().Find(placed.name);
    const auto looked = LookAt({geometry::Transformed(known.mesh_B, placed.X_WB)},
                               static_cast<std::uint64_t>(GetParam()));
    const auto found = Find(looked, Shelf());
    ASSERT_EQ(found.size(), 1u) << placed.name;
    EXPECT_EQ(found[0].object, placed.name);
    const PoseDifference off = Difference(found[0].X_CB, placed.X_WB, known.symmetry);
    EXPECT_LT(off.distance_m, 0.003) << placed.name;
    EXPECT_LT(off.angle_rad, base::Deg(3.0)) << placed.name;
    EXPECT_LT(found[0].violations, 0.05) << placed.name;
  }
}

TEST_P(SeededRecognition, LeavesAnotherObjectUnknown) {
  // The last one is a can 5 mm wider and 35 mm higher than the known one.
  const auto others = {synthetic::BoxMesh(0.105, 0.075, 0.105),
                       synthetic::CylinderMesh(0.045, 0.09), synthetic::CylinderMesh(0.0375, 0.15)};
  for (const TriangleMesh& other : others) {
    const double half = other.vertices.back().z();
    const base::Pose X_WB = synthetic::Standing(0.3 * GetParam(), {0.0, 0.0, half});
    const auto looked =
        LookAt({geometry::Transformed(other, X_WB)}, static_cast<std::uint64_t>(GetParam()));
    ASSERT_FALSE(looked.scene.objects.empty());
    for (const FoundObject& found : Find(looked, Shelf())) {
      ADD_FAILURE() << "taken for " << found.object << ", score " << found.score << ", seen "
                    << found.share_seen << ", violations " << found.violations << ", rms "
                    << found.rms_m;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SeededRecognition, testing::Range(1, 6));

bool Same(const std::vector<FoundObject>& a, const std::vector<FoundObject>& b) {
  return std::ranges::equal(a, b, [](const FoundObject& x, const FoundObject& y) {
    return x.object == y.object && x.X_CB.matrix() == y.X_CB.matrix() && x.score == y.score &&
           x.samples == y.samples;
  });
}

TEST(Recognize, OrderOfTheLibraryPlaysNoPart) {
  auto objects = Objects();
  std::ranges::reverse(objects);
  const Library reversed(std::move(objects));
  const auto can =
      geometry::Transformed(Shelf().Find("can").mesh_B, synthetic::Lying(0.7, {0.08, 0.0, 0.035}));
  const auto box = geometry::Transformed(Shelf().Find("box").mesh_B,
                                         synthetic::Standing(0.3, {-0.05, 0.0, 0.0675}));
  const auto looked = LookAt({can, box}, 7);
  const auto found = Find(looked, Shelf());
  EXPECT_EQ(found.size(), 2u);
  EXPECT_TRUE(Same(found, Find(looked, reversed)));
  EXPECT_TRUE(Same(found, Find(looked, Shelf())));
}

// A mug's rotation is ambiguous if its handle is hidden behind it from a low sensor. An ambiguous
// pose must be looked at again.
TEST(Recognize, APoseIsOpenWhereTheHandleIsHidden) {
  for (const bool shown : {false, true}) {
    const base::Pose X_WB = synthetic::Standing(shown ? 0.6 : base::kPi, {0.0, 0.0, 0.0});
    const auto looked =
        LookAt({geometry::Transformed(Shelf().Find("mug").mesh_B, X_WB)}, 2, {0.9, 0.0, 0.3});
    const auto found = Find(looked, Shelf());
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].alternatives_CB.empty(), shown);
    EXPECT_EQ(OpenObjects(looked.scene, found, {}).empty(), shown);
  }
}

// A can and a box next to each other.
TriangleMesh CanAside() {
  return geometry::Transformed(Shelf().Find("can").mesh_B,
                               synthetic::Standing(0.0, {0.06, 0.07, 0.0575}));
}
TriangleMesh BoxAside() {
  return geometry::Transformed(Shelf().Find("box").mesh_B,
                               synthetic::Standing(0.3, {-0.05, -0.05, 0.0675}));
}

std::multiset<std::string> NamesOf(const std::vector<FoundObject>& found) {
  std::multiset<std::string> names;
  for (const FoundObject& one : found) names.insert(one.object);
  return names;
}

// Points that a crop left out of an unordered cloud are not rays that did not return.
TEST(Recognize, PointsLeftOutOfAnUnorderedCloudPlayNoPart) {
  const auto looked = LookAt({CanAside()}, 3);
  const auto found = Find(looked, Shelf());
  ASSERT_EQ(found.size(), 1u);
  Looked gaps = looked;
  geometry::RangeImage& image = gaps.observation.views.front().image;
  image.points_C.clear();
  for (const Vector3d& p : looked.observation.views.front().image.points_C) {
    image.points_C.push_back(p);
    image.points_C.emplace_back(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  image.samples *= 2;
  for (auto& id : gaps.scene.samples) id.sample *= 2;
  const auto with_gaps = Find(gaps, Shelf());
  ASSERT_EQ(with_gaps.size(), 1u);
  EXPECT_EQ(with_gaps[0].object, "can");
  EXPECT_EQ(with_gaps[0].score, found[0].score);
}

// With more points, two objects form one segment: an earlier result is kept, and the rest of the
// segment is the other object. An earlier result is dropped if the view sees through its place.
TEST(Recognize, WhatWasFoundBeforeStaysAsLongAsTheViewsAgree) {
  auto looked = LookAt({CanAside(), BoxAside()}, 3);
  const auto before = Find(looked, Shelf());
  ASSERT_EQ(before.size(), 2u);
  auto& objects = looked.scene.objects;
  for (std::size_t i = 1; i < objects.size(); ++i) {
    std::ranges::copy(objects[i].points, std::back_inserter(objects[0].points));
  }
  objects.resize(1);
  const auto names = [&](std::vector<FoundObject> known) {
    return NamesOf(Recognize(looked.observation, looked.scene, Shelf(), {}, known));
  };
  EXPECT_LT(names({}).size(), 2u);
  EXPECT_EQ(names({before[0]}), (std::multiset<std::string>{"box", "can"}));
  auto elsewhere = before;
  for (FoundObject& one : elsewhere) {
    one.X_CB = Eigen::Translation3d(0.0, 0.12 * (one.object == "can" ? -1.0 : 1.0), 0.0) * one.X_CB;
    one.samples.clear();
  }
  EXPECT_LT(names(elsewhere).size(), 2u);
}

// What is found again in the same pose keeps its rival's score; anything else is compared with all.
TEST(Recognize, WhatIsKnownIsConfirmedInItsPose) {
  const Looked looked = LookAt({CanAside(), BoxAside()}, 3);
  auto known = Find(looked, Shelf());
  std::erase_if(known, [](const FoundObject& one) { return one.object != "box"; });
  ASSERT_EQ(known.size(), 1u);
  constexpr double kRival = 0.123;
  known[0].runner_up = kRival;
  const auto confirmed = [&](const FoundObject& before) {
    const auto found = Recognize(looked.observation, looked.scene, Shelf(), {}, {before});
    EXPECT_EQ(NamesOf(found), (std::multiset<std::string>{"box", "can"}));
    std::multiset<std::string> kept;
    for (const FoundObject& one : found) {
      if (one.runner_up == kRival) kept.insert(one.object);
    }
    return kept;
  };
  EXPECT_EQ(confirmed(known[0]), (std::multiset<std::string>{"box"}));
  FoundObject moved = known[0];
  moved.X_CB = Eigen::Translation3d(0.01, 0.0, 0.0) * moved.X_CB;
  EXPECT_TRUE(confirmed(moved).empty());
  FoundObject misnamed = known[0];
  misnamed.object = "mug";
  EXPECT_TRUE(confirmed(misnamed).empty());
  FoundObject doubtful = known[0];  // its rival was nearly as good as it is now
  doubtful.runner_up = doubtful.score;
  EXPECT_TRUE(confirmed(doubtful).empty());
}

// In another scan from the same place, objects that have not moved are known before they are found
// again. Objects that were taken away are not.
TEST(Recognize, WhatHasNotMovedIsKnownInAnotherScan) {
  auto before = Find(LookAt({CanAside(), BoxAside()}, 3), Shelf());
  ASSERT_EQ(before.size(), 2u);
  before[0].samples.push_back({.view = 1, .sample = 7});
  const auto kept = AsFirstSeen(before);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].samples.size() + 1, before[0].samples.size());
  before[0].samples = {{.view = 1, .sample = 7}};
  EXPECT_EQ(AsFirstSeen(before).size(), 1u);
  RecognitionOptions finds_nothing;
  finds_nothing.min_score = 1.1;
  const auto names = [&](const Looked& looked) {
    return NamesOf(Recognize(looked.observation, looked.scene, Shelf(), finds_nothing, kept));
  };
  EXPECT_EQ(names(LookAt({CanAside(), BoxAside()}, 4)), (std::multiset<std::string>{"box", "can"}));
  EXPECT_EQ(names(LookAt({BoxAside()}, 4)), (std::multiset<std::string>{"box"}));
}

// Pairs of points vote for poses of a round body that slide along it and roll into the table during
// registration. The body in its true resting pose must also be registered.
TEST(Recognize, AHalfCylinderOnItsFaceIsFoundAtEachTurn) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i <= 32; ++i) {
    const double a = -0.5 * base::kPi + base::kPi * i / 32.0;
    profile.emplace_back(0.04 * std::cos(a), 0.04 * std::sin(a));
  }
  const Library library({MakeKnownObject("half", "Half", synthetic::Extrude(profile, 0.17))});
  const base::Pose onto_face(Eigen::AngleAxisd(-0.5 * base::kPi, Vector3d::UnitY()));
  for (int k = 0; k < 12; ++k) {
    const base::Pose X_WB = synthetic::Standing(base::kPi * k / 12, {-0.07, 0.01, 0.0}) * onto_face;
    const auto looked = LookAt({geometry::Transformed(library.Find("half").mesh_B, X_WB)}, 1);
    const auto found = Find(looked, library);
    ASSERT_EQ(found.size(), 1u) << k;
    const auto off = Difference(found[0].X_CB, X_WB, library.Find("half").symmetry);
    EXPECT_LT(off.distance_m, 0.003) << k;
    EXPECT_LT(off.angle_rad, base::Deg(3.0)) << k;
  }
}

constexpr geometry::Rgb kRed{200, 30, 30}, kBlue{30, 60, 180}, kWhite{245, 245, 240};

geometry::MeshColors Plain(const TriangleMesh& mesh, const geometry::Rgb& color) {
  geometry::MeshColors colors;
  colors.plain.assign(mesh.triangles.size(), color);
  return colors;
}

/// Gives each sample the color it would have in half the light.
void Paint(Looked& looked, const std::function<geometry::Rgb(const Vector3d&)>& color_at_W) {
  geometry::View& view = looked.observation.views.front();
  for (const Vector3d& p : view.image.points_C) {
    view.colors.push_back(geometry::ColorOf(0.5 * geometry::LightOf(color_at_W(p))));
  }
}

// Boxes of the same shape printed in different colors: shape alone leaves the name ambiguous. An
// object that looks like neither is neither.
TEST(Recognize, ColorsTellTwinsApart) {
  const TriangleMesh mesh = synthetic::BoxMesh(0.09, 0.06, 0.135);
  const Library library({MakeKnownObject("red", "Red", mesh, Plain(mesh, kRed)),
                         MakeKnownObject("blue", "Blue", mesh, Plain(mesh, kBlue))});
  const base::Pose X_WB = synthetic::Standing(0.4, {0.0, 0.0, 0.0675});
  const auto names = [&](const std::optional<geometry::Rgb>& color, double weight) {
    auto looked = LookAt({geometry::Transformed(mesh, X_WB)}, 1);
    if (color) Paint(looked, [&](const Vector3d& p) { return p.z() > 0.002 ? *color : kWhite; });
    RecognitionOptions options;
    options.color_weight = weight;
    return NamesOf(Recognize(looked.observation, looked.scene, library, options));
  };
  EXPECT_THAT(names(kRed, 0.5), testing::ElementsAre("red"));
  EXPECT_THAT(names(kBlue, 0.5), testing::ElementsAre("blue"));
  EXPECT_THAT(names(geometry::Rgb{40, 150, 60}, 0.5), testing::IsEmpty());
  EXPECT_THAT(names(std::nullopt, 0.5), testing::IsEmpty());
  EXPECT_THAT(names(kRed, 0.0), testing::IsEmpty());
}

// The print resolves the rotation of a mug with a hidden handle. It also gives a can's rotation,
// which its shape does not determine.
TEST(Recognize, ThePrintSettlesATurn) {
  // The can's lid is red like one of its sides, so that its ends differ.
  const auto at = [](const Vector3d& p) {
    return p.y() > 0.0 || std::abs(p.z() - 0.0575) < 0.002 ? kRed : kWhite;
  };
  const auto striped = [&](const TriangleMesh& mesh) {
    geometry::MeshColors colors;
    for (const auto& triangle : mesh.triangles) {
      Vector3d middle = Vector3d::Zero();
      for (const auto corner : triangle) middle += mesh.vertices[corner] / 3.0;
      colors.plain.push_back(at(middle));
    }
    return colors;
  };
  for (const char* name : {"mug", "can"}) {
    const TriangleMesh& mesh = Shelf().Find(name).mesh_B;
    const Library library({MakeKnownObject(name, name, mesh, striped(mesh))});
    const bool mug = std::string(name) == "mug";
    for (const double turn : {2.8, 3.3}) {
      const base::Pose X_WB = synthetic::Standing(turn, {0.0, 0.0, mug ? 0.0 : 0.0575});
      // The handle is hidden from a low sensor; the lid is seen from above.
      const Vector3d sensor_W(0.9, 0.0, mug ? 0.3 : 0.7);
      auto looked = LookAt({geometry::Transformed(mesh, X_WB)}, 2, sensor_W);
      Paint(looked, [&](const Vector3d& p) { return at(X_WB.inverse() * p); });
      const auto found = Find(looked, library);
      ASSERT_EQ(found.size(), 1u) << name;
      EXPECT_GT(found[0].color, 0.9) << name;
      EXPECT_TRUE(found[0].alternatives_CB.empty()) << name;
      const Eigen::AngleAxisd off((found[0].X_CB.linear().transpose() * X_WB.linear()).eval());
      EXPECT_LT(off.angle(), base::Deg(4.0)) << name << " turned by " << turn;
    }
  }
}

TEST(Recognize, ColorsOfAnotherMeshAreRefused) {
  const TriangleMesh mesh = synthetic::BoxMesh(0.09, 0.06, 0.135);
  geometry::MeshColors colors = Plain(mesh, kRed);
  colors.plain.pop_back();
  EXPECT_THROW(MakeKnownObject("box", "Box", mesh, colors), std::invalid_argument);
}

TEST(Recognize, WhatIsLeftOutIsAsIfTheLibraryLackedIt) {
  const auto looked = LookAt({CanAside(), BoxAside()}, 3);
  auto objects = Objects();
  std::erase_if(objects, [](const KnownObject& one) { return one.name == "can"; });
  RecognitionOptions options;
  options.left_out = "can";
  const auto found = Recognize(looked.observation, looked.scene, Shelf(), options);
  EXPECT_TRUE(NamesOf(found).contains("box"));
  EXPECT_FALSE(NamesOf(found).contains("can"));
  EXPECT_TRUE(Same(found, Find(looked, Library(std::move(objects)))));
}

TEST(Recognize, AnUnknownObjectHasItsNearestKnownOneAndAReason) {
  const auto looked = LookAt({BoxAside()}, 3);
  std::vector<UnknownObject> unknown;
  RecognitionOptions options;
  const auto recognize = [&] {
    return Recognize(looked.observation, looked.scene, Shelf(), options, {}, &unknown);
  };
  const auto found = recognize();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(unknown.empty());
  options.min_share_seen = 1.1;  // which no scan reaches
  EXPECT_TRUE(recognize().empty());
  ASSERT_EQ(unknown.size(), 1u);
  EXPECT_EQ(unknown[0].object, 0u);
  EXPECT_EQ(unknown[0].nearest, "box");
  EXPECT_EQ(unknown[0].score, found[0].score);
  EXPECT_THAT(unknown[0].reason, testing::HasSubstr("at least 110 % is needed"));
  options.min_score = 2.0;  // even the guesses are hopeless
  EXPECT_TRUE(recognize().empty());
  ASSERT_EQ(unknown.size(), 1u);
  EXPECT_FALSE(unknown[0].nearest.empty());
  EXPECT_THAT(unknown[0].reason, testing::HasSubstr("at least 2.00"));
  options.min_samples = looked.scene.objects[0].points.size() + 1;
  EXPECT_TRUE(recognize().empty());
  ASSERT_EQ(unknown.size(), 1u);
  EXPECT_TRUE(unknown[0].nearest.empty());
  EXPECT_THAT(unknown[0].reason, testing::HasSubstr("points"));
}

TEST(Recognize, AnEmptyLibraryKnowsNothing) {
  EXPECT_TRUE(Find(LookAt({BoxAside()}, 1), Library({})).empty());
}

}  // namespace
}  // namespace rangegrasp::recognition
