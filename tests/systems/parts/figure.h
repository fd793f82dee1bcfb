#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "parts/solids.h"

namespace rangegrasp::parts::samples {

/// A rod with round ends of different radii.
struct Rod {
  Eigen::Vector3d a, b;
  double radius_a, radius_b;
};
inline double ToRod(const Eigen::Vector3d& p, const Rod& rod) {
  const Eigen::Vector3d along = rod.b - rod.a;
  const double s = std::clamp((p - rod.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - rod.a - s * along).norm() - (rod.radius_a + s * (rod.radius_b - rod.radius_a));
}

/// Lengths and radii of a body [m].
struct Build {
  double height, shoulder, hip, arm, leg, chest, limb, head, neck;
};
/// A limb raised to the side and forwards, and bent at the elbow or knee [deg].
struct Bend {
  double sideways, forwards, bent;
};
struct Posture {
  std::array<Bend, 2> arms, legs;
  double nod, lean;
};
struct Figure {
  Shape shape;
  geometry::Points tips;  ///< head, hands, feet
};

/// A person made of rods: x forwards, y to the left, z up. Elbows bend forwards, knees backwards.
class FigureMaker {
 public:
  FigureMaker(const Build& build, const Posture& posture) : b_(build) {
    const Eigen::Vector3d pelvis(0.0, 0.0, b_.leg + 0.05);
    const double torso = b_.height - b_.leg - 2.0 * b_.head - b_.neck - 0.1;
    const Eigen::Matrix3d lean = AboutY(posture.lean);
    const Eigen::Vector3d up = lean.col(2);
    const Eigen::Vector3d neck = pelvis + torso * up;
    rods_.push_back({pelvis, pelvis + 0.75 * torso * up, 0.85 * b_.chest, b_.chest});
    AddHead(neck, up, posture.nod);
    for (std::size_t s = 0; s < 2; ++s) {
      const double side = s == 0 ? 1.0 : -1.0;
      AddArm(neck - 0.06 * up, lean, side, posture.arms[s]);
      AddLeg(pelvis + Eigen::Vector3d(0.0, side * b_.hip, -0.04), side, posture.legs[s]);
    }
  }

  Figure Make(double step) const {
    Figure figure;
    figure.tips = tips_;
    Eigen::Vector3d low = rods_[0].a, high = rods_[0].a;
    for (const Rod& rod : rods_) {
      low = low.cwiseMin(rod.a).cwiseMin(rod.b);
      high = high.cwiseMax(rod.a).cwiseMax(rod.b);
    }
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.25);
    figure.shape = Isosurface(low - margin, high + margin, step, [&](const Eigen::Vector3d& p) {
      double distance = ToRod(p, rods_[0]);
      for (const Rod& rod : rods_) distance = std::min(distance, ToRod(p, rod));
      return distance;
    });
    return figure;
  }

 private:
  static Eigen::Matrix3d AboutY(double deg) {
    return Eigen::AngleAxisd(deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitY())
        .toRotationMatrix();
  }
  static Eigen::Matrix3d Lifted(double side, const Bend& bend) {
    const double sideways = side * bend.sideways * std::numbers::pi / 180.0;
    return Eigen::AngleAxisd(sideways, Eigen::Vector3d::UnitX()).toRotationMatrix() *
           AboutY(-bend.forwards);
  }

  void AddHead(const Eigen::Vector3d& neck, const Eigen::Vector3d& up, double nod) {
    const Eigen::Vector3d skull = neck + AboutY(nod) * (up * (b_.neck + 1.1 * b_.head));
    rods_.push_back({neck, skull, 1.1 * b_.limb, 1.1 * b_.limb});
    rods_.push_back({skull, skull + 0.03 * up, b_.head, 0.9 * b_.head});
    tips_.push_back(skull + (b_.head + 0.02) * up);
  }
  void AddArm(const Eigen::Vector3d& chest, const Eigen::Matrix3d& lean, double side,
              const Bend& bend) {
    const Eigen::Vector3d out = side * b_.shoulder * lean.col(1);
    rods_.push_back({chest, chest + 0.8 * out, 0.07, 1.2 * b_.limb});
    const Eigen::Matrix3d turn = lean * Lifted(side, bend);
    const Eigen::Vector3d elbow = chest + out - 0.48 * b_.arm * turn.col(2);
    const Eigen::Vector3d hand = elbow - 0.52 * b_.arm * (turn * AboutY(-bend.bent)).col(2);
    rods_.push_back({chest + out, elbow, 1.1 * b_.limb, 0.9 * b_.limb});
    rods_.push_back({elbow, hand, 0.9 * b_.limb, 0.8 * b_.limb});
    tips_.push_back(hand);
  }
  void AddLeg(const Eigen::Vector3d& hip, double side, const Bend& bend) {
    const Eigen::Matrix3d turn = Lifted(side, bend);
    const Eigen::Matrix3d shin = turn * AboutY(bend.bent);
    const Eigen::Vector3d knee = hip - 0.5 * b_.leg * turn.col(2);
    const Eigen::Vector3d foot = knee - 0.5 * b_.leg * shin.col(2);
    rods_.push_back({hip, knee, 1.6 * b_.limb, 1.2 * b_.limb});
    rods_.push_back({knee, foot, 1.2 * b_.limb, b_.limb});
    rods_.push_back({foot, foot + 0.12 * shin.col(0), b_.limb, 0.7 * b_.limb});
    tips_.push_back(foot);
  }

  Build b_;
  std::vector<Rod> rods_;
  geometry::Points tips_;
};

/// A slim adult, a broad adult, a child.
inline constexpr std::array<Build, 3> kBuilds{{
    {1.75, 0.19, 0.09, 0.60, 0.82, 0.15, 0.05, 0.11, 0.06},
    {1.75, 0.24, 0.10, 0.62, 0.80, 0.19, 0.065, 0.11, 0.05},
    {1.15, 0.13, 0.06, 0.38, 0.48, 0.11, 0.038, 0.10, 0.04},
}};
/// Standing; arms and legs spread; walking; sitting; reaching up on one leg.
inline constexpr std::array<Posture, 5> kPostures{{
    {{{{15, 0, 0}, {15, 0, 0}}}, {{{12, 0, 0}, {12, 0, 0}}}, 0, 0},
    {{{{88, 0, 0}, {88, 0, 0}}}, {{{25, 0, 0}, {25, 0, 0}}}, 0, 0},
    {{{{20, -30, 30}, {20, 45, 40}}}, {{{8, 40, 20}, {8, -25, 30}}}, 0, 5},
    {{{{30, 60, 60}, {30, 60, 60}}}, {{{15, 85, 90}, {15, 85, 90}}}, 10, 0},
    {{{{160, 0, 10}, {160, 0, 10}}}, {{{30, 70, 80}, {20, -20, 20}}}, -10, 25},
}};

}  // namespace rangegrasp::parts::samples
