#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "experiment/statistics.h"

namespace rangegrasp::experiment {

/// k of n.
struct Share {
  int k = 0;
  int n = 0;
};

/// What a comparison with a published figure rests on.
///
/// Independent trials on both sides: Fisher's exact test.
struct TrialsEvidence {
  Share own, published;
};
/// Trials that are not independent of each other, beside a published rate that is taken as exact.
struct ClustersEvidence {
  std::vector<Cluster> own;
};
/// Events, of which a run may have several: the exact test of two Poisson rates.
struct EventsEvidence {
  Share own, published;  ///< k events in n runs
};
/// Independent measurements, beside a published mean that is taken as exact: Student's test.
struct MeanEvidence {
  Mean own;
};
/// Times of two different computers: no test.
struct TimesEvidence {
  int measured = 0;
};
using Evidence =
    std::variant<TrialsEvidence, ClustersEvidence, EventsEvidence, MeanEvidence, TimesEvidence>;

/// The key that names a published table in most experiment files.
inline constexpr const char* kReferenceKey = "reference";

/// A figure of a published table, and what a run has in its place.
struct PublishedFigure {
  std::string row = {};   ///< "Coffee Cup, grasping"
  std::string unit = {};  ///< "%", "mm", "deg", "s", "in 50 runs": of both figures
  int digits = 1;         ///< after the point
  bool lower_is_better = false;
  double published = 0.0;
  std::optional<double> own = {};  ///< absent where nothing was counted
  Evidence evidence = {};
  /// The key of the experiment file that names the published table: an experiment may have two.
  std::string key = kReferenceKey;
};

}  // namespace rangegrasp::experiment
