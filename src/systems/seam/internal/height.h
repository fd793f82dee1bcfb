#pragma once

#include <string>

#include "seam/profile_format.h"

namespace rangegrasp::seam {

/// The height of a number of a file [m]: NaN if it means that there is none. `fault` says what is
/// wrong with one out of range; the caller names it.
class HeightOf {
 public:
  /// Of the options; they must outlive it.
  HeightOf(const ProfileFileOptions& options, const HeightScale& scale)
      : options_(options), scale_(scale) {}

  float operator()(double number, std::string& fault) const;

 private:
  const ProfileFileOptions& options_;
  const HeightScale& scale_;
};

}  // namespace rangegrasp::seam
