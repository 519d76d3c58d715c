/// Infinity and NaN under short names.
#pragma once

#include <limits>

namespace pliant {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace pliant
