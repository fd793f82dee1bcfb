// Labelled clouds of a depth camera, where they are at hand: data/kinect in the folder that
// RANGEGRASP_SHARED names, or in ../shared beside the project.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>

#include "core/file.h"
#include "geometry/cloud_file.h"
#include "pcl_bridge/local_convexity.h"

namespace rangegrasp::pcl_bridge {
namespace {

std::filesystem::path Data() {
  const char* shared = std::getenv("RANGEGRASP_SHARED");
  const std::filesystem::path root =
      shared != nullptr ? shared : std::filesystem::path(RANGEGRASP_SOURCE_DIR) / "../shared";
  return root / "data/kinect";
}

std::uint32_t Word(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

/// The first `size` bytes of LZF data: runs of literals (control < 32: control + 1 of them) and
/// copies (a length of 3 bits and more, a distance of 13 bits).
std::string ExpandLzf(const std::string& in, std::size_t size) {
  std::string out;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(in.at(at)); };
  for (std::size_t at = 0; out.size() < size;) {
    const unsigned control = byte(at++);
    if (control < 32) {
      out += in.substr(at, control + 1);
      at += control + 1;
      continue;
    }
    unsigned length = control >> 5;
    if (length == 7) length += byte(at++);
    const std::size_t distance = ((control & 31u) << 8) + byte(at++) + 1;
    for (unsigned k = 0; k < length + 2; ++k) out += out.at(out.size() - distance);
  }
  return out;
}

/// The column `label`, which is the first: compressed columns stand one after the other.
std::vector<std::uint32_t> ReadFirstColumn(const std::filesystem::path& file, std::size_t points) {
  const std::string text = core::ReadFile(file);
  const std::string head = "DATA binary_compressed\n";
  const std::size_t start = text.find(head) + head.size() + 8;  // after the two sizes
  const std::string column = ExpandLzf(text.substr(start), 4 * points);
  std::vector<std::uint32_t> values;
  for (std::size_t i = 0; i < points; ++i) values.push_back(Word(column, 4 * i));
  return values;
}

/// Sum over objects (labels from 20 on) of |G| max over segments S of |G and S| / |G or S|, divided
/// by the sum of |G|: "weighted overlap", 1 where every object is exactly one segment.
double WeightedOverlap(const std::vector<std::uint32_t>& label,
                       const std::vector<std::int32_t>& segment) {
  std::map<std::uint32_t, std::map<std::int32_t, double>> shared;
  std::map<std::int32_t, double> size;
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (label[i] == 0) continue;  // nothing measured
    if (label[i] >= 20) ++shared[label[i]][segment[i]];
    if (segment[i] >= 0) ++size[segment[i]];
  }
  double sum = 0.0;
  double points = 0.0;
  for (const auto& [object, segments] : shared) {
    double object_points = 0.0;
    for (const auto& [s, both] : segments) object_points += both;
    double best = 0.0;
    for (const auto& [s, both] : segments) {
      if (s >= 0) best = std::max(best, both / (object_points + size[s] - both));
    }
    sum += object_points * best;
    points += object_points;
  }
  return sum / points;
}

TEST(Kinect, LocalConvexityFindsTheObjectsOfATable) {
  if (!std::filesystem::exists(Data())) GTEST_SKIP() << "no labelled clouds in " << Data();
  double sum = 0.0;
  const std::vector<std::string> names = {"learn2", "learn20",
                                          "learn40"};  // boxes, a stack, cylinders
  for (const std::string& name : names) {
    const auto file = Data() / (name + ".pcd");
    const auto points = geometry::ReadCloud(file).points;
    const auto label = ReadFirstColumn(file, points.size());
    // Spacing and noise of a depth camera: voxels of 7.5 mm at 1 m, seeds of 30 mm.
    const LocalConvexityOptions options{.voxel_m = 0.0075, .seed_m = 0.03, .camera_depth = true};
    const LocalConvexity found = SegmentByLocalConvexity(Cloud(points), options);
    const double overlap = WeightedOverlap(label, found.segment);
    RecordProperty("weighted_overlap_" + name, std::to_string(overlap));
    EXPECT_GT(overlap, 0.85) << name;
    sum += overlap;
  }
  // Measured: 0.993, 0.956 and 0.941, with 3, 3 and 5 segments. A tenth is left for other versions.
  EXPECT_GT(sum / static_cast<double>(names.size()), 0.9);
}

}  // namespace
}  // namespace rangegrasp::pcl_bridge
