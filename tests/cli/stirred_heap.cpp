// A library to preload with a malloc whose blocks have other addresses, another order and other old
// contents, which differ between calls and between processes. With it, results that depend on
// addresses or on uninitialized memory change.

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

extern "C" void* __libc_malloc(std::size_t size);  // glibc's own
extern "C" void __libc_free(void* block);

namespace {

constexpr std::size_t kHeld = 64;
constexpr std::size_t kFilled = 4096;  // only the start of large blocks, to save time

std::array<std::atomic<void*>, kHeld> held{};

// xorshift64 (Marsaglia 2003), with a stream per thread.
std::uint64_t Draw() {
  thread_local std::uint64_t state = 0;
  if (state == 0) state = 88172645463325252ULL * static_cast<std::uint64_t>(2 * getpid() + 1);
  state ^= state << 13U;
  state ^= state >> 7U;
  state ^= state << 17U;
  return state;
}

// A block that is held for a while moves the next ones to other addresses.
void HoldAnother(std::uint64_t draw, std::size_t size) {
  const std::size_t held_size = 16 * ((draw >> 16U) % 4096) + (size > 20000 ? size : 0);
  __libc_free(held[(draw >> 8U) % kHeld].exchange(__libc_malloc(held_size)));
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
  const std::uint64_t draw = Draw();
  if (size > 200 && draw % 4 == 0) HoldAnother(draw, size);
  void* block = __libc_malloc(size + 16 * ((draw >> 40U) % 16));
  if (block != nullptr) {
    std::memset(block, static_cast<int>((draw >> 24U) & 0xffU), size < kFilled ? size : kFilled);
  }
  return block;
}
