#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "base/error.h"
#include "base/file.h"
#include "base/stopwatch.h"
#include "error_of.h"
#include "geometry/cloud_file.h"
#include "geometry/mesh_file.h"
#include "geometry/random_points.h"
#include "geometry/sample_meshes.h"
#include "temp_folder.h"

namespace rangegrasp::geometry {
namespace {

using base::InputError;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing_support::ErrorOf;

class Io : public ::testing::Test {
 protected:
  std::filesystem::path Path(const std::string& name) const { return folder_ / name; }
  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    return folder_.Write(name, text);
  }
  /// The errors that reading a cloud or mesh with this text gives.
  std::string CloudError(const std::string& name, const std::string& text) const {
    return ErrorOf([&] { ReadCloud(Write(name, text)); });
  }
  std::string MeshError(const std::string& name, const std::string& text) const {
    return ErrorOf([&] { ReadMesh(Write(name, text)); });
  }

  testing_support::TempFolder folder_;
};

std::string Ascii(const std::string& points = "POINTS 2\n", const std::string& fields = "x y z",
                  const std::string& type = "F F F", const std::string& body = "1 2 3\n4 5 6\n",
                  const std::string& data = "ascii") {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS " + fields + "\nSIZE 4 4 4\nTYPE " + type +
         "\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0.5 0 1 1 0 0 0\n" + points + "DATA " + data +
         "\n" + body;
}

pcl::PointCloud<pcl::PointXYZRGB> RandomPclCloud(base::Rng& rng) {
  pcl::PointCloud<pcl::PointXYZRGB> cloud(20, 10);
  for (auto& p : cloud) {
    p.x = static_cast<float>(rng.Normal());
    p.y = static_cast<float>(rng.Normal());
    p.z = static_cast<float>(rng.Normal());
    p.r = static_cast<std::uint8_t>(rng.Index(256));
    p.g = static_cast<std::uint8_t>(rng.Index(256));
    p.b = static_cast<std::uint8_t>(rng.Index(256));
  }
  cloud.at(3, 4).x = std::numeric_limits<float>::quiet_NaN();
  cloud.sensor_origin_ = {0.25f, 0.5f, 1.0f, 1.0f};
  return cloud;
}

void ExpectSame(const CloudFile& ours, const pcl::PointCloud<pcl::PointXYZRGB>& theirs,
                double tolerance) {
  ASSERT_EQ(ours.width, static_cast<int>(theirs.width));
  ASSERT_EQ(ours.height, static_cast<int>(theirs.height));
  ASSERT_EQ(ours.points.size(), theirs.size());
  ASSERT_EQ(ours.colors.size(), theirs.size());
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    EXPECT_EQ(ours.colors[i], (Rgb{theirs[i].r, theirs[i].g, theirs[i].b}));
    const Eigen::Vector3d p = theirs[i].getVector3fMap().cast<double>();
    EXPECT_EQ(ours.points[i].allFinite(), p.allFinite());
    if (!p.allFinite()) continue;
    EXPECT_LE((ours.points[i] - p).norm(), tolerance);
  }
  ASSERT_TRUE(ours.sensor_origin);
  EXPECT_EQ(*ours.sensor_origin, Eigen::Vector3d(0.25, 0.5, 1.0));
}

TEST_F(Io, ReadsWhatPclWritesInEveryPcdFormat) {
  base::Rng rng(1);
  const auto cloud = RandomPclCloud(rng);
  pcl::PCDWriter writer;
  writer.writeASCII(Path("a.pcd").string(), cloud, 9);
  writer.writeBinary(Path("b.pcd").string(), cloud);
  writer.writeBinaryCompressed(Path("c.pcd").string(), cloud);
  ExpectSame(ReadCloud(Path("a.pcd")), cloud, 1e-6);  // 9 digits
  ExpectSame(ReadCloud(Path("b.pcd")), cloud, 0.0);
  ExpectSame(ReadCloud(Path("c.pcd")), cloud, 0.0);
}

RangeImage RandomImage(base::Rng& rng) {
  RangeImage image;
  image.profiles = 7;
  image.samples = 11;
  image.points_C = samples::RandomPoints(77, 1.0, rng);
  image.points_C[5].setConstant(std::numeric_limits<double>::quiet_NaN());
  image.origins_C = {{0.8, 0.0, 0.62}};
  return image;
}

TEST_F(Io, BytesBehindCompressedDataDoNotCount) {
  base::Rng rng(2);
  const auto theirs = RandomPclCloud(rng);
  pcl::io::savePCDFileBinaryCompressed(Path("c.pcd").string(), theirs);
  Write("c.pcd", base::ReadFile(Path("c.pcd")) + std::string(3889, '\0'));  // as older PCL wrote it
  ExpectSame(ReadCloud(Path("c.pcd")), theirs, 0.0);
}

TEST_F(Io, PclReadsWhatWeWrite) {
  base::Rng rng(2);
  const RangeImage image = RandomImage(rng);
  CloudField label{"label", Indices(77, 3u)};
  label.values[4] = 4000000000u;
  WriteCloud(Path("w.pcd"), image, {label});
  pcl::PointCloud<pcl::PointXYZL> cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(Path("w.pcd").string(), cloud), 0);
  ASSERT_EQ(cloud.width, 11u);
  ASSERT_EQ(cloud.height, 7u);
  EXPECT_NEAR(static_cast<double>(cloud.sensor_origin_.z()), 0.62, 1e-6);
  for (std::size_t i = 0; i < 77; ++i) {
    EXPECT_EQ(cloud[i].label, label.values[i]);
    if (i == 5) continue;
    EXPECT_EQ(cloud[i].getVector3fMap(), image.points_C[i].cast<float>());
  }
}

