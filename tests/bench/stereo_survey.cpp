// What a stereo pair reconstructs of the objects of an experiment's trials, beside the truth: which
// share of what the left camera sees of them, and how well, on parts with texture and without.
// Lines of CSV: one an object, one of all, each for textured, plain and all samples. Truth is for
// evaluation alone.
//
//   rangegrasp_stereo_survey EXPERIMENT.yaml --seed N --scans N [--set K=V ...]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "base/units.h"
#include "experiment/experiment.h"
#include "register_all.h"
#include "stereo/sensing/stereo_sensor.h"
#include "trial/cell.h"
#include "trial/grasping_task.h"
#include "trial/trial.h"

namespace rangegrasp {
namespace {

// Texture of a sample: the standard deviation of the brightness in the window of block matching.
// Noise alone has 2 levels, shading over a window up to 2 more.
constexpr int kWindow_px = 21;
constexpr double kTextured_levels = 6.0;
// A sample further off is a mismatch: it lies on no surface of a hand's size.
constexpr double kMismatch_m = 0.015;

/// Samples of one kind that the left camera sees.
struct Group {
  int seen = 0;
  std::vector<double> errors_m;  ///< of those that were reconstructed, along the ray, signed

  void Add(double error_m) {
    ++seen;
    if (!std::isnan(error_m)) errors_m.push_back(error_m);
  }
  void Add(const Group& other) {
    seen += other.seen;
    errors_m.insert(errors_m.end(), other.errors_m.begin(), other.errors_m.end());
  }
};

double Texture(const image::Image& picture, int x, int y) {
  constexpr int kHalf = kWindow_px / 2;
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int row = std::max(0, y - kHalf); row <= std::min(picture.height - 1, y + kHalf); row += 2) {
    for (int column = std::max(0, x - kHalf); column <= std::min(picture.width - 1, x + kHalf);
         column += 2) {
      const std::uint8_t* p = picture.At(column, row);
      // Blue print and the blue table differ in more than texture.
      const double level = 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
      sum += level;
      squares += level * level;
      ++count;
    }
  }
  const double mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean));
}

// [0]: plain, [1]: textured.
using ByTexture = std::array<Group, 2>;

void AddLook(const stereo::StereoLook& look, int step_px, const sim::World& world,
             std::map<std::string, ByTexture>& groups) {
  const auto& view = look.made.view;
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    const auto label = static_cast<int>(look.truth.label[i]);
    if (label < 1 || label > world.objects()) continue;
    const int column = static_cast<int>(i) % view.image.samples;
    const int row = static_cast<int>(i) / view.image.samples;
    const bool textured = Texture(look.made.rectified.left, column * step_px + step_px / 2,
                                  row * step_px + step_px / 2) > kTextured_levels;
    // A sample that colour put on the table is none of the object.
    const bool there = view.noise_m[i] > 0.0F;
    const double range_m = (view.image.points_C[i] - view.image.origins_C.front()).norm();
    const double error_m = there ? range_m - look.truth.true_range_m[i] : std::nan("");
    groups[world.object_name(label - 1)][textured ? 1 : 0].Add(error_m);
  }
}

void Print(const std::string& object, const char* kind, const Group& group) {
  if (group.seen == 0) return;
  std::vector<double> sizes_mm, errors_mm;
  double sum_mm = 0.0;
  int mismatches = 0;
  for (const double error_m : group.errors_m) {
    const double size_m = std::abs(error_m);
    errors_mm.push_back(error_m * base::kMmPerM);
    sizes_mm.push_back(size_m * base::kMmPerM);
    sum_mm += size_m * base::kMmPerM;
    mismatches += size_m > kMismatch_m ? 1 : 0;
  }
  const auto count = static_cast<double>(sizes_mm.size());
  if (sizes_mm.empty()) {
    fmt::print("{},{},{},0,,,,,\n", object, kind, group.seen);
    return;
  }
  fmt::print("{},{},{},{:.3f},{:.2f},{:.2f},{:.2f},{:.2f},{:.4f}\n", object, kind, group.seen,
             count / group.seen, sum_mm / count, base::MedianOf(sizes_mm),
             base::QuantileOf(sizes_mm, 0.95), base::MedianOf(errors_mm), mismatches / count);
}

void Print(const std::string& object, const ByTexture& groups) {
  Group all = groups[0];
  all.Add(groups[1]);
  Print(object, "textured", groups[1]);
  Print(object, "plain", groups[0]);
  Print(object, "all", all);
}

void Survey(const std::string& file, const experiment::Changes& changes, int scans) {
  const auto experiment = experiment::OpenExperiment(file, experiment::AllKinds(), changes);
  const trial::Cell& cell = trial::CellOf(*experiment.task);
  const auto* sensor = dynamic_cast<const stereo::StereoSensor*>(cell.sensor.get());
  if (!sensor) throw base::InputError(file + ": its sensor is no stereo camera");
  std::map<std::string, ByTexture> groups;
  double seconds = 0.0;
  int looks = 0;
  // Spread over the objects.
  const std::size_t step =
      std::max<std::size_t>(1, experiment.cases.size() / static_cast<std::size_t>(scans));
  for (std::size_t i = 0; i < experiment.cases.size() && looks < scans; i += step) {
    const auto spec = trial::SpecOf(experiment.cases[i]);
    auto arranged = ArrangeTrial(cell, spec);
    if (!arranged) continue;
    base::Rng rng = trial::StageStream(spec.seed, "scan");
    auto look = sensor->Look(arranged->world, rng);
    const base::Stopwatch watch;
    stereo::Reconstruct(look.shot.photos.left, look.shot.photos.right, sensor->rectifier(),
                        sensor->setup().reconstruct);
    seconds += watch.Seconds();
    AddLook(look, sensor->setup().reconstruct.step_px, arranged->world, groups);
    ++looks;
  }
  fmt::print("object,samples,seen,share,mean_mm,median_mm,p95_mm,bias_mm,mismatches\n");
  ByTexture all;
  for (const auto& [object, of_object] : groups) {
    Print(object, of_object);
    for (const std::size_t k : {0, 1}) all[k].Add(of_object[k]);
  }
  Print("all", all);
  fmt::print(stderr, "{} pairs, {:.0f} ms each to reconstruct\n", looks, 1e3 * seconds / looks);
}

}  // namespace
}  // namespace rangegrasp

int main(int argc, char** argv) {
  rangegrasp::RegisterAll();
  using namespace rangegrasp;
  CLI::App app{"What a stereo pair reconstructs of the objects, beside the truth."};
  std::string file;
  experiment::Changes changes;
  std::uint64_t seed = 11;
  int scans = 24;
  app.add_option("experiment", file, "with a stereo camera")->required();
  app.add_option("--seed", seed, "of the experiment");
  app.add_option("--scans", scans, "trials that are looked at")->check(CLI::PositiveNumber);
  app.add_option("--set", changes.set, "KEY=VALUE in place of what the file says");
  CLI11_PARSE(app, argc, argv);
  changes.seed = seed;
  try {
    Survey(file, changes, scans);
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
  return 0;
}
