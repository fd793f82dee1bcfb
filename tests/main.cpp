#include <gtest/gtest.h>

#include "register_all.h"

int main(int argc, char** argv) {
  rangegrasp::RegisterAll();
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
