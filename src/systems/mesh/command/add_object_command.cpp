#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/image/image.h"
#include "base/installation.h"
#include "base/process/program.h"
#include "base/units.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/output.h"
#include "experiment/experiment.h"
#include "experiment/runner.h"
#include "geometry/mesh.h"
#include "mesh/mesh_object.h"
#include "sim/check/check.h"
#include "sim/render.h"
#include "sim/resting_poses.h"
#include "sim/surfaces.h"

namespace rangegrasp::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureWidth = 960;
constexpr int kPictureHeight = 720;
constexpr double kGram = 1e-3;
// Time limit of a trial of the lift test. Trials of the shipped experiments need a second.
constexpr double kTrialLimit_s = 60.0;
// Resting poses that tip over earlier are excluded from experiments (min_tipping_deg).
constexpr double kMinTipping_rad = base::Deg(10.0);

struct Arguments {
  std::string mesh, name, title, unit, up, texture, surface = "plastic", out = "objects";
  std::optional<double> size_mm, mass_g, density;
  int trials = 3;
  bool fill_holes = false, overwrite = false;
};

/// Results of add-object.
struct Found {
  objects::MeshObject object;
  objects::ObjectLook look;
  std::vector<sim::RestingPose> poses;
  std::vector<std::string> outcomes;  // of the lift test
  std::vector<base::Finding> findings;
  fs::path folder;
};

objects::MeshObjectOptions OptionsOf(const Arguments& a, const sim::Surface& surface) {
  objects::MeshObjectOptions options;
  if (!a.unit.empty()) options.unit = base::FromWord<objects::LengthUnit>(a.unit, "--unit");
  if (!a.up.empty()) options.up = base::FromWord<objects::Up>(a.up, "--up");
  if (a.size_mm) options.longest_m = *a.size_mm * base::kMm;
  if (a.mass_g) options.mass_kg = *a.mass_g * kGram;
  options.density_kg_m3 = a.density.value_or(surface.density_kg_m3);
  if (a.fill_holes) options.max_hole = 1.0;
  return options;
}

// Outcomes of trials of the object alone on the shipped table with the improved method, as in table
// 5.2.
std::vector<std::string> LiftTest(const fs::path& objects, const std::string& name, int trials) {
  const fs::path data = base::DataFolder();
  const fs::path file = objects / "lift_test.yaml";
  const nlohmann::ordered_json experiment = {
      {"name", "lift_test"},
      {"scene", (data / "scenes/tabletop.xml").string()},
      {"sensor", (data / "models/sensors/line_scanner.yaml").string()},
      {"object_folders", nlohmann::ordered_json::array({objects.string()})},
      {"objects", nlohmann::ordered_json::array({name})},
      {"trials_per_object", trials}};
  base::WriteFile(file, experiment.dump(2) + "\n");  // which is YAML
  const auto e = experiment::OpenExperiment(file, {});
  const auto run = [&](const experiment::Case& which) { return e.task->Run(which); };
  std::vector<std::string> outcomes;
  for (const experiment::Case& which : e.cases) {
    outcomes.push_back(experiment::RunApart(which, kTrialLimit_s, run).outcome);
  }
  return outcomes;
}

// Moves a folder completely or not at all: copies it next to its destination, then renames it.
void MoveTo(const fs::path& from, const fs::path& to) {
  const fs::path beside = to.parent_path() / ("." + to.filename().string() + ".new");
  try {
    base::MakeFolderOf(to);
    fs::remove_all(beside);
    fs::copy(from, beside, fs::copy_options::recursive);
    fs::remove_all(to);
    fs::rename(beside, to);
  } catch (const fs::filesystem_error& error) {
    std::error_code ignored;
    fs::remove_all(beside, ignored);
    throw base::RunError(to.string() + ": cannot be written: " + error.code().message());
  }
}

