#include "cli/run.h"

#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/installation.h"
#include "base/words.h"
#include "cli/commands.h"
#include "experiment/experiment.h"
#include "experiment/store.h"
#include "external/outside_detector.h"
#include "python/values.h"
#include "trial/registry.h"

namespace rangegrasp::python {
namespace {

/// The word of a detector that is a Python function.
constexpr const char* kPython = "python";

// The function of a run or report and its name in stamps; during its lifetime detector `python`.
struct Asked {
  Asked(const nb::object& function, const std::string& function_name)
      : ask(function), name(function_name) {
    present = this;
    cli::HasPythonDetector() = !function.is_none();
  }
  ~Asked() {
    present = nullptr;
    cli::HasPythonDetector() = false;
  }
  Asked(const Asked&) = delete;
  Asked& operator=(const Asked&) = delete;

  nb::object ask;
  std::string name;
  static inline const Asked* present = nullptr;
};

nb::dict DictOf(const external::Question& question) {
  nb::dict dict = python::DictOf(question.observation);
  dict["noise_m"] = question.noise_m;
  dict["seed"] = question.seed;
  AddWorkspace(question.robot, question.margin_m, dict);
  return dict;
}

std::string Ask(const external::Question& question) {
  const nb::gil_scoped_acquire gil;
  try {
    return nb::cast<std::string>(Asked::present->ask(DictOf(question)));
  } catch (nb::python_error& e) {
    throw grasp::DetectorFailed(e.what());  // with the traceback
  } catch (const nb::cast_error&) {
    throw grasp::DetectorFailed("the detector's answer is not a string");
  }
}

std::unique_ptr<grasp::Detector> MakeDetector(const trial::Options& options,
                                              const robot::Robot& robot,
                                              grasp::SceneObserver observer) {
  if (!Asked::present || Asked::present->ask.is_none()) {
    throw base::InputError(
        "detector: python: is a function of a Python program; rangegrasp.evaluate runs it");
  }
  return external::MakeFunctionDetector(Ask, options, robot, std::move(observer));
}

// Forks while no other Python thread holds a lock. On Ctrl-C, the parent ends its children.
int Fork() {
  PyOS_BeforeFork();
  const pid_t pid = fork();
  if (pid != 0) {
    PyOS_AfterFork_Parent();
    return pid;
  }
  PyOS_AfterFork_Child();
  std::signal(SIGINT, SIG_IGN);
  return 0;
}

// Waits while other Python threads may run. Ctrl-C ends the run.
void Wait(const std::function<void()>& wait) {
  {
    const nb::gil_scoped_release others_may_run;
    wait();
  }
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

using OnProgress = std::function<void(int, int, const std::string&)>;

std::string Run(const std::string& file, const std::vector<std::string>& set,
                std::optional<int> trials, const std::vector<std::string>& objects,
                const std::vector<std::uint64_t>& seeds, const std::string& out, int jobs,
                bool resume, bool overwrite, const nb::object& ask, const std::string& name,
                const OnProgress& progress) {
  const Asked asked(ask, name);
  experiment::Changes changes{.set = set, .trials = trials, .groups = objects};
  if (seeds.size() == 1) changes.seed = seeds.front();
  const cli::RunIntoOptions options{.jobs = jobs,
                                    .resume = resume,
                                    .overwrite = overwrite,
                                    .progress = [&](int before, int total) -> experiment::Progress {
                                      return [&progress, before, total](
                                                 int done, int, const experiment::Record& last) {
                                        progress(before + done, total, last.result.outcome);
                                      };
                                    },
                                    .processes = {.fork = Fork, .wait = Wait},
                                    .names = {.resume = "resume=True",
                                              .overwrite = "overwrite=True",
                                              .out = "out=...",
                                              .seeds = "seed=[...]"}};
  return cli::RunExperiment(base::FindExperiment(file), changes,
                            seeds.size() > 1 ? seeds : std::vector<std::uint64_t>{}, out, options)
      .failed;
}

std::string Table(const std::string& folder, const std::string& format) {
  const auto results = experiment::ReadResults(folder);
  return experiment::Format(experiment::ReportOf(results), results.stamp,
                            base::FromWord<experiment::TableFormat>(format, "format"));
}

nb::list Records(const std::string& folder) {
  nb::list records;
  for (const auto& record : experiment::ReadResults(folder).records) {
    records.append(ObjectOf(nlohmann::ordered_json::parse(experiment::ToJson(record))));
  }
  return records;
}

nb::dict Compare(const std::string& first, const std::string& second) {
  const auto c = experiment::CompareRuns(first, second);
  if (!c.warning.empty() && PyErr_WarnEx(PyExc_UserWarning, c.warning.c_str(), 1) < 0) {
    throw nb::python_error();
  }
  nb::dict dict;
  dict["pairs"] = c.pairs;
  dict["both"] = c.both;
  dict["only_first"] = c.only_first;
  dict["only_second"] = c.only_second;
  dict["same_outcome"] = c.same_outcome;
  dict["p_value"] = c.p_value;
  return dict;
}

void Report(const std::string& folder, int jobs, const nb::object& ask, const std::string& name,
            bool run_detector) {
  const Asked asked(ask, name);
  const auto make_report = cli::MakeReportFor();
  if (!make_report) {
    base::CheckBuilt("command", "report");
    throw base::InputError("this package was built without reports");
  }
  make_report(folder, jobs, run_detector);
}

}  // namespace

void AddRun(nb::module_& m) {
  trial::AddDetector({.word = kPython,
                      .make = MakeDetector,
                      .add_to = [](const trial::Options&, experiment::Stamp& stamp) {
                        stamp.identity["detector_function"] = Asked::present->name;
                      }});
  m.def("run", &Run, nb::arg("experiment"), nb::arg("set"), nb::arg("trials").none(),
        nb::arg("objects"), nb::arg("seeds"), nb::arg("out"), nb::arg("jobs"), nb::arg("resume"),
        nb::arg("overwrite"), nb::arg("ask").none(), nb::arg("name"), nb::arg("progress"));
  m.def("table", &Table, nb::arg("folder"), nb::arg("format"));
  m.def("records", &Records, nb::arg("folder"));
  m.def("compare", &Compare, nb::arg("first"), nb::arg("second"));
  m.def("report", &Report, nb::arg("folder"), nb::arg("jobs"), nb::arg("ask").none(),
        nb::arg("name"), nb::arg("run_detector"));
}

}  // namespace rangegrasp::python
