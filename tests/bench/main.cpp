#include <benchmark/benchmark.h>

#include "register_all.h"

int main(int argc, char** argv) {
  rangegrasp::RegisterAll();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