TEST_F(Io, CloudsSurviveAWriteAndARead) {
  base::Rng rng(3);
  const RangeImage image = RandomImage(rng);
  WriteCloud(Path("w.pcd"), image);
  WriteCloud(Path("w.ply"), image, {{"label", Indices(77, 1u)}});
  const CloudFile pcd = ReadCloud(Path("w.pcd"));
  const CloudFile ply = ReadCloud(Path("w.ply"));
  EXPECT_EQ(pcd.width, 11);
  EXPECT_EQ(pcd.height, 7);
  EXPECT_EQ(ply.points.size(), 76u);  // only measured points
  EXPECT_TRUE(std::isnan(pcd.points[5].x()));
  for (std::size_t i = 0; i < 77; ++i) {
    if (i == 5) continue;
    EXPECT_LE((pcd.points[i] - image.points_C[i]).norm(), 1e-7);
    EXPECT_LE((ply.points[i - (i > 5 ? 1 : 0)] - image.points_C[i]).norm(), 1e-7);
  }
  ASSERT_TRUE(ply.sensor_origin);
  EXPECT_LE((*ply.sensor_origin - image.origins_C[0]).norm(), 1e-6);  // 6 decimals
  EXPECT_THROW(WriteCloud(Path("x.pcd"), image, {{"label", {1}}}), std::invalid_argument);
}

TEST_F(Io, OnlyOurCommentIsAPlysViewpoint) {
  const auto origin = [&](const std::string& comment) {
    return ReadCloud(Write("a.ply", "ply\nformat ascii 1.0\ncomment " + comment +
                                        "\nelement vertex 1\nproperty float x\nproperty float y\n"
                                        "property float z\nend_header\n1 2 3\n"),
                     0.001)
        .sensor_origin;
  };
  ASSERT_TRUE(origin("viewpoint 100 0 -250"));
  EXPECT_EQ(*origin("viewpoint 100 0 -250"), Eigen::Vector3d(0.1, 0.0, -0.25));
  for (const char* other : {"hi", "viewpoint", "viewpoint from the left", "viewpoint 1 2 nan"}) {
    EXPECT_FALSE(origin(other)) << other;
  }
}

std::vector<Rgb> RandomColors(std::size_t count, base::Rng& rng) {
  std::vector<Rgb> colors(count);
  for (Rgb& color : colors) {
    for (auto& level : color) level = static_cast<std::uint8_t>(rng.Index(256));
  }
  return colors;
}

TEST_F(Io, ColorsSurviveAWriteAndARead) {
  base::Rng rng(4);
  const RangeImage image = RandomImage(rng);
  auto colors = RandomColors(77, rng);
  WriteCloud(Path("w.pcd"), image, {{"label", Indices(77, 1u)}, ColorField(colors)});
  WriteCloud(Path("w.ply"), image, {ColorField(colors), {"label", Indices(77, 1u)}});
  EXPECT_EQ(ReadCloud(Path("w.pcd")).colors, colors);
  EXPECT_EQ(ReadCloud(Path("w.pcd")).labels, Indices(77, 1u));
  pcl::PointCloud<pcl::PointXYZRGB> theirs;
  ASSERT_EQ(pcl::io::loadPCDFile(Path("w.pcd").string(), theirs), 0);
  for (std::size_t i = 0; i < 77; ++i) {
    EXPECT_EQ(colors[i], (Rgb{theirs[i].r, theirs[i].g, theirs[i].b}));
  }
  colors.erase(colors.begin() + 5);  // point 5 was not measured
  EXPECT_EQ(ReadCloud(Path("w.ply")).colors, colors);
  WriteCloud(Path("none.pcd"), image);
  EXPECT_TRUE(ReadCloud(Path("none.pcd")).colors.empty());
}

// A field named rgb that is not a packed color, and red without green and blue, are no colors.
TEST_F(Io, WhatIsNoColorIsLeftOut) {
  Write("a.pcd",
        "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 2\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 1\n"
        "HEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3 4\n");
  Write("b.pcd",
        "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 1\n"
        "HEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3 65793\n");
  EXPECT_TRUE(ReadCloud(Path("a.pcd")).colors.empty());
  EXPECT_EQ(ReadCloud(Path("b.pcd")).colors, (std::vector<Rgb>{{1, 1, 1}}));
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\n";
  Write("a.ply", head + "end_header\n1 2 3 4\n");
  Write("b.ply", head + "property uchar green\nproperty uchar blue\nend_header\n1 2 3 4 5 255\n");
  EXPECT_TRUE(ReadCloud(Path("a.ply")).colors.empty());
  EXPECT_EQ(ReadCloud(Path("b.ply")).colors, (std::vector<Rgb>{{4, 5, 255}}));
}

TEST_F(Io, TheUnitScalesPointsAndViewpoint) {
  const CloudFile cloud = ReadCloud(Write("mm.pcd", Ascii()), 0.001);
  EXPECT_TRUE(cloud.points[1].isApprox(Eigen::Vector3d(0.004, 0.005, 0.006)));
  EXPECT_TRUE(cloud.sensor_origin->isApprox(Eigen::Vector3d(0.0005, 0.0, 0.001)));
  EXPECT_THROW(ReadCloud(Path("mm.pcd"), 0.0), std::invalid_argument);
}

TEST_F(Io, APointThatIsNotWhollyMeasuredIsNotMeasured) {
  const CloudFile cloud =
      ReadCloud(Write("holes.pcd", Ascii("", "x y z", "F F F", "1 2 3\n4 nan 6\n")));
  ASSERT_EQ(cloud.points.size(), 2u);
  EXPECT_TRUE(cloud.points[0].allFinite());
  EXPECT_TRUE(cloud.points[1].array().isNaN().all());
}