std::string NameOf(const Arguments& a) {
  const std::string name =
      a.name.empty() ? objects::ObjectNameFrom(fs::path(a.mesh).stem().string()) : a.name;
  if (name.empty() || objects::ObjectNameFrom(name) != name) {
    throw base::InputError(
        "--name '" + name +
        "' must consist of lowercase letters, digits and '_': it is used for files and table rows");
  }
  return name;
}

void RefuseNumbers(const Arguments& a) {
  const auto positive = [](const char* flag, std::optional<double> value) {
    if (!value || (std::isfinite(*value) && *value > 0.0)) return;
    throw base::InputError(fmt::format("{} {} must be above 0", flag, *value));
  };
  positive("--size-mm", a.size_mm);
  positive("--mass", a.mass_g);
  positive("--density", a.density);
}

// Throws if no solid has the object's density. Names all guesses about the mesh, since the check of
// the finished object cannot know them.
void RefuseImplausible(const Arguments& a, const objects::MeshObject& object) {
  geometry::Points corners_O;
  for (const auto& hull_O : object.hulls_O) {
    corners_O.insert(corners_O.end(), hull_O.vertices.begin(), hull_O.vertices.end());
  }
  const double density = object.mass_kg / geometry::Volume(geometry::ConvexHull(corners_O));
  if (density >= sim::kMinDensity_kg_m3 && density <= sim::kMaxDensity_kg_m3) return;
  std::string said;
  for (const std::string& line : object.said) said += "; " + line;
  throw base::InputError(fmt::format(
      "{}: its mass of {:.4g} g is implausible: {:.3g} kg/m3 in its hull, {:g} to {:g} are "
      "possible; it is {:.4g} mm long{}; correct the size (--unit, --size-mm) or the mass "
      "(--density is in kg/m3, `--mass` is in grams)",
      a.mesh, object.mass_kg / kGram, density, sim::kMinDensity_kg_m3, sim::kMaxDensity_kg_m3,
      object.size_m.maxCoeff() * base::kMmPerM, said));
}

Found Add(const Arguments& a) {
  RefuseNumbers(a);
  Found found;
  const std::string name = NameOf(a);
  found.folder = fs::path(a.out) / name;
  if (fs::exists(found.folder) && !a.overwrite) {
    throw base::InputError(
        found.folder.string() +
        ": already exists; --overwrite replaces it, --name chooses another name");
  }
  // The surfaces for the object's final folder.
  const auto surfaces = sim::SurfacesFor(found.folder / (name + ".xml"));
  const sim::Surface& surface = sim::FindSurface(surfaces, a.surface);
  found.look = {name, a.title.empty() ? name : a.title, surface, {}};
  // The engine would blame the mesh, and a temporary file, for a damaged texture.
  if (!a.texture.empty()) found.look.texture_png = image::ReadPngOfAnyKind(a.texture);
  {
    StepLine line(a.mesh);
    line.Begin("repair, then cutting into convex hulls");
    found.object = objects::MakeMeshObject(a.mesh, OptionsOf(a, surface), !a.texture.empty());
  }
  RefuseImplausible(a, found.object);

  const process::OwnFolder workshop;
  const fs::path folder = workshop.path() / name;
  for (const auto& [file, text] : objects::ObjectFiles(found.object, found.look)) {
    base::WriteFile(folder / file, text);
  }
  const fs::path own_surfaces = fs::path(a.out) / "surfaces.yaml";
  if (fs::exists(own_surfaces)) fs::copy_file(own_surfaces, workshop.path() / "surfaces.yaml");
  const sim::ObjectModel model{name, folder / (name + ".xml")};
  found.findings = check::CheckObject(model);
  if (base::HasError(found.findings)) {
    const base::Finding& first = found.findings.front();
    throw base::InputError(
        fmt::format("{}: cannot become an object: {}; {}", a.mesh, first.what, first.cure));
  }
  found.poses = sim::StableRestingPoses(model, kMinTipping_rad);
  // The trials run before anything is drawn, since drawing starts threads.
  if (a.trials > 0) found.outcomes = LiftTest(workshop.path(), name, a.trials);
  image::WritePng(folder / (name + ".png"), DrawObject(model, "", kPictureWidth, kPictureHeight));
  MoveTo(folder, found.folder);
  return found;
}

