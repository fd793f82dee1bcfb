#include "parts/benchmark.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

#include "core/error.h"
#include "core/parallel.h"
#include "parts/baselines.h"
#include "parts/files.h"
#include "parts/improved.h"
#include "parts/metrics.h"
#include "parts/mirror.h"

namespace rangegrasp::parts {
namespace {

using Labels = std::vector<std::int32_t>;

/// Of the calling thread: a time that other threads and programs do not stretch.
double ProcessorSeconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The human segmentations of a model, in the order of their numbers.
std::vector<std::filesystem::path> HumanFiles(const std::filesystem::path& folder, int id) {
  const std::string name = std::to_string(id);
  const std::filesystem::path place = folder / "seg" / name;
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(place, error)) {
    const std::string file = entry.path().filename().string();
    if (file.starts_with(name + "_") && file.ends_with(".seg")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    const std::string x = a.filename().string(), y = b.filename().string();
    return x.size() != y.size() ? x.size() < y.size() : x < y;
  });
  return files;
}

/// A model with all that its rows need, read once for all methods.
struct Model {
  geometry::TriangleMesh input;
  Shape shape;
  CutMeasure cuts;
  std::vector<Labels> humans;           ///< of the input's faces
  std::vector<Labels> humans_of_shape;  ///< of the shape's faces
};

/// From labels of the input's faces to labels of the faces that were kept.
Labels OfShape(const Shape& shape, const Labels& of_input) {
  Labels labels(shape.Elements(), 0);
  for (std::size_t i = of_input.size(); i-- > 0;) {
    const std::int32_t element = shape.element_of_input[i];
    if (element >= 0) labels[static_cast<std::size_t>(element)] = of_input[i];
  }
  return labels;
}

Model ReadModel(const std::filesystem::path& folder, int id) {
  const auto file = folder / "off" / (std::to_string(id) + ".off");
  geometry::TriangleMesh input = ReadInput(file);
  Shape shape = MakeShape(input);
  if (!shape.IsMesh()) throw core::InputError(file.string() + ": has no faces; a mesh is needed");
  CutMeasure cuts(shape);
  Model model{std::move(input), std::move(shape), std::move(cuts), {}, {}};
  for (const auto& human : HumanFiles(folder, id)) {
    model.humans.push_back(ReadLabels(human, model.input.triangles.size()));
    model.humans_of_shape.push_back(OfShape(model.shape, model.humans.back()));
  }
  if (model.humans.empty()) {
    const std::string name = std::to_string(id);
    throw core::InputError((folder / "seg" / name).string() + ": holds no human segmentation " +
                           name + "_<k>.seg of the model");
  }
  return model;
}

void Score(const Model& model, const Segmentation& found, BenchmarkRow& row) {
  const Labels labels = LabelsOfInput(model.shape, model.input, found);
  double discrepancy = 0.0;
  int defined = 0;
  for (std::size_t h = 0; h < model.humans.size(); ++h) {
    row.rand_error += RandError(labels, model.humans[h]);
    const auto one = model.cuts.Discrepancy(found.label, model.humans_of_shape[h]);
    discrepancy += one.value_or(0.0);
    defined += one ? 1 : 0;
  }
  row.rand_error /= static_cast<double>(model.humans.size());
  if (defined > 0) row.cut_discrepancy = discrepancy / defined;
}

/// Numbers are filled in all together or, of a method that fails, not at all.
void RunMethod(const Model& model, int clusters, BenchmarkRow& row) {
  BenchmarkRow done = row;
  const double begin = ProcessorSeconds();
  const Segmentation found = Segment(model.shape, row.method, clusters);
  done.seconds = std::round((ProcessorSeconds() - begin) * 1e6) / 1e6;
  done.parts = found.parts;
  done.note = found.note;
  Score(model, found, done);
  row = done;
}

/// What is to be done with one model; `rows` are those of it in the result.
struct Task {
  const BenchmarkClass* models = nullptr;
  int id = 0;
  std::vector<std::size_t> rows;
};

class Run {
 public:
  Run(const BenchmarkOptions& options, const std::vector<BenchmarkRow>& done) : options_(options) {
    for (const BenchmarkClass& models : options.classes) {
      for (const int id : models.tune) Add(models, id, Split::kTune, done);
      for (const int id : models.report) Add(models, id, Split::kReport, done);
    }
  }

