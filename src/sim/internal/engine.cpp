#include "sim/internal/engine.h"

#include <csetjmp>
#include <cstring>

#include "base/error.h"

namespace rangegrasp::sim::internal {
namespace {

struct Recovery {
  std::jmp_buf point;
  char message[1024];
  std::vector<std::string>* warnings;
};

thread_local Recovery* recovery = nullptr;
mjfLogHandler previous_handler = nullptr;

void Handle(const mjLogMessage* message) {
  if (!recovery) {
    // Not our call: leave it to whoever had the log before us.
    if (previous_handler) previous_handler(message);
    return;
  }
  if (message->level == mjLOG_ERROR) {
    std::strncpy(recovery->message, message->subject, sizeof(recovery->message) - 1);
    recovery->message[sizeof(recovery->message) - 1] = '\0';
    std::longjmp(recovery->point, 1);
  }
  if (message->level == mjLOG_WARNING && recovery->warnings) {
    recovery->warnings->emplace_back(message->subject);
  }
}

// Once.
void InstallHandler() {
  static const bool installed = [] {
    previous_handler = mju_setLogHandler(Handle);
    return true;
  }();
  static_cast<void>(installed);
}

// Alone in its function, so that no automatic object with a destructor stands between setjmp and
// longjmp.
bool RunRecoverably(Recovery& here, const std::function<void()>& call) {
  if (setjmp(here.point) != 0) return false;
  call();
  return true;
}

}  // namespace

void CallEngine(std::vector<std::string>* warnings, const std::function<void()>& call) {
  InstallHandler();
  Recovery here;
  here.message[0] = '\0';
  here.warnings = warnings;
  Recovery* const outer = recovery;
  recovery = &here;
  bool ok = false;
  try {
    ok = RunRecoverably(here, call);
  } catch (...) {
    recovery = outer;
    throw;
  }
  recovery = outer;
  if (!ok) throw base::RunError(std::string("MuJoCo: ") + here.message);
}

}  // namespace rangegrasp::sim::internal
