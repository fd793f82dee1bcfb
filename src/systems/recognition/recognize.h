#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/frames.h"
#include "base/rng.h"
#include "geometry/observation.h"
#include "perception/scene.h"
#include "recognition/library.h"

namespace rangegrasp::recognition {

struct RecognitionOptions {
  /// Of an explained sample from a model's surface, across it: three times what a scan's noise and
  /// a pose's error are together.
  double tolerance_m = 0.003;
  double coarse_tolerance_m = 0.010;  ///< the same of poses before they are registered
  /// Rays this far beside a segment are looked at, too: a model must not stand there.
  double beside_m = 0.12;
  std::size_t coarse_rays = 240;    ///< half of them a segment's own
  std::size_t fine_rays = 3000;     ///< half of them a segment's own
  std::size_t source_points = 300;  ///< of a segment, for registration
  int references = 24;              ///< points of a segment whose pairs vote for poses
  int registered = 4;  ///< poses of one object and segment, the best by the coarse score
  /// Objects whose score is so far below the best one's are not registered, nor refined.
  double hopeless = 0.25;
  /// u of the score: less than 1, for two objects may be one segment.
  double unexplained_weight = 0.6;
  /// l of the score, less where a ray meets the surface at more than 60 deg: it may have been lost
  /// to gloss or in a shadow of the sensor's camera.
  double lost_weight = 0.3;

  // An object is named if all of these hold.
  double min_score = 0.72;
  double margin = 0.02;  ///< of the score above any other object's there, over share_seen
  /// Of FoundObject::violations: of right finds alone 0.005 at most was, of a box that is 20 mm
  /// shorter 0.027.
  double max_violations = 0.02;
  /// Of rms_m, as a share of the tolerance: 0.16 at most in right finds alone. A cylinder of
  /// another diameter fits more loosely.
  double max_rms = 0.17;
  /// Of the samples that it leaves unexplained: those this near to it would be of a shape that is a
  /// little larger. What reaches away is a neighbor's.
  double hugs_m = 0.012;
  double max_hugging = 0.05;
  double min_share_seen = 0.4;   ///< of what is hidden one cannot tell its size
  std::size_t min_samples = 60;  ///< that it explains, and of what is compared with the library
  double min_color = 0.5;        ///< of FoundObject::color

  /// A perceived object with up to this share of another one's points, and this near to it, may be
  /// a part of it: the handle of a cup is perceived apart.
  double max_piece = 0.25;
  double piece_gap_m = 0.025;
  /// w of the score; 0: colors play no part.
  double color_weight = 0.5;
  /// Colors that differ by as much agree no more: in the shares of red and blue white and cream
  /// differ by 0.1, orange and yellow by 0.2, red and white by 0.7.
  double color_tolerance = 0.25;
  double max_sunk_m = 0.003;  ///< deeper in the table no object stands
};

/// A known object that was found.
struct FoundObject {
  std::string object;  ///< KnownObject::name
  base::Pose X_CB = base::Pose::Identity();
  double score = 0.0;  ///< 0 to 1; Recognize
  double color = 1.0;  ///< c of the score; 1 where colors are not known
  /// Of the rays that meet the model's surface in this pose: measured where it is.
  double share_seen = 0.0;
  /// Of those that nothing stopped before it: went through it and met something behind.
  double violations = 0.0;
  double hugging = 0.0;    ///< of the perceived object's samples: close about it, and unexplained
  double runner_up = 0.0;  ///< the score of the next best object there
  double rms_m = 0.0;      ///< of the samples' distances to the model, across its surface
  std::vector<geometry::SampleId> samples;  ///< that it explains
  /// Other poses of it that explain the samples as well, within RecognitionOptions::margin: what
  /// would tell them apart was not seen, e.g. a handle.
  std::vector<base::Pose> alternatives_CB;
};

/// Finds known objects in what was perceived. Each perceived object is compared with each known
/// one: poses in which it would lie on the table, turned in steps, and poses that pairs of points
/// with normals vote for (Drost et al. 2010); the best of them are registered (PCL), and judged by
/// what the views must and must not see. Each measured sample is a ray: a sample on the model's
/// surface is explained; one behind it saw through where the model would be (a violation); one of
/// the perceived object that lies before the surface or beside the model is unexplained.
///
///   score = sum of (1 - (e / tolerance)^2) over explained samples
///           / (explained + violations + u unexplained + l lost)
///
/// with e across the surface, u = options.unexplained_weight, l = options.lost_weight, and lost the
/// rays that should have met the surface and did not come back. Where samples and models have
/// colors, the score is
///
///   score (1 - w (1 - c)),  c = mean over explained samples of 1 - min(1, (d / tolerance)^2)
///
/// with w = options.color_weight and d the distance of the sample's color from the model's there,
/// in the shares of red and of blue; brightness counts less, and all samples' mean of it not at
/// all. What no model explains well enough, or two explain about as well, is not named. The order
/// of the library plays no part.
/// @param scene  of this observation
/// @param known  SureOnes of earlier looks at the same scene. Those that are not found again, since
/// more points make two objects one segment, stay as long as the new views agree with them; what
/// lies within two tolerances of them is theirs, the rest of their segment is looked at by itself
/// @return best first
std::vector<FoundObject> Recognize(const geometry::Observation& observation,
                                   const perception::Scene& scene, const Library& library,
                                   const RecognitionOptions& options, base::Rng& rng,
                                   std::vector<FoundObject> known = {});

/// The perceived objects that another view should be taken for: of which no find explains half of
/// the points, or only one whose pose is open (FoundObject::alternatives_CB). What is too small to
/// be compared with the library is none.
/// @return positions in scene.objects, ascending (topmost first)
std::vector<std::size_t> OpenObjects(const perception::Scene& scene,
                                     const std::vector<FoundObject>& found,
                                     const RecognitionOptions& options);

/// The finds whose pose is not open: what the next look at the same scene need not find again.
std::vector<FoundObject> SureOnes(std::vector<FoundObject> found);

/// Finds for another scan from where the first view was taken, of a scene that may have changed
/// since: what only further views saw of them is left out. What has not moved need not be found
/// again, and what has fits no longer (Recognize).
std::vector<FoundObject> AsFirstSeen(std::vector<FoundObject> found);

}  // namespace rangegrasp::recognition
