#include "cylinders/task/compare_fits.h"

#include "base/stopwatch.h"
#include "base/words.h"
#include "cylinders/fit_least_squares.h"
#include "cylinders/fit_rcf.h"
#include "cylinders/fit_refined.h"
#include "pcl_bridge/ransac.h"

namespace rangegrasp::cylinder_task {
namespace {

using cylinders::Barrel;
using cylinders::BarrelFit;
using cylinders::FitInput;

std::optional<Barrel> BarrelOf(const std::optional<BarrelFit>& fit) {
  return fit ? std::optional(fit->barrel) : std::nullopt;
}

ComparedFit Lsf(const FitInput& input, int iterations) {
  const base::Stopwatch watch;
  const auto fit = cylinders::FitLeastSquares(input.points, {iterations});
  return {Method::kLsf, iterations, BarrelOf(fit), watch.Seconds(), 0.0};
}

/// RCF's preparation serves all numbers of iterations and the refinement.
struct Prepared {
  cylinders::RcfOptions options;
  cylinders::RcfPreparation preparation;
  double seconds = 0.0;
};

Prepared Prepare(const FitInput& input, const Options& options) {
  Prepared prepared;
  prepared.options.neighborhood_m = options.neighborhood_m;
  const base::Stopwatch watch;
  prepared.preparation = cylinders::PrepareRcf(input, prepared.options);
  prepared.seconds = watch.Seconds();
  return prepared;
}

ComparedFit Rcf(const FitInput& input, const Prepared& prepared, Method method, int iterations,
                std::uint64_t seed) {
  cylinders::RcfOptions options =
      method == Method::kPrinted ? cylinders::RcfAsPrinted() : cylinders::RcfOptions{};
  options.neighborhood_m = prepared.options.neighborhood_m;
  options.circle.draws = iterations;
  base::Rng rng(
      base::DeriveSeed(base::DeriveSeed(seed, "rcf"), static_cast<std::uint64_t>(iterations)));
  const base::Stopwatch watch;
  const auto fit = cylinders::FitRcf(input, prepared.preparation, options, rng);
  return {method, iterations, BarrelOf(fit), prepared.seconds + watch.Seconds(), prepared.seconds};
}

ComparedFit Refined(const FitInput& input, const ComparedFit& rcf) {
  const base::Stopwatch watch;
  const auto fit =
      rcf.barrel ? cylinders::FitRefined(input, *rcf.barrel) : std::optional<BarrelFit>{};
  return {Method::kRefined, rcf.iterations, BarrelOf(fit), rcf.seconds + watch.Seconds(),
          rcf.preparation_seconds};
}

void AddPcl(const FitInput& input, const Options& options, std::vector<ComparedFit>& fits) {
  const base::Stopwatch watch;
  const pcl_bridge::Cloud cloud(input.points, input.eye);
  const auto normals = pcl_bridge::EstimateNormals(cloud, {options.neighborhood_m});
  const double preparation = watch.Seconds();
  for (const int iterations : options.iterations) {
    pcl_bridge::CylinderOptions model;
    model.max_draws = iterations;
    const base::Stopwatch own;
    const auto fit = pcl_bridge::FitCylinder(cloud, normals, model);
    std::optional<Barrel> barrel;
    if (fit) {
      barrel = Barrel{{fit->cylinder.point, fit->cylinder.axis}, fit->cylinder.radius_m};
    }
    fits.push_back({Method::kPcl, iterations, barrel, preparation + own.Seconds(), preparation});
  }
}

}  // namespace

std::vector<ComparedFit> CompareFits(const FitInput& input, const Options& options,
                                     std::uint64_t seed) {
  std::vector<ComparedFit> fits;
  const Prepared prepared = Prepare(input, options);
  for (const Method method : options.methods) {
    if (method == Method::kPcl) {
      AddPcl(input, options, fits);
      continue;
    }
    for (const int iterations : options.iterations) {
      if (method == Method::kLsf) {
        fits.push_back(Lsf(input, iterations));
        continue;
      }
      const Method start = method == Method::kRefined ? Method::kRcf : method;
      const ComparedFit rcf = Rcf(input, prepared, start, iterations, seed);
      fits.push_back(method == Method::kRefined ? Refined(input, rcf) : rcf);
    }
  }
  return fits;
}

FitError ErrorOf(const Barrel& barrel, const CylinderShape& truth) {
  return {barrel.radius_m - truth.radius_m,
          cylinders::AngleBetween(barrel.axis.direction, Eigen::Vector3d::UnitX())};
}

}  // namespace rangegrasp::cylinder_task