  std::vector<BenchmarkRow> Go(int jobs, const std::function<void(const BenchmarkRow&)>& finished) {
    std::mutex mutex;
    core::ForEach(static_cast<int>(tasks_.size()), jobs, {}, [&](int i) {
      const Task& task = tasks_[static_cast<std::size_t>(i)];
      Do(task, [&](const BenchmarkRow& row) {
        const std::scoped_lock lock(mutex);
        if (finished) finished(row);
      });
    });
    return std::move(rows_);
  }

 private:
  void Add(const BenchmarkClass& models, int id, Split split,
           const std::vector<BenchmarkRow>& done) {
    Task task{&models, id, {}};
    for (const Method method : options_.methods) {
      BenchmarkRow row;
      row.class_name = models.name;
      row.id = id;
      row.split = split;
      row.method = method;
      const auto known = std::find_if(done.begin(), done.end(), [&](const BenchmarkRow& other) {
        return !other.failed && other.id == id && other.method == method &&
               other.class_name == models.name;
      });
      if (known == done.end()) {
        task.rows.push_back(rows_.size());
      } else {
        row = *known;
        row.split = split;
      }
      rows_.push_back(row);
    }
    if (!task.rows.empty()) tasks_.push_back(std::move(task));
  }

  int Clusters(const BenchmarkClass& models) {
    const std::scoped_lock lock(clusters_mutex_);
    auto [place, fresh] = clusters_.try_emplace(&models, 0);
    if (fresh) place->second = MeanHumanSegments(options_.folder, models);
    return place->second;
  }

  void Do(const Task& task, const std::function<void(const BenchmarkRow&)>& finished) {
    std::optional<Model> model;
    std::string why;
    try {
      model.emplace(ReadModel(options_.folder, task.id));
    } catch (const std::exception& e) {
      why = e.what();
    }
    for (const std::size_t r : task.rows) {
      BenchmarkRow& row = rows_[r];
      try {
        if (!model) throw core::InputError(why);
        const bool counts = row.method == Method::kKMeans;
        RunMethod(*model, counts ? Clusters(*task.models) : 0, row);
      } catch (const std::exception& e) {
        row.failed = true;
        row.note = e.what();
      }
      // As it will be read back from a file.
      std::replace_if(
          row.note.begin(), row.note.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
      finished(row);
    }
  }

  const BenchmarkOptions& options_;
  std::vector<BenchmarkRow> rows_;
  std::vector<Task> tasks_;
  std::mutex clusters_mutex_;
  std::map<const BenchmarkClass*, int> clusters_;
};

}  // namespace

const char* Name(Method method) {
  switch (method) {
    case Method::kMirror:
      return "mirror";
    case Method::kImproved:
      return "improved";
    case Method::kKMeans:
      return "kmeans";
    case Method::kSdf:
      return "sdf";
    case Method::kCore:
      return "core";
  }
  throw std::invalid_argument("Name: no such method");
}

const char* Name(Split split) { return split == Split::kTune ? "tune" : "report"; }

int MeanHumanSegments(const std::filesystem::path& folder, const BenchmarkClass& models) {
  std::vector<int> ids = models.tune;
  ids.insert(ids.end(), models.report.begin(), models.report.end());
  double sum = 0.0;
  int files = 0;
  for (const int id : ids) {
    for (const auto& file : HumanFiles(folder, id)) {
      try {
        const Labels labels = ReadLabels(file);
        sum += static_cast<double>(std::set(labels.begin(), labels.end()).size());
        ++files;
      } catch (const core::InputError&) {
        // The rows of that model tell it.
      }
    }
  }
  return files > 0 ? std::max(1, static_cast<int>(std::lround(sum / files))) : 1;
}

Segmentation Segment(const Shape& shape, Method method, int kmeans_clusters) {
  switch (method) {
    case Method::kMirror: {
      MirrorOptions options;
      options.go_on_outside = true;
      return SegmentByMirroring(shape, options);
    }
    case Method::kImproved:
      return SegmentImproved(shape, {});
    case Method::kKMeans: {
      KMeansOptions options;
      options.clusters = kmeans_clusters;
      return SegmentByKMeans(shape, options);
    }
    case Method::kSdf:
      return SegmentBySdf(shape, {});
    case Method::kCore:
      return SegmentByCoreExtraction(shape, {});
  }
  throw std::invalid_argument("Segment: no such method");
}

std::vector<BenchmarkRow> RunBenchmark(const BenchmarkOptions& options, int jobs,
                                       const std::vector<BenchmarkRow>& done,
                                       const std::function<void(const BenchmarkRow&)>& finished) {
  return Run(options, done).Go(jobs, finished);
}

}  // namespace rangegrasp::parts
