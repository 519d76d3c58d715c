/// Packs of four numbers (SIMD): one for each of several vectors that are worked on at once.
#pragma once

#include <experimental/simd>

namespace pliant {

inline constexpr std::size_t num_several = 4;
using SeveralFloats =
    std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, static_cast<int>(num_several)>>;
using SeveralDoubles =
    std::experimental::simd<double, std::experimental::simd_abi::deduce_t<double, static_cast<int>(num_several)>>;

/// Lane by lane.
inline SeveralDoubles to_doubles(const SeveralFloats& x) {
  return std::experimental::static_simd_cast<SeveralDoubles>(x);
}
inline SeveralFloats to_floats(const SeveralDoubles& x) {
  return std::experimental::static_simd_cast<SeveralFloats>(x);
}

}  // namespace pliant
