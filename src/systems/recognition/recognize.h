#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/frames.h"
#include "geometry/observation.h"
#include "perception/scene.h"
#include "recognition/library.h"

namespace rangegrasp::recognition {

struct RecognitionOptions {
  /// Maximum distance of an explained sample from a model's surface, along the normal: three times
  /// the combined error of a scan's noise and a pose.
  double tolerance_m = 0.003;
  double coarse_tolerance_m = 0.010;  ///< the same for poses before registration
  /// Rays this far around a segment are also evaluated: a model must not extend there.
  double beside_m = 0.12;
  std::size_t coarse_rays = 240;    ///< half of them from the segment itself
  std::size_t fine_rays = 3000;     ///< half of them from the segment itself
  std::size_t source_points = 300;  ///< of a segment, for registration
  int references = 24;              ///< points of a segment whose pairs vote for poses
  int registered = 4;               ///< best poses by the coarse score, per object and segment
  /// Objects whose score is this far below the best one's are neither registered nor refined.
  double hopeless = 0.25;
  /// u of the score: less than 1, because one segment may contain two objects.
  double unexplained_weight = 0.6;
  /// l of the score, less where a ray meets the surface at more than 60 deg: it may have been lost
  /// by gloss or in a shadow of the sensor's camera.
  double lost_weight = 0.3;

  // An object is named only if all of the following hold.
  double min_score = 0.72;
  double margin = 0.02;  ///< lead of the score over any other object's, divided by share_seen
  /// Maximum of FoundObject::violations: it was at most 0.005 in correct finds alone, and 0.027 for
  /// a box that is 20 mm shorter.
  double max_violations = 0.02;
  /// Maximum of rms_m, as a share of the tolerance: it was at most 0.16 in correct finds alone. A
  /// cylinder of another diameter fits more loosely.
  double max_rms = 0.17;
  /// Unexplained samples this near to the model would belong to a slightly larger shape. Samples
  /// further away belong to a neighbor.
  double hugs_m = 0.012;
  double max_hugging = 0.05;
  double min_share_seen = 0.4;   ///< the size of a mostly hidden object is unknown
  std::size_t min_samples = 60;  ///< explained ones; also of a segment to be compared
  double min_color = 0.5;        ///< minimum of FoundObject::color

  /// A perceived object with up to this share of another one's points, and this near to it, may be
  /// a part of it, e.g. a cup's handle that is segmented separately.
  double max_piece = 0.25;
  double piece_gap_m = 0.025;
  /// w of the score.
  double color_weight = 0.5;
  /// Colors that differ by this much do not agree at all. In the shares of red and blue, white and
  /// cream differ by 0.1, orange and yellow by 0.2, red and white by 0.7.
  double color_tolerance = 0.25;
  double max_sunk_m = 0.003;  ///< maximum depth of an object in the table
  std::string left_out;       ///< a known object that is not compared; empty: none
};

/// A known object that was found.
struct FoundObject {
  std::string object;  ///< KnownObject::name
  base::Pose X_CB = base::Pose::Identity();
  double score = 0.0;  ///< 0 to 1; see Recognize
  double color = 1.0;  ///< c of the score; 1 if colors are unknown
  /// Share of the rays to the model's surface in this pose that measured it there.
  double share_seen = 0.0;
  /// Share of the unhidden rays that passed through it and met something behind.
  double violations = 0.0;
  double hugging = 0.0;    ///< share of the segment's samples close to it but unexplained
  double runner_up = 0.0;  ///< the score of the next best object there
  double rms_m = 0.0;      ///< of the samples' distances to the model, along the normal
  std::vector<geometry::SampleId> samples;  ///< explained samples
  /// Other poses of it that explain the samples equally well, within RecognitionOptions::margin,
  /// since the distinguishing part was not seen, e.g. a handle.
  std::vector<base::Pose> alternatives_CB;
};

/// A perceived object that was not named.
struct UnknownObject {
  std::size_t object = 0;    ///< position in Scene::objects
  std::string nearest = {};  ///< the known object with the highest score; empty: none was compared
  double score = 0.0;        ///< its score, or that of a rough pose if this was hopeless
  std::string reason = {};   ///< the first condition of RecognitionOptions that it does not meet
};

/// Finds known objects in a perceived scene. Each perceived object is compared with each known one.
/// Candidate poses are those in which it would lie on the table, turned in steps, and those that
/// pairs of points with normals vote for (Drost et al. 2010). The best are registered (PCL) and
/// scored by what the views must and must not see. Each measured sample is a ray. A sample on the
/// model's surface is explained; one behind it is a violation, since its ray passed through the
/// model; one of the perceived object in front of the surface or next to the model is unexplained.
///
///   score = sum of (1 - (e / tolerance)^2) over explained samples
///           / (explained + violations + u unexplained + l lost)
///
/// with e the distance along the normal, u = options.unexplained_weight, l = options.lost_weight,
/// and lost the rays that should have met the surface but did not return; none is known without
/// scan order. Where samples and models have colors, the score is
///
///   score (1 - w (1 - c)),  c = mean over explained samples of 1 - min(1, (d / tolerance)^2)
///
/// with w = options.color_weight and d the difference between the sample's color and the model's
/// there, in the shares of red and blue; brightness counts less, and its mean over all samples not
/// at all. Objects that no model explains well enough, or that two explain equally well, are not
/// named. The order of the library has no influence.
/// @param scene  perceived from this observation
/// @param known  SureOnes of earlier looks at the same scene. A segment with most of the samples of
/// one is compared with that object alone, and with all if it is not found in the same pose again.
/// With more points two objects may become one segment. Known ones that are not found again are
/// therefore kept as long as the new views agree with them; points within two tolerances of them
/// are theirs, and the rest of their segment is recognized separately
/// @param unknown  receives the perceived objects that were not named, unless finds explain half of
/// their points, in the scene's order; may be null
/// @return best first
std::vector<FoundObject> Recognize(const geometry::Observation& observation,
                                   const perception::Scene& scene, const Library& library,
                                   const RecognitionOptions& options,
                                   std::vector<FoundObject> known = {},
                                   std::vector<UnknownObject>* unknown = nullptr);

/// The perceived objects that need another view: those of which no find explains half of the
/// points, or only one whose pose is ambiguous (FoundObject::alternatives_CB). Objects too small to
/// be compared with the library are excluded.
/// @return positions in scene.objects, ascending (topmost first)
std::vector<std::size_t> OpenObjects(const perception::Scene& scene,
                                     const std::vector<FoundObject>& found,
                                     const RecognitionOptions& options);

/// The finds with an unambiguous pose, which the next look at the same scene need not find again.
std::vector<FoundObject> SureOnes(std::vector<FoundObject> found);

/// Finds for another scan from the first viewpoint, of a scene that may have changed since. Samples
/// that only further views saw are removed. Objects that have not moved need not be found again;
/// those that have moved no longer fit (Recognize).
std::vector<FoundObject> AsFirstSeen(std::vector<FoundObject> found);

}  // namespace rangegrasp::recognition