TEST_F(Io, UnitsAreFiniteAndEndingsOfEitherCase) {
  const auto file = Write("mm.pcd", Ascii());
  for (const double unit :
       {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(ReadCloud(file, unit), std::invalid_argument) << unit;
  }
  EXPECT_THAT(CloudError("BROKEN.PLY", "plx\n"), HasSubstr("starts with the line"));
}

TEST_F(Io, BrokenPcdFilesAreNamedWithLineAndCause) {
  const auto message = [this](const std::string& text) { return CloudError("broken.pcd", text); };
  EXPECT_THAT(ErrorOf([&] { ReadCloud(Path("none.pcd")); }),
              AllOf(HasSubstr("none.pcd"), HasSubstr("no such file")));
  EXPECT_THAT(ErrorOf([&] { ReadCloud(folder_.path()); }), HasSubstr("is a folder"));
  EXPECT_THAT(message(""), HasSubstr("is empty"));
  EXPECT_THAT(message("hello\n"), AllOf(HasSubstr("broken.pcd:1:"), HasSubstr("\"hello\"")));
  EXPECT_THAT(message("# nothing more\n"), HasSubstr("without DATA"));
  EXPECT_THAT(message(Ascii("POINTS 99999999999999\n")),
              AllOf(HasSubstr("broken.pcd:10:"), HasSubstr("99999999999999")));
  EXPECT_THAT(message(Ascii("POINTS 3\n")), HasSubstr("WIDTH x HEIGHT is 2 x 1"));
  EXPECT_THAT(message(Ascii("POINTS -2\n")), HasSubstr("\"-2\""));
  EXPECT_THAT(message(Ascii("", "x y q")), HasSubstr("has no z"));
  EXPECT_THAT(message(Ascii("", "x y z", "U F F")),
              AllOf(HasSubstr("field x"), HasSubstr("TYPE U")));
  EXPECT_THAT(message(Ascii("", "x y")), HasSubstr("2 FIELDS"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n")), HasSubstr("after 1 point;"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1\n")), HasSubstr("truncated"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n   \n")), HasSubstr("after 1 point;"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n4 5\n")),
              AllOf(HasSubstr("broken.pcd:12:"), HasSubstr("2 values")));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n4 five 6\n")), HasSubstr("\"five\""));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "nan nan nan\nnan 1 2\n")),
              HasSubstr("none of its 2 points is finite"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "0123456789", "binary")), HasSubstr("24"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "0123456789", "zip")), HasSubstr("\"zip\""));
  EXPECT_THAT(message("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 0\nDATA ascii\n"),
              HasSubstr("no points"));
  EXPECT_THAT(message("FIELDS x y z\nWIDTH 2147483647\nHEIGHT 2147483647\nDATA binary\n"),
              HasSubstr("too large"));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n4 5 6\n7 8 9\n")),
              AllOf(HasSubstr("broken.pcd:13:"), HasSubstr("more data follow")));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n4 5 6 7\n")),
              AllOf(HasSubstr("broken.pcd:12:"), HasSubstr("4 values")));
  // One extra byte shifts all numbers after it.
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", std::string(25, '7'), "binary")),
              AllOf(HasSubstr("25 bytes"), HasSubstr("says 24")));
  EXPECT_THAT(message(Ascii("", "x y z", "F F F", "1 2 3\n4 5 1e5\n")),
              AllOf(HasSubstr("broken.pcd: point 1"), HasSubstr("beyond 10000")));
  // A value too large for a double counts as not measured.
  const auto cloud = ReadCloud(Write("e.pcd", Ascii("", "x y z", "F F F", "1 2 3\n4 5 1e400\n")));
  EXPECT_TRUE(cloud.points[1].array().isNaN().all());
}

TEST_F(Io, AValueThatItsTypeDoesNotHoldIsNamed) {
  const auto message = [this](const std::string& type, const std::string& value) {
    const auto file = Write("label.ply",
                            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                            "property float y\nproperty float z\nproperty " +
                                type + " label\nend_header\n1 2 3 " + value + "\n");
    return testing_support::MessageOf<InputError>([&] { ReadCloud(file); });
  };
  for (const char* value : {"0.00029", "-1", "4294967296", "nan"}) {
    EXPECT_THAT(message("uint", value), AllOf(HasSubstr("label.ply:9:"), HasSubstr(value)));
  }
  EXPECT_TRUE(message("uint", "4294967295").empty());
  EXPECT_TRUE(message("char", "-128").empty());
  EXPECT_THAT(message("char", "128"), HasSubstr("\"128\""));
  EXPECT_TRUE(message("float", "0.00029").empty());
}

TEST_F(Io, ReadsPlyCloudsInBothBinaryOrdersAndAscii) {
  const std::string properties =
      "element vertex 1\nproperty uchar red\nproperty double x\nproperty float y\n"
      "property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";
  Write("a.ply", "ply\nformat ascii 1.0\ncomment hi\n" + properties + "7 1.5 2 -3\n");
  // 1.5 = 3ff8..., 2 = 40000000, -3 = c0400000, most significant byte first.
  const std::string big("\x07\x3f\xf8\0\0\0\0\0\0\x40\0\0\0\xc0\x40\0\0", 17);
  const std::string little("\x07\0\0\0\0\0\0\xf8\x3f\0\0\0\x40\0\0\x40\xc0", 17);
  Write("b.ply", "ply\nformat binary_big_endian 1.0\n" + properties + big);
  Write("l.ply", "ply\nformat binary_little_endian 1.0\n" + properties + little);
  for (const char* name : {"a.ply", "b.ply", "l.ply"}) {
    EXPECT_EQ(ReadCloud(Path(name)).points, (Points{{1.5, 2.0, -3.0}})) << name;
  }
}

