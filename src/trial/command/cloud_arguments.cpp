#include "trial/command/cloud_arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/error.h"

namespace rangegrasp::cli {
namespace {

double UnitFrom(const std::string& name) {
  if (name == "mm") return 1e-3;
  if (name == "cm") return 1e-2;
  return 1.0;
}

}  // namespace

void AddCloudOptions(CLI::App& command, CloudArguments& arguments) {
  command.add_option(
      "--sensor-origin", arguments.origin,
      "x,y,z of the sensor in the cloud's frame [m] (a PCD's viewpoint, else 0,0,0)");
  command
      .add_option("--crop", arguments.crop,
                  "only points between x,y,z and x,y,z, e.g. -0.3,-0.3,-1,0.3,0.3,1 [m]")
      ->delimiter(',')
      ->expected(6);
  command.add_option("--up", arguments.up, "direction away from the table, where it is known");
  command.add_option("--unit", arguments.unit, "of the cloud's coordinates")
      ->check(CLI::IsMember({"m", "cm", "mm"}));
}

Eigen::Vector3d ParseVector(const std::string& text, const char* option) {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &x, &y, &z, &rest) != 3 ||
      !std::isfinite(x + y + z)) {
    throw base::InputError(std::string(option) + " '" + text + "' must be x,y,z, e.g. 0,0,1");
  }
  return {x, y, z};
}

geometry::CloudFile ReadCloud(const CloudArguments& arguments) {
  auto file = geometry::ReadCloud(arguments.cloud, UnitFrom(arguments.unit));
  const std::vector<double>& crop = arguments.crop;
  if (crop.empty()) return file;
  const Eigen::Array3d low(crop[0], crop[1], crop[2]);
  const Eigen::Array3d high(crop[3], crop[4], crop[5]);
  if (!(low < high).all()) {
    throw base::InputError("--crop: the first three numbers must be below the last three");
  }
  std::size_t left = 0;
  for (auto& p : file.points) {
    if ((p.array() >= low).all() && (p.array() <= high).all()) {
      ++left;
    } else {
      p.setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  if (left == 0) {
    throw base::InputError(fmt::format(
        "--crop: the crop left 0 points of {}; its numbers are metres in the cloud's frame",
        file.points.size()));
  }
  return file;
}

Eigen::Vector3d OriginOf(const CloudArguments& arguments, const geometry::CloudFile& file) {
  if (!arguments.origin.empty()) return ParseVector(arguments.origin, "--sensor-origin");
  return file.sensor_origin.value_or(Eigen::Vector3d::Zero());
}

std::optional<Eigen::Vector3d> UpOf(const CloudArguments& arguments) {
  if (arguments.up.empty()) return std::nullopt;
  const Eigen::Vector3d up = ParseVector(arguments.up, "--up");
  if (up.norm() == 0.0) throw base::InputError("--up must not be 0,0,0");
  return up.normalized();
}

}  // namespace rangegrasp::cli
