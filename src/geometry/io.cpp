#include "geometry/io.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/error.h"
#include "geometry/internal/cloud_format.h"
#include "geometry/internal/file_bytes.h"

namespace rangegrasp::geometry {
namespace {

bool EndsWith(const std::filesystem::path& file, std::string_view ending) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  return extension == ending;
}

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
      throw std::invalid_argument("WriteCloud: field " + field.name + " has " +
                                  std::to_string(field.values.size()) + " values; the image has " +
                                  std::to_string(image.points_C.size()) + " points");
    }
  }
}

void AppendPoint(const Eigen::Vector3d& p, std::string& bytes) {
  for (const double value : p) internal::AppendRaw(static_cast<float>(value), bytes);
}

void AppendRow(const RangeImage& image, const std::vector<CloudField>& fields, std::size_t i,
               std::string& bytes) {
  AppendPoint(image.points_C[i], bytes);
  for (const CloudField& field : fields) internal::AppendRaw(field.values[i], bytes);
}

Eigen::Vector3d Viewpoint(const RangeImage& image) {
  return image.origins_C.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                                 : Centroid(image.origins_C);
}

std::string Repeated(std::size_t n, const std::string& word) {
  std::string text;
  for (std::size_t i = 0; i < n; ++i) text += " " + word;
  return text;
}

std::string PcdBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  const std::size_t n = fields.size();
  const Eigen::Vector3d origin = Viewpoint(image);
  std::string bytes = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z";
  for (const CloudField& field : fields) bytes += " " + field.name;
  bytes += "\nSIZE 4 4 4" + Repeated(n, "4") + "\nTYPE F F F" + Repeated(n, "U") + "\nCOUNT 1 1 1" +
           Repeated(n, "1") + "\nWIDTH " + std::to_string(image.samples) + "\nHEIGHT " +
           std::to_string(image.profiles) + "\nVIEWPOINT " + std::to_string(origin.x()) + " " +
           std::to_string(origin.y()) + " " + std::to_string(origin.z()) + " 1 0 0 0\nPOINTS " +
           std::to_string(image.points_C.size()) + "\nDATA binary\n";
  for (std::size_t i = 0; i < image.points_C.size(); ++i) AppendRow(image, fields, i, bytes);
  return bytes;
}

std::string PlyBytes(const RangeImage& image, const std::vector<CloudField>& fields) {
  Indices measured;
  ToCloud(image, &measured);
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(measured.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\n";
  for (const CloudField& field : fields) bytes += "property uint " + field.name + "\n";
  bytes += "end_header\n";
  for (const std::uint32_t i : measured) AppendRow(image, fields, i, bytes);
  return bytes;
}

}  // namespace

CloudFile ReadCloud(const std::filesystem::path& file, double unit_m) {
  if (!(unit_m > 0.0) || !std::isfinite(unit_m)) {
    throw std::invalid_argument("ReadCloud: unit_m must be a finite number > 0");
  }
  const std::string bytes = internal::ReadBytes(file);
  const bool ply = bytes.starts_with("ply\n") || bytes.starts_with("ply\r");
  if (!ply && EndsWith(file, ".ply")) {
    throw core::InputError(file.string() + ":1: a PLY file starts with the line \"ply\"");
  }
  CloudFile cloud = ply ? internal::ReadPlyCloud(file, bytes) : internal::ReadPcd(file, bytes);
  Normalize(cloud, unit_m);
  const bool any = std::any_of(cloud.points.begin(), cloud.points.end(),
                               [](const Eigen::Vector3d& p) { return p.allFinite(); });
  if (!any) {
    throw core::InputError(file.string() + ": none of its " + std::to_string(cloud.points.size()) +
                           " points is finite");
  }
  return cloud;
}

void WriteCloud(const std::filesystem::path& file, const RangeImage& image,
                const std::vector<CloudField>& fields) {
  CheckFields(image, fields);
  internal::WriteBytes(file,
                       EndsWith(file, ".ply") ? PlyBytes(image, fields) : PcdBytes(image, fields));
}

void WriteColoredPly(const std::filesystem::path& file, const TriangleMesh& mesh,
                     const std::vector<std::array<std::uint8_t, 3>>& colors) {
  if (colors.size() != mesh.vertices.size()) {
    throw std::invalid_argument("WriteColoredPly: " + std::to_string(colors.size()) +
                                " colours for " + std::to_string(mesh.vertices.size()) +
                                " vertices");
  }
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.vertices.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\n"
                      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                      "element face " +
                      std::to_string(mesh.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    AppendPoint(mesh.vertices[i], bytes);
    for (const std::uint8_t channel : colors[i]) internal::AppendRaw(channel, bytes);
  }
  for (const auto& triangle : mesh.triangles) {
    internal::AppendRaw(std::uint8_t{3}, bytes);
    for (const std::uint32_t vertex : triangle) {
      internal::AppendRaw(static_cast<std::int32_t>(vertex), bytes);
    }
  }
  internal::WriteBytes(file, bytes);
}

}  // namespace rangegrasp::geometry