// An .npy file as numpy.save writes it: the header ends with a newline at a multiple of 64 bytes.
std::string Npy(const std::string& shape, const std::string& descr, const std::string& data,
                const std::string& fortran = "False") {
  std::string header =
      "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': (" + shape + "), }";
  header += std::string((64 - (header.size() + 11) % 64) % 64, ' ') + "\n";
  const auto length = static_cast<char>(header.size());
  return std::string("\x93NUMPY\x01\x00", 8) + length + '\0' + header + data;
}

template <class Real>
std::string BytesOf(std::initializer_list<Real> values) {
  std::string bytes;
  for (const Real value : values) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  return bytes;
}

const double kNan = std::numeric_limits<double>::quiet_NaN();

TEST_F(Io, ReadsArraysOfNumPy) {
  const auto rows =
      ReadCloud(Write("a.npy", Npy("2, 3", "<f4", BytesOf({1.f, 2.f, 3.f, 4.f, 5.f, 6.f}))));
  EXPECT_EQ(rows.points, (Points{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(rows.width, 2);
  EXPECT_EQ(rows.height, 1);
  EXPECT_FALSE(rows.sensor_origin);
  const auto image = ReadCloud(
      Write("b.npy", Npy("2, 1, 3", "<f8", BytesOf({1.0, 2.0, 3.0, 4.0, kNan, 6.0}))), 0.001);
  EXPECT_EQ(image.width, 1);
  EXPECT_EQ(image.height, 2);
  EXPECT_TRUE(image.points[0].isApprox(Eigen::Vector3d(0.001, 0.002, 0.003)));
  EXPECT_FALSE(image.points[1].array().isFinite().any());  // all three are NaN
  std::string swapped = BytesOf({3.0f, 2.0f, 1.0f});
  std::ranges::reverse(swapped);
  EXPECT_EQ(ReadCloud(Write("c.npy", Npy("1, 3", ">f4", swapped))).points, (Points{{1, 2, 3}}));
}

TEST_F(Io, BrokenArraysAreNamedWithTheirCause) {
  const auto told = [this](const std::string& bytes) { return CloudError("bad.npy", bytes); };
  const std::string six = BytesOf({1.f, 2.f, 3.f, 4.f, 5.f, 6.f});
  EXPECT_THAT(told("PK"), HasSubstr("bad.npy: byte 0: an NPY file starts with"));
  EXPECT_THAT(told(std::string("\x93NUMPY\x04\x00"
                               "aaaa",
                               12)),
              HasSubstr("byte 6: no format version"));
  EXPECT_THAT(told(std::string("\x93NUMPY\x01\x00\xff\x7f{}", 12)),
              HasSubstr("byte 8: the header has 32767 bytes"));
  EXPECT_THAT(told(Npy("2, 3", "<i4", six)), HasSubstr("'descr' is \"<i4\"; the numbers must be"));
  EXPECT_THAT(told(Npy("2, 3", "<f4", six, "True")), HasSubstr("numpy.ascontiguousarray"));
  EXPECT_THAT(told(Npy("2, 3", "<f4", six, "0")), HasSubstr("no valid 'fortran_order'"));
  for (const char* shape : {"6,", "3, 2", "1, 1, 2, 3", "0, 3", "99999999999999999999, 3"}) {
    EXPECT_THAT(told(Npy(shape, "<f4", six)), HasSubstr("N x 3 or H x W x 3 are needed")) << shape;
  }
  EXPECT_THAT(told(Npy("3, 3", "<f4", six)),
              HasSubstr("(3, 3) needs 36 bytes of data; there are 24"));
  EXPECT_THAT(told(Npy("2147483647, 2147483647, 3", "<f4", six)), HasSubstr("bytes of data"));
  EXPECT_THAT(told(Npy("1, 3", "<f4", six)), HasSubstr("needs 12 bytes"));
  EXPECT_THAT(told(Npy("1, 3", "<f8", BytesOf({kNan, 0.0, 0.0}))),
              HasSubstr("none of its 1 points"));
  EXPECT_THAT(told(Npy("1, 3", "<f8", BytesOf({1e9, 0.0, 0.0}))),
              HasSubstr("point 0 [m] is at 1e+09"));
}

TEST_F(Io, ReadsRowsOfText) {
  const auto cloud = ReadCloud(Write("a.xyz", "# x y z intensity\r\n1 2 3 0.5\n\n4\tnan 6 0.1\n"));
  EXPECT_EQ(cloud.width, 2);
  EXPECT_EQ(cloud.height, 1);
  EXPECT_EQ(cloud.points[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(cloud.points[1].array().isFinite().any());
  EXPECT_EQ(ReadCloud(Write("a.TXT", "1 2 3")).points, (Points{{1, 2, 3}}));
  const auto told = [this](const std::string& text) { return CloudError("bad.xyz", text); };
  EXPECT_THAT(told("1 2 3\n1,2,3\n"), HasSubstr("bad.xyz:2: \"1,2,3\" has 1 value;"));
  EXPECT_THAT(told("1 2 3\n1 2 3 4\n"),
              HasSubstr("bad.xyz:2: has 4 values; the lines before have 3"));
  EXPECT_THAT(told("1 2 x\n"), HasSubstr("bad.xyz:1: \"x\" is not a number"));
  EXPECT_THAT(told("# nothing\n"), HasSubstr("none of its 0 points"));
}

TEST_F(Io, BrokenPlyFilesAreNamedWithLineAndCause) {
  const auto message = [this](const std::string& text) { return CloudError("broken.ply", text); };
  const std::string head = "ply\nformat ascii 1.0\nelement vertex ";
  const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  EXPECT_THAT(message("plx\n"), HasSubstr("starts with the line"));
  EXPECT_THAT(message("ply\nformat zip 1.0\nelement vertex 1" + xyz), HasSubstr("\"zip\""));
  EXPECT_THAT(message(head + "99999999999" + xyz), HasSubstr("broken.ply:3:"));
  EXPECT_THAT(message(head + "1000000" + xyz + "1 2 3\n"), HasSubstr("truncated"));
  EXPECT_THAT(message(head + "0" + xyz), HasSubstr("no points"));
  EXPECT_THAT(message(head + "1\nproperty float x\nend_header\n1\n"), HasSubstr("no property y"));
  EXPECT_THAT(message(head + "1\nproperty int x\nend_header\n1\n"), HasSubstr("\"int\""));
  EXPECT_THAT(message(head + "1\nproperty float x\n"), HasSubstr("without end_header"));
  EXPECT_THAT(message(head + "1" + xyz + "1 2 3\n4 5 6\n"), HasSubstr("more data follow"));
  EXPECT_THAT(message(head + "1" + xyz + "1 2 3 4\n"), HasSubstr("4 values"));
  EXPECT_THAT(message("ply\nformat binary_little_endian 1.0\nelement vertex 1" + xyz +
                      std::string(13, '7')),
              HasSubstr("13 bytes"));
}

/// Flips, cuts, duplicates or fills bytes at random.
std::string Mutated(std::string bytes, base::Rng& rng) {
  const std::size_t changes = 1 + rng.Index(8);
  for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) {
    // Half of the changes hit the header.
    const std::size_t end =
        rng.Index(2) == 0 ? bytes.size() : std::min<std::size_t>(300, bytes.size());
    const std::size_t at = rng.Index(end);
    switch (rng.Index(5)) {
      case 0:
        bytes[at] = static_cast<char>(rng.Index(256));
        break;
      case 1:
        bytes.resize(at);
        break;
      case 2:
        bytes.erase(at, rng.Index(20));
        break;
      case 3:
        bytes.insert(at, bytes.substr(rng.Index(bytes.size()), 20));
        break;
      default:
        bytes[at] = static_cast<char>('0' + rng.Index(10));
        break;
    }
  }
  return bytes;
}

TEST_F(Io, AnyMutatedFileIsReadOrRefusedWithoutACrashAndWithoutAWord) {
  base::Rng rng(11);
  const auto cloud = RandomPclCloud(rng);
  pcl::PCDWriter().writeASCII(Path("0").string(), cloud, 9);
  pcl::PCDWriter().writeBinary(Path("1").string(), cloud);
  pcl::PCDWriter().writeBinaryCompressed(Path("2").string(), cloud);
  WriteCloud(Path("3.ply"), RandomImage(rng));
  const std::vector<std::string> seeds = {base::ReadFile(Path("0")), base::ReadFile(Path("1")),
                                          base::ReadFile(Path("2")), base::ReadFile(Path("3.ply")),
                                          Npy("2, 3", "<f4", std::string(24, '\0'))};
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto file = Write("mutated", Mutated(seeds[rng.Index(seeds.size())], rng));
    try {
      EXPECT_FALSE(ReadCloud(file).points.empty());
    } catch (const InputError& error) {
      ++refused;
      EXPECT_THAT(error.what(), HasSubstr("mutated"));
    }
  }
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 2000);
}

// The vertices of an OBJ file.
std::string ObjVertices(const std::string& rows) {
  std::string obj;
  std::istringstream lines(rows);
  for (std::string row; std::getline(lines, row);) obj += "v " + row + "\n";
  return obj;
}

// A box in every text format, with polygons where the format allows them.
std::vector<std::pair<std::string, std::string>> BoxFiles() {
  const std::string corners = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n";
  const std::string faces =
      "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n3 1 2 6\n3 1 6 5\n4 2 3 7 6\n4 3 0 4 7\n";
  const std::string obj =
      ObjVertices(corners) +
      "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  std::string stl = "solid box\n";
  for (int k = 0; k < 4; ++k) {
    stl += "facet normal 0 0 1\nouter loop\nvertex 0 0 " + std::to_string(k) +
           "\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  }
  return {{"box.off", "OFF\n8 7 0\n" + corners + faces},
          {"box.ply",
           "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float "
           "y\nproperty float z\nelement face 7\nproperty list uchar int "
           "vertex_indices\nend_header\n" +
               corners + faces},
          {"box.obj", obj},
          {"box.stl", stl + "endsolid box\n"}};
}

// The box in binary formats, too.
std::vector<std::pair<std::string, std::string>> MeshFiles(const testing_support::TempFolder& at) {
  auto files = BoxFiles();
  const TriangleMesh box = samples::BoxMesh({0.1, 0.2, 0.3});
  WriteStl(at / "binary.stl", box);
  WriteColoredPly(at / "binary.ply", box, {8, {255, 0, 10}});
  for (const char* name : {"binary.stl", "binary.ply"}) {
    files.emplace_back(name, base::ReadFile(at / name));
  }
  files.emplace_back("tetrahedron.glb",
                     base::ReadFile(RANGEGRASP_SOURCE_DIR "/tests/data/meshes/tetrahedron.glb"));
  return files;
}

TEST_F(Io, AnyMutatedMeshIsReadOrRefusedAtOnceAndWithoutACrash) {
  constexpr double kLimit_s = 5.0;  // for a file of a few hundred bytes
  base::Rng rng(12);
  int refused = 0;
  int read = 0;
  for (const auto& [name, text] : MeshFiles(folder_)) {
    EXPECT_NO_THROW(ReadMesh(Write(name, text))) << name;
    for (int i = 0; i < 500; ++i) {
      const auto file = Write(name, Mutated(text, rng));
      const base::Stopwatch watch;
      try {
        const TriangleMesh mesh = ReadMesh(file);
        EXPECT_FALSE(mesh.triangles.empty());
        for (const auto& triangle : mesh.triangles) {
          for (const std::uint32_t v : triangle) EXPECT_LT(v, mesh.vertices.size());
        }
        ++read;
      } catch (const InputError& error) {
        ++refused;
        EXPECT_THAT(error.what(), HasSubstr(name));
      }
      EXPECT_LT(watch.Seconds(), kLimit_s) << name << " " << i;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_GT(read, 200);
}

// assimp has readers for fifty formats and chooses one from the file's content.
TEST_F(Io, AMeshOfAnotherFormatIsRefused) {
  const std::string ac3d =
      "AC3Db\nMATERIAL \"a\" rgb 1 1 1 amb 1 1 1 emis 0 0 0 spec 0 0 0 shi 0 trans 0\n"
      "OBJECT world\nkids 1\nOBJECT poly\nnumvert 3\n0 0 0\n1 0 0\n0 1 0\nnumsurf 1\nSURF 0x20\n"
      "mat 0\nrefs 3\n0 0 0\n1 0 0\n2 0 0\nkids 0\n";
  const std::string open_gex = "g\xbelT\"geometrynode\"3.0  {";  // its reader reads beyond the end
  for (const std::string& text : {ac3d, open_gex}) {
    EXPECT_THAT(MeshError("other.glb", text),
                AllOf(HasSubstr("other.glb"), HasSubstr("cannot be read as OFF, OBJ")));
  }
}

TEST_F(Io, APlyThatDeclaresFacesIsAMesh) {
  EXPECT_TRUE(PlyHoldsMesh(Write("box.ply", BoxFiles()[1].second)));
  base::Rng rng(3);
  WriteCloud(Path("cloud.ply"), RandomImage(rng));
  EXPECT_FALSE(PlyHoldsMesh(Path("cloud.ply")));
  EXPECT_FALSE(PlyHoldsMesh(Write("box.off", BoxFiles()[0].second)));
  EXPECT_THROW(PlyHoldsMesh(Write("bad.ply", "ply\nelement\n")), InputError);
}

TEST_F(Io, AMissingFolderIsMadeAndAFullDiskIsARunError) {
  base::Rng rng(4);
  const RangeImage image = RandomImage(rng);
  WriteCloud(Path("no/such/folder.pcd"), image);
  EXPECT_TRUE(std::filesystem::is_regular_file(Path("no/such/folder.pcd")));
  EXPECT_THROW(WriteCloud(Path("no/such/folder.pcd/cloud.pcd"), image), base::InputError);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THAT(ErrorOf<base::RunError>([&] { WriteCloud("/dev/full", image); }),
              HasSubstr("/dev/full"));
}

TEST_F(Io, AColoredMeshIsReadBack) {
  const TriangleMesh mesh = samples::BoxMesh({0.1, 0.2, 0.3});
  WriteColoredPly(Path("box.ply"), mesh, {8, {255, 0, 10}});
  const TriangleMesh read = ReadMesh(Path("box.ply"));
  EXPECT_EQ(read.vertices.size(), 8u);
  EXPECT_EQ(read.triangles.size(), 12u);
  EXPECT_NEAR(Volume(read), 8.0 * 0.1 * 0.2 * 0.3, 1e-7);  // single precision
  EXPECT_THROW(WriteColoredPly(Path("box.ply"), mesh, {}), std::invalid_argument);
}

TEST_F(Io, ReadsTheMeshFormats) {
  Write("t.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  Write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  std::string stl = "solid t\n";
  for (const char* facet :
       {"0 0 0|0 1 0|1 0 0", "0 0 0|1 0 0|0 0 1", "1 0 0|0 1 0|0 0 1", "0 0 0|0 0 1|0 1 0"}) {
    std::string corners = facet;
    stl += "facet normal 0 0 0\nouter loop\n";
    for (std::size_t bar; (bar = corners.find('|')) != std::string::npos;) {
      stl += "vertex " + corners.substr(0, bar) + "\n";
      corners.erase(0, bar + 1);
    }
    stl += "vertex " + corners + "\nendloop\nendfacet\n";
  }
  Write("t.stl", stl + "endsolid t\n");
  for (const char* name : {"t.off", "t.obj", "t.stl"}) {
    const TriangleMesh mesh = ReadMesh(Path(name));
    EXPECT_EQ(mesh.vertices.size(), 4u) << name;
    EXPECT_EQ(mesh.triangles.size(), 4u) << name;
    EXPECT_NEAR(Volume(mesh), 1.0 / 6.0, 1e-9) << name;
  }
}

TEST_F(Io, ACubeAtSurveyCoordinatesKeepsItsMillimetres) {
  // At 5e6 m, single precision has steps of 0.5 m and double precision 1e-9 m.
  const Eigen::Vector3d shift(5e6, 4.5e6, 1e6);
  const std::string ply_header =
      "element vertex 4\nproperty double x\nproperty double y\nproperty "
      "double z\nelement face 4\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  const std::string places =
      "5000000 4500000 1000000\n5000000.125 4500000 1000000\n5000000 4500000.25 1000000\n"
      "5000000 4500000 1000000.0625\n";
  const std::string faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  Write("t.off", "OFF\n4 4 0\n" + places + faces);
  Write("t.ply", "ply\nformat ascii 1.0\n" + ply_header + places + faces);
  Write("t.obj", ObjVertices(places) + "f 1 3 2\nf 1 2 4\nf -3 -2 -1\nf 1/7 4//3 3/1/1\n");
  for (const char* name : {"t.off", "t.ply", "t.obj"}) {
    TriangleMesh mesh = ReadMesh(Path(name));
    ASSERT_EQ(mesh.vertices.size(), 4U) << name;
    EXPECT_EQ(mesh.vertices[1], shift + Eigen::Vector3d(0.125, 0, 0)) << name;
    for (Eigen::Vector3d& p : mesh.vertices) p -= shift;
    EXPECT_DOUBLE_EQ(Volume(mesh), 0.125 * 0.25 * 0.0625 / 6.0) << name;
  }
}

TEST_F(Io, PolygonsAreCutWhereTheyStandAndKnownByTheirNumber) {
  // A square, a line, an arrowhead with its concave corner last, and an L with six corners.
  const auto file = Write("p.off",
                          "OFF\n14 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
                          "2 0 0\n4 1 0\n2 2 0\n3 1 0\n"
                          "5 0 0\n7 0 0\n7 1 0\n6 1 0\n6 2 0\n5 2 0\n"
                          "4 0 1 2 3\n2 0 1\n4 4 5 6 7\n6 8 9 10 11 12 13\n");
  const PolygonMesh read = ReadPolygonMesh(file);
  EXPECT_EQ(read.polygons, 4U);
  EXPECT_EQ(read.polygon, (std::vector<std::uint32_t>{0, 0, 2, 2, 3, 3, 3, 3}));
  std::vector<double> area(4, 0.0);
  for (std::size_t t = 0; t < read.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = read.mesh.triangles[t];
    const Eigen::Vector3d& p = read.mesh.vertices[a];
    const Eigen::Vector3d n = (read.mesh.vertices[b] - p).cross(read.mesh.vertices[c] - p);
    EXPECT_GT(n.z(), 0.0) << t;  // none is flipped, so the triangles do not overlap
    area[read.polygon[t]] += 0.5 * n.z();
  }
  EXPECT_EQ(area, (std::vector<double>{1.0, 0.0, 1.0, 3.0}));
}

// No fan of triangles stays inside a cross.
TEST_F(Io, APolygonWithConcaveCornersOnAllSidesIsCutInsideItsBorder) {
  const PolygonMesh read = ReadPolygonMesh(
      Write("p.off",
            "OFF\n12 1 0\n1 0 0\n2 0 0\n2 1 0\n3 1 0\n3 2 0\n2 2 0\n2 3 0\n1 3 0\n1 2 0\n"
            "0 2 0\n0 1 0\n1 1 0\n12 0 1 2 3 4 5 6 7 8 9 10 11\n"));
  double area = 0.0;
  for (const auto& [a, b, c] : read.mesh.triangles) {
    const Eigen::Vector3d& p = read.mesh.vertices[a];
    const Eigen::Vector3d n = (read.mesh.vertices[b] - p).cross(read.mesh.vertices[c] - p);
    EXPECT_GT(n.z(), 0.0);
    area += 0.5 * n.z();
  }
  EXPECT_DOUBLE_EQ(area, 5.0);
}

TEST_F(Io, APolygonThatCrossesItselfHasTriangles) {
  const PolygonMesh read = ReadPolygonMesh(
      Write("p.off", "OFF\n5 1 0\n0 0 0\n2 2 0\n2 0 0\n0 2 0\n-1 1 0\n5 0 1 2 3 4\n"));
  EXPECT_EQ(read.mesh.triangles.size(), 3U);
}

TEST_F(Io, FacesOfAPlyAreTheSameInEveryFormat) {
  const std::string head =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar "
      "red\nelement edge 1\nproperty short a\nelement face 2\nproperty uchar flag\nproperty list "
      "ushort uint vertex_index\nend_header\n";
  const auto bytes = [](bool swap) {
    std::string all;
    const auto put = [&](auto value) {
      std::string one(reinterpret_cast<const char*>(&value), sizeof(value));
      if (swap) std::reverse(one.begin(), one.end());
      all += one;
    };
    for (const auto& [x, y, z] :
         {std::tuple{0.F, 0.F, 0.F}, {1.F, 0.F, 0.F}, {1.F, 1.F, 0.F}, {0.F, 1.F, 1.F}}) {
      put(x), put(y), put(z), put(std::uint8_t{7});
    }
    put(std::int16_t{-1});
    for (const std::vector<std::uint32_t>& face :
         {std::vector<std::uint32_t>{0, 1, 2, 3}, {0, 2, 1}}) {
      put(std::uint8_t{9}), put(static_cast<std::uint16_t>(face.size()));
      for (const std::uint32_t v : face) put(v);
    }
    return all;
  };
  Write("a.ply", "ply\nformat ascii 1.0\n" + head +
                     "0 0 0 7\n1 0 0 7\n1 1 0 7\n0 1 1 7\n-1\n9 4 0 1 2 3\n9 3 0 2 1\n");
  Write("l.ply", "ply\nformat binary_little_endian 1.0\n" + head + bytes(false));
  Write("b.ply", "ply\nformat binary_big_endian 1.0\n" + head + bytes(true));
  for (const char* name : {"a.ply", "l.ply", "b.ply"}) {
    const PolygonMesh read = ReadPolygonMesh(Path(name));
    EXPECT_EQ(read.polygon, (std::vector<std::uint32_t>{0, 0, 1})) << name;
    EXPECT_EQ(read.mesh.triangles[2], (std::array<std::uint32_t, 3>{0, 2, 1})) << name;
    EXPECT_EQ(read.mesh.vertices[3], Eigen::Vector3d(0, 1, 1)) << name;
  }
}

TEST_F(Io, WhatAMeshDeclaresAndCannotHoldIsToldAtOnce) {
  const std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float "
      "y\nproperty float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n";
  const std::string vertex(12, '\0');
  EXPECT_THAT(MeshError("a.ply", ply + vertex + "\xff\xff\xff\xff" + "0123"),
              AllOf(HasSubstr("4294967295 values"), HasSubstr("too short")));
  EXPECT_THAT(MeshError("a.ply", ply + vertex + std::string("\1\0\0\0\1\0\0\0", 8)),
              HasSubstr("face 0 uses vertex 1; there are 1"));
  EXPECT_THAT(MeshError("a.ply", ply + vertex + "\1"), HasSubstr("the data end"));
  EXPECT_THAT(MeshError("a.off", "OFF\n4000000000 4000000000 0\n0 0 0\n"), HasSubstr("too short"));
  EXPECT_THAT(MeshError("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
              AllOf(HasSubstr("a.off:6:"), HasSubstr("uses vertex '3'; there are 3")));
  EXPECT_THAT(MeshError("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
              HasSubstr("face 1 of 2"));
  EXPECT_THAT(MeshError("a.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"),
              HasSubstr("vertex 1 is not finite"));
  EXPECT_THAT(MeshError("a.off", "OFF\n3 1 0\n0 0 0\n1 1e30 0\n0 1 0\n3 0 1 2\n"),
              HasSubstr("vertex 1 is at 1 1e+30 0, beyond 1e+10"));
  EXPECT_THAT(MeshError("a.off", "OFF\n3 1 0\n0 0 0\n1 x 0\n0 1 0\n3 0 1 2\n"),
              AllOf(HasSubstr("a.off:4:"), HasSubstr("\"x\" is not a number")));
  EXPECT_THAT(MeshError("a.off", "OFF BINARY\n"), HasSubstr("binary OFF is not supported"));
  EXPECT_THAT(MeshError("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
              AllOf(HasSubstr("a.obj:4:"), HasSubstr("\"4\"; there are 3")));
  EXPECT_THAT(MeshError("a.obj", "v 0 0 0\nf 0 1 1\n"), HasSubstr("\"0\""));
}

// tests/data/meshes: written with Python's struct, not by assimp.
TEST_F(Io, ReadsGltf) {
  const PolygonMesh read =
      ReadPolygonMesh(RANGEGRASP_SOURCE_DIR "/tests/data/meshes/tetrahedron.glb");
  EXPECT_EQ(read.polygons, 4U);
  EXPECT_EQ(read.mesh.vertices.size(), 4U);
  EXPECT_NEAR(Volume(read.mesh), 1.0 / 6.0, 1e-6);
  EXPECT_THAT(MeshError("a.3mf", "PK"), HasSubstr("3MF is not supported"));
}

TEST_F(Io, WhatAMeshNamesLiesInItsFolder) {
  std::string triangle;
  for (const float x : {0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F}) {
    triangle.append(reinterpret_cast<const char*>(&x), sizeof(x));
  }
  Write("secret.bin", triangle);
  Write("mesh/data/own.bin", triangle);
  std::filesystem::create_symlink(Path("secret.bin"), Path("mesh/link.bin"));
  const auto read = [&](const std::string& uri) {
    return ReadMesh(Write("mesh/t.gltf",
                          R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "buffers": [{"byteLength": 36, "uri": ")" +
                              uri + R"("}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                           "min": [0, 0, 0], "max": [1, 1, 0]}]})"));
  };
  EXPECT_EQ(read("data/own.bin").triangles.size(), 1U);
  for (const std::string uri : {"../secret.bin", "link.bin"}) {
    EXPECT_THAT(ErrorOf([&] { read(uri); }),
                AllOf(HasSubstr("t.gltf"), HasSubstr(uri), HasSubstr("folder of the mesh")));
  }
}

TEST_F(Io, BytesBehindABinaryStlDoNotCount) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  WriteStl(Path("t.stl"), mesh);
  const std::string bytes = base::ReadFile(Path("t.stl"));
  for (const std::string& behind :
       {std::string("\n"), std::string(500, '\0'), std::string("facet")}) {
    const TriangleMesh read = ReadMesh(Write("more.stl", bytes + behind));
    EXPECT_EQ(read.triangles.size(), 4U);
    EXPECT_NEAR(Volume(read), 1.0 / 6.0, 1e-9);
  }
  EXPECT_THAT(MeshError("less.stl", bytes.substr(0, bytes.size() - 1)), HasSubstr("less.stl"));
}

TEST_F(Io, ATextStlThatIsCutOffIsNamed) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\n";
  const std::string solid = "solid a\n" + facet + facet + "endsolid facet_a\n";
  EXPECT_EQ(ReadMesh(Write("one.stl", solid)).triangles.size(), 2U);
  EXPECT_EQ(ReadMesh(Write("two.stl", solid + solid)).triangles.size(), 4U);
  for (const std::string& cut : {"solid a\n" + facet, solid + "solid b\n" + facet}) {
    EXPECT_THAT(MeshError("cut.stl", cut), HasSubstr("cut.stl: is cut off"));
  }
}

TEST_F(Io, BrokenMeshesAreNamed) {
  EXPECT_THAT(ErrorOf([&] { ReadMesh(Path("none.off")); }), HasSubstr("no such file"));
  EXPECT_THAT(MeshError("junk.off", "this is no mesh"), HasSubstr("junk.off"));
  EXPECT_THAT(MeshError("points.obj", "v 0 0 0\nv 1 0 0\n"), HasSubstr("points.obj"));
}

}  // namespace
}  // namespace rangegrasp::geometry
