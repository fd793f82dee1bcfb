#include "geometry/cloud_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "geometry/internal/cloud_format.h"
#include "geometry/internal/pcd.h"
#include "geometry/internal/ply.h"

namespace rangegrasp::geometry {
namespace {

/// Rows keep their places, but a point is either finite or NaN as a whole.
void Normalize(CloudFile& cloud, double unit_m) {
  for (Eigen::Vector3d& p : cloud.points) {
    p *= unit_m;
    if (!p.allFinite()) p.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  if (cloud.sensor_origin) *cloud.sensor_origin *= unit_m;
}

void CheckFields(const RangeImage& image, const std::vector<CloudField>& fields) {
  for (const CloudField& field : fields) {
    if (field.values.size() != image.points_C.size()) {
      throw std::invalid_argument(
          fmt::format("WriteCloud: field {} has {} values; the image has {} points", field.name,
                      field.values.size(), image.points_C.size()));
    }
  }
}

constexpr char kColor[] = "rgb";

void AppendChannels(std::uint32_t packed, std::string& bytes) {
  for (const int shift : {16, 8, 0}) bytes.push_back(static_cast<char>(packed >> shift & 0xffu));
}

Eigen::Vector3d Viewpoint(const RangeImage& image) {
  return image.origins_C.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                 : Centroid(image.origins_C);
}

std::string PcdBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  std::string names, sizes, types, counts;
  for (const CloudField& field : fields) {
    names += " " + field.name;
    sizes += " 4";
    types += " U";
    counts += " 1";
  }
  const Eigen::Vector3d origin = Viewpoint(image);
  std::string bytes = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z{}\n"
      "SIZE 4 4 4{}\nTYPE F F F{}\nCOUNT 1 1 1{}\nWIDTH {}\nHEIGHT {}\n"
      "VIEWPOINT {:f} {:f} {:f} 1 0 0 0\nPOINTS {}\nDATA binary\n",
      names, sizes, types, counts, image.samples, image.profiles, origin.x(), origin.y(),
      origin.z(), image.points_C.size());
  for (std::size_t i = 0; i < image.points_C.size(); ++i) {
    internal::AppendPoint(image.points_C[i], bytes);
    for (const CloudField& field : fields) internal::AppendRaw(field.values[i], bytes);
  }
  return bytes;
}

std::string PlyBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  Indices measured;
  ToCloud(image, &measured);
  std::string bytes = internal::PlyVertexHeader(measured.size());
  for (const CloudField& field : fields) {
    bytes += field.name == kColor
                 ? "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                 : "property uint " + field.name + "\n";
  }
  bytes += "end_header\n";
  for (const std::uint32_t i : measured) {
    internal::AppendPoint(image.points_C[i], bytes);
    for (const CloudField& field : fields) {
      if (field.name == kColor) {
        AppendChannels(field.values[i], bytes);
      } else {
        internal::AppendRaw(field.values[i], bytes);
      }
    }
  }
  return bytes;
}

}  // namespace

CloudFile ReadCloud(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m)) {
    throw std::invalid_argument("ReadCloud: unit_m must be a finite number > 0");
  }
  const std::string bytes = base::ReadNonEmptyFile(file);
  const bool ply = internal::IsPly(bytes);
  if (!ply && base::EndingOf(file) == ".ply") {
    throw base::InputError(file.string() + ":1: a PLY file starts with the line \"ply\"");
  }
  CloudFile cloud = ply ? internal::ReadPlyCloud(file, bytes) : internal::ReadPcd(file, bytes);
  Normalize(cloud, unit_m);
  const bool any = std::any_of(cloud.points.begin(), cloud.points.end(),
                               [](const Eigen::Vector3d& p) { return p.allFinite(); });
  if (!any) {
    throw base::InputError(
        fmt::format("{}: none of its {} points is finite", file.string(), cloud.points.size()));
  }
  return cloud;
}

CloudField ColorField(const std::vector<Rgb>& colors) {
  CloudField field{kColor, {}};
  for (const auto& [red, green, blue] : colors) {
    field.values.push_back(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue);
  }
  return field;
}

void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields) {
  CheckFields(image, fields);
  base::WriteFile(
      file, base::EndingOf(file) == ".ply" ? PlyBytes(image, fields) : PcdBytes(image, fields));
}

}  // namespace rangegrasp::geometry
