#include "report/internal/view_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/rng.h"

namespace rangegrasp::report {
namespace {

std::string Coded(const std::string& text) {
  return Base64({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
}

TEST(Base64, IsThatOfTheStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ(Coded(""), "");
  EXPECT_EQ(Coded("f"), "Zg==");
  EXPECT_EQ(Coded("fo"), "Zm8=");
  EXPECT_EQ(Coded("foo"), "Zm9v");
  EXPECT_EQ(Coded("foob"), "Zm9vYg==");
  EXPECT_EQ(Coded("fooba"), "Zm9vYmE=");
  EXPECT_EQ(Coded("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Coded("\xff\xfe\xfd"), "//79");
}

// Decodes as a browser's atob does. Written from the standard's table, not from the encoder.
std::string Decoded(const std::string& text) {
  const auto digit = [](char c) -> unsigned {
    if (c >= 'A' && c <= 'Z') return static_cast<unsigned>(c - 'A');
    if (c >= 'a' && c <= 'z') return static_cast<unsigned>(c - 'a') + 26;
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0') + 52;
    return c == '+' ? 62 : 63;
  };
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | digit(c);
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> static_cast<unsigned>(count -= 8) & 0xffU);
  }
  return bytes;
}

template <typename Number>
std::vector<Number> Numbers(const nlohmann::ordered_json& text) {
  const std::string bytes = Decoded(text);
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

geometry::Points Unpacked(const nlohmann::ordered_json& json) {
  const auto steps = Numbers<std::uint16_t>(json["data"]);
  geometry::Points points(steps.size() / 3);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    points[i / 3][static_cast<int>(i % 3)] =
        json["low"][i % 3].get<double>() + json["step"].get<double>() * steps[i];
  }
  return points;
}

TEST(PackedPoints, AreWithinHalfAStep) {
  base::Rng rng(11);
  geometry::Points points;
  for (int i = 0; i < 1000; ++i) {
    points.emplace_back(rng.Uniform(-2.0, 1.0), rng.Uniform(0.0, 0.1), rng.Uniform(5.0, 5.5));
  }
  const auto read = Unpacked(PackedPoints(points));
  ASSERT_EQ(read.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Half of 3 m / 65535, plus the rounding of doubles.
    EXPECT_LE((read[i] - points[i]).cwiseAbs().maxCoeff(), 0.5 * 3.0 / 65535.0 + 1e-12);
  }
}

TEST(PackedPoints, OnePointAndNoneAreExact) {
  EXPECT_TRUE(Unpacked(PackedPoints({})).empty());
  const Eigen::Vector3d p(0.1, -0.2, 0.3);
  EXPECT_EQ(Unpacked(PackedPoints({p, p})), (geometry::Points{p, p}));
}

TEST(PackedNumbers, AreWithinHalfAStepAndGapsStayGaps) {
  base::Rng rng(13);
  std::vector<double> numbers = {NAN, INFINITY, -7.0, 5.0};
  for (int i = 0; i < 500; ++i) numbers.push_back(rng.Uniform(-7.0, 5.0));
  const auto json = PackedNumbers(numbers);
  const auto steps = Numbers<std::uint16_t>(json["data"]);
  ASSERT_EQ(steps.size(), numbers.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i] == 65535, !std::isfinite(numbers[i])) << i;
    if (steps[i] == 65535) continue;
    const double read = json["low"].get<double>() + json["step"].get<double>() * steps[i];
    EXPECT_LE(std::abs(read - numbers[i]), 0.5 * 12.0 / 65534.0 + 1e-12);
  }
  EXPECT_EQ(PackedNumbers({})["data"], "");
  EXPECT_EQ(Numbers<std::uint16_t>(PackedNumbers(std::vector<double>{NAN})["data"])[0], 65535);
  EXPECT_EQ(PackedNumbers(std::vector{2.0, 2.0})["low"].get<double>(), 2.0);
}

TEST(PackedMesh, HasWideCornersOnlyWhereItNeedsThem) {
  geometry::TriangleMesh mesh;
  mesh.vertices.assign(65535, Eigen::Vector3d::Zero());
  mesh.triangles = {{0, 1, 65534}};
  auto json = PackedMesh(mesh);
  EXPECT_FALSE(json["wide"].get<bool>());
  EXPECT_EQ(Numbers<std::uint16_t>(json["triangles"]), (std::vector<std::uint16_t>{0, 1, 65534}));
  mesh.vertices.assign(65537, Eigen::Vector3d::Zero());
  mesh.triangles = {{0, 1, 65536}};
  json = PackedMesh(mesh);
  EXPECT_TRUE(json["wide"].get<bool>());
  EXPECT_EQ(Numbers<std::uint32_t>(json["triangles"]), (std::vector<std::uint32_t>{0, 1, 65536}));
}

TEST(PackedPoses, TurnsAreWithinAThousandthOfADegreeOrSo) {
  base::Rng rng(12);
  std::vector<base::Pose> poses;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector4d q(rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0),
                            rng.Uniform(0.1, 1.0));
    poses.push_back(base::MakePose(Eigen::Quaterniond(q.normalized()).toRotationMatrix(),
                                   {rng.Uniform(-1.0, 1.0), 0.0, 0.0}));
  }
  const auto json = PackedPoses(poses);
  const auto parts = Numbers<std::int16_t>(json["turns"]);
  const auto places = Unpacked(json["places"]);
  ASSERT_EQ(parts.size(), 4 * poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Quaterniond read(parts[4 * i + 3], parts[4 * i], parts[4 * i + 1],
                                  parts[4 * i + 2]);
    // Four components, each off by half of 1 / 32767, rotate by at most 2 * 2 * half of it.
    EXPECT_LE(read.normalized().angularDistance(Eigen::Quaterniond(poses[i].linear())),
              2.0 / 32767.0 + 1e-9);
    EXPECT_LE((places[i] - poses[i].translation()).norm(), 2.0 / 65535.0);
  }
}

}  // namespace
}  // namespace rangegrasp::report
