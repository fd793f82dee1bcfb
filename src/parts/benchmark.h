#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "parts/shape.h"

namespace rangegrasp::parts {

enum class Method { kMirror, kImproved, kKMeans, kSdf, kCore };
inline constexpr std::array kMethods = {Method::kMirror, Method::kImproved, Method::kKMeans,
                                        Method::kSdf, Method::kCore};
const char* Name(Method method);  ///< "mirror", "improved", "kmeans", "sdf", "core"

/// Parameters are tuned on the models of one split only, so that the other tells what they are
/// worth.
enum class Split { kTune, kReport };
const char* Name(Split split);  ///< "tune", "report"

/// A class of a benchmark laid out as Chen et al. 2009: `off/<id>.off`, `seg/<id>/<id>_<k>.seg`.
struct BenchmarkClass {
  std::string name;
  std::vector<int> tune;    ///< ids
  std::vector<int> report;  ///< ids; no id stands twice
};

/// An experiment file such as experiments/parts_psb.yaml.
struct BenchmarkOptions {
  std::string name;
  std::filesystem::path file;
  std::filesystem::path folder;  ///< holds off/ and seg/
  std::vector<BenchmarkClass> classes;
  std::vector<Method> methods;
  std::filesystem::path runtimes;  ///< published table 6.1, or empty
};
/// @param folder  of the data, if it is not to be the file's key `data`; may be empty.
/// @throws core::InputError naming file, line, key; also where the folder holds no off/ and seg/.
BenchmarkOptions ReadBenchmark(const std::filesystem::path& file,
                               const std::filesystem::path& folder);

/// One method on one model, against all of its human segmentations.
struct BenchmarkRow {
  std::string class_name;
  int id = 0;
  Split split = Split::kReport;
  Method method = Method::kMirror;
  int parts = 0;
  double rand_error = 0.0;                ///< mean over the humans
  std::optional<double> cut_discrepancy;  ///< mean over those where it is defined
  double seconds = 0.0;                   ///< processor time of the method alone [s]
  std::string note;                       ///< a failure's text, or the method's
  bool failed = false;                    ///< then all numbers are 0
};

/// Runs all models and methods on `jobs` threads. Rows that `done` holds already (a run that was
/// killed) are not run again, those that failed are; `finished` (may be empty) is called, one at a
/// time, for each new row. A method or model that fails makes rows that say why, and the others go
/// on. Result: all rows in the order of the options, whatever `jobs` and `done`; but for `seconds`
/// they are always the same.
std::vector<BenchmarkRow> RunBenchmark(const BenchmarkOptions& options, int jobs,
                                       const std::vector<BenchmarkRow>& done,
                                       const std::function<void(const BenchmarkRow&)>& finished);

/// Segments with a method at its defaults; kmeans_clusters: the class's mean number of human
/// segments. Mirroring goes on where no centre inside is found, as in the chapter's evaluation.
Segmentation Segment(const Shape& shape, Method method, int kmeans_clusters);

/// The mean number of segments of all human segmentations of a class, rounded, at least 1; those
/// that cannot be read do not count.
int MeanHumanSegments(const std::filesystem::path& folder, const BenchmarkClass& models);

/// rows.csv: one line a row, appended as they finish; what a killed run left half-written is
/// dropped. Numbers are written so that they are read back the same. A file that is not there has
/// no rows. @throws core::InputError naming file, line and value.
std::vector<BenchmarkRow> ReadRows(const std::filesystem::path& csv);
/// Begins the file if it is not there. @throws core::RunError if it cannot be written.
void AppendRow(const std::filesystem::path& csv, const BenchmarkRow& row);
/// The whole file anew, never half of it. @throws core::RunError if it cannot be written.
void WriteRows(const std::filesystem::path& csv, const std::vector<BenchmarkRow>& rows);

}  // namespace rangegrasp::parts
