#include "seam/stitching/recording.h"

#include <cmath>
#include <limits>

#include "base/rng.h"

namespace rangegrasp::stitching {
namespace {

// The sensor keeps its height over the mats to within this: a head on a flat mould.
constexpr double kHeightError_m = 2e-3;

// The sensor's place over the first profile: the edge starts anywhere within the share of the line
// that is asked for.
LinePose FirstPose(const Mats& mats, const seam::LineGeometry& line, double edge_within,
                   base::Rng& rng) {
  const double line_m = line.columns / line.columns_per_m;
  const double across = rng.Uniform(-0.5, 0.5);
  LinePose pose;
  pose.height_m = rng.Uniform(-kHeightError_m, kHeightError_m);
  const double edge = mats.EdgeX(0.0);
  pose.x_m = (std::isfinite(edge) ? edge : 0.0) - across * edge_within * line_m;
  return pose;
}

double LabelColumn(const Mats& mats, const StripeSensor& sensor, const LinePose& pose) {
  const double edge = mats.EdgeX(pose.y_m);
  if (!std::isfinite(edge)) return std::numeric_limits<double>::quiet_NaN();
  const double height = mats.At(edge, pose.y_m).height_m - pose.height_m;
  return sensor.ColumnOf(edge - pose.x_m, height);
}

}  // namespace

Recording Record(const Mats& mats, const StripeSensor& sensor, const RecordOptions& options,
                 std::uint64_t seed) {
  base::Rng rng(seed);
  LinePose pose = FirstPose(mats, sensor.options().line, options.edge_within, rng);
  const double period_s = 1.0 / sensor.Rate(mats.options().texture);
  Recording recording;
  for (int i = 0; i < options.profiles; ++i) {
    pose.y_m = i * period_s * options.speed_m_s;
    const seam::RawProfile* previous = recording.raw.empty() ? nullptr : &recording.raw.back();
    recording.raw.push_back(sensor.Scan(mats, pose, i * period_s, previous, rng));
    recording.label_column.push_back(LabelColumn(mats, sensor, pose));
  }
  return recording;
}

}  // namespace rangegrasp::stitching
