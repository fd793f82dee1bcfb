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

/// Arguments of commands that read a cloud, recorded or simulated.
struct CloudArguments {
  std::string cloud, origin, up, unit = "m";
  std::vector<double> crop;
};

/// Adds --sensor-origin, --crop, --up and --unit; `arguments` must outlive the command.
void AddCloudOptions(CLI::App& command, CloudArguments& arguments);

/// Reads the cloud in metres. Points outside the crop become NaN, so that the rows keep their
/// lengths.
/// @throws base::InputError naming the error, such as a crop without points.
geometry::CloudFile ReadCloud(const CloudArguments& arguments);
/// The cloud's points that were measured: those without NaN, in their order.
geometry::Points MeasuredPoints(const geometry::CloudFile& file);

/// The sensor's position: from the option, else from the file, else the origin.
Eigen::Vector3d OriginOf(const CloudArguments& arguments, const geometry::CloudFile& file);

/// Warning if points this far apart (perception::Sampling) are not those of a tabletop, so that the
/// file has another unit; else empty.
std::string UnitWarning(double spacing_m);

/// Warning if neither the option nor the file states the sensor's position; else empty.
std::string OriginWarning(const CloudArguments& arguments, const geometry::CloudFile& file);

/// Advice for errors of perception: "; ... give --sensor-origin" if neither the option nor the file
/// states the sensor's position, else empty.
std::string OriginAdvice(const CloudArguments& arguments, const Eigen::Vector3d& origin);

/// The unit vector away from the table; nullopt without the option.
/// @throws base::InputError.
std::optional<Eigen::Vector3d> UpOf(const CloudArguments& arguments);

}  // namespace rangegrasp::cli
