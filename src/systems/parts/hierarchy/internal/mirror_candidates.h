#pragma once

#include <vector>

#include "parts/hierarchy/internal/cells.h"

namespace rangegrasp::parts {

struct CandidateOptions {
  int centers = 60;  ///< interior centers to mirror about
  int levels = 8;    ///< cores of different size per center
  double min_share =
      0.004;               ///< of the surface, of the first core: a little below the smallest part
  double max_share = 0.7;  ///< of the last core; what is outside of it is to be a part
  /// The cut lies in a band between a core and one so many times as large: a wider band finds more
  /// distant necks and costs more time.
  double reach = 3.0;
};

/// The center of a ball inside of the shape that touches it in cell `c`: the smallest such ball
/// that no other cell's center is in.
Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c);

/// Sets of cells that may be parts. About each center the cells' centers are mirrored (eq. 6.2);
/// how deep an image lies below the hull (eq. 6.3) says how well it is seen. A core grows from the
/// cells next to the center over its neighbors, best seen first; another grows where the shape is
/// thinnest first (the radius of the inscribed ball), which follows a handle round to its other
/// end. Cores of several sizes are cut off where it is cheapest between them and a core some times
/// as large.
std::vector<std::vector<bool>> MirrorCandidates(const Cells& cells,
                                                const CandidateOptions& options);

}  // namespace rangegrasp::parts
