#include "core/hash.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "temp_folder.h"

namespace rangegrasp::core {
namespace {

using testing_support::TempFolder;

TEST(Fnv1a, MatchesThePublishedVectors) {
  // Noll's test suite for 64-bit FNV-1a.
  EXPECT_EQ(Fnv1a(""), 0xcbf29ce484222325u);
  EXPECT_EQ(Fnv1a("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(Fnv1a("b"), 0xaf63df4c8601f1a5u);
  EXPECT_EQ(Fnv1a("fo"), 0x08985907b541d342u);
  EXPECT_EQ(Fnv1a("foobar"), 0x85944171f73967e8u);
}

TEST(Fnv1a, GoesOnFromAState) { EXPECT_EQ(Fnv1a("bar", Fnv1a("foo")), Fnv1a("foobar")); }

TEST(Fnv1a, TakesEveryByteAsUnsigned) {
  // By the definition: (basis xor 0xff) * prime modulo 2^64.
  EXPECT_EQ(Fnv1a("\xff"), (0xcbf29ce484222325u ^ 0xffu) * 0x100000001b3u);
  EXPECT_NE(Fnv1a(std::string_view("\0", 1)), Fnv1a(""));
}

TEST(Hex, WritesSixteenDigits) {
  EXPECT_EQ(Hex(0), "0000000000000000");
  EXPECT_EQ(Hex(0xdeadbeefu), "00000000deadbeef");
  EXPECT_EQ(Hex(~std::uint64_t{0}), "ffffffffffffffff");
}

TEST(ReadFile, GivesEveryByte) {
  const TempFolder folder;
  const std::string bytes("a\0\r\n\xff", 5);
  EXPECT_EQ(ReadFile(folder.Write("bytes", bytes)), bytes);
}

TEST(ReadFile, NamesTheFileThatItCannotRead) {
  const TempFolder folder;
  folder.Write("empty", "");
  for (const char* name : {"missing", "empty", "."}) {
    try {
      ReadFile(folder / name);
      ADD_FAILURE() << name;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find((folder / name).string()), std::string::npos)
          << e.what();
    }
  }
}

}  // namespace
}  // namespace rangegrasp::core
