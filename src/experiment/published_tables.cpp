#include "experiment/published_tables.h"

#include <algorithm>

#include "base/error.h"
#include "base/words.h"

namespace rangegrasp::experiment {
namespace {

// Seconds of a case were measured with `rangegrasp reproduce --short --jobs 1`.
PublishedTable Rates(const std::string& number, const std::string& title,
                     const std::string& experiment, double case_s) {
  return {.number = number,
          .title = title,
          .experiment = experiment,
          .cases = 120,
          .trials = 10,
          .short_trials = 1,
          .case_s = case_s};
}

PublishedTable StereoRates(const std::string& number, const std::string& title,
                           const std::string& experiment) {
  PublishedTable table = Rates(number, title, experiment, 3.0);
  table.cases = 60;
  table.trials = 5;
  return table;
}

// 13 seams are one round of the shapes.
PublishedTable Seams(const std::string& number, const std::string& title,
                     const std::string& experiment, const std::string& key) {
  return {.number = number,
          .title = title,
          .experiment = experiment,
          .key = key,
          .cases = 78,
          .trials = 78,
          .short_trials = 13,
          .case_s = 1.0};
}

PublishedTable Demo(const std::string& number, const std::string& title, const std::string& key) {
  return {.number = number,
          .title = title,
          .experiment = "cylinder_demo",
          .key = key,
          .cases = 50,
          .trials = 50,
          .short_trials = 5,
          .case_s = 3.0};
}

std::vector<PublishedTable> MakeTables() {
  return {
      Seams("3.1", "Times of the edge detection", "seam_base", "runtimes"),
      Seams("3.2", "Edges found, base sensor", "seam_base", "reference"),
      Seams("3.3", "Edges found, three-lines sensor", "seam_three_lines", "reference"),
      Seams("3.5", "Improvements of the edge detection", "seam_three_lines", "improvements"),
      Demo("4.1", "Problems of the live demo", "reference"),
      Demo("4.2", "Times of the cylinder detection", "runtimes"),
      {.number = "4.3",
       .title = "Fits of a cylinder at five resolutions",
       .experiment = "cylinder_resolution",
       .groups = {"perfect"},
       .cases = 250,
       .trials = 50,
       .short_trials = 5,
       .case_s = 2.0},
      {.number = "4.4",
       .title = "Fits of two cylinders",
       .experiment = "cylinder_iterations",
       .groups = {"perfect"},
       .cases = 40,
       .trials = 20,
       .short_trials = 2,
       .case_s = 20.0},
      {.number = "5.1",
       .title = "Times of the calculation steps",
       .experiment = "stage_times",
       .cases = 20,
       .trials = 10,
       .short_trials = 1,
       .case_s = 5.0,
       .is_of_times = true},
      Rates("5.2", "Objects alone", "laser_single", 0.4),
      Rates("5.2-as-published", "Objects alone, method as published", "laser_single_as_published",
            0.4),
      Rates("5.3", "Touching objects", "laser_touching", 0.8),
      Rates("5.3-as-published", "Touching objects, method as published",
            "laser_touching_as_published", 0.8),
      Rates("5.4", "Objects in a box", "laser_box", 1.5),
      Rates("5.4-as-published", "Objects in a box, method as published", "laser_box_as_published",
            1.5),
      Rates("5.5", "Objects in a pile", "laser_pile", 1.5),
      Rates("5.5-as-published", "Objects in a pile, method as published", "laser_pile_as_published",
            1.5),
      StereoRates("5.6", "Objects in a pile, dense stereo", "stereo_pile"),
      StereoRates("5.6-as-published", "Objects in a pile, dense stereo, method as published",
                  "stereo_pile_as_published"),
      {.number = "5.8",
       .title = "Times of the segmentations (figures 5.8 and 5.9)",
       .experiment = "segmentation_times",
       .cases = 10,
       .trials = 5,
       .short_trials = 1,
       .case_s = 5.0,
       .is_of_times = true},
      {.number = "6.1",
       .title = "Times of taking objects apart",
       .experiment = "parts_psb",
       .key = "runtimes",
       .cases = 200,
       .trials = 2,  // of each class and split
       .short_trials = 1,
       .case_s = 3.0,
       .is_drawn = false},
  };
}

bool IsChosen(const PublishedTable& table, const std::string& number) {
  return table.number == number || table.number.starts_with(number + ".");
}

}  // namespace

std::span<const PublishedTable> PublishedTables() {
  static const std::vector<PublishedTable> tables = MakeTables();
  return tables;
}

std::vector<PublishedTable> ChosenTables(const std::vector<std::string>& numbers) {
  const auto all = PublishedTables();
  std::vector<std::string> known;
  for (const PublishedTable& table : all) known.push_back(table.number);
  for (const std::string& number : numbers) {
    if (std::ranges::any_of(all, [&](const auto& one) { return IsChosen(one, number); })) continue;
    throw base::InputError("table " + base::MustBeOneOf(number, known) +
                           "; a chapter (3 to 6) stands for all of its tables");
  }
  std::vector<PublishedTable> chosen;
  std::ranges::copy_if(all, std::back_inserter(chosen), [&](const PublishedTable& table) {
    return numbers.empty() || std::ranges::any_of(numbers, [&](const std::string& number) {
             return IsChosen(table, number);
           });
  });
  return chosen;
}

}  // namespace rangegrasp::experiment
