/// Values with their places in the input file.
#pragma once

#include "base/error.hpp"

namespace pliant {

/// A value and its place in the file, to which later checks (for example against the mesh's groups) can point.
template <class T>
struct Located {
  T value{};
  Location where;
};

}  // namespace pliant
