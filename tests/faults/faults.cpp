// A preload library. It counts the calls of each kind that a program and its workers make, and
// makes one of them fail or kills the process in it. tests/faults/faults_test controls it through
// environment variables:
//
//   FAULTS_FILE   a file that all processes of the program share: see Shared. Without it nothing is
//                 counted.
//   FAULTS_AT     "ROLE KIND N ACTION": role 0 is the first process, 1 a process that it forks. The
//                 N-th call (from 1) of a kind fails (ACTION fail) or never returns (kill). Without
//                 FAULTS_AT, the first call of each call stack is recorded.
//   FAULTS_TRACE  prints the call stack of the failing call.
//   FAULTS_CLOCK  the wall clock jumps a day ahead and back, from one reading to the next.

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>
#include <unwind.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

extern "C" {  // glibc's own functions
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
}

namespace {

enum Kind : std::uint32_t { kWrite, kFsync, kOpen, kFork, kMmap, kMalloc, kRename, kKinds };
constexpr const char* kKindWords[kKinds] = {"write", "fsync",  "open",  "fork",
                                            "mmap",  "malloc", "rename"};

constexpr std::uint32_t kMaxSites = 1U << 18U;
// The number of return addresses that distinguish call stacks. A malloc is called by operator new,
// that by std::string, that by a function that copies a string, and that by the code in question.
constexpr int kFrames = 8;

// A call stack and its first call.
struct Site {
  std::atomic<std::uint64_t> hash;
  std::uint32_t role, kind, number;
  std::uint32_t unused;
};

struct Shared {
  std::atomic<std::uint32_t> calls[2][kKinds];
  std::atomic<std::uint32_t> fired;
  std::uint32_t unused;
  Site sites[kMaxSites];  // open hashing; hash 0: empty
};

Shared* shared = nullptr;
std::uint32_t own_role = 0;
bool fails = false;
bool kills = false;
bool clock_jumps = false;
std::uint32_t wanted_role = 0;
std::uint32_t wanted_kind = 0;
std::uint32_t wanted_number = 0;
thread_local bool inside = false;

struct Walk {
  std::uint64_t hash = 0xcbf29ce484222325U;
  int frames = 0;
};

_Unwind_Reason_Code AddFrame(_Unwind_Context* context, void* data) {
  auto& walk = *static_cast<Walk*>(data);
  walk.hash = (walk.hash ^ _Unwind_GetIP(context)) * 0x100000001b3U;
  return ++walk.frames < kFrames + 2 ? _URC_NO_REASON : _URC_END_OF_STACK;  // two are in this file
}

void NoteSite(std::uint32_t kind, std::uint32_t number) {
  Walk walk;
  _Unwind_Backtrace(AddFrame, &walk);
  const std::uint64_t hash = ((walk.hash ^ kind) * 2 + own_role) | (1ULL << 63U);
  for (std::uint64_t i = hash % kMaxSites, tries = 0; tries < kMaxSites;
       i = (i + 1) % kMaxSites, ++tries) {
    std::uint64_t there = 0;
    Site& site = shared->sites[i];
    if (site.hash.compare_exchange_strong(there, hash)) {
      site.role = own_role;
      site.kind = kind;
      site.number = number;
      return;
    }
    if (there == hash) return;
  }
}

void Trace() {
  void* frames[24];
  backtrace_symbols_fd(frames, backtrace(frames, 24), STDERR_FILENO);
}

// Counts a call and returns whether it must fail.
bool Fails(std::uint32_t kind, int why) {
  if (shared == nullptr || inside) return false;
  inside = true;
  const std::uint32_t number = ++shared->calls[own_role][kind];
  bool now = false;
  if (wanted_number == 0) {
    NoteSite(kind, number);
  } else if (number == wanted_number && kind == wanted_kind && own_role == wanted_role) {
    shared->fired = 1;
    if (getenv("FAULTS_TRACE") != nullptr) Trace();
    if (kills) syscall(SYS_kill, getpid(), SIGKILL);
    now = fails;
  }
  inside = false;
  if (now) errno = why;
  return now;
}

template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int OpenAt(int folder, const char* name, int flags, mode_t mode) {
  if (Fails(kOpen, EMFILE)) return -1;
  return static_cast<int>(syscall(SYS_openat, folder, name, flags, mode));
}

// The mode argument of an open function, which is only present with certain flags.
mode_t ModeOf(int flags, va_list list) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
}

// The program's own main function. Calls that libraries make before it are not counted.
int (*own_main)(int, char**, char**) = nullptr;