std::string Text(const Found& found) {
  const objects::MeshObject& o = found.object;
  const Eigen::Vector3d mm = o.size_m * base::kMmPerM;
  constexpr double kCm3PerM3 = 1e6;
  std::string text =
      fmt::format("{}: {:.0f} x {:.0f} x {:.0f} mm, {:.1f} cm3, {:.0f} g ({:.0f} kg/m3), {}\n",
                  found.look.name, mm.x(), mm.y(), mm.z(), o.volume_m3 * kCm3PerM3,
                  o.mass_kg / kGram, o.mass_kg / o.volume_m3, found.look.surface.name);
  for (const std::string& line : o.said) text += line + "\n";
  text += fmt::format("hulls: {}; they cover {:.1f} % of the solid and add {:.1f} % outside it\n",
                      o.hulls_O.size(), 100.0 * o.overlap.covered, 100.0 * o.overlap.beyond);
  text += "resting poses:";
  for (const auto& pose : found.poses) {
    text += fmt::format(" {} {:.0f} % (tips over at {:.0f} deg),", pose.label,
                        100.0 * pose.probability, base::ToDeg(pose.tipping_rad));
  }
  text.back() = '\n';
  if (!found.outcomes.empty()) {
    text += fmt::format("lift test: {} of {} delivered ({})\n",
                        std::ranges::count(found.outcomes, "delivered"), found.outcomes.size(),
                        base::Join(found.outcomes));
  }
  for (const base::Finding& finding : found.findings) text += base::TextOf(finding) + "\n";
  return text + fmt::format("written: {0}, with a picture {0}/{1}.png\n", found.folder.string(),
                            found.look.name);
}

}  // namespace

void AddAddObjectCommand(CLI::App& app) {
  auto* command = app.add_subcommand("add-object",
                                     "Make an object for experiments from a mesh: repair it, "
                                     "compute its mass and convex hulls, test it by lifting.");
  auto a = std::make_shared<Arguments>();
  command->add_option("mesh", a->mesh, "mesh: OBJ, STL, PLY, OFF or glTF")->required();
  command->add_option("--name", a->name, "name of the object (default: the file's)");
  command->add_option("--title", a->title, "title in tables (default: the name)");
  command->add_option("-o,--out", a->out, "output folder, a folder of objects")
      ->capture_default_str();
  command->add_option("--unit", a->unit, "unit of the mesh (default: guessed from its size)")
      ->check(CLI::IsMember(base::WordList<objects::LengthUnit>()));
  command->add_option("--size-mm", a->size_mm,
                      "scale so that the longest side of the bounding box has this length");
  command->add_option("--up", a->up, "axis of the mesh that points up (default: z; y of glTF)")
      ->check(CLI::IsMember(base::WordList<objects::Up>()));
  auto* mass = command->add_option("--mass", a->mass_g, "mass in grams");
  command->add_option("--density", a->density, "density in kg/m3 (default: the surface's)")
      ->excludes(mass);
  command->add_option("--surface", a->surface, "surface, a name in surfaces.yaml")
      ->capture_default_str();
  command->add_option("--texture", a->texture, "PNG texture, for a mesh with texture coordinates");
  command->add_flag("--fill-holes", a->fill_holes, "close every hole, regardless of its size");
  command->add_option("--lift-trials", a->trials, "number of trials of the lift test; 0: none")
      ->transform(WholeNumber(0, 1000))
      ->capture_default_str();
  command->add_flag("--overwrite", a->overwrite, "replace an existing object with this name");
  command->footer(
      "Example: rangegrasp add-object mug.stl --surface ceramic --mass 320 --out objects\nThen "
      "list it in an experiment: object_folders: [objects], objects: [mug]");
  command->callback([a] { WriteResult(Text(Add(*a))); });
}

}  // namespace rangegrasp::cli

namespace rangegrasp {

void RegisterMesh() { cli::AddCommand(cli::AddAddObjectCommand); }

}  // namespace rangegrasp
