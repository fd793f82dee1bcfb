#include <dlfcn.h>
#include <nanobind/nanobind.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <mutex>

#include "base/error.h"
#include "base/file.h"
#include "base/installation.h"
#include "cli/commands.h"
#include "python/values.h"
#include "trial/registry.h"

namespace rangegrasp {

/// Registers the systems that are built. CMake generates it (cmake/RangegraspSystems.cmake).
void RegisterSystems();

namespace python {
namespace {

// Sends messages to Python's logger "rangegrasp".
class LogSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (!Py_IsInitialized()) return;
    const nb::gil_scoped_acquire gil;
    const std::string text(message.payload.data(), message.payload.size());
    // Python's levels are ten times spdlog's: info 2 -> 20, warning 3 -> 30, error 4 -> 40.
    nb::module_::import_("logging")
        .attr("getLogger")("rangegrasp")
        .attr("log")(10 * static_cast<int>(message.level), "%s", text);
  }
  void flush_() override {}
};

std::filesystem::path OwnFile() {
  Dl_info info{};
  dladdr(reinterpret_cast<const void*>(&OwnFile), &info);
  return std::filesystem::absolute(info.dli_fname);
}

// The error of a path that cannot be used, e.g. a link to itself.
void TranslateFileError(const std::exception_ptr& thrown, void* input_error) {
  try {
    std::rethrow_exception(thrown);
  } catch (const std::filesystem::filesystem_error& error) {
    PyErr_SetString(static_cast<PyObject*>(input_error), base::TextOf(error).c_str());
  }
}

int Main(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return cli::RunProgram(static_cast<int>(words.size()), arguments.data());
}

}  // namespace
}  // namespace python

NB_MODULE(_core, m) {
  namespace nb = nanobind;
  m.doc() = "C++ core of the testbed; use the package rangegrasp instead.";
  base::SetProgram(python::OwnFile());
  RegisterTrial();
  RegisterSystems();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("python", std::make_shared<python::LogSink>()));
  nb::exception<base::RunError>(m, "RunError", PyExc_RuntimeError).doc() =
      "A run that failed through no fault of its input, e.g. a full disk.";
  nb::exception<base::InputError> input_error(m, "InputError", PyExc_ValueError);
  input_error.doc() =
      "Bad input; the text names the file, the line or key, the value and what would be right.";
  nb::register_exception_translator(&python::TranslateFileError, input_error.ptr());
  m.def("version", &base::Version, "The version, e.g. '0.5.0'.");
  m.def("main", &python::Main, nb::arg("words"),
        "Runs the command line with its words; the first is the program's name.");
  m.def(
      "data_folder", [] { return base::DataFolder().string(); },
      "The folder of models/, scenes/ and experiments/.");
  m.def(
      "experiments", [] { return base::ExperimentNames(base::DataFolder()); },
      "The names of the experiments that come with the package.");
  python::AddScene(m);
  python::AddPerceive(m);
  python::AddRun(m);
}

}  // namespace rangegrasp
