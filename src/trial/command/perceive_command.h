#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "geometry/cloud_file.h"

namespace CLI {
class App;
}  // namespace CLI

namespace rangegrasp::cli {

void AddPerceiveCommand(CLI::App& app);  ///< perceive

/// What commands on any cloud ask of it, a recorded one too.
struct CloudArguments {
  std::string cloud, origin, up, unit = "m";
  std::vector<double> crop;
};

/// Adds --sensor-origin, --crop, --up and --unit; `arguments` must outlive the command.
void AddCloudOptions(CLI::App& command, CloudArguments& arguments);

/// "x,y,z" -> a vector.
/// @throws base::InputError naming the option.
Eigen::Vector3d ParseVector(const std::string& text, const char* option);

/// The file, in metres, with NaN in the place of all points outside the crop, so that rows stay
/// whole.
/// @throws base::InputError naming what is wrong, such as a crop that leaves nothing.
geometry::CloudFile ReadCloud(const CloudArguments& arguments);

/// Where the sensor stood: as the option says, else the file, else the origin.
Eigen::Vector3d OriginOf(const CloudArguments& arguments, const geometry::CloudFile& file);

/// For errors of perception: "; ... give --sensor-origin" where neither the option nor the file
/// says where the sensor stood, else empty.
std::string OriginAdvice(const CloudArguments& arguments, const Eigen::Vector3d& origin);

/// The direction away from the table, unit; nullopt without the option.
/// @throws base::InputError.
std::optional<Eigen::Vector3d> UpOf(const CloudArguments& arguments);

}  // namespace rangegrasp::cli
