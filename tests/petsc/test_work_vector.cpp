// Vectors that take memory at their first use.
#include "petsc/work_vector.hpp"

#include <gtest/gtest.h>

namespace {

using pliant::check;
using pliant::Handle;
using pliant::WorkVector;

TEST(WorkVector, is_made_at_its_first_use_and_once) {
  int made = 0;
  const WorkVector work([&made] {
    ++made;
    Handle<Vec> vector;
    check(VecCreateMPI(PETSC_COMM_WORLD, 2, PETSC_DETERMINE, vector.out()));
    return vector;
  });
  EXPECT_FALSE(work.is_used());
  EXPECT_EQ(made, 0);
  const Vec first = work.get();
  EXPECT_EQ(work.get(), first);
  EXPECT_TRUE(work.is_used());
  EXPECT_EQ(made, 1);
}

}  // namespace