void Begin() {
  clock_jumps = getenv("FAULTS_CLOCK") != nullptr;
  const char* file = getenv("FAULTS_FILE");
  const char* at = getenv("FAULTS_AT");
  if (file == nullptr) return;
  if (at != nullptr) {
    char kind[16] = "";
    char action[16] = "";
    if (std::sscanf(at, "%u %15s %u %15s", &wanted_role, kind, &wanted_number, action) != 4)
      abort();
    for (std::uint32_t k = 0; k < kKinds; ++k) {
      if (std::strcmp(kind, kKindWords[k]) == 0) wanted_kind = k;
    }
    kills = std::strcmp(action, "kill") == 0;
    fails = !kills;
  }
  const int fd =
      static_cast<int>(syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (fd < 0 || ftruncate(fd, sizeof(Shared)) != 0) abort();
  // Only the program and the processes that it forks are counted, not programs that it starts.
  unsetenv("FAULTS_FILE");
  shared = reinterpret_cast<Shared*>(
      syscall(SYS_mmap, nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
  close(fd);
}

int CountedMain(int argc, char** argv, char** environment) {
  Begin();
  return own_main(argc, argv, environment);
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv,
                      int (*init)(int, char**, char**), void (*fini)(), void (*rtld_fini)(),
                      void* stack_end) {
  own_main = main;
  return Next<decltype(__libc_start_main)>("__libc_start_main")(CountedMain, argc, argv, init, fini,
                                                                rtld_fini, stack_end);
}

void* malloc(std::size_t size) { return Fails(kMalloc, ENOMEM) ? nullptr : __libc_malloc(size); }
void* calloc(std::size_t count, std::size_t size) {
  return Fails(kMalloc, ENOMEM) ? nullptr : __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  return Fails(kMalloc, ENOMEM) ? nullptr : __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return Fails(kMalloc, ENOMEM) ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  void* made = Fails(kMalloc, ENOMEM) ? nullptr : __libc_memalign(alignment, size);
  if (made == nullptr) return ENOMEM;
  *block = made;
  return 0;
}

ssize_t write(int fd, const void* bytes, std::size_t size) {
  // Error messages must always be written.
  if (fd != STDERR_FILENO && Fails(kWrite, ENOSPC)) return -1;
  return syscall(SYS_write, fd, bytes, size);
}
ssize_t writev(int fd, const iovec* parts, int count) {
  if (fd != STDERR_FILENO && Fails(kWrite, ENOSPC)) return -1;
  return syscall(SYS_writev, fd, parts, count);
}
ssize_t pwrite(int fd, const void* bytes, std::size_t size, off_t at) {
  return Fails(kWrite, ENOSPC) ? -1 : syscall(SYS_pwrite64, fd, bytes, size, at);
}
ssize_t pwrite64(int fd, const void* bytes, std::size_t size, off64_t at) {
  return pwrite(fd, bytes, size, at);
}
std::size_t fwrite(const void* bytes, std::size_t size, std::size_t count, FILE* file) {
  static auto* next = Next<decltype(fwrite)>("fwrite");
  return file != stderr && Fails(kWrite, ENOSPC) ? 0 : next(bytes, size, count, file);
}

int fsync(int fd) { return Fails(kFsync, EIO) ? -1 : static_cast<int>(syscall(SYS_fsync, fd)); }
int fdatasync(int fd) {
  return Fails(kFsync, EIO) ? -1 : static_cast<int>(syscall(SYS_fdatasync, fd));
}

int open(const char* name, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = ModeOf(flags, list);
  va_end(list);
  return OpenAt(AT_FDCWD, name, flags, mode);
}
int open64(const char* name, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = ModeOf(flags, list);
  va_end(list);
  return OpenAt(AT_FDCWD, name, flags, mode);
}
int openat(int folder, const char* name, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = ModeOf(flags, list);
  va_end(list);
  return OpenAt(folder, name, flags, mode);
}
int openat64(int folder, const char* name, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = ModeOf(flags, list);
  va_end(list);
  return OpenAt(folder, name, flags, mode);
}
FILE* fopen(const char* name, const char* mode) {
  static auto* next = Next<decltype(fopen)>("fopen");
  return Fails(kOpen, EMFILE) ? nullptr : next(name, mode);
}
FILE* fopen64(const char* name, const char* mode) {
  static auto* next = Next<decltype(fopen64)>("fopen64");
  return Fails(kOpen, EMFILE) ? nullptr : next(name, mode);
}

pid_t fork() {
  static auto* next = Next<decltype(fork)>("fork");
  if (Fails(kFork, EAGAIN)) return -1;
  const pid_t child = next();
  if (child == 0) own_role = 1;
  return child;
}

void* mmap(void* address, std::size_t size, int protection, int flags, int fd, off_t at) {
  if (Fails(kMmap, ENOMEM)) return MAP_FAILED;
  return reinterpret_cast<void*>(syscall(SYS_mmap, address, size, protection, flags, fd, at));
}
void* mmap64(void* address, std::size_t size, int protection, int flags, int fd, off64_t at) {
  return mmap(address, size, protection, flags, fd, at);
}

int rename(const char* from, const char* to) {
  return Fails(kRename, EIO)
             ? -1
             : static_cast<int>(syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to));
}

int clock_gettime(clockid_t which, timespec* now) {
  const auto code = static_cast<int>(syscall(SYS_clock_gettime, which, now));
  static std::atomic<std::uint32_t> looks{0};
  if (clock_jumps && which == CLOCK_REALTIME && ++looks % 2 == 0) now->tv_sec += 86400;
  return code;
}
int gettimeofday(timeval* now, void*) {
  timespec precise{};
  clock_gettime(CLOCK_REALTIME, &precise);
  now->tv_sec = precise.tv_sec;
  now->tv_usec = precise.tv_nsec / 1000;
  return 0;
}
time_t time(time_t* also) {
  timespec precise{};
  clock_gettime(CLOCK_REALTIME, &precise);
  if (also != nullptr) *also = precise.tv_sec;
  return precise.tv_sec;
}

}  // extern "C"
