#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/stopwatch.h"
#include "base/units.h"
#include "stereo/sensing/stereo_sensor.h"
#include "surveys/task/measures.h"

namespace rangegrasp::surveys {
namespace {

using experiment::Column;
using nlohmann::ordered_json;

// Texture of a sample: the standard deviation of the brightness in the block-matching window. Noise
// alone gives 2 levels, shading over a window up to 2 more.
constexpr int kWindow_px = 21;
constexpr double kTextured_levels = 6.0;
/// Errors are counted in steps of this, up to kMismatch_m: a sample further off lies on no surface
/// of a hand's size.
constexpr double kStep_m = 0.0001;
constexpr double kMismatch_m = 0.015;
constexpr std::array kKinds = {"plain", "textured"};

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

/// Samples of one kind that the left camera sees.
struct Samples {
  int seen = 0, made = 0, mismatches = 0;
  double sum_m = 0.0;            ///< of the absolute errors
  std::map<int, int> histogram;  ///< of the errors along the ray, in steps; without mismatches

  void Add(double error_m) {
    ++made;
    sum_m += std::abs(error_m);
    if (std::abs(error_m) > kMismatch_m) {
      ++mismatches;
    } else {
      ++histogram[static_cast<int>(std::lround(error_m / kStep_m))];
    }
  }
  void Add(const Samples& other) {
    seen += other.seen;
    made += other.made;
    mismatches += other.mismatches;
    sum_m += other.sum_m;
    for (const auto& [step, count] : other.histogram) histogram[step] += count;
  }
};

ordered_json JsonOf(const Samples& s) {
  ordered_json histogram = ordered_json::array();
  for (const auto& [step, count] : s.histogram) histogram.push_back({step, count});
  return {{"seen", s.seen},
          {"reconstructed", s.made},
          {"mismatches", s.mismatches},
          {"sum_m", s.sum_m},
          {"errors_0.1mm", histogram}};
}

Samples SamplesOf(const ordered_json& json) {
  Samples s{json.at("seen"), json.at("reconstructed"), json.at("mismatches"), json.at("sum_m"), {}};
  for (const auto& bin : json.at("errors_0.1mm")) s.histogram[bin[0]] = bin[1];
  return s;
}

/// Quantile of the errors of all samples, with mismatches as the largest; of the absolute or the
/// signed errors. @return [mm]; nullopt if it is a mismatch, or without samples
std::optional<double> Quantile(const Samples& s, double share, bool size) {
  std::map<int, int> steps;
  for (const auto& [step, count] : s.histogram) steps[size ? std::abs(step) : step] += count;
  double below = 0.0;
  for (const auto& [step, count] : steps) {
    below += count;
    if (below >= share * s.made) return step * kStep_m * base::kMmPerM;
  }
  return std::nullopt;
}

}  // namespace

ordered_json MeasureReconstruction(const trial::Cell& cell, const trial::Arrangement& scene,
                                   std::uint64_t seed, Seconds& seconds) {
  const auto& sensor = dynamic_cast<const stereo::StereoSensor&>(*cell.sensor);
  base::Rng rng = trial::StageStream(seed, "scan");
  const base::Stopwatch watch;
  const auto look = sensor.Look(scene.world, rng);
  seconds.emplace_back("scan", watch.Seconds());

  const auto& view = look.made.view;
  const int step_px = sensor.setup().reconstruct.step_px;
  std::map<std::string, std::array<Samples, kKinds.size()>> objects;
  for (std::size_t i = 0; i < view.image.points_C.size(); ++i) {
    const auto label = static_cast<int>(look.truth.label[i]);
    if (label < 1 || label > scene.world.objects()) continue;
    const int column = static_cast<int>(i) % view.image.samples;
    const int row = static_cast<int>(i) / view.image.samples;
    const bool textured = Texture(look.made.rectified.left, column * step_px + step_px / 2,
                                  row * step_px + step_px / 2) > kTextured_levels;
    Samples& samples = objects[scene.world.object_name(label - 1)][textured ? 1 : 0];
    ++samples.seen;
    // Samples that were put on the table because of their color do not count as the object's.
    const double range_m = (view.image.points_C[i] - view.image.origins_C.front()).norm();
    const double error_m = range_m - look.truth.true_range_m[i];
    if (view.noise_m[i] > 0.0F && !std::isnan(error_m)) samples.Add(error_m);
  }
  ordered_json data = ordered_json::object();
  for (const auto& [object, kinds] : objects) {
    for (std::size_t k = 0; k < kKinds.size(); ++k) data[object][kKinds[k]] = JsonOf(kinds[k]);
  }
  return data;
}

experiment::Section ReconstructionTable(const std::vector<Measured>& scans) {
  struct Row {
    std::string object, kind;
    Samples samples;
  };
  std::map<std::string, std::map<std::string, Samples>> objects;
  for (const Measured& scan : scans) {
    for (const auto& [object, kinds] : scan.data.items()) {
      for (const auto& [kind, json] : kinds.items()) {
        const Samples samples = SamplesOf(json);
        for (const auto& name : {object, std::string("all")}) {
          objects[name][kind].Add(samples);
          objects[name]["all"].Add(samples);
        }
      }
    }
  }
  std::vector<Row> rows;
  for (const auto& [object, kinds] : objects) {
    for (const auto& [kind, samples] : kinds) {
      if (samples.seen > 0) rows.push_back({object, kind, samples});
    }
  }
  // "all" comes last.
  std::ranges::stable_partition(rows, [](const Row& row) { return row.object != "all"; });
  const auto quantile = [](double share, bool size) {
    return [=](const Row& row) { return Quantile(row.samples, share, size); };
  };
  const std::vector<Column<Row>> columns = {
      {"object", "", &Row::object, experiment::kLeft},
      {"samples", "", &Row::kind, experiment::kLeft},
      {"seen", "", [](const Row& row) { return row.samples.seen; }},
      {"reconstructed %", "",
       [](const Row& r) { return experiment::PercentText(r.samples.made, r.samples.seen, 1); }},
      {"mean |error| [mm]", ".2f",
       [](const Row& r) -> std::optional<double> {
         if (r.samples.made == 0) return std::nullopt;
         return r.samples.sum_m / r.samples.made * base::kMmPerM;
       }},
      {"median |error| [mm]", ".1f", quantile(0.5, true)},
      {"95 % [mm]", ".1f", quantile(0.95, true)},
      {"median error [mm]", ".1f", quantile(0.5, false)},
      {"off by > 15 mm %", "", [](const Row& r) {
         return experiment::PercentText(r.samples.mismatches, r.samples.made, 2);
       }}};
  return {"Stereo reconstruction of what the left camera sees", GridOf(columns, rows)};
}

}  // namespace rangegrasp::surveys
