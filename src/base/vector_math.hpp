/// exp and expm1 of packs, by glibc's vector mathematics library (libmvec), to some 2 ulp; lane by lane where it is
/// absent. A scalar takes the C library's.
#pragma once

#include "base/simd.hpp"

#include <cmath>

#if defined(__x86_64__) && defined(__GLIBC__) && __GLIBC_PREREQ(2, 35)
#include <immintrin.h>
#define PLIANT_HAS_LIBMVEC
// Names of the x86-64 vector function ABI: e = AVX-512, d = AVX2, c = AVX, b = SSE.
extern "C" {
#if defined(__AVX512F__)
__m512d _ZGVeN8v_exp(__m512d);    // NOLINT(readability-identifier-naming)
__m512d _ZGVeN8v_expm1(__m512d);  // NOLINT(readability-identifier-naming)
#elif defined(__AVX2__)
__m256d _ZGVdN4v_exp(__m256d);    // NOLINT(readability-identifier-naming)
__m256d _ZGVdN4v_expm1(__m256d);  // NOLINT(readability-identifier-naming)
#elif defined(__AVX__)
__m256d _ZGVcN4v_exp(__m256d);    // NOLINT(readability-identifier-naming)
__m256d _ZGVcN4v_expm1(__m256d);  // NOLINT(readability-identifier-naming)
#else
__m128d _ZGVbN2v_exp(__m128d);    // NOLINT(readability-identifier-naming)
__m128d _ZGVbN2v_expm1(__m128d);  // NOLINT(readability-identifier-naming)
#endif
}
#endif

namespace pliant {

inline double exp(double x) {
  return std::exp(x);
}
inline double expm1(double x) {
  return std::expm1(x);
}

inline Pack exp(const Pack& x) {
#if !defined(PLIANT_HAS_LIBMVEC)
  return Pack([&](auto i) { return std::exp(static_cast<double>(x[i])); });
#elif defined(__AVX512F__)
  return Pack(_ZGVeN8v_exp(static_cast<__m512d>(x)));
#elif defined(__AVX2__)
  return Pack(_ZGVdN4v_exp(static_cast<__m256d>(x)));
#elif defined(__AVX__)
  return Pack(_ZGVcN4v_exp(static_cast<__m256d>(x)));
#else
  return Pack(_ZGVbN2v_exp(static_cast<__m128d>(x)));
#endif
}

inline Pack expm1(const Pack& x) {
#if !defined(PLIANT_HAS_LIBMVEC)
  return Pack([&](auto i) { return std::expm1(static_cast<double>(x[i])); });
#elif defined(__AVX512F__)
  return Pack(_ZGVeN8v_expm1(static_cast<__m512d>(x)));
#elif defined(__AVX2__)
  return Pack(_ZGVdN4v_expm1(static_cast<__m256d>(x)));
#elif defined(__AVX__)
  return Pack(_ZGVcN4v_expm1(static_cast<__m256d>(x)));
#else
  return Pack(_ZGVbN2v_expm1(static_cast<__m128d>(x)));
#endif
}

}  // namespace pliant
