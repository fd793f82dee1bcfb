#include "grasp/internal/closing.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "geometry/random_points.h"
#include "grasp/fixtures.h"
#include "grasp/internal/placing.h"
#include "grasp/surface.h"

namespace rangegrasp::grasp::internal {
namespace {

using namespace test;

/// A box with a width along x, its top at z = -15 mm and its bottom at 60 mm, in the frame T.
SurfaceSamples BoxBetweenThePads(double width_m, double x_m) {
  auto mesh = Extrude(Rectangle(width_m, 0.08), 0.075);
  return SampleSurface(geometry::Transformed(mesh, Move(x_m, 0.0, -0.015)), 10000);
}

TEST(IndexAtGap, IsTheNearestOneAbove) {
  const auto& hand = Hand();
  for (double gap = 0.005; gap < 0.1; gap += 0.007) {
    const std::size_t s = hand.IndexAtGap(gap);
    EXPECT_GE(hand.states[s].gap_m, gap);
    if (s + 1 < hand.states.size()) {
      EXPECT_LT(hand.states[s + 1].gap_m, gap);
    }
  }
  EXPECT_EQ(hand.IndexAtGap(0.5), 0u);
}

TEST(HandProfiles, APositivePitchTakesTheThumbDown) {
  const auto& open = Hand().states[0];
  for (const double pitch : {0.0, 0.1, 0.25}) {
    const base::Pose X_TH = HandProfiles::X_TH(Hand(), pitch);
    const Vector3d line = X_TH * open.thumb_pad_H - X_TH * open.finger_pad_H;
    // At pitch 0, the tips are level within 1 mm.
    EXPECT_NEAR(line.z(), std::sin(pitch) * line.norm(), 0.0015);
    EXPECT_GT(line.x(), 0.09);
  }
}

TEST(HandProfiles, FieldsAgreeWithTheShapes) {
  HandProfiles profiles(Hand());
  const double pitch = 0.15;
  const auto& inner = profiles.InnerSide(pitch, 5);
  const auto& state = Hand().states[5];
  const base::Pose X_TH = HandProfiles::X_TH(Hand(), pitch);
  int covered = 0;
  for (int j = 0; j < inner.grid.nv; ++j) {
    for (int i = 0; i < inner.grid.nu; ++i) {
      const double y = inner.grid.u0_m + (i + 0.5) * inner.grid.cell_m;
      const double z = inner.grid.v0_m + (j + 0.5) * inner.grid.cell_m;
      const double x = inner.thumb[static_cast<std::size_t>(j * inner.grid.nu + i)];
      if (!std::isfinite(x)) continue;
      ++covered;
      // Distance of the field's point to the nearest thumb capsule's surface.
      double nearest = 1.0;
      for (std::size_t k = 0; k < state.shapes.size(); ++k) {
        const auto& shape = state.shapes[k];
        if (!state.is_thumb[k]) continue;
        const Vector3d q = (X_TH * shape.X_BS).inverse() * Vector3d(x, y, z);
        const double along = std::clamp(q.z(), -shape.size.y(), shape.size.y());
        nearest = std::min(nearest, (q - Vector3d(0, 0, along)).norm() - shape.size.x());
      }
      // With 12 sides, facets are up to r (1 - cos 15 deg) = 0.34 mm inside, and twice that at a
      // capsule's end, which is faceted in both directions.
      EXPECT_NEAR(nearest, 0.0, 0.0008);
    }
  }
  EXPECT_GT(covered, 300);
}

TEST(CloseOn, FindsTheWidthAndTheFacesOfABox) {
  HandProfiles profiles(Hand());
  for (const double width : {0.03, 0.045, 0.06, 0.075}) {
    const auto box = BoxBetweenThePads(width, 0.0);
    const auto closing =
        CloseOn(profiles, 0.14, 0, box.points, box.normals, box.area_m2, Vector3d::Zero());
    ASSERT_TRUE(closing);
    EXPECT_NEAR(closing->thumb_T.x() - closing->finger_T.x(), width, 1e-6);
    EXPECT_GT(closing->thumb_out_T.x(), 0.999);
    EXPECT_LT(closing->finger_out_T.x(), -0.999);
    // The gap is measured between the capsules. Leaning pads do not touch at their nearest points:
    // up to r (1 / cos 25 deg - 1) = 2 mm on both sides, plus 0.7 mm for facets.
    EXPECT_NEAR(closing->gap_m, width, 0.003);
  }
}

TEST(CloseOn, DragsWhatIsNotMidway) {
  HandProfiles profiles(Hand());
  const auto at = [&](double x) {
    const auto box = BoxBetweenThePads(0.05, x);
    return CloseOn(profiles, 0.14, 0, box.points, box.normals, box.area_m2, Vector3d::Zero())
        .value();
  };
  const double here = at(0.0).drag_m;
  // A box 6 mm nearer to the thumb is dragged 6 mm further towards the fingers.
  EXPECT_NEAR(at(0.006).drag_m, here - 0.006, 5e-4);
  EXPECT_NEAR(at(-0.006).drag_m, here + 0.006, 5e-4);
}

TEST(CloseOn, NeedsBothSides) {
  HandProfiles profiles(Hand());
  // A sheet far below the tips.
  const auto box = BoxBetweenThePads(0.05, 0.0);
  EXPECT_FALSE(
      CloseOn(profiles, 0.0, 0, box.points, box.normals, box.area_m2, Vector3d(0.0, 0.0, -0.1)));
}

TEST(Antipodal, MatchesTheAngleOfACylindersChord) {
  // For a chord at height h of a circle of radius R, both normals are asin(h / R) off the chord.
  const double R = 0.035;
  for (const double h : {0.0, 0.005, 0.02}) {
    const double x = std::sqrt(R * R - h * h);
    const Vector3d finger(-x, 0.0, h), thumb(x, 0.0, h);
    const auto angles = Antipodal(finger, finger / R, thumb, thumb / R);
    EXPECT_NEAR(angles.finger_rad, std::asin(h / R), 1e-12);
    EXPECT_NEAR(angles.thumb_rad, std::asin(h / R), 1e-12);
  }
}

TEST(Antipodal, MatchesTheDirectFormula) {
  base::Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d f = geometry::samples::RandomVector(rng);
    const Vector3d t = geometry::samples::RandomVector(rng);
    const Vector3d nf = geometry::samples::RandomDirection(rng);
    const Vector3d nt = geometry::samples::RandomDirection(rng);
    const auto angles = Antipodal(f, nf, t, nt);
    EXPECT_NEAR(std::cos(angles.finger_rad), -nf.dot(t - f) / (t - f).norm(), 1e-12);
    EXPECT_NEAR(std::cos(angles.thumb_rad), nt.dot(t - f) / (t - f).norm(), 1e-12);
  }
}

/// The formula of internal/placing.h, term by term.
double Transcribed(const Quality& q, double cone_rad, const ScoreWeights& w) {
  const auto square = [](double x) { return x * x; };
  const double A =
      std::min(4.0, square(std::max(q.angles.finger_rad, q.angles.thumb_rad) / cone_rad));
  const double P = std::min(4.0, square((q.pitch_rad - q.best_pitch_rad) / w.pitch_scale_rad));
  const double L = std::min(4.0, square(q.lever_m / w.lever_scale_m));
  const double H =
      std::min(2.0, square(q.above_m / (q.above_m > 0.0 ? w.above_scale_m : w.below_scale_m)));
  const double D = std::min(2.0, std::abs(q.drag_m) / w.drag_scale_m);
  const double S = std::min(2.0, std::abs(q.slope_m) / w.slope_scale_m);
  const double missing = (w.margin_m - q.top_margin_m) / w.margin_m;
  const double M = missing < 0.0 ? 0.0 : std::min(2.0, missing);
  const double R = q.room_m >= w.room_scale_m ? 0.0
                   : q.room_m <= 0.0          ? 1.0
                                              : square(1.0 - q.room_m / w.room_scale_m);
  const double T = std::min(1.0, q.contact_m2 / w.contact_scale_m2);
  return 1.0 - w.antipodal * A - w.pitch * P - w.lever * L - w.height * H - w.drag * D -
         w.slope * S - w.shallow * M - w.room * R + w.tight * T + w.arm * q.thumb_to_arm;
}

// Values within and beyond the bounds of every term, with weights that distinguish the terms.
TEST(Score, IsTheSumOfItsTerms) {
  base::Rng rng(8);
  ScoreWeights odd;
  for (double* value : {&odd.antipodal, &odd.pitch, &odd.lever, &odd.height, &odd.drag, &odd.slope,
                        &odd.shallow, &odd.tight, &odd.room, &odd.arm, &odd.margin_m}) {
    *value *= rng.Uniform(0.5, 2.0);
  }
  for (int i = 0; i < 2000; ++i) {
    Quality q;
    q.angles.finger_rad = rng.Uniform(0.0, 1.5);
    q.angles.thumb_rad = rng.Uniform(0.0, 1.5);
    q.pitch_rad = rng.Uniform(-0.3, 0.5);
    q.best_pitch_rad = rng.Uniform(0.0, 0.3);
    q.lever_m = rng.Uniform(0.0, 0.06);
    q.above_m = rng.Uniform(-0.1, 0.1);
    q.drag_m = rng.Uniform(-0.05, 0.05);
    q.slope_m = rng.Uniform(-0.06, 0.06);
    q.top_margin_m = rng.Uniform(-0.03, 0.03);
    q.contact_m2 = rng.Uniform(0.0, 6e-4);
    q.room_m = rng.Uniform(-0.01, 0.03);
    q.thumb_to_arm = rng.Uniform(-1.0, 1.0);
    for (const ScoreWeights& weights : {ScoreWeights{}, odd}) {
      EXPECT_NEAR(Score(q, 0.46, weights), Transcribed(q, 0.46, weights), 1e-12) << i;
    }
  }
}

TEST(Score, FallsWithEveryFlaw) {
  Quality good;
  good.top_margin_m = 0.03;
  good.room_m = 0.03;
  good.contact_m2 = 4e-4;
  const double best = Score(good, 0.46, {});
  EXPECT_NEAR(best, 1.0 + ScoreWeights{}.tight, 1e-12);
  const auto with = [&](auto change) {
    Quality q = good;
    change(q);
    return Score(q, 0.46, {});
  };
  EXPECT_LT(with([](Quality& q) { q.angles.thumb_rad = 0.1; }), best);
  EXPECT_LT(with([](Quality& q) { q.angles.finger_rad = 0.1; }), best);
  EXPECT_LT(with([](Quality& q) { q.pitch_rad = 0.1; }), best);
  EXPECT_LT(with([](Quality& q) { q.lever_m = 0.01; }), best);
  EXPECT_LT(with([](Quality& q) { q.above_m = 0.01; }), best);
  EXPECT_LT(with([](Quality& q) { q.above_m = -0.01; }), best);
  EXPECT_LT(with([](Quality& q) { q.drag_m = -0.01; }), best);
  EXPECT_LT(with([](Quality& q) { q.slope_m = -0.01; }), best);
  EXPECT_LT(with([](Quality& q) { q.top_margin_m = 0.005; }), best);
  EXPECT_LT(with([](Quality& q) { q.room_m = 0.005; }), best);
  EXPECT_LT(with([](Quality& q) { q.contact_m2 = 1e-4; }), best);
  EXPECT_LT(with([](Quality& q) { q.thumb_to_arm = -0.5; }), best);
  // At the edge of the friction cone the term is its weight.
  EXPECT_NEAR(with([](Quality& q) { q.angles.thumb_rad = 0.46; }), best - 1.0, 1e-12);
}

}  // namespace
}  // namespace rangegrasp::grasp::internal
