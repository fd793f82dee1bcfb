#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "grasp/internal/object_view.h"

namespace rangegrasp::grasp::internal {

struct Candidate {
  Grasp grasp;
  std::size_t open_state = 0;
  std::size_t narrow_state = 0;  ///< tried where the open state collides
  std::size_t held_state = 0;
  double depth_m = 0.0;     ///< z of the pads' middle in the view
  bool to_contact = false;  ///< comes down until it meets something, wherever that is
  int group = 0;            ///< candidates of one group are alike; see ChooseFree
};

/// The candidate for T at origin_A; its states, widths and score are still to be set.
Candidate MakeCandidate(const Task& task, const View& view, const Eigen::Vector3d& origin_A,
                        const Eigen::Vector3d& center_A, double pitch_rad, GraspType type);
/// Opens the candidate's hand to a state, for what is expected to be held at another with a width.
void SetStates(const Task& task, std::size_t open, std::size_t held, double width_m,
               Candidate& candidate);

/// Where the contacts are sought.
struct Aim {
  double pitch_rad = 0.0;
  double best_pitch_rad = 0.0;
  double depth_m = 0.0;     ///< wanted z of the pads' middle; the hand stops earlier where it must
  double back_off_m = 0.0;  ///< and then goes back up by this
  /// The object's, where it is known from more than what the hand passes (a diameter).
  std::optional<double> width_m{};
  /// What is too wide for the hand further down is gripped by the part of it that is not.
  bool upper_part = false;
};

/// The depth of a hand that comes down until it meets the object, or the table.
constexpr double kToContact_m = std::numeric_limits<double>::infinity();

/// Places the hand so that its pads close on the object in the band and at the aim, midway between
/// the contacts; nullopt if it does not fit or meets nothing on one side. Without centering the
/// tool centre comes to x = 0 and the band's y instead, whatever the hand meets there.
std::optional<Candidate> Place(Task& task, const View& view, const Band& band, const Aim& aim,
                               GraspType type);
/// Place at each of the depths, from the first down, and, where the hand had to stop above the
/// first of them, also a little higher (PlacingOptions::back_offs_m).
void PlaceAtDepths(Task& task, const View& view, const Band& band, Aim aim,
                   std::span<const double> depths_m, GraspType type, int group,
                   std::vector<Candidate>& candidates);

}  // namespace rangegrasp::grasp::internal
