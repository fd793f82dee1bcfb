#pragma once

#include <cstddef>
#include <vector>

#include "perception/scene.h"
#include "recognition/recognize.h"

namespace rangegrasp::recognition {

/// The perceived objects that another view should be taken for: of which no find explains half of
/// the points, or only one whose pose is open (FoundObject::alternatives_CB). What is too small to
/// be compared with the library is none.
/// @return positions in scene.objects, ascending (topmost first)
std::vector<std::size_t> OpenObjects(const perception::Scene& scene,
                                     const std::vector<FoundObject>& found,
                                     const RecognitionOptions& options);

/// The finds whose pose is not open: what the next look at the same scene need not find again.
std::vector<FoundObject> SureOnes(const std::vector<FoundObject>& found);

/// Finds for another scan from where the first view was taken, of a scene that may have changed
/// since: what further views alone told of them is left out. What has not moved need not be found
/// again, and what has fits no longer (Recognize).
std::vector<FoundObject> AsFirstSeen(std::vector<FoundObject> found);

}  // namespace rangegrasp::recognition
