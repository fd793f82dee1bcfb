#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cylinders/fit.h"
#include "cylinders/task/cylinders_options.h"

namespace rangegrasp::cylinder_task {

/// One method's fit of one cloud.
struct ComparedFit {
  Method method = Method::kLsf;
  int iterations = 0;
  std::optional<cylinders::Barrel> barrel;  ///< nullopt where the fit failed
  double seconds = 0.0;                     ///< in all
  double preparation_seconds = 0.0;         ///< of these: normals and curvature points
};

/// All methods with all numbers of iterations. Random draws depend on the seed, the method and the
/// iterations alone. `refined` starts from the RCF of as many triples. Without PCL in the build,
/// `pcl` is left out.
std::vector<ComparedFit> CompareFits(const cylinders::FitInput& input, const Options& options,
                                     std::uint64_t seed);

/// How far a fit is from the truth: the cylinder along x through the origin.
struct FitError {
  double radius_m = 0.0;  ///< signed: above 0 where the fit is too large
  double axis_rad = 0.0;
};
FitError ErrorOf(const cylinders::Barrel& barrel, const CylinderShape& truth);

}  // namespace rangegrasp::cylinder_task
