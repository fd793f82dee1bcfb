#pragma once

#include <Eigen/Geometry>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "base/frames.h"
#include "geometry/mesh.h"
#include "geometry/point_cloud.h"

namespace rangegrasp::geometry {

/// An organised range image: `profiles` rows (one per laser line) of `samples` columns.
struct RangeImage {
  int profiles = 0;
  int samples = 0;
  Points points_C;   ///< row-major, [m]; NaN where nothing was measured
  Points origins_C;  ///< the sensor's origin per profile [m]; one entry if it does not move

  /// False for a cloud without an order of the scan, whose points are one row.
  bool HasScanOrder() const { return profiles > 1; }
  std::size_t Index(int profile, int sample) const {
    return static_cast<std::size_t>(profile) * static_cast<std::size_t>(samples) +
           static_cast<std::size_t>(sample);
  }
  /// The sensor's position when it measured the sample at `index`.
  /// @throws std::invalid_argument unless there is one origin, or one per profile.
  const Eigen::Vector3d& OriginOf(std::size_t index) const;
};

/// The measured points of an image, in its order.
PointCloud ToCloud(const RangeImage& image);

/// The distance of neighbors in the image [m]: the median over the samples of the mean distance to
/// the next sample of the profile and to the same sample of the next profile (only to one of them
/// if the other was not measured; the median of all distances would jump between the two). 0: none.
double MedianSpacing(const RangeImage& image);

/// The measurements of one sensor from one position. Nothing in it is ground truth.
struct View {
  /// Organised samples in the order of the scan, in the observation's frame C (in a trial W),
  /// computed with the calibration that the robot knows.
  RangeImage image;
  base::Pose X_CV = base::Pose::Identity();  ///< the sensor's frame, as calibrated
  /// Standard deviation of the measured point along its ray [m], one per sample (NaN where nothing
  /// was measured), from the sensor's own model; empty if unknown.
  std::vector<float> noise_m;
  /// The color of each sample (any where nothing was measured); empty without a color camera.
  std::vector<Rgb> colors;
  double spacing_m = 0.0;  ///< median distance of neighbors in the image [m]; 0: unknown
};

/// A sample of an observation: its view, and its index in that view's image.
struct SampleId {
  std::uint32_t view = 0;
  std::uint32_t sample = 0;

  auto operator<=>(const SampleId&) const = default;  ///< by view, then by sample
};

/// One or more views of one scene, in one frame C.
struct Observation {
  std::vector<View> views;
};

/// An observation with one view, of which only the image is known.
inline Observation ObservationOf(RangeImage image) {
  Observation observation;
  observation.views.emplace_back().image = std::move(image);
  return observation;
}

/// The field of view of a sensor: a pyramid along z of its frame S (x right, y down).
struct Field {
  double half_right_rad = 0.3;  ///< half angle from z to the sides, about S's y axis
  double half_down_rad = 0.3;   ///< half angle up and down, about S's x axis
  double near_m = 0.1;          ///< shortest range
  double far_m = 1.0;           ///< longest range
};

/// What views show of a box of space: each cell is free (seen through), a surface, or unseen.
/// O(samples * cells along a ray) per view.
class SeenSpace {
 public:
  enum class Cell : std::uint8_t { kUnseen, kFree, kSurface };

  /// @param box_C   aligned with C's axes; the cells that fit into it start at its lowest corner
  /// @param cell_m  > 0, edge of a cell
  /// @param seen    its views are added
  /// @throws std::invalid_argument if the box is empty, not finite or has more than 1e8 cells
  SeenSpace(const Eigen::AlignedBox3d& box_C, double cell_m, const Observation& seen = {});

  /// The ray of each measured sample is free up to one cell before its point. The point's cell
  /// becomes a surface, and stays one. Samples that were not measured change nothing.
  void Add(const View& view);

  Cell At(const Eigen::Vector3i& cell) const { return cells_[Index(cell)]; }
  const Eigen::Vector3i& Size() const { return size_; }
  /// The cell that contains a point; nullopt outside the box.
  std::optional<Eigen::Vector3i> CellOf(const Eigen::Vector3d& p_C) const;
  /// Numbers the cells from 0, without gaps.
  std::size_t Index(const Eigen::Vector3i& cell) const {
    return static_cast<std::size_t>((cell.z() * size_.y() + cell.y()) * size_.x() + cell.x());
  }
  Eigen::Vector3d MiddleOf(const Eigen::Vector3i& cell) const;
  double UnseenVolume() const;  ///< [m^3]

  /// The expected unseen volume [m^3] that a sensor at X_CS would see: the sum over the unseen
  /// cells of `region_C`, weighted by the largest probability of a ray to reach the cell. A ray
  /// ends at a known surface; its probability to pass unseen space is exp(-distance / depth_m).
  double GainFrom(const base::Pose& X_CS, const Field& field, const Eigen::AlignedBox3d& region_C,
                  double depth_m) const;

  /// A surface above everything that is seen or may exist: in each column margin_m above the cells
  /// that are not free, counted from below up to the first free cell. There is none if the lowest
  /// cell is free. The result is one mesh of horizontal tops and vertical walls, open below.
  TriangleMesh Ceiling(double margin_m) const;

 private:
  template <typename Visit>
  void Walk(const Eigen::Vector3d& from_C, const Eigen::Vector3d& to_C, const Visit& visit) const;

  Eigen::Vector3d low_C_;
  double cell_m_;
  Eigen::Vector3i size_;
  std::vector<Cell> cells_;
};

}  // namespace rangegrasp::geometry
