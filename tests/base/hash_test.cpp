#include "base/hash.h"

#include <gtest/gtest.h>

namespace rangegrasp::base {
namespace {

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

}  // namespace
}  // namespace rangegrasp::base
