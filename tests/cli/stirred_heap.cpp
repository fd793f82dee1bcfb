// A library to preload: malloc whose blocks lie elsewhere, in another order, and are filled with
// other remains, from one call to the next as well as from one process to the next. What a program
// computes from addresses, or from memory that it never wrote, comes out otherwise with it.

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
constexpr std::size_t kFilled = 4096;  // of large blocks: their start is enough, and time counts

std::array<std::atomic<void*>, kHeld> held{};

// xorshift64 (Marsaglia 2003); a stream for each thread.
std::uint64_t Draw() {
  thread_local std::uint64_t state = 0;
  if (state == 0) state = 88172645463325252ULL * static_cast<std::uint64_t>(2 * getpid() + 1);
  state ^= state << 13U;
  state ^= state >> 7U;
  state ^= state << 17U;
  return state;
}

// A block that is held for a while makes the next ones lie elsewhere.
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
