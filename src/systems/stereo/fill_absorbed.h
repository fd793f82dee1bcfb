#pragma once

#include <vector>

#include "geometry/observation.h"

namespace rangegrasp::perception {

struct FillOptions {
  /// A sample within so many gaps of a ray that came back, as the laser sees it, adds nothing: it
  /// is measured already, or the laser saw through it, or it lies behind what the laser saw. Less:
  /// single lost rays are filled too; more: what is absorbed loses a wider border.
  double gaps = 1.0;
  /// Of the geometrical filter, in spacings of the stereo samples, as in PreprocessOptions: the
  /// unit of length of eq. 4.8, and the distance of a neighbor that no outlier has. Samples that
  /// are evenly spaced would nearly all be outliers without.
  double unit_spacings = 0.34;
  double keep_spacings = 1.3;
};

/// Of the samples of a stereo camera those that fill what a laser is blind to because its light
/// does not come back (section 7.2, figure 7.1): no ray of the laser that came back passes by them,
/// and the geometrical filter (section 4.2.2) keeps them. The gap is the angle from one profile of
/// the laser to the next, or from one sample to the next where that is wider.
/// @param laser, stereo  in one frame. O(n log n)
/// @return one a sample of `stereo`; all that were measured if the laser measured nothing.
std::vector<bool> FillsAbsorbed(const geometry::View& laser, const geometry::View& stereo,
                                const FillOptions& options = {});

}  // namespace rangegrasp::perception
