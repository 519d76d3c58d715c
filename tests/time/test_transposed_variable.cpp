#include "time/every_method.hpp"
#include "time/stage_variable.hpp"
#include "time/transposed_variable.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace pliant::test_transposed_variable {
namespace {

class TransposedAlgebra : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, TransposedAlgebra, test::every_method(), test::method_name);

/// Numbers without a pattern.
Handle<Vec> numbers(int seed) {
  constexpr PetscInt size = 5;
  Handle<Vec> x;
  check(VecCreateMPI(MPI_COMM_WORLD, size, PETSC_DECIDE, x.out()));
  double* values = nullptr;
  check(VecGetArray(x.get(), &values));
  for (PetscInt i = 0; i < size; ++i) values[i] = std::sin(13.0 * seed + 7.0 * static_cast<double>(i) + 1.0);
  check(VecRestoreArray(x.get(), &values));
  return x;
}

double dot(Vec a, Vec b) {
  PetscScalar result = 0.0;
  check(VecDot(a, b, &result));
  return result;
}

// J = e . y_{n+1} + sum_i s_i . Y_i0 of any y* and Y_i is dJ/dy* . y* + sum_i dJ/dY_i . Y_i.
TEST_P(TransposedAlgebra, GivesTheDerivativesOfTheSums) {
  const Method& method = GetParam();
  const auto num_stages = static_cast<std::size_t>(method.num_stages);
  const Handle<Vec> base = numbers(1), end = numbers(2);
  StageVariable forward(method, base.get());
  const Vec past = base.get();
  const double one = 1.0;
  forward.set_base(std::span(&past, 1), std::span(&one, 1));
  double number = 0.0;
  std::vector<Handle<Vec>> starts, solutions;
  for (std::size_t i = 0; i < num_stages; ++i) {
    starts.push_back(numbers(10 + static_cast<int>(i)));
    solutions.push_back(numbers(20 + static_cast<int>(i)));
    forward.start_stage(method.At[i]);
    number += dot(starts[i].get(), forward.start());
    check(VecCopy(solutions[i].get(), forward.stage()));
    forward.end_stage(i);
  }
  forward.complete_step(method.bt);
  number += dot(end.get(), forward.end());

  TransposedVariable backward(num_stages, base.get());
  backward.begin(method, end.get());
  double expected = 0.0;
  for (std::size_t i = num_stages; i-- > 0;) {
    expected += dot(backward.stage(i), solutions[i].get());
    backward.start_stage(method, i, starts[i].get());
  }
  expected += dot(backward.base(), base.get());
  EXPECT_NEAR(number, expected, 1e-13 * static_cast<double>(num_stages + 1) * 20.0);
}

}  // namespace
}  // namespace pliant::test_transposed_variable
