// A library to preload that makes Mesa's off-screen library appear not installed.

#include <dlfcn.h>

#include <cstring>

extern "C" void* dlopen(const char* file, int flags) {
  using Open = void* (*)(const char*, int);
  static const auto open = reinterpret_cast<Open>(dlsym(RTLD_NEXT, "dlopen"));
  return open(file && std::strstr(file, "OSMesa") ? "libmissing.so" : file, flags);
}
