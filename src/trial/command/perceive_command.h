#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "geometry/cloud_file.h"
#include "geometry/plane.h"
#include "perception/perceive.h"

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

/// A cloud with warnings of points that are left out as not measured.
struct Cloud : geometry::CloudFile {
  std::vector<std::string> warnings;
};

/// Reads the cloud in metres. Points that were not measured and points outside the crop become NaN,
/// so that the rows keep their lengths.
/// @throws base::InputError naming the error, such as a crop without points.
Cloud ReadCloud(const CloudArguments& arguments);
/// The cloud's points that were measured: those without NaN, in their order.
geometry::Points MeasuredPoints(const geometry::CloudFile& file);

/// The sensor's position: from the option, else from the file, else the origin.
Eigen::Vector3d OriginOf(const CloudArguments& arguments, const geometry::CloudFile& file);

/// Prints what a user should know of a cloud before its table is known: the warnings of reading it,
/// an assumed or far position of the sensor, points as far apart as in another unit.
void WarnOfCloud(const CloudArguments& arguments, const Cloud& cloud);

/// Warning if the sensor does not lie above the table; else empty.
std::string SideWarning(const geometry::Plane& table, const Eigen::Vector3d& sensor);

/// Advice for errors of perception: "; ... give --sensor-origin" if neither the option nor the file
/// states the sensor's position, else empty.
std::string OriginAdvice(const CloudArguments& arguments, const Eigen::Vector3d& origin);

/// What to try if no table was found: a cloud in another unit has none, nor has one with the wrong
/// sign of --up. Which side of a table a sensor in its plane is on is left to noise.
std::string TableAdvice(const geometry::Points& points, const Eigen::Vector3d& origin,
                        const perception::PerceptionOptions& options, base::Rng& rng);

/// The unit vector away from the table; nullopt without the option.
/// @throws base::InputError.
std::optional<Eigen::Vector3d> UpOf(const CloudArguments& arguments);

}  // namespace rangegrasp::cli
