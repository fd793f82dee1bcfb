#include "sensing/depth_camera_options.h"

#include <cmath>

namespace rangegrasp::sensing {
namespace {

using base::kDeg;
using base::kMm;
using Eigen::Vector3d;

// Maximum coordinate in a file: far beyond any work cell, but small enough to detect a wrong unit.
constexpr double kFarthest_mm = 1e5;

/// Every key with its option, range and documentation.
void ReadCameraKeys(base::YamlMap& from, DepthCameraOptions& o) {
  from.Read("width_px", o.width, 2, 4096, "columns of the depth image");
  from.Read("height_px", o.height, 2, 4096, "rows of the depth image");
  from.ReadScaled("field_deg", o.field_right_rad, kDeg, 1.0, 150.0,
                  "horizontal field of view; pixels are square");
  from.ReadScaled("min_depth_mm", o.min_depth_m, kMm, 1.0, 100000.0, "minimum measurable depth");
  from.ReadScaled("max_depth_mm", o.max_depth_m, kMm, 1.0, 100000.0, "maximum measurable depth");
  from.Read("frames", o.frames, 1, 1000,
            "number of images that are averaged; reduces the noise that differs between images");
  from.ReadScaled("baseline_mm", o.baseline_m, kMm, 1.0, 5000.0,
                  "active stereo: distance between the two lenses");
  from.Read("disparity_sigma_px", o.disparity_sigma_px, 0.0, 10.0,
            "active stereo: noise of the disparity; the depth's is z^2 / (f b) times that");
  from.Read("disparity_step_px", o.disparity_step_px, 0.0, 10.0,
            "active stereo: resolution of the disparity; 0: none");
  from.Read("window_px", o.window_px, 1, 63,
            "active stereo: columns over which the matching averages: neighbors' errors are alike");
  from.Read("window_rows_px", o.window_rows_px, 1, 63, "active stereo: rows of that window");
  from.Read("fixed_share", o.fixed_share, 0.0, 1.0,
            "share of the noise's variance that is the same in all images of a scene");
  from.ReadScaled("range_sigma_mm", o.range_sigma_m, kMm, 0.0, 1000.0,
                  "time of flight: noise at 1 m on a white surface that faces the camera; grows "
                  "with the range and the inverse root of the reflected light");
  from.ReadScaled("range_offset_mm", o.range_offset_m, kMm, 0.0, 1000.0,
                  "time of flight: error of all ranges, root mean square; one draw per scan");
  from.Read("edge_reach_px", o.edge_reach_px, 0.0, 32.0,
            "distance from a depth edge within which samples are lost, mixed or moved across it");
  from.Read("edge_loss", o.edge_loss, 0.0, 1.0, "share of these samples that are lost");
  from.Read("flying_share", o.flying_share, 0.0, 1.0,
            "share of the other samples there that lie between the two surfaces (flying pixels)");
  from.Read("lateral_sigma_px", o.lateral_sigma_px, 0.0, 10.0,
            "noise of the place of depth edges in the image");
  ReadSharedKeys(from, o);
}

/// The pose of a camera at `from` whose axis points to `to`. Its x axis is horizontal. For a camera
/// that looks straight up or down it is W's y axis.
base::Pose Looking(const Vector3d& from, const Vector3d& to) {
  constexpr double kVertical = 1e-6;
  const Vector3d z = (to - from).normalized();
  const Vector3d right = z.cross(Vector3d::UnitZ());
  Eigen::Matrix3d R;
  R.col(0) = right.norm() > kVertical ? right.normalized() : Vector3d::UnitY().eval();
  R.col(1) = z.cross(R.col(0)).normalized();
  R.col(2) = R.col(0).cross(R.col(1));
  return base::MakePose(R, from);
}

void ReadPlace(base::YamlMap& map, DepthCameraOptions& options) {
  map.Read("site", options.site,
           "site of the scene where the camera stands, x right, y down, z forward; a site on the "
           "arm moves with it");
  if (!map.HoldsMap("place")) return;
  if (map.Has("site")) map.Fail("site", "cannot be used with place: give one of the two");
  base::YamlMap place = map.Child("place", "where the camera stands instead, in world W");
  Vector3d from, to;
  const std::array<const char*, 3> from_keys = {"x_mm", "y_mm", "z_mm"};
  const std::array<const char*, 3> to_keys = {"look_x_mm", "look_y_mm", "look_z_mm"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto read = [&](const char* key, double& value, const char* doc) {
      place.Require(key);
      place.ReadScaled(key, value, kMm, -kFarthest_mm, kFarthest_mm, doc);
    };
    read(from_keys[axis], from[axis], "position of the lens");
    read(to_keys[axis], to[axis], "point in the middle of the image");
  }
  place.Finish();
  if (from == to) {
    map.Fail("place",
             "the camera's position and the point that it looks at are the same; change look_z_mm");
  }
  options.X_WS = Looking(from, to);
}

}  // namespace

DepthCameraOptions ReadDepthCamera(const std::filesystem::path& file) {
  auto map = base::YamlMap::FromFile(file);
  std::string type = kDepthCamera;
  map.Read("type", type, {kDepthCamera}, "type of the sensor");
  DepthCameraOptions options;
  map.Read("principle", options.principle, "how depth is measured");
  ReadCameraKeys(map, options);
  ReadPlace(map, options);
  FinishShared(map, options);
  if (options.min_depth_m >= options.max_depth_m) {
    map.Fail(map.Has("min_depth_mm") ? "min_depth_mm" : "max_depth_mm",
             "min_depth_mm must be less than max_depth_mm");
  }
  return options;
}

double FocalLength(const DepthCameraOptions& options) {
  return 0.5 * options.width / std::tan(0.5 * options.field_right_rad);
}

}  // namespace rangegrasp::sensing
