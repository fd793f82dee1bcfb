#include "trial/listings.h"

#include <fmt/format.h>

#include <string>

#include "cli/commands.h"
#include "sim/info.h"
#include "sim/surfaces.h"
#include "trial/options.h"

namespace rangegrasp::trial {
namespace {

std::string Objects() {
  std::string text;
  for (const auto& file : cli::ShippedFiles("models/objects", ".xml")) {
    const std::string name = file.stem().string();
    if (file.parent_path().filename() == name) {
      text += cli::ListingLine(name, sim::ObjectTitle({name, file}));
    }
  }
  return text;
}

std::string Surfaces() {
  std::string text;
  for (const auto& surface : sim::ReadSurfaces(sim::ShippedSurfaces())) {
    text += cli::ListingLine(surface.name, fmt::format("friction of the glove {:.2f} to {:.2f}",
                                                       surface.glove.low, surface.glove.high));
  }
  return text;
}

std::string Scenes() {
  std::string text;
  for (const auto& file : cli::ShippedFiles("scenes", ".xml")) text += file.stem().string() + "\n";
  return text;
}

std::string Sensors() {
  std::string text;
  for (const auto& file : cli::ShippedFiles("models/sensors", ".yaml"))
    text += file.stem().string() + "\n";
  return text;
}

std::string Additions() {
  std::string text;
  for (const auto& key : AdditionKeys()) text += cli::ListingLine(key.path, key.doc);
  return text;
}

}  // namespace

void AddListings() {
  cli::AddListing({"objects", "objects", Objects});
  cli::AddListing({"surfaces", "kinds of surfaces", Surfaces});
  cli::AddListing({"scenes", "scenes", Scenes});
  cli::AddListing({"sensors", "sensors", Sensors});
  cli::AddListing({"additions", "keys of grasping experiments that go beyond the dissertation",
                   Additions, false});
}

}  // namespace rangegrasp::trial
