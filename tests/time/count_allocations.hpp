/// Operator new of this test program counts.
#pragma once

#include <cstddef>

namespace pliant::test {

/// How often memory was taken by `new` so far; PETSc's objects are not among it.
std::size_t num_allocations();

}  // namespace pliant::test
