/// exp, expm1 and sqrt of packs, and quotients of them that keep their digits near 0. exp and expm1 use glibc's vector
/// mathematics library (libmvec), accurate to about 2 ulp, or the C library lane by lane where libmvec is absent.
/// Scalars use the C library.
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

PLIANT_INLINE double sqrt(double x) {
  return std::sqrt(x);
}
PLIANT_INLINE Pack sqrt(const Pack& x) {
#if defined(PLIANT_HAS_LIBMVEC) && defined(__AVX512F__)
  // Not _mm512_sqrt_pd: g++ 12 warns of its own header.
  const auto v = static_cast<__m512d>(x);
  return Pack(_mm512_mask_sqrt_pd(v, 0xff, v));
#else
  return std::experimental::sqrt(x);
#endif
}

/// (exp(x) - 1) / x; 1 at 0.
template <class T>
PLIANT_INLINE T phi1(const T& x) {
  const auto zero = x == 0.0;
  const T safe = select(zero, T(1.0), x);
  return select(zero, T(1.0), T(expm1(safe) / safe));
}

/// (exp(x) - 1 - x) / x^2; 1/2 at 0. For |x| <= 1 by its power series, whose first term left out is below 1e-17.
template <class T>
PLIANT_INLINE T phi2(const T& x) {
  const auto far = x * x > 1.0;
  const T near = select(far, T(0.0), x);
  T series = 1.0 / 19;
  for (int n = 18; n >= 3; --n) series = (1.0 + near * series) / n;
  series = 0.5 * (1.0 + near * series);
  if (!any_of(far)) return series;
  const T safe = select(far, x, T(1.0));
  return select(far, T((expm1(safe) - safe) / (safe * safe)), series);
}

}  // namespace pliant
