#pragma once

#include <vector>

#include "parts/internal/improved_cells.h"

namespace rangegrasp::parts {

struct CandidateOptions {
  int centers = 60;      ///< interior centres to mirror about
  int levels = 8;        ///< cores of different size per centre
  double least = 0.004;  ///< share of the surface of the smallest core
  double reach = 3.0;  ///< between core and rest lies a band of this many times the core's surface
};

/// The centre of a ball inside of the shape that touches it in cell `c`: the smallest such ball
/// that no other cell's centre is in.
Eigen::Vector3d InnerCenter(const Cells& cells, std::uint32_t c);

/// Sets of cells that may be parts. About each centre the cells' centres are mirrored (eq. 6.2);
/// how deep an image lies below the hull (eq. 6.3) says how well it is seen. A core grows from the
/// cells next to the centre over its neighbours, best seen first. Cores of several sizes are cut
/// off where it is cheapest between them and a core some times as large.
std::vector<std::vector<bool>> MirrorCandidates(const Cells& cells,
                                                const CandidateOptions& options);

}  // namespace rangegrasp::parts
