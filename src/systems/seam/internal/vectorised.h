#pragma once

/// Put before a function with a loop over many columns: it is also compiled for wide vectors, which
/// are used if the machine has them. The results are the same. Clang does not link such functions.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RANGEGRASP_VECTORISED __attribute__((target_clones("avx2", "default")))
#else
#define RANGEGRASP_VECTORISED
#endif
